#!/bin/sh
# Scenes here and in POV-Ray, one ray through each pixel's centre: how many pixels agree to 0.1 %.
# Usage: compare/povray.sh FILE.scn…          (needs povray; exit status 77 without it, 1 if fewer
# than 99.5 % agree, or than a scene's line "// povray: at least 98 %" says)
#
# OUT=FOLDER keeps the pictures, the exported scenes and maps of the pixels that differ.
set -eu
here=$(cd "$(dirname "$0")/.." && pwd)
command -v povray >/dev/null || { echo "skipped: needs povray (apt-get install povray)" >&2; exit 77; }
if [ -z "${SCNRENDER:-}" ]; then
    build=$here/$("$here/tools/build" release)
    SCNRENDER=$build/bin/scnrender
    COMPARE_EXACT=$build/tests/compare/compare_exact
    export SCNRENDER_MODULES="$build/lib/scnrender"
fi
work=${OUT:-$(mktemp -d)}
[ -n "${OUT:-}" ] || trap 'rm -rf "$work"' EXIT
mkdir -p "$work"
failures=0
for scene in "$@"; do
    name=$(basename "$scene" .scn)
    "$SCNRENDER" "$scene" --quiet -o "$work/$name.exr"
    "$SCNRENDER" export --to povray "$scene" --quiet -o "$work/$name.pov"
    size=$(sed -n 's/^.*\(+W[0-9]* +H[0-9]*\).*$/\1/p' "$work/$name.pov" | head -1)
    # HOME: POV-Ray wants a folder of its own there.
    HOME=$work povray "+I$work/$name.pov" "+O$work/$name.povray.exr" $size +FE -A -D -P -V \
        >"$work/$name.log" 2>&1 || { cat "$work/$name.log" >&2; exit 1; }
    least=$(sed -n 's/^.*povray: at least \([0-9.]*\) %.*$/\1/p' "$scene" | head -1)
    printf '%-24s ' "$name"
    "$COMPARE_EXACT" "$work/$name.exr" "$work/$name.povray.exr" "${least:-99.5}" "$work/$name.differ.pgm" ||
        failures=$((failures + 1))
done
[ "$failures" -eq 0 ] || exit 1
