#!/bin/sh
# Renders the example of an entry of the manual, small, and compares it with the manual's picture.
# Usage: kind.sh SCNRENDER COMPARE PICTURE.png
set -eu
scnrender=$1 compare=$2 picture=$3
name=$(basename "$picture" .png)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$SOURCE_DIR/examples"
"$scnrender" explain --example "$name" >"$work/$name.scn"
"$scnrender" fmt --check "$work/$name.scn" || { echo "the example isn't laid out as fmt does" >&2; exit 1; }
"$scnrender" - -o "$work/small.png" --size 120x75 --samples 24 <"$work/$name.scn" 2>"$work/log" ||
    { cat "$work/log" >&2; exit 1; }
if grep -E '^(error|warning|note)' "$work/log"; then
    echo "an example must not give diagnostics" >&2
    exit 1
fi
"$compare" "$picture" "$work/small.png"
