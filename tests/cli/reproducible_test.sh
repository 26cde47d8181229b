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
finish
