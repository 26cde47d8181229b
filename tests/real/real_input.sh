#!/bin/sh
# Renders real_input.scn where Debian's glmark2-data and blender-data are installed; else it is skipped.
# Usage: real_input.sh SCNRENDER SCENE [PICTURE]
set -eu
scnrender=$1 scene=$2
models=/usr/share/glmark2/models surroundings=/usr/share/blender/datafiles/studiolights/world
if [ ! -f "$models/bunny.obj" ] || [ ! -f "$surroundings/courtyard.exr" ]; then
    echo "needs the packages glmark2-data and blender-data"
    exit 77
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
picture=${3:-$work/real.png}

# The sandbox holds: without leave, files outside the scene's folder are not read.
if "$scnrender" check "$scene" 2>"$work/log"; then
    echo "files outside the scene's folder were read without --allow-path" >&2
    exit 1
fi
grep -q 'outside the folders that a scene may read' "$work/log"

size=
[ $# -ge 3 ] || size='--size 64x32 --samples 8'
"$scnrender" "$scene" $size --allow-path "$models" --allow-path "$surroundings" -o "$picture" 2>"$work/log" ||
    { cat "$work/log" >&2; exit 1; }
cat "$work/log"
[ -s "$picture" ]
