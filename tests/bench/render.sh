#!/bin/sh
# What rendering costs beside the least that could draw the same: scnrender and tests/bench/prototype.c
# on the Cornell box, one thread each, alternating; and the instructions of both, which are the same
# from run to run. Prints processor time, so that other work on the machine matters less.
# Usage: tests/bench/render.sh [RUNS]   (needs valgrind for the instructions)
set -eu
cd "$(dirname "$0")/../.."
runs=${1:-5}
build=build/release
tools/build release >/dev/null
cmake --build $build --target prototype >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cpu() { # seconds of processor time of: size samples
    /usr/bin/time -f "%U %S" -o "$work/time" $build/bin/scnrender examples/cornell_box.scn --quiet \
        --threads 1 --size "$1x$1" --samples "$2" -o "$work/picture.png"
    awk '{ print $1 + $2 }' "$work/time"
}

for run in $(seq "$runs"); do
    fixed=$(cpu 16 1) # starting, and loading what writes pictures
    whole=$(cpu 256 64)
    least=$($build/tests/bench/prototype 256 64 | awk '{ print $1 }')
    awk -v fixed="$fixed" -v whole="$whole" -v least="$least" 'BEGIN {
        speed = 256 * 256 * 64 * 1e-6 / (whole - fixed)
        printf "scnrender %.3f Msamples/s, prototype %.3f, ratio %.3f\n", speed, least, speed / least
    }'
done

command -v valgrind >/dev/null || exit 0
instructions() { # function command…
    of=$1
    shift
    valgrind --tool=callgrind --toggle-collect="$of" --callgrind-out-file="$work/callgrind" "$@" 2>&1 >/dev/null |
        awk '/Collected/ { printf "%.1f", $4 * 1e-6 }'
}
# A PNG, for which no thread loads OpenImageIO meanwhile.
printf 'millions of instructions for 32x32 pixels of 16 samples: scnrender %s, prototype %s\n' \
    "$(instructions render_tile $build/bin/scnrender examples/cornell_box.scn --threads 1 --size 32x32 --samples 16 -o "$work/picture.png")" \
    "$(instructions main $build/tests/bench/prototype 32 16)"
