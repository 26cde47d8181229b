# Sweeps: a picture for each value, and a sheet of them.
. "$SOURCE_DIR/tests/cli/support.sh"
cat >shelf.scn <<'END'
film { width: 16, height: 12 }
render { samples: 1 }
camera { position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg }
import "lib.scn" as lib
param alpha: number = 0.5 in 0..1 "roughness"
param size: length = 1m
param turn: angle = 0deg
param tint: color = #fff
param word: string = "a"
param wide: int = 16 in 1..64
print(alpha, size, turn, tint, word, wide)
assert(word != "bad", "a bad word")
sphere { radius: size, transform: rotate_y(turn), material: lambert { color: tint * (1 - alpha) }, name: word }
lib.ball
environment_light { radiance: 1 }
END
echo 'param far: length = 3m
let ball = sphere { center: (far, 0, 0) }' >lib.scn

# values LINES…: what print() said of the pictures, in order.
values() {
    grep -v '^\[\|scnrender:\|pictures\?,' err >printed
    printf '%s\n' "$@" >wanted
    cmp -s printed wanted || { fail "$last: not the values:"; diff wanted printed >&2; }
}

run shelf.scn --sweep alpha=0.25,0.5 --sweep size=10cm..1m:3
expect_code 0
values '0.25 0.1m 0deg rgb(1, 1, 1) a 16' '0.5 0.1m 0deg rgb(1, 1, 1) a 16' \
    '0.25 0.55m 0deg rgb(1, 1, 1) a 16' '0.5 0.55m 0deg rgb(1, 1, 1) a 16' \
    '0.25 1m 0deg rgb(1, 1, 1) a 16' '0.5 1m 0deg rgb(1, 1, 1) a 16'
expect_text err "shelf.sweep.png: 6 pictures, 6 of them rendered now"
for name in "alpha=0.25,size=0.1m" "alpha=0.5,size=0.55m" "alpha=0.5,size=1m"; do
    [ "$(png_size "shelf.sweep/$name.png")" = 16x12 ] || fail "no $name.png"
    expect_text "shelf.sweep/$name.exr" scnrender:parameters
done
expect_text "shelf.sweep/alpha=0.5,size=0.55m.exr" 'alpha=0.5, size=0.55m'
[ -s shelf.sweep.png ] || fail "no sheet"
expect_no_leftovers
# The picture is the one that --set gives.
run shelf.scn --set alpha=0.5 --set size=0.55m -o one.exr
cmp -s one.exr "shelf.sweep/alpha=0.5,size=0.55m.exr" || fail "--sweep and --set differ"
run shelf.scn --set alpha=0.5 --set size=0.55m -o one.png
cmp -s one.png "shelf.sweep/alpha=0.5,size=0.55m.png" || fail "--sweep and --set differ in the PNG"

# What is there is left: all of it, or all but what is new, was touched, or was made of other files.
again 0 shelf.scn --sweep alpha=0.25,0.5 --sweep size=10cm..1m:3
again 2 shelf.scn --sweep alpha=0.25,0.5 --sweep size=0.1m,0.55m,70cm
echo spoilt >"shelf.sweep/alpha=0.5,size=70cm.png"
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm
rm "shelf.sweep/alpha=0.5,size=70cm.exr"
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm
echo '{"settings": "' >"shelf.sweep/.records/alpha=0.5,size=70cm.json"
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm
again 0 shelf.scn --sweep alpha=0.5 --sweep size=70cm --threads 1
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm --samples 2
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm --set wide=17
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm --set wide=17 --again
echo '// changed' >>lib.scn
again 1 shelf.scn --sweep alpha=0.5 --sweep size=70cm --set wide=17
again 0 shelf.scn --sweep alpha=0.5 --sweep size=70cm --set wide=17

# Values: numbers, ranges, units, colors, strings, lists, names of imported files' params.
run shelf.scn -o v.png --sweep 'turn=0..90deg:3' --sweep 'wide=16..18'
values '0.5 1m 0deg rgb(1, 1, 1) a 16' '0.5 1m 45deg rgb(1, 1, 1) a 16' '0.5 1m 90deg rgb(1, 1, 1) a 16' \
    '0.5 1m 0deg rgb(1, 1, 1) a 17' '0.5 1m 45deg rgb(1, 1, 1) a 17' '0.5 1m 90deg rgb(1, 1, 1) a 17' \
    '0.5 1m 0deg rgb(1, 1, 1) a 18' '0.5 1m 45deg rgb(1, 1, 1) a 18' '0.5 1m 90deg rgb(1, 1, 1) a 18'
