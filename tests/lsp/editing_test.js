// Going to and renaming declarations across files; outline, colors, layout, fixes, tokens, hints.
'use strict';
const test = require('node:test');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const { Client, killLeft, rpc, marked, positionOf, offsetOf, applyEdits } = require('./client');

let client;
test.before(async () => {
  client = await new Client().start();
});
test.after(async () => {
  assert.equal(await client.stop(), 0);
});

const slice = (text, range) => text.slice(offsetOf(text, range.start), offsetOf(text, range.end));

// Opens `text` under a name of its own and asks for something at its mark.
let number = 0;
async function ask(method, text, params = {}) {
  const { text: plain, offset } = text.includes('|') ? marked(text) : { text, offset: 0 };
  const name = `e${++number}.scn`;
  await client.open(name, plain);
  const result = await client.request(method, name,
    { position: positionOf(plain, offset), ...params });
  return { name, text: plain, result };
}

const LIB = '// Warm.\nlet warm = blackbody(2700K)\nfn lamp(at, power = 60W) = point_light {\n' +
  '  position: at, power: power, color: warm\n}\n';
const SCENE = 'import "lib/lamps.scn" as lamps\nlamps.lamp((0, 2, 0), power: 800lm)\n' +
  'let bright = lamps.warm\nplane { material: lambert { color: bright } }\n';

test('definitions and references across files, open or not', async () => {
  client.write('lib/lamps.scn', LIB);
  client.write('other.scn', 'import "lib/lamps.scn" as l\nl.lamp((1, 2, 0))\n');
  await client.open('scene.scn', SCENE);
  const at = (mark, shift = 0) => positionOf(SCENE, SCENE.indexOf(mark) + shift);
  const lamp = await client.request('textDocument/definition', 'scene.scn',
    { position: at('lamp(', 1) });
  assert.equal(lamp.uri, client.uri('lib/lamps.scn'));
  assert.equal(slice(LIB, lamp.range), 'lamp');
  const argument = await client.request('textDocument/definition', 'scene.scn',
    { position: at('power:', 2) });
  assert.equal(slice(LIB, argument.range), 'power');
  assert.equal(argument.range.start.line, 2);
  const file = await client.request('textDocument/definition', 'scene.scn',
    { position: at('lamps.scn', 1) });
  assert.equal(file.uri, client.uri('lib/lamps.scn'));
  const namespace = await client.request('textDocument/definition', 'scene.scn',
    { position: at('lamps.warm', 1) });
  assert.equal(slice(SCENE, namespace.range), 'lamps');
  assert.equal(namespace.range.start.line, 0);
  const uses = await client.request('textDocument/references', 'scene.scn',
    { position: at('lamp(', 1), context: { includeDeclaration: true } });
  assert.deepEqual(uses.map((use) => path.basename(use.uri)).sort(),
    ['lamps.scn', 'other.scn', 'scene.scn']);
  const without = await client.request('textDocument/references', 'scene.scn',
    { position: at('lamp(', 1), context: { includeDeclaration: false } });
  assert.equal(without.length, 2);
  const marks = await client.request('textDocument/documentHighlight', 'scene.scn',
    { position: at('bright') });
  assert.deepEqual(marks.map((mark) => slice(SCENE, mark.range)), ['bright', 'bright']);
});

test('renaming in all files that use the name', async () => {
  const at = (mark, shift = 0) => positionOf(SCENE, SCENE.indexOf(mark) + shift);
  const range = await client.request('textDocument/prepareRename', 'scene.scn',
    { position: at('lamp(', 1) });
  assert.equal(slice(SCENE, range), 'lamp');
  const edit = await client.request('textDocument/rename', 'scene.scn',
    { position: at('lamp(', 1), newName: 'bulb' });
  assert.equal(applyEdits(SCENE, edit.changes[client.uri('scene.scn')]),
    SCENE.replace('.lamp(', '.bulb('));
  assert.equal(applyEdits(LIB, edit.changes[client.uri('lib/lamps.scn')]),
    LIB.replace('fn lamp', 'fn bulb'));
  assert.equal(edit.changes[client.uri('other.scn')].length, 1);
  const parameter = await client.request('textDocument/rename', 'scene.scn',
    { position: at('power:', 1), newName: 'strength' });
  assert.equal(applyEdits(LIB, parameter.changes[client.uri('lib/lamps.scn')]),
    LIB.replace('power = 60W', 'strength = 60W').replace('power: power', 'power: strength'));
  assert.equal(applyEdits(SCENE, parameter.changes[client.uri('scene.scn')]),
    SCENE.replace('power: 800lm', 'strength: 800lm'));
});

