. "$SOURCE_DIR/tests/cli/support.sh"
# wrong_use TEXT ARGUMENTS…: exit status 2, and the message says TEXT in one line.
wrong_use() {
    text=$1
    shift
    run "$@"
    expect_code 2
    expect_text err "$text"
    expect_empty out
    [ "$(wc -l <err)" -eq 1 ] || fail "$last: more than a line"
}
wrong_use 'did you mean `--samples`?' ball.scn --smaples 4
wrong_use 'no option `--xyzzy`' ball.scn --xyzzy
wrong_use 'no option `-z`' ball.scn -z
wrong_use 'did you mean `check`?' chekc ball.scn
wrong_use 'one operand too many: `b.scn`' ball.scn b.scn
wrong_use '`check` doesn'"'"'t take `--samples`' check --samples 3 ball.scn
wrong_use '`--quiet` takes no argument' ball.scn --quiet=yes
wrong_use '`--samples` wants an argument' ball.scn --samples
wrong_use '`-o` wants an argument' ball.scn -o
for number in 0 -1 x 1x '' 1.5 99999999999 +1 ' 1'; do
    wrong_use '`--samples` takes a whole number' ball.scn --samples "$number"
done
for size in 0x1 1x0 10 x 10x 10x10x 9999999x1 -1x5 1e3x5; do
    wrong_use '`--size` takes a size' ball.scn --size "$size"
done
wrong_use '`--threads` takes a whole number' ball.scn --threads 0
wrong_use '`--seed` takes a whole number' ball.scn --seed -2
wrong_use '`--set` takes NAME=VALUE' ball.scn --set size
wrong_use '`--set` takes NAME=VALUE' ball.scn --set =3
wrong_use '`--dump` takes tokens, ast or scene' ball.scn --dump token
wrong_use '`--diagnostics` takes text or json' ball.scn --diagnostics xml
wrong_use '`--bits` takes 8, 16 or 32' ball.scn --bits 12
wrong_use 'can'"'"'t have 16 bits' ball.scn -o a.jpg --bits 16
wrong_use 'did you mean `call_depth`?' ball.scn --limit cal_depth=3
wrong_use 'takes a whole number' ball.scn --limit call_depth=deep
wrong_use 'did you mean `albedo`?' ball.scn -o a.exr --aov normal,albdo
wrong_use 'only an EXR' ball.scn -o a.png --aov normal
wrong_use 'with commas' ball.scn -o a.exr --aov normal,
wrong_use 'not of a type that can be written' ball.scn -o a.doc
wrong_use 'not of a type that can be written' ball.scn -o png
wrong_use 'no camera called `back`' ball.scn --camera back
wrong_use '`front`, `side`' ball.scn --camera back
wrong_use 'more than the limit of 700' ball.scn --size 50x50 --limit pixels=700
# The ways to write an option.
for form in '--samples 2' '--samples=2'; do
    run ball.scn $form
    expect_code 0
    expect_text err "2 samples"
done
for form in '-o a.png' '-oa.png' '--output a.png' '--output=a.png' '-qo a.png' '-qoa.png'; do
    rm -f a.png
    run ball.scn --samples 1 $form
    expect_code 0
    [ -s a.png ] || fail "$form: no picture"
done
# Options before and after, and files that look like options.
cp ball.scn ./-ball.scn
cp ball.scn check
run --samples 1 -- -ball.scn
expect_code 0
[ -s ./-ball.png ] || fail "no -ball.png"
run --quiet check ball.scn
expect_code 0
run ./check --samples 1
expect_code 0
[ -s check.png ] || fail "no check.png"
finish
