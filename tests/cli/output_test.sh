. "$SOURCE_DIR/tests/cli/support.sh"
# The name.
run ball.scn
expect_code 0
[ "$(png_size ball.png)" = 32x20 ] || fail "ball.png is $(png_size ball.png)"
expect_text err "ball.png: 32 x 20, 8 samples"
mkdir sub
cp ball.scn sub/no_extension
run sub/no_extension
[ -s sub/no_extension.png ] || fail "no picture beside sub/no_extension"
sed 's/height: 20/height: 20, file: "mine.exr"/' ball.scn >sub/named.scn
run sub/named.scn
expect_code 0
[ -s sub/mine.exr ] || fail "film's file isn't used"
run sub/named.scn -o other.png
[ -s other.png ] || fail "-o doesn't win"
# A scene can't write outside its folder.
for file in ../out.png "$work/out.png" sub/../../out.png; do
    sed "s|height: 20|height: 20, file: \"$file\"|" ball.scn >sub/reaching.scn
    run sub/reaching.scn
    expect_code 1
    expect_text err "outside the scene's folder"
    [ ! -e out.png ] || fail "$file was written"
done
sed 's/height: 20/height: 20, file: "deep\/mine.png"/' ball.scn >sub/deep.scn
mkdir sub/deep
run sub/deep.scn
expect_code 0
expect_text err "sub/deep/mine.png: 32"
sed 's/height: 20/height: 20, file: "mine.txt"/' ball.scn >sub/typed.scn
run sub/typed.scn
expect_code 1
expect_text err "not of a type"
mkdir elsewhere
ln -s ../elsewhere sub/link
sed 's|height: 20|height: 20, file: "link/out.png"|' ball.scn >sub/reaching.scn
run sub/reaching.scn
expect_code 1
[ ! -e elsewhere/out.png ] || fail "a link led out"
# Every type.
for type in exr png tif tiff hdr jpg jpeg webp bmp tga ppm; do
    run ball.scn -o "types.$type"
    expect_code 0
    [ -s "types.$type" ] || fail "no types.$type"
done
# What is there is replaced as a whole, with its permissions, through links.
echo old >replaced.png
chmod 604 replaced.png
ln -s replaced.png link.png
run ball.scn -o link.png
expect_code 0
[ -h link.png ] || fail "the link is gone"
[ "$(png_size replaced.png)" = 32x20 ] || fail "the link's target isn't replaced"
[ "$(stat -c %a replaced.png)" = 604 ] || fail "other permissions: $(stat -c %a replaced.png)"
# What can't be written is told before rendering.
run ball.scn -o none/out.png --samples 100000
expect_code 3
expect_text err "No such file"
mkdir dir.png
run ball.scn -o dir.png --samples 100000
expect_code 3
expect_text err "Is a directory"
mkfifo pipe.png
run ball.scn -o pipe.png --samples 100000
expect_code 3
expect_text err "not a regular file"
if [ "$(id -u)" -ne 0 ]; then
    mkdir locked
    chmod 555 locked
    run ball.scn -o locked/out.png --samples 100000
    expect_code 3
    expect_text err "Permission denied"
fi
# A full disk: a message, the old picture, nothing left behind. (ulimit counts blocks of 512.)
cp ball.png kept.png
cp kept.png before.png
(ulimit -f 1 && "$SCNRENDER" ball.scn -o kept.png --size 200x200 >out 2>err)
code=$?
last="full disk"
expect_code 3
expect_text err "File too large"
cmp -s kept.png before.png || fail "the old picture was spoilt"
expect_no_leftovers
# What writes the picture is missing. PNG and EXR don't need OpenImageIO; it writes EXR, too.
SCNRENDER_MODULES=/nonexistent
export SCNRENDER_MODULES
cp "$SCNRENDER" ./alone
for missing in "exr:OpenImageIO" "png:libpng"; do
    ./alone ball.scn -o "alone.${missing%:*}" >out 2>err
    code=$?
    last="without ${missing#*:}"
    expect_code 3
    expect_text err "${missing#*:} can't be loaded"
    [ ! -e "alone.${missing%:*}" ] || fail "a picture without ${missing#*:}"
    expect_no_leftovers
done
modules=$(dirname "$SCNRENDER")/../lib/scnrender
for only in png.png exr.exr oiio.exr; do
    mkdir "$only"
    [ -e "$modules/scn_${only%.*}.so" ] && cp "$modules/scn_${only%.*}.so" "$only"
    SCNRENDER_MODULES="$work/$only"
    ./alone ball.scn -o "$only/alone.${only#*.}" >out 2>err
    code=$?
    last="with ${only%.*} alone"
    expect_code 0
    [ -s "$only/alone.${only#*.}" ] || fail "$last: no picture"
done
[ "$(png_size png.png/alone.png)" = 32x20 ] || fail "alone.png is $(png_size png.png/alone.png)"
cmp -s exr.exr/alone.exr oiio.exr/alone.exr && fail "OpenEXR's module isn't used"
finish
