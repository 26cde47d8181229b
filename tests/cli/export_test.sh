. "$SOURCE_DIR/tests/cli/support.sh"
cat >rough.scn <<'END'
film { width: 32, height: 20 }
render { integrator: "direct" }
camera { position: (0, 1, 5), look_at: (0, 0, 0) }
sphere { material: burley { color: #c0392b } }
mesh { vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces: [[0, 1, 2]], material: ggx { f0: gray(0.9) } }
point_light { position: (2, 3, 4), power: 60W, attenuation: window { start: 1m, end: 4m } }
END
# What has no partner is told by its line, by the check and at the head of the file.
run check rough.scn
expect_code 0
expect_no_text err N0980
run check --for povray rough.scn
expect_code 0
expect_text err 'note[N0980]'
expect_text err 'rough.scn:4:20'
expect_text err '`burley` has no partner'
expect_text err '`window` has no partner'
run export --to povray rough.scn
expect_code 0
expect_text err '`ggx` has no partner'
expect_text rough.pov '//   rough.scn:4: `burley`'
expect_text rough.pov '//   rough.scn:6: the attenuation `window`'
expect_text rough.pov '// sphere, rough.scn:4'
expect_text rough.pov 'mesh2 {'
expect_text rough.pov 'assumed_gamma 1'
run check --for json rough.scn
expect_no_text err N0980
run export --to povray ball.scn -q -o -
expect_code 0
expect_empty err
expect_text out 'camera {'
# JSON, with the meshes' data.
run export --to json rough.scn -q
expect_code 0
"$JSON_CHECK" <rough.json || fail "the export isn't JSON"
expect_text rough.json '"indices": [0, 1, 2]'
run export --to json rough.scn -o - -q
"$JSON_CHECK" <out || fail "the export isn't JSON"
# Wrong uses.
run export ball.scn
expect_code 2
expect_text err '--to'
run export --to povry ball.scn
expect_code 2
expect_text err 'did you mean `povray`'
run export --to povray wrong.scn -o wrong.pov
expect_code 1
[ ! -e wrong.pov ] || fail "a wrong scene was exported"
run export --to povray ball.scn -o nowhere/ball.pov
expect_code 3
run --for povray ball.scn
expect_code 2
last="export to a full disk"
"$SCNRENDER" export --to json ball.scn -q -o - >/dev/full 2>err
code=$?
expect_code 3
expect_no_leftovers
finish
