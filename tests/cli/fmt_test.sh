. "$SOURCE_DIR/tests/cli/support.sh"
printf 'sphere{radius:1,\n}  // ball\n' >messy.scn
printf 'sphere {\n  radius: 1\n} // ball\n' >tidy.scn
cp messy.scn first.scn

run fmt --check messy.scn tidy.scn
expect_code 1
[ "$(cat out)" = messy.scn ] || fail "$last: $(cat out)"
cmp -s messy.scn first.scn || fail "$last changed the file"

run fmt --diff messy.scn tidy.scn
expect_code 0
printf -- '--- messy.scn\n+++ messy.scn\n@@ -1,2 +1,3 @@\n-sphere{radius:1,\n-}  // ball\n+sphere {\n+  radius: 1\n+} // ball\n' >expected
cmp -s out expected || { fail "$last:"; cat out >&2; }
cmp -s messy.scn first.scn || fail "$last changed the file"
if command -v patch >/dev/null; then
    cp messy.scn patched.scn
    patch -s patched.scn <out || fail "patch refuses the diff"
    cmp -s patched.scn tidy.scn || fail "the diff leads elsewhere"
fi
run fmt --check --diff messy.scn
expect_code 1
expect_text out "@@"

# In place: a link stays, permissions stay, what is tidy isn't touched.
chmod 640 messy.scn
ln -s messy.scn link.scn
touch -d '2001-02-03 04:05:06' tidy.scn
before=$(ls -l --time-style=full-iso tidy.scn; ls -i tidy.scn)
run fmt link.scn tidy.scn
expect_code 0
expect_text err "formatted link.scn"
expect_no_text err tidy
cmp -s messy.scn tidy.scn || { fail "$last:"; cat messy.scn >&2; }
[ -L link.scn ] || fail "$last replaced the link"
[ "$(stat -c %a messy.scn)" = 640 ] || fail "$last changed the permissions"
[ "$(ls -l --time-style=full-iso tidy.scn; ls -i tidy.scn)" = "$before" ] || fail "$last touched a tidy file"
expect_no_leftovers
cp first.scn messy.scn
run fmt -q messy.scn
expect_code 0
expect_empty err
run fmt --check messy.scn
expect_code 0
expect_empty out

# From standard input to standard output.
last="fmt -"
"$SCNRENDER" fmt - <first.scn >out 2>err
code=$?
expect_code 0
cmp -s out tidy.scn || fail "$last: $(cat out)"
"$SCNRENDER" fmt --check - <first.scn >out 2>err
code=$?
expect_code 1
expect_text out "<stdin>"

# Errors of syntax: the file is left alone, the others are formatted.
printf 'sphere { radius: }\n' >broken.scn
cp broken.scn first_broken.scn
cp first.scn messy.scn
run fmt broken.scn messy.scn
expect_code 1
expect_text err "error[E0201]"
expect_text err "broken.scn:1:18"
cmp -s broken.scn first_broken.scn || fail "$last changed a file with errors"
cmp -s messy.scn tidy.scn || fail "$last stopped at the first file"
run fmt broken.scn --diagnostics json
expect_code 1
expect_text err '"code":"E0201"'
# Errors of meaning are none of its business.
run fmt wrong.scn
expect_code 0
expect_text wrong.scn "sphere { radus: 1 } // wrong"

run fmt missing.scn tidy.scn
expect_code 3
expect_text err missing.scn
run fmt
expect_code 2
run fmt tidy.scn --samples 3
expect_code 2
if [ "$(id -u)" != 0 ]; then
    mkdir shut && cp first.scn shut/messy.scn && chmod 555 shut
    run fmt shut/messy.scn
    expect_code 3
    cmp -s shut/messy.scn first.scn || fail "$last changed the file"
    chmod 755 shut
fi

# A nest deeper than the limit, and one under a raised limit.
{ printf 'let a = '; printf '[%.0s' $(seq 300); printf ']%.0s' $(seq 300); echo; } >deep.scn
run fmt deep.scn
expect_code 1
run fmt --limit nesting=400 deep.scn
expect_code 0

# The first examples are formatted.
for name in cornell_box first_light image_textures instances language_tour sphere_flake units \
    lib/paints textures/tiles; do
    run fmt --check "$SOURCE_DIR/examples/$name.scn"
    expect_code 0
done
finish