run shelf.scn -o v.png --sweep 'tint=#f00, rgb(0, 1, 0)' --sweep 'word="b, c",d,../e'
expect_code 0
values '0.5 1m 0deg rgb(1, 0, 0) b, c 16' '0.5 1m 0deg rgb(0, 1, 0) b, c 16' '0.5 1m 0deg rgb(1, 0, 0) d 16' \
    '0.5 1m 0deg rgb(0, 1, 0) d 16' '0.5 1m 0deg rgb(1, 0, 0) ../e 16' '0.5 1m 0deg rgb(0, 1, 0) ../e 16'
[ "$(ls v/*,word=d.png | wc -l)" = 1 ] || fail "not one v/tint=#f00,word=d.png"
[ "$(find v -name '*e-*.exr' | wc -l)" = 2 ] || fail "no names for values with a /"
run shelf.scn -o v.png --sweep lib.far=3,4m --sweep alpha=0.3 --sweep wide=16,17 --sweep word=a,b
expect_code 0
expect_text err "[8/8] v/"

# Mistakes.
run shelf.scn --sweep alhpa=1,2
expect_code 1
expect_text err 'did you mean `alpha`?'
[ "$(grep -c '^error' err)" = 1 ] || fail "$last: told more than once"
refuse "doesn't say how many" shelf.scn --sweep alpha=0.1..0.5
refuse "one end is length, the other angle" shelf.scn --sweep size=1m..20deg:3
refuse 'no unit `foo`' shelf.scn --sweep size=1foo..2foo:3
refuse "2 to 10000 values" shelf.scn --sweep alpha=0..1:1
refuse "2 to 10000 values" shelf.scn --sweep alpha=0..1:x
refuse "a value is missing" shelf.scn --sweep alpha=1,,2
refuse "NAME=VALUE" shelf.scn --sweep alpha
refuse "swept twice" shelf.scn --sweep alpha=1 --sweep alpha=2
refuse "both set and swept" shelf.scn --sweep alpha=1 --set alpha=2
refuse "more than 10000" shelf.scn --sweep alpha=0..1:200 --sweep size=1..2:200
refuse "more than 64 sweeps" shelf.scn -o none.png $(seq 65 | sed 's/.*/--sweep p&=1/')
[ ! -e none ] || fail "$last: it made a folder"
refuse "for display" shelf.scn --sweep alpha=1 -o sheet.exr
refuse "not of a type" shelf.scn --sweep alpha=1 -o sheet.txt
refuse 'either `--frames` or' shelf.scn --sweep alpha=1 --frames 0..3
refuse "for one picture" shelf.scn --sweep alpha=1 --checkpoint c
refuse "for one picture" shelf.scn --sweep alpha=1 --dump scene
refuse "wants \`--frames\`" shelf.scn --again
run - --sweep alpha=1 -o s.png
expect_code 2
expect_text err "a file"
run shelf.scn --sweep alpha=0.5 -o none/s.png
expect_code 3
echo >blocked
run shelf.scn --sweep alpha=0.5 -o blocked.png
expect_code 3
expect_text err "folder"
# One value has an error: the others are there, and its place says so.
run shelf.scn -o w.png --sweep word=a,bad,c --sweep alpha=0.5,7
expect_code 1
[ "$(grep -c '^error' err)" = 2 ] || fail "$last: not two errors"
expect_text err "there is no picture for word = bad, alpha = 0.5"
[ "$(find w -name '*.png' | wc -l)" = 2 ] || fail "$last: not two pictures"
[ -s w.png ] || fail "$last: no sheet"
expect_text err "w.png: 2 of 6 pictures"
run shelf.scn -o n.png --sweep word=bad
expect_code 1
[ ! -e n.png ] || fail "a sheet of nothing"
# Pictures of several sizes; and a sheet that is too large shows them smaller.
sed 's/width: 16/width: wide/' shelf.scn >sizes.scn
run sizes.scn -q --sweep wide=8,64
expect_code 0
expect_empty err
run shelf.scn -q -o large.png --size 20x16400 --sweep size=1
expect_code 0
png_size large.png | awk -Fx '{ exit !($1 < 200 && $2 > 8200 && $2 < 8300) }' ||
    fail "the sheet is $(png_size large.png)"

# Ctrl-C: what is done stays, and the same command goes on.
cat >long.sh <<'END'
exec "$SCNRENDER" shelf.scn -o long.png --size 200x200 --sweep alpha=0.1,0.2,0.3,0.4 --samples 1000000
END
last="Ctrl-C"
interrupt long.sh "long/.records/alpha=0.1.part"
expect_code 130
expect_text err "interrupted; \`long\` has 0 of 4 pictures; the same command goes on"
[ ! -e long.png ] || fail "a sheet of nothing"
run shelf.scn -q -o long.png --size 200x200 --sweep alpha=0.1 --samples 2
expect_code 0
[ -s long/alpha=0.1.png ] || fail "what another run left is in the way"
[ ! -e "long/.records/alpha=0.1.part" ] || fail "what is of no use any more is left"
expect_no_leftovers
finish
