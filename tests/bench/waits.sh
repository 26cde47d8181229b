#!/bin/sh
# Where rendering makes the processor wait for numbers that it has just stored: the places that read
# some of them otherwise than they were written, and how often a sample (waits.c). Some minutes.
# Usage: tests/bench/waits.sh [SCENE [LEAST]]   (LEAST: times a sample; needs valgrind, addr2line)
set -eu
cd "$(dirname "$0")/../.."
scene=${1:-examples/cornell_box.scn}
least=${2:-0.1}
side=16
samples=16
build=build/waits
# At fixed addresses, so that the list's are those of the program's file.
cmake --preset release -B $build -DCMAKE_C_FLAGS_RELEASE="-O3 -g -DNDEBUG" -DCMAKE_EXE_LINKER_FLAGS=-no-pie >/dev/null
cmake --build $build --target waits --target scnrender --target scn_png >/dev/null
program=$build/bin/scnrender
picture=$(mktemp --suffix=.png)
trap 'rm -f "$picture"' EXIT
valgrind --tool=lackey --trace-mem=yes --log-fd=9 $program "$scene" --threads 1 --quiet \
    --size ${side}x$side --samples $samples -o "$picture" 9>&1 >/dev/null 2>/dev/null |
    $build/tests/bench/waits |
    while read -r count reader writer; do
        awk -v n="$count" -v all=$((side * side * samples)) -v least="$least" \
            'BEGIN { if (n < least * all) exit 1; printf "%6.2f ", n / all }' || break
        place() { addr2line -s -e $program "$1" | sed 's/ .*//'; }
        echo "$(place "$reader") reads what $(place "$writer") wrote"
    done
[ -s "$picture" ] || {
    echo "waits.sh: $scene wasn't rendered" >&2
    exit 1
}
