#!/bin/sh
# The README's scene is examples/shelf.scn, and its figures of agreement are those that are kept.
set -eu
cd "$SOURCE_DIR"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0
awk '/^```scn$/ { inside = 1; next } /^```/ { exit_now = inside; inside = 0 } exit_now { exit } inside' README.md >"$work/scene"
cmp "$work/scene" examples/shelf.scn || failed=1
compare/compare --kept >"$work/kept"
[ "$(wc -l <"$work/kept")" -eq 2 ] || { echo "not a line for each partner"; failed=1; }
sed 's/^[^:]*: //' "$work/kept" >"$work/lines"
while read -r line; do
    grep -qF -- "$line" README.md || { echo "README.md lacks: $line"; failed=1; }
done <"$work/lines"
exit $failed
