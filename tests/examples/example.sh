#!/bin/sh
# Renders an example at a quarter of its size and compares it with the picture beside it.
# Usage: example.sh SCNRENDER COMPARE EXAMPLE.scn
set -eu
scnrender=$1 compare=$2 scene=$3
picture=${scene%.scn}.png
[ -f "$picture" ] || { echo "no picture beside $scene" >&2; exit 1; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
size=$("$compare" --quarter "$picture")
"$scnrender" "$scene" -o "$work/small.png" --size "$size" --samples 48 2>"$work/log" || { cat "$work/log" >&2; exit 1; }
if grep -E '^(error|warning)' "$work/log"; then
    echo "an example must not give diagnostics" >&2
    exit 1
fi
"$compare" "$picture" "$work/small.png"
