. "$SOURCE_DIR/tests/cli/support.sh"
run check wrong.scn
expect_code 1
expect_empty out
expect_text err "2 errors"
expect_text err "did you mean \`radius\`?"
escape=$(printf '\033')
expect_no_text err "$escape"
run check wrong.scn --diagnostics json
expect_code 1
"$JSON_CHECK" lines <err || { fail "not JSON:"; cat err >&2; }
[ "$(wc -l <err)" -eq 2 ] || fail "$(wc -l <err) lines of JSON"
expect_text err '"file":"wrong.scn","line":2'
# Warnings: shown, no failure, left out by --quiet.
echo 'let unused = 3' >>ball.scn
run check ball.scn
expect_code 0
expect_text err "warning[W"
expect_text err "1 warning"
run ball.scn --samples 1 --diagnostics json
expect_code 0
"$JSON_CHECK" lines <err || { fail "not only JSON:"; cat err >&2; }
run check ball.scn --quiet
expect_code 0
expect_empty err
run check wrong.scn -q
expect_code 1
expect_text err "error[E"
run ball.scn -q --samples 1
expect_code 0
expect_empty err
expect_empty out
# Limits.
run check wrong.scn --limit diagnostics=1
expect_code 1
expect_text err "1 not shown"
# Colour on a terminal only, and never where it isn't wanted; a bar while rendering.
if command -v script >/dev/null; then
    TERM=xterm script -qec "'$SCNRENDER' check wrong.scn" /dev/null >out 2>&1 </dev/null
    code=$?
    last="check on a terminal"
    expect_code 1
    expect_text out "$escape["
    NO_COLOR=1 TERM=xterm script -qec "'$SCNRENDER' check wrong.scn" /dev/null >out 2>&1 </dev/null
    last="check with NO_COLOR"
    expect_no_text out "$escape["
    TERM=xterm script -qec "stty cols 50; '$SCNRENDER' ball.scn --size 300x300 --samples 20" /dev/null >out 2>&1 </dev/null
    last="the bar"
    tr '\r' '\n' <out | grep 'samples .*rays/s' >bars
    [ -s bars ] || fail "no bar on a terminal"
    sed "s/$escape\[[0-9;]*[A-Za-z]//g" bars | grep left | awk 'length > 49 { exit 1 }' || fail "a bar of more than 49 columns"
    TERM=xterm script -qec "'$SCNRENDER' ball.scn -q --size 300x300 --samples 20" /dev/null >out 2>&1 </dev/null
    last="the bar with --quiet"
    expect_no_text out "left"
fi
run ball.scn --size 300x300 --samples 20
expect_no_text err "left"
finish
