// Completion, hover and signatures: from the tables of kinds and functions, and from the scene.
'use strict';
const test = require('node:test');
const assert = require('node:assert/strict');
const { Client, killLeft, CAPABILITIES, marked, positionOf, applyEdits } = require('./client');

let client;
test.before(async () => {
  client = await new Client().start();
});
test.after(async () => {
  assert.equal(await client.stop(), 0);
});

let number = 0;
// Opens a text with a `|` and gives the file's name and the position of the mark.
async function open(text) {
  const { text: plain, offset } = marked(text);
  const name = `c${++number}.scn`;
  await client.open(name, plain);
  return { name, text: plain, position: positionOf(plain, offset) };
}

async function complete(text) {
  const at = await open(text);
  const { items } = await client.request('textDocument/completion', at.name,
    { position: at.position });
  return { ...at, items, labels: items.map((item) => item.label) };
}

// The text with the item called `label` put in, snippets' stops taken out.
function accept({ text, items }, label) {
  const item = items.find((other) => other.label === label);
  assert.ok(item, `no ${label} among ${items.map((other) => other.label)}`);
  return applyEdits(text, [item.textEdit]).replace(/\$\d/g, '');
}

test('items: kinds that can stand as statements, names, words', async () => {
  const found = await complete('let red = lambert {}\nsph|');
  assert.ok(found.labels.includes('sphere'));
  assert.ok(found.labels.includes('film'));
  assert.ok(found.labels.includes('let'));
  assert.ok(found.labels.includes('import'));
  assert.ok(found.labels.includes('red'));
  assert.ok(!found.labels.includes('ggx'), 'a material is no item');
  assert.equal(accept(found, 'sphere'), 'let red = lambert {}\nsphere {  }');
  assert.equal(accept(await complete('torus|'), 'torus'),
    'torus { major_radius: , minor_radius:  }');
});

test('fields: those not given, with type, unit, default and manual', async () => {
  const found = await complete('sphere { center: (0, 0, 0), ra| }');
  assert.ok(!found.labels.includes('center'));
  assert.ok(found.labels.includes('material'));
  const radius = found.items.find((item) => item.label === 'radius');
  assert.match(radius.detail, /length, bare in m; above 0; default 1/);
  assert.ok(radius.documentation.value.length > 3);
  assert.equal(accept(found, 'radius'), 'sphere { center: (0, 0, 0), radius:  }');
  const half = await complete('sphere {\n  radius: 1\n  |\n}\nplane {}\n');
  assert.ok(half.labels.includes('center') && !half.labels.includes('radius'));
  const open = await complete('sphere {\n  ce|');
  assert.ok(open.labels.includes('center'));
  const group = await complete('group { transform: translate(1, 0, 0)  | }');
  assert.ok(group.labels.includes('sphere') && group.labels.includes('material'));
  const copy = await complete('let gold = ggx { alpha: 0.2 }\nsphere { material: gold with { al| } }');
  assert.ok(copy.labels.includes('alpha'));
  const colon = await complete('sphere { ra|: 2 }');
  assert.equal(accept(colon, 'radius'), 'sphere { radius: 2 }');
});

test('values: what the field takes comes first', async () => {
  const found = await complete('let red = lambert {}\nlet n = 3\nsphere { material: | }');
  const first = found.items.filter((item) => item.sortText.startsWith('0'))
    .map((item) => item.label);
  assert.ok(first.includes('red') && first.includes('ggx') && first.includes('lambert'));
  assert.ok(!first.includes('n') && !first.includes('sphere'));
  const color = await complete('let m = lambert { color: | }');
  const colors = color.items.filter((item) => item.sortText.startsWith('0'))
    .map((item) => item.label);
  assert.ok(colors.includes('rgb') && colors.includes('blackbody') && colors.includes('checker'));
  assert.equal(accept(color, 'srgb'), 'let m = lambert { color: srgb() }');
  const choice = await complete('camera { position: (0, 0, 1), projection: | }');
  assert.ok(choice.labels.includes('"fisheye"'));
  assert.equal(choice.items.find((item) => item.label === '"perspective"').detail, 'default');
  const text = await complete('camera { position: (0, 0, 1), projection: "f|" }');
  assert.equal(accept(text, 'fisheye'), 'camera { position: (0, 0, 1), projection: "fisheye" }');
  const bool = await complete('mesh { smooth: | }');
  assert.ok(bool.items.find((item) => item.label === 'true').sortText.startsWith('0'));
});

