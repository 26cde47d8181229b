. "$SOURCE_DIR/tests/cli/support.sh"
cp "$SOURCE_DIR/examples/slides/photometric/downlight.ies" .
cat >lamps.scn <<'END'
camera { position: (0, 1, 5), look_at: (0, 1, 0) }
point_light { position: (0, 2, 0), power: 683lm, name: "bulb" }
spot_light { position: (0, 2, 0), target: (0, 0, 0), intensity: 683cd, falloff: cosine_lobe { exponent: 3 },
             attenuation: window { start: 1m, end: 3m } }
directional_light { direction: (0, -1, 0), irradiance: 100lx }
area_light { shape: disc { center: (0, 3, 0), normal: (0, -1, 0), radius: 1 }, radiance: 1, name: "panel" }
environment_light { radiance: 2 }
sphere { center: (5, 0, 0), radius: 0.5, material: emissive { radiance: 1 } }
photometric_light { file: "downlight.ies", position: (0, 3, 0) }
let bulb = group { point_light { position: (0, 0, 0), intensity: 1 } }
instance { of: bulb, transform: translate(1, 0, 0) }
instance { of: bulb, transform: translate(2, 0, 0) }
END
# row PATTERN FIELD VALUE: a figure of a light's row, to 1 %; FIELD counts from the kind.
row() {
    found=$(grep -e "$1" out | sed "s/.*\(point_light\|spot_light\|directional_light\|area_light\|environment_light\|sphere\|photometric_light\) /\1 /" | head -1 | awk -v f="$2" '{ print $f }')
    echo "$found $3" | awk '{ exit !($1 == $2 || ($1 - $2 < 0.01 * $2 && $2 - $1 < 0.01 * $2)) }' ||
        fail "$last: $1: figure $2 is '$found', not $3"
}
run lights lamps.scn --at 0,0,0
expect_code 0
expect_empty err
[ "$(wc -l <out)" -eq 11 ] || { fail "not 11 lines"; cat out >&2; }
# name, W, lm, W/m², lx
row 'bulb (lamps.scn:2)' 2 1
row 'bulb (lamps.scn:2)' 3 683
row 'bulb (lamps.scn:2)' 4 0.0198944
row 'bulb (lamps.scn:2)' 5 13.5878
# 2π/4 sr; the window leaves (1/2)² at 2 m
row 'lamps.scn:3' 2 1.5708
row 'lamps.scn:3' 4 0.25
expect_text out 'cosine_lobe { exponent: 3 }, window { start: 1m, end: 3m }: not physical'
row 'lamps.scn:5' 2 -
row 'lamps.scn:5' 5 100
# π² W; E = π / (1 + 9)
row 'panel' 2 9.8696
row 'panel' 4 0.31416
row 'lamps.scn:7' 4 6.2832
row 'lamps.scn:8' 2 9.8696
# E = π L sin², half a metre seen from 5 m
row 'lamps.scn:8' 4 0.031416
row 'lamps.scn:9' 3 1231.7
row 'lamps.scn:9' 5 100
row 'lamps.scn:10' 2 12.566
row 'lamps.scn:10' 4 1
expect_text out '9 lights'
run lights lamps.scn
expect_code 0
expect_no_text out 'W/m2'
run lights lamps.scn --at '(1, 2.5, -3)'
expect_code 0
for point in 1,2 1,2,3,4 x '' 1,2,inf '(1,2,3' '1,2,3)'; do
    run lights lamps.scn --at "$point"
    expect_code 2
    expect_text err 'takes a point like'
done
run lights wrong.scn
expect_code 1
expect_empty out
# The law is noted by `check` alone.
run check lamps.scn
expect_code 0
expect_text err 'note[N0901]'
expect_text err '`window`'
[ "$(grep -c N0901 err)" -eq 1 ] || fail "N0901 more than once"
run lamps.scn --samples 1 --size 8x8
expect_code 0
expect_no_text err N0901
finish
