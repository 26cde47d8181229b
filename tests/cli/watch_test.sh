. "$SOURCE_DIR/tests/cli/support.sh"
# What is wrong is said before anything is served; the rest is in tests/watch.
run watch -
expect_code 2
expect_text err "\`watch\` wants a file"
run watch missing.scn
expect_code 3
expect_text err "can't read \`missing.scn\`"
run watch ball.scn --tev=nowhere
expect_code 2
expect_text err "HOST:PORT"
run watch ball.scn --port 70000
expect_code 2
run watch ball.scn --terminal
expect_code 2
expect_text err "wants to run on a terminal"
# On a terminal: it draws, a key ends it, and what was found is printed.
if command -v script >/dev/null && [ -e "$BUILD_DIR/lib/scnrender/scn_chafa.so" ]; then
    last="--terminal"
    : >out
    (tries=0
    until grep -q "8 of 8 samples" out || [ $tries -gt 600 ]; do sleep 0.1 && tries=$((tries + 1)); done
    printf 'c'; sleep 1; printf 'q') |
        TERM=xterm-256color COLORTERM=truecolor script -qec "$SCNRENDER watch --terminal=blocks ball.scn" /dev/null >out 2>err
    code=$?
    expect_code 0
    expect_text out "8 of 8 samples"
    expect_text out "scnrender render ball.scn --camera side"
fi
# `render` takes the exposure, the curve and the camera that the page tells.
run ball.scn -o a.png
run ball.scn -o b.png --exposure 0 --tone srgb --camera "camera { position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg }"
expect_code 0
run ball.scn -o c.png --exposure -1 --tone aces
expect_code 0
if cmp -s a.png c.png; then fail "the exposure and the curve change nothing"; fi
run ball.scn -o d.png --camera "sphere {}"
expect_code 2
expect_text err "describes 0 cameras"
run ball.scn -o d.png --exposure much
expect_code 2
run ball.scn -o d.png --tone asec
expect_code 2
finish
