. "$SOURCE_DIR/tests/cli/support.sh"
cat >materials.scn <<'END'
let white = lambert { color: #fff }
let paper = lambert { color: #fff }
let clay = burley { color: #fff, roughness: 1 }
let glass = fresnel { ior: 1.5 }
let paints = [lambert { color: rgb(0.5, 0.2, 0.1) }, mirror { color: gray(0.75) }]
let size = 3
sphere { radius: size, material: white }
sphere { center: (9, 0, 0), material: lambert { color: gray(0.4), name: "<b>&\u{202e}" } }
sphere { center: (18, 0, 0), material: lambert { color: gray(0.3) } }
END
# Every material once, by its name or place; what a law is broken by is said, and no failure where the
# model says so itself.
run furnace materials.scn --samples 2000
expect_code 0
expect_empty err
for line in 'white, paper, lambert (materials.scn:1)' 'clay, burley (materials.scn:3)' 'glass, fresnel (materials.scn:4)' \
    'paints[0], lambert (materials.scn:5)' 'paints[1], mirror (materials.scn:5)' 'lambert (materials.scn:9)'; do
    grep -qxF -e "$line" out || { fail "no $line"; cat out >&2; }
done
[ "$(grep -c '^  energy ' out)" -eq 7 ] || fail "$last: not 7 materials"
expect_text out '<b>&'
expect_no_text out "$(printf '\342\200\256')"
expect_text out '  reflected       1.0000  1.0000  1.0000  1.0000  1.0000  1.0000  1.0000  ± 0'
expect_text out '  reflected r     0.5000'
expect_text out '  from behind          0      15      30      45      60      75      85'
expect_text out 'energy         kept: at most 1.0000'
expect_text out 'energy         gains: '
expect_text out "Burley's model isn't energy-conserving by construction"
expect_text out 'reciprocity    not asked: it scatters in single directions only'
[ -z "$(awk 'length > 160' out)" ] || fail "$last: very long lines"

# The same again, for any number of threads.
cp out first
run furnace materials.scn --samples 2000 --threads 3
cmp -s out first || fail "$last: other figures"
run furnace materials.scn --samples 2000 --seed 9
cmp -s out first && fail "$last: the same figures"

run furnace materials.scn --samples 1000 --json -o plot.svg
expect_code 0
"$JSON_CHECK" <out || fail "$last: not JSON"
for text in '"name": "white, paper", "kind": "lambert", "file": "materials.scn", "line": 1' '"degrees": [0, 2.5, 5,' \
    '"energy": {"verdict": "broken", "most": {"value": 1.5' '"reciprocity": {"verdict": "holds"' '"side": "either"' \
    '"sampling": {"verdict": "not asked"' '"transmitted": [[0.9' '"caveat": null'; do
    expect_text out "$text"
done
[ "$(head -c 4 plot.svg)" = '<svg' ] && [ "$(tail -1 plot.svg)" = '</svg>' ] || fail "$last: no SVG"
[ "$(grep -c 'angle from the normal' plot.svg)" -eq 7 ] || fail "$last: not 7 panels"
expect_text plot.svg '&#60;b&#62;&#38;'
expect_no_text plot.svg '<b>'
expect_text plot.svg 'prefers-color-scheme: dark'
if command -v xmllint >/dev/null; then
    xmllint --noout plot.svg || fail "$last: not XML"
fi
expect_no_leftovers

# A library, whose names nothing uses; failures alone, quietly.
run furnace -q "$SOURCE_DIR/std/metals.scn" --samples 500
expect_code 0
expect_empty out
expect_empty err
echo 'sphere { material: phong { color: #fff, diffuse: 1, specular: 0.3 } }' >bright.scn
run furnace bright.scn --samples 2000
expect_text out 'gains: 30% more'
expect_text out 'should not exceed 1'

echo 'let n = 2 print(n)' >none.scn
run furnace none.scn
expect_code 1
expect_text err 'has no materials'
run furnace wrong.scn
expect_code 1
expect_empty out
run furnace materials.scn -o plot.png
expect_code 2
expect_text err '.svg'
run furnace materials.scn --samples 100 -o nowhere/plot.svg
expect_code 3
finish
