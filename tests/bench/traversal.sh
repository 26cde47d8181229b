#!/bin/sh
# Which part of its time rendering spends in finding what rays meet: Embree's library, and our own
# functions beside it and in its place (src/render/accel_*.c, but for the surfaces at hits). As it
# is, with few flat pieces swept; and with all of them left to Embree, as the yardstick has it
# (tests/bench/prototype.c), which is listed, too. Of each the parts, and the processor time.
# Usage: tests/bench/traversal.sh [SCENE]   (needs perf)
set -eu
cd "$(dirname "$0")/../.."
scene=${1:-examples/cornell_box.scn}
command -v perf >/dev/null || {
    echo "traversal.sh: needs perf" >&2
    exit 1
}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

build() { # folder, SCN_SWEEP
    cmake --preset release -B "$1" -DSCN_SWEEP="$2" >/dev/null
    cmake --build "$1" --target scnrender --target scn_png --target prototype >/dev/null
}

measure() { # name, folder of the accelerator's objects or -, command…
    name=$1
    objects=$2
    shift 2
    perf record -o "$work/perf" -F 5000 "$@" >/dev/null 2>&1
    /usr/bin/time -o "$work/time" -f "%U" "$@" >/dev/null
    : >"$work/ours"
    if [ "$objects" != - ]; then
        find "$objects" -name 'accel_*.o' ! -name 'accel_surface*' -exec nm {} + |
            awk 'tolower($2) == "t" { print $3 }' >"$work/ours"
    fi
    perf report -i "$work/perf" --sort dso,symbol --stdio 2>/dev/null |
        awk -v name="$name" -v seconds="$(cat "$work/time")" -v ours="$work/ours" '
            BEGIN { while ((getline line < ours) > 0) own[line] = 1 }
            $1 ~ /^[0-9.]+%$/ {
                part = $1 + 0
                all += part
                if ($2 ~ /embree/) embree += part
                else if ($4 in own) beside += part
            }
            END {
                printf "%-36s %5.1f %% traversal (Embree %.1f, ours %.1f), %.2f s\n", name,
                    100 * (embree + beside) / all, 100 * embree / all, 100 * beside / all, seconds
            }'
}

render() { # name, build
    measure "$1" "$2/CMakeFiles/scn_render.dir" "$2/bin/scnrender" "$scene" --quiet --threads 1 \
        --size 256x256 --samples 128 -o "$work/picture.png"
}

build build/release ON
build build/embree OFF
render "scnrender" build/release
render "scnrender, all left to Embree" build/embree
measure "prototype (always the Cornell box)" - build/release/tests/bench/prototype 256 128
