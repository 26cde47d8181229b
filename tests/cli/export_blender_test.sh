# The export for Blender: valid Python for every kind there is, and what has no partner by its line.
. "$SOURCE_DIR/tests/cli/support.sh"
printf 'IESNA:LM-63-2002\nTILT=NONE\n1 -1 2 3 1 1 2 0 0 0\n1 1 50\n0 45 90\n0\n100 50 0\n' >lamp.ies
cat >all.scn <<'END'
film { width: 32, height: 20, filter: "tent" }
render { integrator: "path", samples: 4, clamp: 10 }
camera { position: (0, 1, 5), look_at: (0, 0, 0), aperture: 0.01, name: "a \"quoted\" name" }
let wood = lambert { color: checker { scale: 2, a: gray(0.7) } * 0.5 }
sphere { material: burley { color: #c0392b }, name: "ball" }
sphere { material: lambert { color: checker { space: "object" } } }
sphere { material: lambert { color: gradient { colors: [gray(0), gray(1)], value: noise {} } } }
box { size: (1, 1, 1), material: ggx { f0: gray(1), alpha: (0.1, 0.3) } }
plane { material: wood }
disc { material: ggx { ior: 1.5, alpha: 0.4 } }
rectangle { corner: (0, 0, 0), u: (1, 0, 0), v: (0, 1, 0), material: mirror { eta: rgb(0.1, 0.4, 1.4), k: rgb(4, 2.4, 1.6) } }
triangle { a: (0, 0, 0), b: (1, 0, 0), c: (0, 1, 0), material: mask { opacity: checker {}, base: wood } }
cylinder { from: (0, 0, 0), to: (0, 1, 0), material: fresnel { ior: 1.5, absorption: rgb(1, 2, 3), priority: 2 } }
cone { from: (0, 0, 0), to: (0, 1, 0), material: two_sided { front: wood, back: emissive { radiance: 2 } } }
torus { major_radius: 1, minor_radius: 0.2, material: phong { specular: 0.3 } }
mesh {
  vertices: [(0, 0, 0), (1, 0, 0), (0, 1, 0)], faces: [[0, 1, 2]], uvs: [(0, 0), (1, 0), (0, 1)]
  material: layered { coat: fresnel {}, base: wood }
}
let pair = group { sphere { radius: 0.1 }, box { size: (1, 1, 1), material: wood }, point_light { position: (0, 1, 0), power: 1W } }
instance { of: pair, transform: [scale(1, 2, 1), rotate_z(20deg)], material: blinn_phong { specular: 0.2 } }
instance { of: pair }
point_light { position: (2, 3, 4), power: 60W, attenuation: window { start: 1m, end: 4m } }
spot_light { position: (2, 3, 4), target: (0, 0, 0), power: 60W, falloff: cosine_lobe { exponent: 3 } }
spot_light { position: (2, 3, 4), target: (0, 0, 0), intensity: 6, attenuation: polynomial { a: 1, b: 1, c: 1 } }
directional_light { direction: (0, -1, 0), irradiance: 1, angle: 1deg }
photometric_light { file: "lamp.ies", position: (0, 3, 0) }
area_light { shape: rectangle { corner: (-1, 3, -1), u: (2, 0, 0), v: (0, 0, 2) }, power: 10W }
environment_light { radiance: 0.1 }
END
run check --for blender all.scn
expect_code 0
expect_text err 'for Blender 3.4:'
expect_text err 'all.scn:5:1'
expect_text err 'within 1.6e-4 radii of the surface'
expect_text err 'all.scn:9:1'
expect_text err '`plane` has no end'
expect_text err '`priority` has no partner'
expect_text err 'the highlight of `phong` has no partner'
expect_text err '`layered` has no partner'
expect_text err 'the tent filter has no partner'
run export --to blender all.scn -q
expect_code 0
expect_empty err
for text in '# What has no exact partner:' '#   all.scn:9: `plane` has no end' 'import bpy' 'n.burley(' \
    'n.ggx((1, 1, 1), (0.1, 0.3), 0)' 'n.ggx_ior(1.5, 0.4' 'n.gradient([(0, 0, 0), (1, 1, 1)], [0, 1], ' 'n.noise(' 'n.conductor(' 'n.mask(' 'absorption=(1, 2, 3)' \
    'n.two_sided(material_' 'n.window(1, 4)' 'n.polynomial(1, 1, 1)' 'n.cosine_lobe(3)' \
    'n.smooth_cone(' 'n.photometric(web, 200' 'radiance_of(' '# sphere "ball", all.scn:5' 'film(32, 20, ' \
    'instance(prototype_1, ' '"a \"quoted\" name"'; do
    expect_text all.py "$text"
done
# Python that compiles, where there is Python.
for scene in ball.scn "$SOURCE_DIR"/examples/[b-hk-z]*.scn "$SOURCE_DIR"/compare/scenes/*.scn; do
    run export --to blender "$scene" -q -o "$(basename "$scene" .scn).py"
    expect_code 0
done
if command -v python3 >/dev/null; then
    python3 -c 'import ast, sys
for name in sys.argv[1:]:
    ast.parse(open(name, encoding="utf-8").read(), name)' ./*.py || fail "not Python"
fi
# What it says runs in Blender, where there is one.
if command -v blender >/dev/null && [ -z "$SANITIZE" ]; then
    last="blender -P all.py"
    HOME=$work blender -b --factory-startup --python-exit-code 1 -P all.py -- --output all_{seed}.exr \
        --samples 2 --seeds 3,4 >log 2>&1 || { fail "$last"; tail -20 log >&2; }
    [ -s all_3.exr ] && [ -s all_4.exr ] || fail "$last: no pictures"
    HOME=$work blender -b --factory-startup --python-exit-code 1 -P all.py -- --outptu all.exr >log 2>&1
    expect_text log 'usage: blender'
fi
run export --to blender wrong.scn -o wrong.py
expect_code 1
[ ! -e wrong.py ] || fail "a wrong scene was exported"
finish
