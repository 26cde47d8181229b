. "$SOURCE_DIR/tests/cli/support.sh"
last="cmake --install"
DESTDIR='' cmake --install "$BUILD_DIR" --prefix "$work/prefix" >out 2>err || { fail "it can't be installed"; cat err >&2; }
unset SCNRENDER_MODULES
for file in bin/scnrender share/bash-completion/completions/scnrender \
    share/zsh/site-functions/_scnrender share/fish/vendor_completions.d/scnrender.fish share/man/man1/scnrender.1 share/scnrender/examples/first_light.scn share/scnrender/std/metals.scn; do
    [ -f "prefix/$file" ] || fail "no $file"
done
for module in scn_png scn_exr scn_oiio scn_assimp; do
    [ -n "$(find prefix -path "*/scnrender/$module.so")" ] || fail "no $module.so"
done
cp prefix/share/scnrender/examples/first_light.scn .
last="the installed program"
./prefix/bin/scnrender first_light.scn --samples 1 --size 16x10 >out 2>err
code=$?
expect_code 0
[ "$(png_size first_light.png)" = 16x10 ] || fail "no picture"
mv prefix moved
rm first_light.png
printf 'import "std/metals.scn" as metals\nsphere { material: metals.gold }\n' >gold.scn
last="the installed program, moved"
./moved/bin/scnrender first_light.scn --samples 1 --size 16x10 >out 2>err
code=$?
expect_code 0
./moved/bin/scnrender first_light.scn --samples 1 --size 16x10 -o first_light.exr >out 2>err
code=$?
expect_code 0
[ -s first_light.exr ] || fail "no EXR"
./moved/bin/scnrender check gold.scn >out 2>err
code=$?
expect_code 0
finish
