. "$SOURCE_DIR/tests/cli/support.sh"
run ball.scn
expect_code 0
run check ball.scn
expect_code 0
run check wrong.scn
expect_code 1
expect_text err "error[E"
expect_text err "wrong.scn:2:"
run wrong.scn -o wrong.png
expect_code 1
[ ! -e wrong.png ] || fail "a scene with errors made a picture"
run
expect_code 2
expect_text err "no scene is named"
run missing.scn
expect_code 3
expect_text err "No such file"
run check missing.scn
expect_code 3
mkdir folder
run folder
expect_code 3
expect_text err "not a file"
run help nothing
expect_code 2
run explain no_such_thing
expect_code 2
run check
expect_code 2
expect_text err "FILE"
finish
