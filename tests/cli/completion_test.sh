. "$SOURCE_DIR/tests/cli/support.sh"
# names KIND: those of the commands or options in the tables.
commands=$(sed -n 's/^COMMAND([A-Z_]*, "\([a-z-]*\)".*/\1/p' "$SOURCE_DIR/src/cli/options.def")
options=$(tr '\n' ' ' <"$SOURCE_DIR/src/cli/options.def" | sed 's/OPTION(/\n/g' | sed -n 's/^[A-Z_]*, [^,]*, "\([a-z-]*\)".*/\1/p')
[ "$(echo "$commands" | wc -l)" -ge 9 ] || fail "the commands can't be listed"
[ "$(echo "$options" | wc -l)" -ge 18 ] || fail "the options can't be listed"
for shell in bash zsh fish; do
    run completion $shell
    expect_code 0
    expect_empty err
    cp out script.$shell
    for command in $commands; do
        expect_text out "$command"
    done
    for option in $options; do
        case $shell in
        fish) grep -q -e " -l $option " out || fail "$shell: no --$option" ;;
        *) grep -q -e "--$option[] '=[}]" out || fail "$shell: no --$option" ;;
        esac
    done
done
if command -v bash >/dev/null; then
    bash -n script.bash || fail "bash refuses its script"
    # complete WORD…: what bash would offer for the last word.
    complete() {
        bash -c '. ./script.bash
            COMP_WORDS=("$@") COMP_CWORD=$(($# - 1))
            _scnrender
            printf "%s\n" "${COMPREPLY[@]}"' bash "$@" >out
        last="completing $*"
    }
    complete scnrender ch
    expect_text out check
    complete scnrender fmt --d
    expect_text out --diff
    expect_no_text out --dump
    complete scnrender ball.scn --
    expect_text out --samples
    expect_no_text out --diff
    complete scnrender check ball
    expect_text out ball.scn
    cp ball.scn 'two words.scn'
    complete scnrender check two
    [ "$(cat out)" = 'two words.scn' ] || fail "$last: $(cat out)"
    mkdir 'a folder'
    complete scnrender ball.scn --allow-path a
    [ "$(cat out)" = 'a folder' ] || fail "$last: $(cat out)"
    complete scnrender --
    expect_text out --samples
    complete scnrender ''
    expect_text out "two words.scn"
    expect_text out render
    complete scnrender render ball.scn --dump = s
    [ "$(cat out)" = scene ] || fail "$last: $(cat out)"
    complete scnrender completion z
    [ "$(cat out)" = zsh ] || fail "$last: $(cat out)"
fi
if command -v zsh >/dev/null; then
    zsh -n script.zsh || fail "zsh refuses its script"
fi
if command -v fish >/dev/null; then
    fish -n script.fish || fail "fish refuses its script"
fi
run completion tcsh
expect_code 2
expect_text err "bash, zsh and fish"
finish
