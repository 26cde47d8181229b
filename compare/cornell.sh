#!/bin/sh
# The Cornell box at equal samples here and in Cycles: ratio of means, over the picture and over nine
# regions, with its standard error from independent seeds; and the time of each.
# Usage: compare/cornell.sh [SEEDS] [SAMPLES] [SIZE]     (needs blender and openimageio-tools)
set -eu
cd "$(dirname "$0")/.."
seeds=${1:-8} samples=${2:-64} size=${3:-512}
for tool in blender oiiotool; do
    command -v $tool >/dev/null || { echo "needs $tool: apt-get install blender openimageio-tools" >&2; exit 1; }
done
tools/build release >/dev/null
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

means() { # file: one line for each region, "region r g b"; oiiotool takes long to start, so once
    third=$((size / 3)) regions=whole
    set -- "$1" --ch R,G,B --echo "{TOP.AVGCOLOR}"
    for y in 0 1 2; do
        for x in 0 1 2; do
            set -- "$@" --pop "$1" --ch R,G,B --cut "${third}x$third+$((x * third))+$((y * third))" --echo "{TOP.AVGCOLOR}"
            regions="$regions region_$x$y"
        done
    done
    oiiotool "$@" | tr ',' ' ' | awk -v names="$regions" 'NF == 3 { split(names, name, " "); print name[++n], $0 }'
}

for seed in $(seq "$seeds"); do
    start=$(date +%s.%N)
    build/release/bin/scnrender examples/cornell_box.scn --quiet --samples "$samples" --size "${size}x$size" \
        --seed "$seed" -o "$work/ours.exr"
    middle=$(date +%s.%N)
    blender -b --factory-startup -P compare/cornell_cycles.py -- "$work/cycles.exr" "$samples" "$seed" "$size" >"$work/log" 2>&1 ||
        { cat "$work/log" >&2; exit 1; }
    seconds=$(awk '/^cycles_seconds/ { print $2 }' "$work/log")
    echo "time $(echo "$middle - $start" | bc) $seconds" >>"$work/all"
    means "$work/ours.exr" >"$work/a"
    means "$work/cycles.exr" >"$work/b"
    paste -d' ' "$work/a" "$work/b" >>"$work/all"
done
awk '
    $1 == "time" { ours += $2; theirs += $3; next }
    {
        if (!($1 in n)) order[++regions] = $1
        for (c = 0; c < 3; ++c) {
            ratio = $(2 + c) / $(6 + c)
            n[$1]++; sum[$1] += ratio; square[$1] += ratio * ratio
        }
    }
    END {
        printf "%-10s %10s %10s   (scnrender / Cycles, mean of R, G, B)\n", "region", "ratio", "+-"
        for (i = 1; i <= regions; ++i) {
            r = order[i]; mean = sum[r] / n[r]
            spread = n[r] > 1 ? sqrt((square[r] / n[r] - mean * mean) / (n[r] - 1)) : 0
            printf "%-10s %10.5f %10.5f\n", r, mean, spread
        }
        printf "time       %10.3f             (Cycles / scnrender; ours from start to file)\n", theirs / ours
    }' "$work/all"
