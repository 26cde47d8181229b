. "$SOURCE_DIR/tests/cli/support.sh"
# Renders for hours unless it is stopped. setsid and exec: shells start background jobs with SIGINT
# ignored, and the program leaves an ignored signal alone; so a terminal's job is made of it.
cat >long.sh <<'END'
exec "$SCNRENDER" ball.scn -o "$1" --samples 1000000 --size 300x300 --threads 2
END
start() {
    env --default-signal=INT sh long.sh "$1" >out 2>err &
    pid=$!
    sleep "$2"
}
for signal in INT:130 TERM:143 HUP:129; do
    name=${signal%:*}
    last="SIG$name"
    rm -f stopped.png
    # (Before the first sample there is nothing to be kept: on a busy machine that may take a while.)
    for delay in 1.5 5 15; do
        start stopped.png $delay
        kill -s "$name" $pid
        wait $pid
        code=$?
        grep -q "before the first sample" err || break
    done
    expect_code "${signal#*:}"
    expect_text err "interrupted; \`stopped.png\` has what was done"
    [ "$(png_size stopped.png)" = 300x300 ] || fail "$last: no picture"
done
expect_no_leftovers
# Started to ignore it, as by nohup.
last="an ignored SIGINT"
env --ignore-signal=INT sh long.sh ignored.png >out 2>err &
pid=$!
sleep 1
kill -s INT $pid
sleep 0.5
kill -0 $pid 2>/dev/null || fail "it ended by a signal that it was to ignore"
kill -s TERM $pid
wait $pid
code=$?
expect_code 143
# A mistake in the scene ends at once, before signals are taken.
finish
