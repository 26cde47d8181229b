. "$SOURCE_DIR/tests/cli/support.sh"
run ball.scn --dump tokens
expect_code 0
[ "$(wc -l <out)" -ge 40 ] || fail "few tokens"
expect_empty err
run ball.scn --dump ast
expect_code 0
expect_text out "(kind"
run ball.scn --dump scene
expect_code 0
expect_text out '"sphere"'
"$JSON_CHECK" <out || fail "the scene isn't JSON"
[ ! -e ball.png ] || fail "a dump made a picture"
for stage in tokens ast scene; do
    run wrong.scn --dump $stage
    case $stage in
    scene) expect_code 1 ;;
    *) expect_code 0 ;;
    esac
done
run params ball.scn
expect_code 0
expect_text out '"size"'
expect_text out 'How large the ball is'
"$JSON_CHECK" <out || fail "the parameters aren't JSON"
run params ball.scn --set size=2.5
expect_text out '2.5'
# Outputs that can't be written.
for stage in tokens ast scene; do
    last="--dump $stage to a full disk"
    "$SCNRENDER" ball.scn --dump $stage >/dev/full 2>err
    code=$?
    expect_code 3
    expect_text err "No space left"
    last="--dump $stage to a closed output"
    "$SCNRENDER" ball.scn --dump $stage >&- 2>err
    code=$?
    expect_code 3
done
last="--help to a full disk"
"$SCNRENDER" --help >/dev/full 2>err
code=$?
expect_code 3
last="a closed standard error"
"$SCNRENDER" ball.scn -o closed.png >out 2>&-
code=$?
expect_code 0
[ "$(png_size closed.png)" = 32x20 ] || fail "$last: no picture"
last="a reader that goes away"
{ sleep 0.3; "$SCNRENDER" reference; echo $? >status; } 2>err | true
read -r code <status
expect_code 3
expect_text err "Broken pipe"
finish
