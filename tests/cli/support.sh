# What every script begins with: a folder of its own with some scenes, and ways to say what is
# expected. SCNRENDER is the program under test.
set -u
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
failures=0

cat >ball.scn <<'END'
film { width: 32, height: 20 }
render { samples: 8 }
camera { position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg, name: "front" }
camera { position: (3, 4, 0), look_at: (0, 0, 0), fov: 40deg, name: "side" }
param size: number = 1 in 0.1..3 "How large the ball is"
param shade: number = 0.5
sphere { radius: size, material: lambert { color: gray(shade) } }
environment_light { radiance: 1 }
END
cat >wrong.scn <<'END'
camera { position: (0, 0, 5), look_at: (0, 0, 0) }
sphere { radus: 1 }  // wrong
sphere { radius: "one" }
END

fail() {
    echo "FAILED: $*" >&2
    failures=$((failures + 1))
}

# run ARGUMENTS…: leaves what the program says in out and err, its exit status in $code.
run() {
    last="$*"
    "$SCNRENDER" "$@" >out 2>err </dev/null
    code=$?
}

expect_code() {
    [ "$code" -eq "$1" ] || { fail "$last: exit status $code, not $1"; cat err >&2; }
}

# expect_text FILE TEXT: the file holds the text.
expect_text() {
    grep -qF -e "$2" "$1" || { fail "$last: no \"$2\" in $1:"; head -20 "$1" >&2; }
}

expect_no_text() {
    if grep -qF -e "$2" "$1"; then fail "$last: \"$2\" in $1"; fi
}

expect_empty() {
    [ ! -s "$1" ] || { fail "$last: $1 isn't empty:"; head -5 "$1" >&2; }
}

# interrupt SCRIPT FILE: starts the script, which execs the program, and presses Ctrl-C until it has
# left the file, later and later: a busy machine may take long to begin.
interrupt() {
    for delay in 1.5 4 12 30; do
        env --default-signal=INT sh "$1" >out 2>err &
        pid=$!
        sleep "$delay"
        kill -s INT $pid
        wait $pid
        code=$?
        [ ! -s "$2" ] || break
    done
    [ -s "$2" ] || fail "$last: no $2"
}

# again RENDERED ARGUMENTS…: a series of pictures, of which so many are rendered in this run.
again() {
    rendered=$1
    shift
    run "$@"
    expect_code 0
    expect_text err " $rendered of them rendered now"
}

# refuse TEXT ARGUMENTS…: wrong use.
refuse() {
    text=$1
    shift
    run "$@"
    expect_code 2
    expect_text err "$text"
}

# Nothing is left beside the pictures.
expect_no_leftovers() {
    left=$(find . -name '*.tmp')
    [ -z "$left" ] || fail "$last: left behind: $left"
}

# png_size FILE: "WIDTHxHEIGHT"
png_size() {
    od -An -tu1 -j16 -N8 "$1" | awk '{ print $1*16777216+$2*65536+$3*256+$4 "x" $5*16777216+$6*65536+$7*256+$8 }'
}

# trust_none NAME FAILURES TRIES: the script's line in the table of trust (tests/trust.h).
trust_none() {
    folder=$BUILD_DIR/trust
    [ "${SCN_TRUST:-}" != full ] || folder=$folder/full
    script=$(basename "$0")
    printf 'none\t%s\tcli/%s\t%d\t%d\n' "$1" "$script" "$3" "$2" >"$folder/cli_${script%.sh}.tsv"
}

finish() {
    [ "$failures" -eq 0 ] || { echo "$failures failed" >&2; exit 1; }
    exit 0
}