test('units behind a number, those of the field first', async () => {
  const found = await complete('camera { position: (0, 0, 1), fov: 40| }');
  assert.ok(found.labels.includes('deg') && found.labels.includes('lm'));
  assert.ok(found.items.find((item) => item.label === 'deg').sortText.startsWith('0'));
  assert.ok(!found.items.find((item) => item.label === 'lm').sortText.startsWith('0'));
  assert.equal(accept(found, 'deg'), 'camera { position: (0, 0, 1), fov: 40deg }');
  assert.equal(accept(await complete('let a = 1.5e3c|'), 'cm'), 'let a = 1.5e3cm');
});

test('names in scope: parameters, loop variables, and not what is elsewhere', async () => {
  const found = await complete('fn f(a, b = 2) = sphere { radius: | }\nfn g(other) = other\n');
  assert.ok(found.labels.includes('a') && found.labels.includes('b') && found.labels.includes('g'));
  assert.ok(!found.labels.includes('other'));
  const loop = await complete('for (i in 0..<3) {\n  let k = i\n  sphere { radius: k + |\n}\n');
  assert.ok(loop.labels.includes('i') && loop.labels.includes('k'));
  const named = await complete('fn lamp(at, power = 60W) = point_light { position: at, power: power }\nlamp((0, 1, 0), |)');
  assert.ok(named.labels.includes('power: '));
  for (const nothing of ['let |', 'fn |', 'import "a" as |', '// a |', 'fn f(|', 'for (|', '1|5']) {
    assert.deepEqual((await complete(nothing)).labels, [], nothing);
  }
  assert.deepEqual((await complete('import "a.scn" |')).labels, ['as']);
  assert.ok((await complete('param n: |')).labels.includes('luminous_flux'));
});

test('members of an import, and of values', async () => {
  client.write('metals.scn', '// Polished.\nlet gold = ggx {}\nfn brushed(alpha) = ggx { alpha: alpha }\n');
  const found = await complete('import "metals.scn" as metals\nsphere { material: metals.| }');
  assert.deepEqual(found.labels.sort(), ['brushed', 'gold']);
  assert.match(found.items.find((item) => item.label === 'gold').documentation.value, /Polished/);
  const parts = await complete('let v = (1, 2, 3)\nlet x = v.|');
  assert.ok(parts.labels.includes('x'));
});

test('files in strings: below the scene, and only there', async () => {
  client.write('textures/wood.png', 'x');
  client.write('textures/more/a.png', 'x');
  client.write('lib/parts.scn', '');
  const folder = await complete('let t = image { file: "tex|" }');
  assert.equal(accept(folder, 'textures/'), 'let t = image { file: "textures/" }');
  const inside = await complete('let t = image { file: "textures/w|" }');
  assert.deepEqual(inside.labels.sort(), ['more/', 'wood.png']);
  assert.equal(accept(inside, 'wood.png'), 'let t = image { file: "textures/wood.png" }');
  const scenes = await complete('import "lib/|" as lib');
  assert.deepEqual(scenes.labels, ['parts.scn']);
  assert.deepEqual((await complete('let t = image { file: "../|" }')).labels, []);
  assert.deepEqual((await complete('let t = image { file: "/etc/|" }')).labels, []);
  const half = await complete('let t = image { file: "textures/|');
  assert.ok(half.labels.includes('wood.png'));
});

test('resolving a kind gives its manual', async () => {
  const found = await complete('sph|');
  const item = found.items.find((other) => other.label === 'sphere');
  const resolved = await client.connection.sendRequest('completionItem/resolve', item);
  assert.match(resolved.documentation.value, /\| `radius` \|/);
});

async function hover(text) {
  const at = await open(text);
  const result = await client.request('textDocument/hover', at.name, { position: at.position });
  return result && result.contents.value;
}

