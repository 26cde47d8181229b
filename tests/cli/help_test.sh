. "$SOURCE_DIR/tests/cli/support.sh"
man=$SOURCE_DIR/docs/scnrender.1
fits() { # fits LINES
    [ "$(wc -l <out)" -le "$1" ] || fail "$last: more than $1 lines"
    [ -z "$(awk 'length > 80' out)" ] || fail "$last: a line of more than 80 columns"
}
for form in --help -h help; do
    run $form
    expect_code 0
    expect_text out "Usage: scnrender"
    fits 24
done
commands=$(sed -n 's/^COMMAND([A-Z]*, "\([a-z]*\)".*/\1/p' "$SOURCE_DIR/src/cli/options.def")
[ "$(echo "$commands" | wc -l)" -ge 7 ] || fail "the commands can't be listed"
sed 's/\\-/-/g' "$man" >manual
for command in $commands; do
    run --help
    expect_text out "  $command"
    expect_text manual "$command"
    run help "$command"
    expect_code 0
    expect_text out "scnrender $command"
    fits 32
    cp out first
    cat out >>helps
    run "$command" --help
    expect_code 0
    cmp -s out first || fail "help $command and $command --help differ"
done
options=$(tr '\n' ' ' <"$SOURCE_DIR/src/cli/options.def" | sed 's/OPTION(/\n/g' | sed -n 's/^[A-Z_]*, [^,]*, "\([a-z-]*\)".*/\1/p')
[ "$(echo "$options" | wc -l)" -ge 16 ] || fail "the options can't be listed"
for option in $options; do
    expect_text helps "--$option"
    grep -q -- "--$option" manual || fail "the manual page lacks --$option"
done
for limit in $("$SCNRENDER" help check | awk '/^Limits/ { on = 1; next } on { print $1 }'); do
    expect_text manual "$limit"
done
for code in 0 1 2 3 4 130; do
    grep -q "^\.B $code\$" manual || fail "the manual page lacks exit status $code"
done
run version
expect_code 0
expect_text out "scnrender "
cp out first
run --version
cmp -s out first || fail "--version and version differ"
if command -v man >/dev/null && command -v groff >/dev/null; then
    LC_ALL=C.UTF-8 groff -man -Tutf8 -ww "$man" >page 2>warnings || fail "groff refuses the page"
    [ ! -s warnings ] || { fail "groff warns:"; cat warnings >&2; }
fi
finish
