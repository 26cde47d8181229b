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
expect_text out '"passed": 3, "failed": 2, "undecided": 0, "not_run": 1, "broken_files": 2'
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

# Light: a floor under a disc of light, half of which it sees.
cat >light.scn <<'END'
film { width: 20, height: 20 }
render { bounces: 1, sampling: "bsdf" }
camera { position: (0, 0.5, 0), look_at: (0, 0, 0), up: (0, 0, 1), fov: 1deg }
plane { material: lambert { color: #fff }, name: "floor" }
area_light { shape: disc { center: (0, 1, 0), normal: (0, -1, 0), radius: 1 }, radiance: 1 }
param target: number = 0.5
let middle = radiance(region((5, 5), (15, 15)))
expect middle within 2% of target
expect luminance(radiance()) < 0.6
expect coverage(object("floor")) within 1e-5 of 1
END
run test light.scn
expect_code 0
expect_empty err
expect_text out 'pass  line 8    expect middle within 2% of target'
expect_text out ' in r, g and b (99.9% confidence), '
expect_text out '3 passed, 0 failed ('
run test light.scn --set target=0.55
expect_code 1
expect_text out 'FAIL  line 8 '
expect_text out '% off 0.55, and 2% is allowed'
expect_text out 'middle is radiance(region((5, 5), (15, 15)))'
expect_text out 'target is 0.55'
run test light.scn --set target=0.507 --samples 9000
expect_code 1
expect_text out '????  line 8 '
expect_text out 'too uncertain to tell: about '
expect_text out '1 undecided'
# What it says would decide does.
needed=$(sed -n 's/.*(--samples \([0-9]*\)).*/\1/p' out)
run test light.scn --set target=0.507 --samples "$needed"
expect_no_text out 'undecided'

# The same seed, the same figures; another seed, others. Of the times nothing is promised.
figures() { sed 's/, [0-9.:]* s$//; s/ ([0-9.]* s)$//' out; }
run test light.scn --threads 1
figures >first
run test light.scn --threads 3
figures | cmp -s - first || fail "$last: other figures"
run test light.scn --seed 5
figures | cmp -s - first && fail "$last: the same figures"
run test light.scn --confidence 0.99
expect_text out '(99% confidence)'
run test light.scn --confidence 1
expect_code 2

run test light.scn --json --set target=0.55
expect_code 1
"$JSON_CHECK" <out || fail "$last: not JSON"
for key in '"verdict": "fail"' '"measured": [' '"half_width": [' '"confidence": 0.999' '"relation": "within"' \
    '"target": [0.55,' '"tolerance": 0.011' '"samples": ' '"relation": "below", "target": 0.6' '"undecided": 0'; do
    expect_text out "$key"
done

# Nothing is seen of what isn't there.
cat >hidden.scn <<'END'
camera { position: (0, 0, 5), look_at: (0, 0, 0) }
sphere { center: (0, 0, 20), name: "behind" }
environment_light { radiance: 1 }
expect radiance(object("behind")) > 1
expect coverage(object("behind")) < 0.01
END
run test hidden.scn --samples 10000
expect_code 1
expect_text out 'no ray meets it'
expect_text out '1 passed, 0 failed, 1 undecided'

# An interrupt ends it, and says so.
# What is equal by symmetry alone is never known.
sed '$d' light.scn >endless.scn
echo 'expect radiance(region((0, 5), (10, 15))) within 1e-9 of radiance(region((10, 5), (20, 15)))' >>endless.scn
"$SCNRENDER" test endless.scn --samples 1000000000000 >out 2>err &
process=$!
while [ ! -s out ] && kill -0 $process; do sleep 0.1; done
sleep 0.3
kill -TERM $process
wait $process
code=$?
last='test, interrupted'
expect_code 143
expect_text out 'interrupted before it could be told'
finish
