. "$SOURCE_DIR/tests/cli/support.sh"
# Renders killed and taken up again have the bytes of one that was left alone. KILLS: how many at
# least; SEED: of the moments (both for tools/nightly).
kills=${KILLS:-20}
[ -z "${SANITIZE:-}" ] || kills=4
seed=${SEED:-1}
echo "kills $kills, seed $seed"
all_killed=0 other_bytes=0
cat >scene.scn <<'END'
film { width: 90, height: 70, aovs: ["albedo", "variance"] }
render { samples: 330, bounces: 4 }
camera { position: (0, 1, 5), look_at: (0, 0, 0), fov: 40deg }
sphere { radius: 1, material: lambert { color: image { file: "skin.ppm" } } }
plane { point: (0, -1, 0), material: ggx { f0: gray(0.5), alpha: 0.2 } }
area_light { shape: sphere { center: (2, 3, 1), radius: 0.4 }, radiance: 20 }
environment_light { radiance: 0.3 }
END
printf 'P3 2 2 255 255 0 0 0 255 0 0 0 255 9 9 9\n' >skin.ppm
keeping="--checkpoint c --checkpoint-interval 0.05 --resume"

run scene.scn -o whole.exr
expect_code 0
sed 's/samples: 330/samples: 600, stop: until { error: 0.05 }/' scene.scn >stops.scn
run stops.scn -o stops_whole.exr
expect_code 0

# --- SIGKILL at random moments -------------------------------------------------------------------

# milliseconds_of ARGUMENTS…: of processor time that such a run takes. Moments are parts of it, so
# that a slow machine meets the same ones.
milliseconds_of() {
    "$STOP_CHECK" 0 0 "$SCNRENDER" "$@" 2>err | awk '{ print int(1000 * $3) + 1 }'
}
# milliseconds N: a random moment of `whole_time`, the same for the same seed and number.
milliseconds() {
    awk -v s="$seed" -v n="$1" -v longest="$whole_time" 'BEGIN { srand(s * 10007 + n); for (i = 0; i < 5; ++i) rand(); print int(1 + 0.6 * longest * rand()) }'
}
# kill_often SCENE WHOLE KILLS
kill_often() {
    scene=$1 whole=$2 wanted=$3 killed=0 finished=0 resumed=0 tries=0
    last="killing $scene"
    rm -f c killed.exr
    whole_time=$(milliseconds_of "$scene" -o killed.exr $keeping --threads 2)
    rm -f c killed.exr
    while { [ $killed -lt "$wanted" ] || [ $resumed -eq 0 ]; } && [ $tries -lt $((20 * wanted + 20)) ]; do
        tries=$((tries + 1))
        [ ! -e c ] || resumed=$((resumed + 1))
        result=$("$STOP_CHECK" 9 "$(milliseconds $tries)" "$SCNRENDER" "$scene" -o killed.exr $keeping --threads $((tries % 3 + 1)) 2>err)
        case $result in
        137*) killed=$((killed + 1)) ;;
        0*)
            cmp -s "$whole" killed.exr || { fail "$last: other bytes after $killed kills" && other_bytes=$((other_bytes + 1)); }
            finished=$((finished + 1))
            rm -f c killed.exr
            ;;
        *) fail "$last: after $killed kills it ended with $result: $(cat err)" && break ;;
        esac
    done
    [ $killed -ge "$wanted" ] || fail "only $killed of $wanted kills met it at work"
    [ $resumed -gt 0 ] || fail "no run found a checkpoint"
    run "$scene" -o killed.exr $keeping
    expect_code 0
    cmp -s "$whole" killed.exr || { fail "$last: other bytes after all kills" && other_bytes=$((other_bytes + 1)); }
    all_killed=$((all_killed + killed))
    echo "$scene: $killed kills, $resumed runs from a checkpoint, finished $finished times meanwhile"
}
kill_often stops.scn stops_whole.exr $((kills / 4))
run merge c -o x.exr
expect_code 3
expect_text err "stops where it is good enough, which has no parts"
run stops.scn --sample-range 0..63 --checkpoint x
expect_code 1
expect_text err "can't be rendered in parts"
kill_often scene.scn whole.exr $((kills - kills / 4))
trust_none "27 kills by SIGKILL, resumed to other bytes" $other_bytes $all_killed
rm -f killed.exr.*.tmp # of pictures that were being written
expect_no_leftovers

# A finished one is taken up, too, and costs nothing.
run scene.scn -o again.exr $keeping
cmp -s whole.exr again.exr || fail "other bytes from a finished checkpoint"

# --- What doesn't belong together ----------------------------------------------------------------