test('renaming is refused where it would change what something means', async () => {
  const text = 'let a = 1\nlet b = 2\nfn f(c) = a + |b + c\nsphere { radius: f(1) }\n';
  for (const [newName, message] of [['a', /taken/], ['c', /taken/], ['1x', /letters/],
    ['with', /reserved/], ['', /letters/]]) {
    await assert.rejects(ask('textDocument/rename', text, { newName }), message, newName);
  }
  const good = await ask('textDocument/rename', text, { newName: 'bb' });
  assert.equal(applyEdits(good.text, good.result.changes[client.uri(good.name)]),
    marked(text).text.replace('let b', 'let bb').replace('+ b', '+ bb'));
  assert.equal((await ask('textDocument/prepareRename', 'sph|ere {}')).result, null);
});

test('an outline with what is inside', async () => {
  const { result } = await ask('textDocument/documentSymbol', `param count: int = 3 in 1..9
let clay = lambert { color: #c0704a }
fn ball(i) = sphere { center: (i, 0, 0) }
group {
  sphere { name: "left" }
  for (i in 0..<count) { ball(i) }
}
`);
  const shape = (list) => list.map((symbol) =>
    symbol.children ? [symbol.name, shape(symbol.children)] : symbol.name);
  assert.deepEqual(shape(result),
    ['count', 'clay', 'ball', ['group', ['left', ['for (i in 0..<count)', ['ball']]]]]);
  assert.equal(result[1].detail, 'lambert');
  const symbols = await client.connection.sendRequest('workspace/symbol', { query: 'wrm' });
  assert.ok(symbols.some((symbol) => symbol.name === 'warm'));
});