test('hover: the manual, declarations with comments, values', async () => {
  assert.match(await hover('sphe|re {}'), /### `sphere`[^]*radius/);
  assert.match(await hover('sphere { rad|ius: 1 }'), /`radius`: length, bare in m; above 0; default 1/);
  assert.match(await hover('sphere { na|me: "x" }'), /A name for messages/);
  assert.match(await hover('let a = cla|mp(1, 2, 3)'), /clamp\(x, low, high\)/);
  assert.match(await hover('let a = p|i'), /3\.14159/);
  assert.match(await hover('let a = 40|deg'), /an angle, 0\.698131\d* rad, 40deg/);
  assert.match(await hover('let a = #ff|8000'), /linear: rgb\(1, 0\.2159, 0\)/);
  assert.match(await hover('// How wide.\nlet a = 25cm\nlet b = |a'), /let a = 25cm[^]*How wide\./);
  assert.match(await hover('fn f(x, y = 2) = x + y\nlet b = |f(1)'), /```scn\nfn f\(x, y = 2\)\n```/);
  assert.match(await hover('fn f(x, y = 2) = x + |y'), /parameter y = 2/);
  assert.match(await hover('for (i in 0..<3) { sphere { radius: |i + 1 } }'), /for i in 0\.\.<3/);
  assert.match(await hover('le|t a = 1'), /let name = value/);
  assert.match(await hover('param n: in|t = 3'), /A whole number/);
  assert.match(await hover('sphere { ra|dus: 1 }'), /E0301: /);
  assert.equal(await hover('sphere {} |'), null);
});

test('hover tells what a name came to', async () => {
  const { text, offset } = marked('let r = 20cm + 5cm\nlet s = |r * 2\nsphere { radius: s }\n');
  await client.open('value.scn', text);
  const position = positionOf(text, offset);
  for (let tries = 0; ; ++tries) {
    const result = await client.request('textDocument/hover', 'value.scn', { position });
    if (/a length: 0\.25m/.test(result.contents.value)) break;
    assert.ok(tries < 200, result.contents.value);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
});

async function help(text) {
  const at = await open(text);
  return client.request('textDocument/signatureHelp', at.name, { position: at.position });
}

function active(signatures) {
  const signature = signatures.signatures[signatures.activeSignature];
  const parameter = signature.parameters[signatures.activeParameter];
  return parameter && signature.label.slice(...parameter.label);
}

test('signatures: built-in and own functions, by place and by name', async () => {
  assert.equal(active(await help('let a = clamp(1, |')), 'low');
  assert.equal(active(await help('let a = clamp(1, (2, 3), |)')), 'high');
  assert.equal(active(await help('let a = min(1, 2, 3, |)')), '…');
  assert.equal(active(await help('let a = hypot(1, 2, |)')), 'z');
  assert.equal(active(await help('fn f(x, y = 2) = x\nlet a = f(|)')), 'x');
  assert.equal(active(await help('fn f(x, y = (1, 2)) = x\nlet a = f(1, |)')), 'y = (1, 2)');
  assert.equal(active(await help('fn f(x, y = 2) = x\nlet a = f(y: |)')), 'y = 2');
  assert.equal(active(await help('fn f(x) = x\nlet a = f(1, |)')), undefined);
  assert.equal(active(await help('import "metals.scn" as m\nlet a = m.brushed(|)')), 'alpha');
  assert.equal(await help('let a = (1, |'), null);
  assert.equal(await help('sphere { |'), null);
});

test('of very many names those that match are listed, and the list is asked for again', async () => {
  const itemDefaults = ['editRange'];
  const capabilities = structuredClone(CAPABILITIES);
  capabilities.textDocument.completion.completionList = { itemDefaults };
  const other = await new Client({ capabilities }).start();
  const lets = Array.from({ length: 1000 }, (_, i) => `let name_${i} = ${i}`).join('\n');
  const text = `${lets}\nlet x = nm99`;
  await other.open('many.scn', text);
  const list = await other.request('textDocument/completion', 'many.scn',
    { position: positionOf(text, text.length) });
  assert.equal(list.isIncomplete, true);
  const names = list.items.filter((item) => item.label.startsWith('name_'));
  assert.ok(names.length < 350 && names.some((item) => item.label === 'name_999'));
  const { start, end } = list.itemDefaults.editRange;
  assert.deepEqual([start.character, end.character], [8, 12]);
  assert.ok(list.items.every((item) => item.textEdit === undefined));
  assert.equal(await other.stop(), 0);
});

test.after(killLeft);