refuses() { # refuses TEXT ARGUMENTS…
    text=$1
    shift
    cp c before
    rm -f x.exr
    run "$@" -o x.exr $keeping
    expect_code 3
    expect_text err "$text"
    cmp -s c before || fail "$last: the checkpoint was changed"
    [ ! -e x.exr ] || fail "$last: a picture"
}
refuses "of another size: 90 x 70, not 91 x 70" scene.scn --size 91x70
refuses "of another seed: 0, not 3" scene.scn --seed 3
refuses "ends within a block" scene.scn --samples 400
refuses "of another range of samples" scene.scn --sample-range 64..127
sed 's/radius: 1,/radius: 1.01,/' scene.scn >other.scn
refuses "of another scene" other.scn
cp skin.ppm kept.ppm
printf 'P3 2 2 255 255 0 0 0 255 0 0 0 255 9 9 8\n' >skin.ppm
refuses "of another state of the scene's files" scene.scn
mv kept.ppm skin.ppm
cp c sound
for size in 0 7 11 400 100000; do
    head -c $size sound >c
    refuses "$([ $size -lt 8 ] && echo 'something else than a checkpoint' || echo 'is cut off')" scene.scn
done
{ head -c 50000 sound && printf x && tail -c +50002 sound; } >c
refuses "it is damaged" scene.scn
# Not asked to go on, it begins anew over a damaged checkpoint, but over no other file.
run scene.scn -o x.exr --checkpoint c --samples 4
expect_code 0
cp scene.scn precious
run scene.scn -o x.exr --checkpoint precious --samples 4
expect_code 3
expect_text err "\`precious\` is something else than a checkpoint, and stays as it is"
cmp -s precious scene.scn || fail "a scene was overwritten"
run scene.scn -o x.exr --checkpoint none/c --samples 4
expect_code 3
run scene.scn -o x.exr --checkpoint . --samples 4
expect_code 3
for wrong in "--resume" "--checkpoint-interval 3" "--sample-range 0..63" \
    "--checkpoint c --checkpoint-interval 0" "--checkpoint c --checkpoint-interval x"; do
    run scene.scn $wrong
    expect_code 2
done

# --- A full disk ---------------------------------------------------------------------------------

# (ulimit counts blocks of 512.) The old picture and the old checkpoint stay.
run scene.scn -o full.exr --checkpoint full --samples 8
expect_code 0
cp full.exr old.exr
cp full old
(ulimit -f 100 && "$SCNRENDER" scene.scn -o full.exr --checkpoint full --checkpoint-interval 0.01 --samples 150 >out 2>err)
code=$?
last="full disk"
expect_code 3
expect_text err "can't write \`full\`: File too large; will try again"
cmp -s full old || fail "the old checkpoint was spoilt"
cmp -s full.exr old.exr || fail "the old picture was spoilt"
expect_no_leftovers
# The same on a file system of its own, where that can be had without being root.
if unshare -rm true 2>/dev/null; then
    mkdir disk
    unshare -rm sh -c 'mount -t tmpfs -o size=1500k none disk &&
        "$SCNRENDER" scene.scn -o disk/a.exr --checkpoint disk/c --samples 8 2>err1 &&
        cp disk/a.exr disk/c . && { head -c 1500000 /dev/zero >disk/fill; } 2>/dev/null
        "$SCNRENDER" scene.scn -o disk/a.exr --checkpoint disk/c --resume --samples 64 2>err
        code=$?
        cmp a.exr disk/a.exr && cmp c disk/c && [ "$(ls disk | wc -l)" = 3 ] || code="$code, spoilt"
        echo "$code"' >result
    [ "$(cat result)" = 3 ] || { fail "full tmpfs: $(cat result)"; cat err1 err >&2; }
    expect_text err "No space left on device"
fi

# --- Signals -------------------------------------------------------------------------------------

# Stops within a second, by the clock or (on a busy machine) by the time that it worked, even where
# one sample takes long: 65536 scatterings. What it leaves is valid, and goes on to the same bytes.
cat >slow.scn <<'END'
film { width: 12, height: 8 }
render { samples: 3, bounces: 65536, russian_roulette: false }
camera { position: (0, 0, 0.5), look_at: (0, 0, 0), fov: 90deg }
box { min: (-1, -1, -1), max: (1, 1, 1), material: lambert { color: gray(1) } }
area_light { shape: sphere { center: (0, 0.8, 0), radius: 0.05 }, radiance: 20 }
END
[ -z "${SANITIZE:-}" ] || sed -i 's/65536/2000/' slow.scn
run slow.scn -o slow_whole.exr
expect_code 0
slow_time=$(milliseconds_of slow.scn -o slow.exr)
for signal in 2:130 15:143 1:129; do
    last="signal ${signal%:*}"
    # (Before rendering begins a signal ends it at once, and nothing is there to be kept.)
    for part in 4 2 1.5; do
        rm -f slow slow.exr
        delay=$(awk -v t="$slow_time" -v part=$part 'BEGIN { print int(t / part) }')
        result=$("$STOP_CHECK" "${signal%:*}" $delay "$SCNRENDER" slow.scn -o slow.exr --checkpoint slow 2>err)
        [ ! -e slow ] || break
    done
    code=${result%% *}
    [ "$code" = 0 ] && continue # it was done before
    expect_code "${signal#*:}"
    expect_text err "--checkpoint slow --resume goes on"
    echo "$result" | awk '{ exit !($2 < 1 || $3 < 1) }' || fail "$last: took long to stop: $result"
    [ -s slow.exr ] || fail "$last: no picture"
    run slow.scn -o slow.exr --checkpoint slow --resume
    expect_code 0
    cmp -s slow.exr slow_whole.exr || fail "$last: other bytes afterwards"
done
finish
