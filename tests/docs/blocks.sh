#!/bin/sh
# Every block of scn in the manual that isn't an excerpt (with … in it) is a sound scene.
# Usage: blocks.sh SCNRENDER PAGE.md…
set -eu
scnrender=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failed=0 checked=0
cd "$SOURCE_DIR/examples" # what the blocks name
for page; do
    rm -f "$work"/*.scn
    awk -v work="$work" '/^```scn$/ { n++; file = sprintf("%s/%03d.scn", work, n); inside = 1; next }
        /^```/ { inside = 0 } inside { print >file }' "$page"
    for block in "$work"/*.scn; do
        [ -f "$block" ] && ! grep -q '…' "$block" || continue
        checked=$((checked + 1))
        if ! "$scnrender" check - <"$block" >"$work/out" 2>"$work/err" || grep -qE '^(error|warning\[(W0[0-8]|W092[1-9]))' "$work/err"; then
            echo "$page: block $(basename "$block" .scn):"
            cat "$block" "$work/err"
            failed=1
        fi
    done
done
[ "$checked" -gt 0 ] || { echo "no block was found"; exit 1; }
echo "$checked blocks checked"
exit $failed
