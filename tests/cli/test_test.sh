. "$SOURCE_DIR/tests/cli/support.sh"
mkdir -p suite/inner suite/.hidden
cat >suite/good.scn <<'END'
param n: int = 3
let xs = [for (i in 0..<n) i]
expect len(xs) == 3
for (i in xs) { expect i < 3 }
if (n > 9) { expect n == 10 }
END
cat >suite/inner/bad.scn <<'END'
let n = 2
expect n == 2
expect n + 1 == 2
expect "\u{1b}[31m" == ""
END
cat >suite/none.scn <<'END'
sphere {}
END
cp suite/none.scn suite/.hidden/more.scn
echo 'expect false' >suite/.hidden/never.scn

run test suite/good.scn
expect_code 0
expect_empty err
cat >expected <<'END'
suite/good.scn
  pass  line 3    expect len(xs) == 3
  pass  line 4    expect i < 3  (3 times)
  ----  line 5    expect n == 10  (never run)

3 expectations in 1 file: 2 passed, 0 failed, 1 never run
END
sed 's/ ([0-9.]* s)$//' out | cmp -s - expected || { fail "$last:"; cat out >&2; }

run test suite/good.scn --set n=4
expect_code 1
cat >expected <<'END'
suite/good.scn
  FAIL  line 3    expect len(xs) == 3
                  4 is not 3
                  len(xs) is 4
                  xs is [0, 1, 2, 3]
  FAIL  line 4    expect i < 3  (1 of 4 times; the first:)
                  3 is not below 3
                  i is 3
  ----  line 5    expect n == 10  (never run)

3 expectations in 1 file: 0 passed, 2 failed, 1 never run
END
sed 's/ ([0-9.]* s)$//' out | cmp -s - expected || { fail "$last:"; cat out >&2; }

# A folder: what lies below it, but for hidden folders and scenes that expect nothing.
run test suite
expect_code 1
expect_text out "suite/inner/bad.scn"
expect_no_text out "none.scn"
expect_no_text out "hidden"
expect_text out "6 expectations in 2 files: 3 passed, 2 failed, 1 never run"
# What a scene says can't control the terminal.
expect_no_text out "$(printf '\033')"

run test -q suite
expect_code 1
expect_no_text out pass
expect_text out "suite/inner/bad.scn:"
expect_text out "FAIL"

run test --json suite wrong.scn missing.scn
expect_code 3
"$JSON_CHECK" <out || fail "$last: not JSON"
expect_text out '"verdict": "fail"'
expect_text out '"values": {"n + 1": "3", "n": "2"}'
expect_text out '"passed": 3, "failed": 2, "not_run": 1, "broken_files": 2'
expect_text out '{"file": "wrong.scn", "error": "the scene has errors", "expectations": []}'

run test wrong.scn
expect_code 1
expect_text out "wrong.scn: can't be tested"
expect_text err "did you mean \`radius\`?"

# Nothing to test is no success.
run test suite/none.scn
expect_code 1
expect_text err "nothing was tested"
run test
expect_code 2
run test --samples
expect_code 2

# Elsewhere it is a warning, and the picture is made.
run check suite/inner/bad.scn
expect_code 0
expect_text err "warning[W0501]"
echo 'camera { position: (0, 0, 5), look_at: (0, 0, 0) } sphere {} expect false' >seen.scn
run seen.scn --size 8x8 --samples 1
expect_code 0
expect_text err "warning[W0501]"
[ -s seen.png ] || fail "$last: no picture"
"$SCNRENDER" test - <seen.scn >out 2>err
[ $? -eq 1 ] || fail "a scene from a pipe isn't tested"
expect_text out "FAIL  line 1"
finish
