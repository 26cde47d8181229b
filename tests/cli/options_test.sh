. "$SOURCE_DIR/tests/cli/support.sh"
# Each option changes what it says.
run ball.scn -o plain.exr
expect_code 0
run ball.scn -o a.exr --samples 9
expect_text err "9 samples"
cmp -s plain.exr a.exr && fail "--samples changes nothing"
run ball.scn -o a.png --size 7x9
[ "$(png_size a.png)" = 7x9 ] || fail "--size gave $(png_size a.png)"
run ball.scn -o a.exr --camera front
cmp -s plain.exr a.exr || { strings -n3 a.exr >a; strings -n3 plain.exr >b; fail "the first camera isn't the default"; }
run ball.scn -o a.exr --camera side
cmp -s plain.exr a.exr && fail "--camera changes nothing"
run ball.scn -o a.exr --set size=2
expect_code 0
cmp -s plain.exr a.exr && fail "--set changes nothing"
expect_text a.exr "size=2"
expect_text a.exr "shade=0.5"
run ball.scn -o b.exr --set size=2 --set shade=0.9
expect_text b.exr "shade=0.9"
cat >uses.scn <<'END'
import "lib.scn" as lib
import "lib.scn" as again
param own: int = 1
camera { position: (0, 0, 5), look_at: (0, 0, 0) }
environment_light {}
sphere { radius: lib.size, center: (lib.deep_x, again.size, own) }
END
printf 'import "deep.scn" as deep\nparam size: length = 1m in 0m..3m "How large"\nlet deep_x = deep.x\n' >lib.scn
printf 'param x: length = 2m\n' >deep.scn
run params uses.scn --set lib.size=2m
expect_code 0
expect_text out '"name": "own"'
expect_text out '"name": "lib.size", "type": "length", "default": "1m", "value": "2m", "min": "0m", "max": "3m", "description": "How large"'
[ "$(grep -c '"name"' out)" = 2 ] || fail "$last: not what can be set, once each"
# Wherever it is stopped, it ends in good order.
for steps in 1 2 3 4 5 6 7 8 9 10 11 12 14 16 20; do
    run params uses.scn --limit steps=$steps
    [ "$code" -le 1 ] || fail "$last: exit status $code"
done

run check ball.scn --set sise=2
expect_code 1
expect_text err "size"
run check ball.scn --set size=200
expect_code 1
# What an EXR carries.
for text in scnrender:version scnrender:scene_hash scnrender:seed scnrender:samples \
    scnrender:parameters scnrender:scene ball.scn chromaticities; do
    expect_text a.exr "$text"
done
expect_no_text a.exr "$work"
run ball.scn -o a.exr --aov albedo,normal,depth --aov position,object_id,material_id,variance,alpha
expect_code 0
for channel in albedo.R normal.X depth.Z position.Y object_id.id material_id.id variance.Y; do
    expect_text a.exr "$channel"
    expect_no_text plain.exr "$channel"
done
# The depth of a channel: the tenth byte of a PNG's header.
for bits in 8 16; do
    run ball.scn -o bits.png --bits $bits
    [ "$(od -An -tu1 -j24 -N1 bits.png | tr -d ' ')" = $bits ] || fail "not $bits bits"
done
run ball.scn -o half.exr --bits 16
expect_code 0
[ "$(wc -c <half.exr)" -lt "$(wc -c <plain.exr)" ] || fail "half floats take no less"
# Limits and the sandbox.
mkdir project shared
echo 'let grey = lambert { color: gray(0.2) }' >shared/materials.scn
printf 'import "../shared/materials.scn" as m\nsphere { material: m.grey }\n' >project/scene.scn
run check project/scene.scn
expect_code 1
expect_text err "outside"
run check project/scene.scn --allow-path shared
expect_code 0
run check project/scene.scn --allow-path missing
expect_code 3
run check ball.scn --limit file_bytes=10
expect_code 1
expect_text err "error[E"
# explain
run explain sphere
expect_code 0
expect_text out "radius"
run explain E0001
expect_text out "out of memory"
run explain e0001
expect_code 0
run explain sphre
expect_code 2
expect_text err 'did you mean `sphere`?'
run explain
expect_text out "point_light"
run explain light
expect_text out "point_light"
run explain deg
expect_text out "angle"
run reference
expect_code 0
expect_text out '### `sphere`'
finish
