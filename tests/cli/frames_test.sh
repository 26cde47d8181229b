# Films: numbered pictures of what moves.
. "$SOURCE_DIR/tests/cli/support.sh"
cat >clock.scn <<'END'
film { width: 17, height: 12 }
render { samples: 1 }
camera { position: (0, 0, 5), look_at: (0, 0, 0), fov: 40deg }
param shade: number = 0.5
let at = 1m * (time / 1s)
print(frame, time)
assert(frame != 13, "an unlucky number")
sphere { center: (at, 0, 0), material: lambert { color: gray(shade) } }
environment_light { radiance: 1 }
END
# values LINES…: what print() said of the pictures, in order.
values() {
    grep '^-\?[0-9.]* [-0-9.]*s$' err >printed
    printf '%s\n' "$@" >wanted
    cmp -s printed wanted || { fail "$last: not the values:"; diff wanted printed >&2; }
}
names() { # names FOLDER NAMES…
    folder=$1
    shift
    [ "$(cd "$folder" && ls | tr '\n' ' ')" = "$* " ] || fail "$last: $(ls "$folder")"
}

run clock.scn --frames 0..2
expect_code 0
values '0 0s' '1 0.0416666666666667s' '2 0.0833333333333333s'
names clock.frames 0000.png 0001.png 0002.png
[ "$(png_size clock.frames/0002.png)" = 17x12 ] || fail "not the size of the film"
expect_text err "clock.frames: 3 pictures, 3 of them rendered now"
cmp -s clock.frames/0000.png clock.frames/0002.png && fail "nothing moves"
run clock.scn -o still.png
cmp -s clock.frames/0000.png still.png || fail "without --frames it isn't the moment 0"
run clock.scn --frames -1..3:2 --fps 10 -o a.exr
values '-1 -0.1s' '1 0.1s' '3 0.3s'
names a -001.exr 0001.exr 0003.exr
run clock.scn --frames 123456 --fps 29.97 -o b.jpg
names b 123456.jpg

# Resuming.
again 0 clock.scn --frames 0..2
again 2 clock.scn --frames 0..4
again 2 clock.scn --frames 3..4 --again
again 1 clock.scn --frames 3 --fps 25
rm clock.frames/0001.png
again 1 clock.scn --frames 0..2
again 3 clock.scn --frames 0..2 --set shade=0.4
sed -i 's/radiance: 1/radiance: 2/' clock.scn
again 3 clock.scn --frames 0..2 --set shade=0.4
again 0 clock.scn --frames 0..2 --set shade=0.4 --threads 1
run ball.scn --frames 0..2
expect_text err 'neither `frame` nor `time`'
run ball.scn --frames 0 --again
expect_no_text err 'neither `frame` nor `time`'
# A frame with an error ends it.
run clock.scn --frames 12..14
expect_code 1
expect_text err "frame 13 can't be rendered"
names clock.frames 0000.png 0001.png 0002.png 0003.png 0004.png 0012.png
# Each diagnostic is told once.
sed 's/^print.*/let unused = 1/' clock.scn >warned.scn
run warned.scn --frames 0..2
[ "$(grep -c '^warning' err)" = 1 ] || fail "$last: $(grep -c '^warning' err) warnings"

# Wrong use.
refuse "first and the last frame" clock.scn --frames 2..1
refuse "first and the last frame" clock.scn --frames 1..2:0
refuse "first and the last frame" clock.scn --frames a..b
refuse "at most 1000000 frames" clock.scn --frames 0..1000000
refuse "frames a second" clock.scn --frames 1..2 --fps 0
refuse "wants \`--frames" clock.scn --fps 3
refuse "neither of a picture's type" clock.scn --frames 1..2 -o film.txt
refuse "for one picture" clock.scn --frames 1..2 --sample-range 0..63 --checkpoint p

# Films, through ffmpeg.
empty=$work/empty
mkdir "$empty"
PATH=$empty "$SCNRENDER" clock.scn --frames 0..2 -o film.mp4 >out 2>err
code=$?
last="without ffmpeg"
expect_code 3
expect_text err 'ffmpeg, which isn'"'"'t installed'
[ ! -e film ] || fail "rendered without ffmpeg"
# A program of that name that keeps what it was told and given.
cat >"$empty/ffmpeg" <<'END'
#!/bin/sh
printf '%s\n' "$@" >arguments
/bin/cat >pictures
for last in "$@"; do :; done
[ ! -e fail ] || { echo "no such codec" >&2; exit 1; }
echo "a film" >"$last"
END
chmod +x "$empty/ffmpeg"
film() {
    last="$*"
    PATH=$empty:$PATH "$SCNRENDER" "$@" >out 2>err
    code=$?
}
film clock.scn --frames 0..4:2 --fps 10 -o film.mp4
expect_code 0
expect_text err "film.mp4: 3 pictures, 0.6 s"
[ "$(cat film.mp4)" = "a film" ] || fail "no film"
grep -qx 5 arguments || fail "every second frame of 10 a second aren't 5 a second"
cat film/0000.png film/0002.png film/0004.png | cmp -s - pictures || fail "not the pictures in order"
touch fail
film clock.scn --frames 0..4:2 -o film.mp4
expect_code 3
expect_text err "ffmpeg says: no such codec"
[ "$(cat film.mp4)" = "a film" ] || fail "the old film was spoilt"
expect_no_leftovers
printf '#!/bin/sh\nexit 1\n' >"$empty/ffmpeg" # reads nothing
film clock.scn --frames 0..4:2 -o film.gif
expect_code 3
[ ! -e film.gif ] || fail "a film of nothing"
expect_no_leftovers
if command -v ffprobe >/dev/null; then
    for type in mp4 gif; do
        run clock.scn --frames 0..4 --fps 10 -o film.$type
        expect_code 0
        frames=$(ffprobe -v error -count_frames -select_streams v -show_entries stream=nb_read_frames -of csv=p=0 film.$type)
        [ "$frames" = 5 ] || fail "film.$type has $frames frames"
    done
    ffmpeg -v error -i film.mp4 -frames:v 1 back.png || fail "the film can't be read"
    [ "$(png_size back.png)" = 16x12 ] || fail "the film is $(png_size back.png)"
fi

# Ctrl-C, twice: the second run goes on within the picture.
cat >long.sh <<'END'
exec "$SCNRENDER" clock.scn -o long.png --size 200x200 --frames 1..3 --samples 1000000
END
for turn in 1 2; do
    last="Ctrl-C $turn"
    interrupt long.sh long/.records/0001.part
    expect_code 130
    expect_text err "interrupted; \`long\` has 0 of 3 pictures; the same command goes on"
done
run clock.scn -q -o long.png --size 200x200 --frames 1 --samples 2
expect_code 0
[ ! -e long/.records/0001.part ] || fail "what is of no use any more is left"
expect_no_leftovers
finish
