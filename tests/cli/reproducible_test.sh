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

# And so it is for caustics traced from the lamps, in parts and with breaks, too.
sed 's/guided/traced/' caustic.scn >traced.scn
run traced.scn -o traced.exr --samples 100 --threads 1
expect_code 0
run traced.scn -o tiles.exr --samples 100 --threads 3 --tile 8x8
cmp -s traced.exr tiles.exr || fail "traced: other bytes for other threads and tiles"
run traced.scn --samples 100 --sample-range 0..63 --checkpoint head
run traced.scn --samples 100 --sample-range 64..99 --checkpoint tail --threads 2
run merge head tail -o merged.exr
expect_code 0
cmp -s traced.exr merged.exr || fail "traced: other bytes for parts"
run traced.scn -o x.exr --samples 20 --checkpoint c
run traced.scn -o resumed.exr --samples 100 --checkpoint c --resume
expect_code 0
cmp -s traced.exr resumed.exr || fail "traced: other bytes after a break"
sed 's/samples: 16/samples: 400, stop: until { error: 0.1 }/' traced.scn >stops.scn
run stops.scn -o stops.exr --threads 1
expect_code 0
run stops.scn -o tiles.exr --threads 3 --tile 8x8
cmp -s stops.exr tiles.exr || fail "traced, stopping where it is good enough: other bytes for other threads and tiles"
# Through the centers of pixels alone no photon is seen: that is told.
sed 's/height: 24/height: 24, filter: "center"/' traced.scn >center.scn
run center.scn -o center.exr
expect_code 0
expect_text err "warning[W0963]: caustics can't be traced to the centers of pixels: paths find them by luck"
expect_text err "center.scn:"
finish
