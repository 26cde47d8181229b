. "$SOURCE_DIR/tests/cli/support.sh"
for type in png exr tif; do
    for threads in 1 2 8; do
        run ball.scn --threads $threads -o "t$threads.$type" --samples 70
        expect_code 0
        cmp -s "t1.$type" "t$threads.$type" || fail "$type: other bytes for $threads threads"
    done
done
sleep 1 # a time stamp would differ
run ball.scn --threads 3 -o later.exr --samples 70
cmp -s t1.exr later.exr || fail "other bytes a second later"
mkdir moved
cp ball.scn moved
run moved/ball.scn -o moved.exr --samples 70
cmp -s t1.exr moved.exr || fail "other bytes in another folder"
run ball.scn -o seed.exr --samples 70 --seed 1
cmp -s t1.exr seed.exr && fail "the seed changes nothing"

# So it is where rays from the lamps are sent before; and they change the noise.
cat >caustic.scn <<'END'
film { width: 32, height: 24 }
render { samples: 16, caustics: "guided" }
camera { position: (0, 2.6, 4.2), look_at: (0, 0.3, 0), fov: 34deg }
plane { material: lambert { color: gray(0.6) } }
sphere { center: (0, 0.75, 0), radius: 0.5, material: fresnel { ior: 1.5 } }
area_light { shape: rectangle { corner: (-1.6, 3.5, 0.4), u: (0.2, 0, 0), v: (0, 0, 0.2) }, radiance: 300 }
END
run caustic.scn -o guided.exr --threads 1
expect_code 0
run caustic.scn -o tiles.exr --threads 3 --tile 8x8
cmp -s guided.exr tiles.exr || fail "guided: other bytes for other threads and tiles"
sed 's/guided/plain/' caustic.scn >plain.scn
run caustic.scn -o guided.png
run plain.scn -o plain.png
expect_code 0
cmp -s guided.png plain.png && fail "guiding changes nothing"
finish
