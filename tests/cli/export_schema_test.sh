# The JSON of every example is what docs/scene.schema.json says.
. "$SOURCE_DIR/tests/cli/support.sh"
schema=$SOURCE_DIR/docs/scene.schema.json
"$JSON_CHECK" <"$schema" || fail "the schema isn't JSON"
scenes=0
for scene in "$SOURCE_DIR"/examples/*.scn "$SOURCE_DIR"/examples/*/*.scn "$SOURCE_DIR"/compare/scenes/*.scn; do
    case $scene in
    */lib/* | *'*'*) continue ;;
    esac
    run export --to json "$scene" -q -o -
    expect_code 0
    [ "$(wc -c <out)" -lt 5000000 ] || continue # more of the same
    "$SCHEMA_CHECK" "$schema" <out || fail "$scene doesn't fit the schema"
    scenes=$((scenes + 1))
done
[ "$scenes" -ge 10 ] || fail "only $scenes scenes"
# The check itself finds mistakes.
run export --to json ball.scn -q -o -
for change in 's/"kind": "sphere"/"kind": 5/' 's/"version": 1/"version": 2/' 's/"light_only"/"light_onli"/' \
    's/"radius": 1/"radius": {"value": 1}/' 's/"hash": "[0-9a-f]*",//'; do
    sed "$change" out >changed
    cmp -s out changed && fail "$change changes nothing"
    "$SCHEMA_CHECK" "$schema" <changed 2>err && fail "$change isn't found"
done
finish