test('swatches of all colors that are written out, and the ways to write one', async () => {
  const text = `let a = lambert { color: #c0704a }
let b = lambert { color: rgb(0.2159, 0, 1) }
let c = lambert { color: srgb(0.5, 0, 1) }
let d = lambert { color: hsv(120deg, 1, 1) }
let e = lambert { color: gray(1/2) }
let f = emissive { radiance: rgb(20, 10, 5) }
fn g(x) = lambert { color: rgb(x, 0, 0) }
`;
  const { name, result } = await ask('textDocument/documentColor', text);
  const found = result.map((swatch) => slice(text, swatch.range));
  assert.deepEqual(found, ['#c0704a', 'rgb(0.2159, 0, 1)', 'srgb(0.5, 0, 1)',
    'hsv(120deg, 1, 1)', 'gray(1/2)', 'rgb(20, 10, 5)']);
  const near = (color, r, g, b) => [r, g, b].forEach((c, i) =>
    assert.ok(Math.abs([color.red, color.green, color.blue][i] - c) < 2e-3, JSON.stringify(color)));
  near(result[0].color, 0xc0 / 255, 0x70 / 255, 0x4a / 255);
  near(result[1].color, 0.5024, 0, 1);
  near(result[2].color, 0.5, 0, 1);
  near(result[3].color, 0, 1, 0);
  near(result[4].color, 0.7354, 0.7354, 0.7354);
  const presentations = (range, red, green, blue) =>
    client.request('textDocument/colorPresentation', name,
      { range, color: { red, green, blue, alpha: 1 } });
  const hex = await presentations(result[0].range, 1, 0.5, 0);
  assert.deepEqual(hex.map((form) => form.label), ['#ff8000', 'rgb(1, 0.214, 0)',
    'srgb(1, 0.5, 0)', 'hsv(12.84deg, 1, 1)']);
  assert.match(applyEdits(text, [hex[0].textEdit]), /color: #ff8000 }/);
  assert.equal((await presentations(result[4].range, 0.5, 0.5, 0.5))[0].label, 'gray(0.214)');
  const bright = await presentations(result[5].range, 1, 1, 0);
  assert.deepEqual(bright.map((form) => form.label), ['rgb(20, 20, 0)', 'hsv(60deg, 1, 20)']);
});

test('formatting as `scnrender fmt`, whole and in part', async () => {
  const text = 'sphere{radius:1}\n\n\n\nplane   {  }\n// 𝒔 stays\nbox{min:(0,0,0),max:(1,1,1)}\n';
  const whole = await ask('textDocument/formatting', text,
    { options: { tabSize: 2, insertSpaces: true } });
  assert.equal(applyEdits(text, whole.result),
    'sphere { radius: 1 }\n\nplane {}\n// 𝒔 stays\nbox { min: (0, 0, 0), max: (1, 1, 1) }\n');
  const range = { start: { line: 6, character: 0 }, end: { line: 7, character: 0 } };
  const part = await ask('textDocument/rangeFormatting', text, { range, options: {} });
  assert.equal(applyEdits(text, part.result), text.replace('box{min:(0,0,0),max:(1,1,1)}',
    'box { min: (0, 0, 0), max: (1, 1, 1) }'));
  assert.deepEqual((await ask('textDocument/formatting', 'plane {}\n')).result, []);
  await assert.rejects(ask('textDocument/formatting', 'plane {\n'), /errors of syntax/);
});

test('a fix for each suggestion, and all at once', async () => {
  const text = 'let x: number = 1\nsphere { radus = x }\ncamera { position: (0, 0, 1), fov: 40 }\n';
  await client.open('fixes.scn', text);
  const list = await client.current('fixes.scn',
    (items) => items.some((item) => item.code === 'E0301'));
  let fixed = text;
  for (const diagnostic of list) {
    const actions = await client.request('textDocument/codeAction', 'fixes.scn',
      { range: diagnostic.range, context: { diagnostics: [diagnostic] } });
    assert.ok(actions.length > 0, diagnostic.message);
    assert.equal(actions[0].kind, 'quickfix');
    assert.equal(actions[0].diagnostics[0].code, diagnostic.code);
  }
  const [all] = await client.request('textDocument/codeAction', 'fixes.scn',
    { range: list[0].range, context: { diagnostics: [], only: ['source.fixAll'] } });
  fixed = applyEdits(text, all.edit.changes[client.uri('fixes.scn')]);
  assert.equal(fixed,
    'let x = 1\nsphere { radius : x }\ncamera { position: (0, 0, 1), fov: 40 }\n');
  await client.change('fixes.scn', [{ text: fixed }]);
  const [angle] = await client.current('fixes.scn',
    (items) => items.some((item) => item.code === 'E0403'));
  const [degrees] = await client.request('textDocument/codeAction', 'fixes.scn',
    { range: angle.range, context: { diagnostics: [angle] } });
  assert.equal(applyEdits(fixed, degrees.edit.changes[client.uri('fixes.scn')]),
    fixed.replace('fov: 40', 'fov: 40deg'));
  const missing = await ask('textDocument/codeAction', 'torus {}\nlet y = 1\n', {
    range: { start: { line: 0, character: 0 }, end: { line: 1, character: 9 } },
    context: { diagnostics: [] },
  });
  const edits = missing.result.map((action) =>
    applyEdits(missing.text, action.edit.changes[client.uri(missing.name)]));
  assert.deepEqual(edits.sort(), ['torus { major_radius: , minor_radius: }\nlet y = 1\n',
    'torus {}\nlet _y = 1\n'].sort());
});

// The tokens as [text, type, modifiers].
function decode(text, data) {
  const legend = client.info.capabilities.semanticTokensProvider.legend;
  const lines = text.split('\n');
  let line = 0, character = 0;
  const tokens = [];
  for (let i = 0; i < data.length; i += 5) {
    character = data[i] ? data[i + 1] : character + data[i + 1];
    line += data[i];
    tokens.push([lines[line].slice(character, character + data[i + 2]),
      legend.tokenTypes[data[i + 3]],
      legend.tokenModifiers.filter((_, bit) => data[i + 4] >> bit & 1).join(' ')]);
  }
  return tokens;
}

test('semantic tokens, whole, in part, and what changed', async () => {
  const text = `/* a
𝒔 */ import "lib/lamps.scn" as lamps // end
param n: int = 3 in 1..9
fn f(x) = sphere { radius: x * pi, material: ggx { alpha: max(n, 2mm) } }
f(x: 1)
lamps.lamp((0, 0, 0))
`;
  const { name, result } = await ask('textDocument/semanticTokens/full', text);
  const tokens = decode(text, result.data);
  for (const expected of [['/* a', 'comment', ''], ['𝒔 */', 'comment', ''],
    ['import', 'keyword', ''], ['"lib/lamps.scn"', 'string', ''],
    ['lamps', 'namespace', 'declaration'], ['// end', 'comment', ''],
    ['n', 'variable', 'declaration readonly'], ['int', 'type', 'defaultLibrary'],
    ['3', 'number', ''], ['f', 'function', 'declaration'], ['x', 'parameter', 'declaration'],
    ['sphere', 'type', 'defaultLibrary'], ['radius', 'property', ''], ['x', 'parameter', ''],
    ['*', 'operator', ''], ['pi', 'variable', 'readonly defaultLibrary'],
    ['max', 'function', 'defaultLibrary'], ['2mm', 'number', ''], ['f', 'function', ''],
    ['lamps', 'namespace', ''], ['lamp', 'function', '']]) {
    assert.ok(tokens.some((token) => JSON.stringify(token) === JSON.stringify(expected)),
      `${expected} in ${JSON.stringify(tokens)}`);
  }
  const part = await client.request('textDocument/semanticTokens/range', name,
    { range: { start: { line: 4, character: 0 }, end: { line: 5, character: 0 } } });
  assert.deepEqual(decode(text, part.data).map((token) => token[0]), ['f', 'x', '1']);
  const at = positionOf(text, text.indexOf('f(x: 1)'));
  await client.change(name, [{ range: { start: at, end: at }, text: '// new\n' }]);
  const delta = await client.request('textDocument/semanticTokens/full/delta', name,
    { previousResultId: result.resultId });
  const data = [...result.data];
  for (const edit of delta.edits) data.splice(edit.start, edit.deleteCount, ...edit.data);
  const whole = await client.request('textDocument/semanticTokens/full', name);
  assert.deepEqual(data, whole.data);
  assert.ok(delta.edits[0].data.length < 20);
});

test('inlay hints: values, names of parameters, quantities', async () => {
  const text = `let r = 20cm + 5cm
let plain = 3
fn lamp(at, power = 60W) = point_light { position: at, power: power }
lamp((0, 2, 0), 800lm)
for (i in 0..<4) {
  let k = i * 2
  sphere { radius: r + k * 1m + plain * 1m, center: (0.5 * i, 0, 0) }
}
let t = 0.25turn
let _unused = t
`;
  await client.open('hints.scn', text);
  const range = { start: { line: 0, character: 0 }, end: positionOf(text, text.length) };
  let hints;
  for (let tries = 0; tries < 200; ++tries) {
    hints = await client.request('textDocument/inlayHint', 'hints.scn', { range });
    if (hints.some((hint) => hint.label.includes('0.25m'))) break;
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  const told = hints.map((hint) => [hint.position.line, hint.label]);
  for (const expected of [[0, '= 0.25m'], [3, 'at:'], [3, 'power:'], [3, '≙ 1.171 W'],
    [5, '= 0, …'], [8, '= 90deg'], [9, '= 90deg']]) {
    assert.ok(told.some((hint) => JSON.stringify(hint) === JSON.stringify(expected)),
      `${expected} in ${JSON.stringify(told)}`);
  }
  assert.ok(!told.some((hint) => hint[0] === 1));
});

test('folding, growing selections, links', async () => {
  client.write('wood.png', 'x');
  const text = `// one
// two
group {
  sphere {
    center: (0, 1, 0)
  }
}
let t = image { file: "wood.png" }
import "lib/lamps.scn" as lamps
`;
  const folds = await ask('textDocument/foldingRange', text);
  assert.deepEqual(folds.result.map((fold) => [fold.startLine, fold.endLine, fold.kind]).sort(),
    [[0, 1, 'comment'], [2, 5, undefined], [3, 4, undefined]]);
  const [selection] = (await ask('textDocument/selectionRange', text,
    { positions: [positionOf(text, text.indexOf('1, 0)'))] })).result;
  const grown = [];
  for (let range = selection; range; range = range.parent) grown.push(slice(text, range.range));
  assert.equal(grown[0], '1');
  assert.equal(grown[1], '(0, 1, 0)');
  assert.equal(grown[2], 'center: (0, 1, 0)');
  assert.match(grown[3], /^sphere \{[^]*\}$/);
  assert.equal(grown[grown.length - 1], text);
  const links = (await ask('textDocument/documentLink', text)).result;
  assert.deepEqual(links.map((link) => [slice(text, link.range), link.target]),
    [['wood.png', client.uri('wood.png')], ['lib/lamps.scn', client.uri('lib/lamps.scn')]]);
});

test('every feature takes every prefix of a scene', async () => {
  const source = fs.readFileSync(path.join(process.env.SOURCE_DIR, 'examples/language_tour.scn'),
    'utf8');
  await client.open('prefix.scn', '');
  const range = { start: { line: 0, character: 0 }, end: { line: 9999, character: 0 } };
  const step = process.env.SANITIZE ? 173 : 37;
  for (let length = 1; length < source.length; length += step) {
    const text = source.slice(0, length);
    await client.change('prefix.scn', [{ text }]);
    const position = positionOf(text, length);
    const params = { position, range, positions: [position], context: { diagnostics: [] },
      options: {}, color: { red: 1, green: 0, blue: 0, alpha: 1 }, newName: 'x',
      previousResultId: '1' };
    await Promise.all(['completion', 'hover', 'signatureHelp', 'definition', 'references',
      'documentHighlight', 'prepareRename', 'rename', 'documentSymbol', 'documentColor',
      'colorPresentation', 'formatting', 'rangeFormatting', 'codeAction', 'semanticTokens/full',
      'semanticTokens/full/delta', 'semanticTokens/range', 'inlayHint', 'foldingRange',
      'selectionRange', 'documentLink'].map((method) =>
      client.request(`textDocument/${method}`, 'prefix.scn', params).catch((error) => {
        assert.ok(error instanceof rpc.ResponseError, error);
      })));
  }
});

test.after(killLeft);
