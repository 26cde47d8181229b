# Whatever has a name in the manual has an entry of its own.
. "$SOURCE_DIR/tests/cli/support.sh"
run reference
expect_code 0
cp out manual
sed -n '/^## Integrators/,/^## Units/s/^### `\([a-z_]*\)`$/\1/p' manual >integrators
[ "$(wc -l <integrators)" -ge 8 ] || fail "the integrators can't be listed"
for name in $(cat integrators); do
    run explain "$name"
    expect_code 0
    expect_text out "integrator: \"$name\""
done
sed -n '/^## Functions/,/^## Limits/s/^| `\([a-z_0-9]*\)(.*/\1/p' manual >functions
[ "$(wc -l <functions)" -ge 60 ] || fail "the functions can't be listed"
for name in $(cat functions); do
    run explain "$name"
    expect_code 0
    expect_text out "$name("
done
for name in $(sed '/^## Integrators/,$d' manual | sed -n 's/^### `\([a-z_]*\)`$/\1/p'); do
    run explain "$name"
    expect_code 0
    expect_text out "$name: a"
done
# Quantities.
run explain pi
expect_text out "pi = 3.14159265358979"
run explain time
expect_text out "time: a time"
expect_text out "--frames"
run explain
expect_text out "Quantities: pi tau frame time"
# Both where a kind and a function share a name; the nearest where there is none.
run explain phong
expect_text out "phong: a material"
expect_text out "phong(n, v, l, e, k)"
run explain norml
expect_code 2
expect_text err "did you mean \`normals\`"
# The example alone, which is a scene; each has its picture in the manual.
run explain --example ggx
expect_code 0
expect_text out "material: ggx {"
"$SCNRENDER" check - <out >log 2>&1 || fail "the example of ggx: $(cat log)"
for name in $(sed -n 's/^!\[.*](kinds\/\(.*\)\.png)$/\1/p' manual); do
    [ -f "$SOURCE_DIR/docs/kinds/$name.png" ] || fail "docs/kinds/$name.png is missing: tools/docs --pictures $name"
done
for name in sphere lambert image point_light smooth_cone window camera film path; do
    grep -q "kinds/$name.png" manual || fail "no picture of $name in the manual"
done
run explain --example sin
expect_code 2
expect_text err "\`sin\` has no example"
finish
