. "$SOURCE_DIR/tests/cli/support.sh"
last="standard input"
"$SCNRENDER" - -o piped.ppm <ball.scn >out 2>err
code=$?
expect_code 0
run ball.scn -o named.ppm
cmp -s piped.ppm named.ppm || fail "another picture from the standard input"
last="a pipe"
cat ball.scn | "$SCNRENDER" /dev/stdin -o piped.ppm >out 2>err
code=$?
expect_code 0
last="without -o"
"$SCNRENDER" - <ball.scn >out 2>err
code=$?
expect_code 2
expect_text err "say -o"
last="mistakes"
"$SCNRENDER" check - <wrong.scn >out 2>err
code=$?
expect_code 1
expect_text err "<stdin>:2:"
last="nothing"
"$SCNRENDER" check - </dev/null >out 2>err
code=$?
expect_code 0
last="closed"
"$SCNRENDER" check - <&- >out 2>err
code=$?
[ "$code" -eq 0 ] || [ "$code" -eq 3 ] || fail "closed standard input: exit status $code"
last="standard input that is too large"
"$SCNRENDER" check - --limit file_bytes=100 <ball.scn >out 2>err
code=$?
expect_code 3
expect_text err "too large"
for stage in tokens ast scene; do
    last="--dump $stage"
    "$SCNRENDER" - --dump $stage <ball.scn >out 2>err
    code=$?
    expect_code 0
    expect_empty err
    [ -s out ] || fail "$last: nothing"
done
last="params"
"$SCNRENDER" params - <ball.scn >out 2>err
code=$?
expect_code 0
"$JSON_CHECK" <out || fail "$last: not JSON"
# Names start from the working folder.
mkdir lib
echo 'let grey = lambert { color: gray(0.2) }' >lib/materials.scn
last="an import"
printf 'import "lib/materials.scn" as m\nsphere { material: m.grey }\n' | "$SCNRENDER" check - >out 2>err
code=$?
expect_code 0
finish
