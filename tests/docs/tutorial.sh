#!/bin/sh
# What the tutorial shows stands in the scenes of its steps, blanks and commas aside; each part that
# is left out is marked with …
set -eu
cd "$SOURCE_DIR"
page=docs/tutorial.md
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
awk -v work="$work" '/^## [0-9]+\./ { step = $2 + 0 }
    /^```scn$/ { inside = 1; next } /^```/ { inside = 0 }
    inside { printf "%s\n", $0 >sprintf("%s/%02d", work, step) }' "$page"
failed=0
for block in "$work"/*; do
    step=$(basename "$block")
    cat "examples/tutorial/step_$step.scn" examples/tutorial/lib/*.scn | sed 's#//.*##' | tr -d ' \n,' >"$work/all"
    sed 's#//.*##; s/…/\n/g' "$block" | while read -r line; do
        line=$(printf '%s' "$line" | tr -d ' ,')
        [ -z "$line" ] || grep -qF -- "$line" "$work/all" || { echo "step $step hasn't: $line"; exit 1; }
    done || failed=1
done
[ "$(ls "$work" | wc -l)" -ge 10 ] || { echo "the steps weren't found"; exit 1; }
exit $failed
