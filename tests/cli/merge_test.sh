. "$SOURCE_DIR/tests/cli/support.sh"
# Parts rendered apart make the picture that one run makes: the same bytes, for any cuts, threads
# and tiles.
layers="albedo,normal,depth,object_id,variance,alpha"
sed 's/height: 20/height: 20, exposure: 0.7, tone: "filmic"/' ball.scn >toned.scn
run toned.scn -o whole.exr --samples 330 --aov $layers --set size=0.9 --camera side
expect_code 0
run toned.scn -o whole.png --samples 330 --set size=0.9 --camera side
part() { # part NAME RANGE OPTIONS…
    name=$1 range=$2
    shift 2
    run toned.scn --samples 330 --sample-range "$range" --checkpoint "$name" --aov $layers --set size=0.9 --camera side "$@"
    expect_code 0
}
part a 0..63 --threads 1
part b 64..127 --tile 5x3
part c 128..319 --threads 3 --tile 1x1
part d 320..329
[ ! -e toned.png ] && [ ! -e toned.exr ] || fail "a part wrote a picture that nobody asked for"
run merge d b a c -o merged.exr
expect_code 0
expect_text err "merged.exr: 32 x 20, 330 samples, of 4 parts"
cmp -s whole.exr merged.exr || fail "other bytes"
run merge a b c d -o merged.png
cmp -s whole.png merged.png || fail "other bytes of a PNG"
run merge a b c d -o less.exr --aov depth
expect_text less.exr "depth.Z"
expect_no_text less.exr "albedo.R"
# A part that was interrupted goes on.
rm -f e
"$STOP_CHECK" 9 120 "$SCNRENDER" toned.scn --samples 330 --sample-range 64..329 --checkpoint e \
    --checkpoint-interval 0.01 --aov $layers --set size=0.9 --camera side >/dev/null 2>&1
part e 64..329 --resume
run merge a e -o merged.exr
cmp -s whole.exr merged.exr || fail "other bytes with a part that was killed"
# A whole picture's checkpoint is a part, too.
run toned.scn --samples 330 -o x.exr --checkpoint f --aov $layers --set size=0.9 --camera side
run merge f -o merged.exr
cmp -s whole.exr merged.exr || fail "other bytes of one part"
# A part's own picture, where one is asked for.
part g 64..127 -o part.exr
[ -s part.exr ] || fail "no picture of a part"

# --- Errors --------------------------------------------------------------------------------------

cp merged.exr kept.exr
refuses() { # refuses TEXT PARTS…
    text=$1
    shift
    run merge "$@" -o kept.exr
    expect_code 3
    expect_text err "$text"
    cmp -s kept.exr merged.exr || fail "$last: the old picture was changed"
    expect_no_leftovers
}
refuses "no part has the samples 64..127" a c d
refuses "no part has the samples 320..329" a b c
refuses "no part has the samples 0..63" b c d
refuses "both have sample 64" a b e c d
refuses "both have sample 0" a a
part s 64..127 --seed 7
refuses "of another seed" a s c d
part s 64..127 --set size=1
refuses "of another scene" a s c d
part s 64..127 --size 31x20
refuses "of another size" a s c d
run toned.scn --samples 300 --sample-range 64..127 --checkpoint s
refuses "is of a picture of 330 samples a pixel, \`s\` of one of 300" a s c d
head -c 5000 b >cut
refuses "is cut off" a cut c d
{ head -c 9000 b && printf x && tail -c +9002 b; } >bent
refuses "it is damaged" a bent c d
refuses "it is not a checkpoint" a toned.scn c d
refuses "No such file" a none c d
for delay in 700 3000 12000; do # until there is something to be kept
    "$STOP_CHECK" 15 $delay "$SCNRENDER" toned.scn --samples 1000000 --sample-range 0..999999 --checkpoint half >/dev/null 2>&1
    [ ! -s half ] || break
done
refuses "isn't done" half
run merge a b c d -o none/x.exr
expect_code 3
run merge a b c d
expect_code 2
expect_text err "\`merge\` wants \`-o FILE\`"
run merge -o x.exr
expect_code 2
run merge a b c d -o x.png --aov depth
expect_code 2
run toned.scn --checkpoint x --sample-range 3..6
expect_code 2
expect_text err "say \`--sample-range 0..7\`"
run ball.scn --samples 330 --checkpoint x --sample-range 10..70
expect_code 2
expect_text err "--sample-range 0..127"
run ball.scn --samples 330 --checkpoint x --sample-range 64..330
expect_code 2
for range in 5 5..3 a..b -1..63 0...63 0..63x; do
    run ball.scn --samples 330 --checkpoint x --sample-range=$range
    expect_code 2
done

# --- Tiles ---------------------------------------------------------------------------------------

for tile in 1x1 7x3 100x100 32x1; do
    run toned.scn -o tiled.exr --samples 330 --aov $layers --set size=0.9 --camera side --tile $tile --threads 2
    cmp -s whole.exr tiled.exr || fail "other bytes for tiles of $tile"
done
for tile in 0x4 4 axb 4x; do
    run toned.scn --tile $tile
    expect_code 2
done
finish
