// Diagnostics as one types: at their places, from open texts, across files, and gone when healed.
'use strict';
const test = require('node:test');
const assert = require('node:assert/strict');
const { Client, killLeft, CAPABILITIES, positionOf } = require('./client');

const codes = (list) => list.map((item) => item.code);

test('a mistake is told with its place, its notes and its suggestion, and heals', async () => {
  const client = await new Client().start();
  const text = 'let size = 1m\n/* größe, 𝒔 is two units wide */ sphere { radus: size }\n';
  await client.open('a.scn', text);
  const [item] = await client.current('a.scn', (list) => list.length > 0);
  assert.equal(item.code, 'E0301');
  assert.equal(item.severity, 1);
  assert.equal(item.source, 'scnrender');
  const begin = text.indexOf('radus');
  assert.deepEqual(item.range,
    { start: positionOf(text, begin), end: positionOf(text, begin + 5) });
  assert.match(item.message, /`radus` is not a field of `sphere`\ndid you mean `radius`\?/);
  assert.match(item.message, /note: sphere takes/);
  const at = positionOf(text, begin + 3);
  await client.change('a.scn', [{ range: { start: at, end: at }, text: 'i' }]);
  assert.deepEqual(await client.current('a.scn'), []);
  assert.equal(await client.stop(), 0);
});

test('what only evaluation finds comes after a pause, and moves with the text', async () => {
  const client = await new Client({ options: { evaluateAfter: 50 } }).start();
  await client.open('a.scn', 'camera { position: (0, 0, 5), look_at: (0, 0, 0), fov: 40 }\n');
  const found = await client.current('a.scn', (list) => codes(list).includes('E0403'));
  assert.equal(found[0].range.start.line, 0);
  const start = { line: 0, character: 0 };
  await client.change('a.scn', [{ range: { start, end: start }, text: '// a line above\n' }]);
  const moved = await client.current('a.scn');
  assert.deepEqual(codes(moved), ['E0403']);
  assert.equal(moved[0].range.start.line, 1);
  assert.equal(await client.stop(), 0);
});

test('a chain of calls is related information', async () => {
  const client = await new Client().start();
  await client.open('a.scn', 'fn ball(r) = sphere { radius: r }\nball(-1)\n');
  const [item] = await client.current('a.scn', (list) => list.length > 0);
  assert.equal(item.code, 'E0404');
  assert.equal(item.range.start.line, 0);
  assert.match(item.relatedInformation[0].message, /in the call of `ball`/);
  assert.equal(item.relatedInformation[0].location.range.start.line, 1);
  await client.stop();
});

test('the text of an open import counts, not the file on the disk', async () => {
  const client = await new Client().start();
  client.write('lib/parts.scn', 'let red = #c00000\n');
  const scene = 'import "lib/parts.scn" as parts\nsphere { material: lambert { color: parts.redd } }\n';
  await client.open('scene.scn', scene);
  await client.current('scene.scn', (list) => codes(list).includes('E0308'));
  await client.open('lib/parts.scn', 'let redd = #c00000\n');
  assert.deepEqual(await client.current('scene.scn', (list) => list.length === 0), []);
  const whole = [{ text: 'let red = #c00000\n' }];
  await client.change('lib/parts.scn', whole);
  await client.current('scene.scn', (list) => codes(list).includes('E0308'));
  await client.change('lib/parts.scn', [{ text: 'let redd = ' }]);
  const broken = await client.current('lib/parts.scn', (list) => list.length > 0);
  assert.equal(broken[0].code, 'E0201');
  await client.close('lib/parts.scn');
  await client.current('scene.scn', (list) => codes(list).includes('E0308'));
  await client.stop();
});

test('mistakes of an import that is not open are shown in its file, and taken back', async () => {
  const client = await new Client().start();
  client.write('parts.scn', 'let red = lambert { colour: #c00000 }\n');
  await client.open('scene.scn', 'import "parts.scn" as parts\nsphere { material: parts.red }\n');
  const inside = await client.diagnostics('parts.scn', (list) => list.length > 0);
  assert.equal(inside[0].code, 'E0301');
  client.write('parts.scn', 'let red = lambert { color: #c00000 }\n');
  await client.connection.sendNotification('workspace/didChangeWatchedFiles',
    { changes: [{ uri: client.uri('parts.scn'), type: 2 }] });
  await client.diagnostics('parts.scn', (list) => list.length === 0);
  await client.stop();
});

test('unused names are marked unnecessary; warnings are warnings', async () => {
  const client = await new Client().start();
  await client.open('a.scn', 'let unused = 1\nsphere {}\n');
  const [item] = await client.current('a.scn', (list) => list.length > 0);
  assert.equal(item.code, 'W0301');
  assert.equal(item.severity, 2);
  assert.deepEqual(item.tags, [1]);
  await client.stop();
});

test('what a file declares to be imported may be unused there', async () => {
  const client = await new Client().start();
  await client.open('lib.scn', 'let a = 1\nfn f(x) { let inner = 2  sphere { radius: x } }\n');
  const list = await client.current('lib.scn', (items) => items.length > 0);
  assert.deepEqual(list.map((item) => [item.code, item.range.start.line]), [['W0301', 1]]);
  await client.change('lib.scn', [{ text: 'let a = 1\nsphere {}\n' }]);
  assert.deepEqual(codes(await client.current('lib.scn', (items) => items.length > 0)), ['W0301']);
  await client.stop();
});

test('positions are bytes where the client can count them', async () => {
  const general = { positionEncodings: ['utf-8', 'utf-16'] };
  const client = await new Client({ capabilities: { ...CAPABILITIES, general } }).start();
  assert.equal(client.info.capabilities.positionEncoding, 'utf-8');
  await client.open('a.scn', '/* größe 𝒔 */ sphere { radus: 1 }\n');
  const [item] = await client.current('a.scn', (list) => list.length > 0);
  assert.equal(item.range.start.character, Buffer.byteLength('/* größe 𝒔 */ sphere { '));
  await client.stop();
});

test('a scene that never ends is given up, and typing goes on', async () => {
  const client = await new Client({ options: { evaluateFor: 200 } }).start();
  const text = 'let n = sum([for (i in 0..<10000) sum([for (j in 0..<10000) i * j])])\n' +
    'sphere { radius: n, center: (0, 0, -1) }\n';
  await client.open('a.scn', text);
  assert.deepEqual(await client.current('a.scn'), []);
  await new Promise((resolve) => setTimeout(resolve, 400));
  await client.change('a.scn', [{ text: 'sphere { radus: 1 }\n' }]);
  assert.deepEqual(codes(await client.current('a.scn', (list) => list.length > 0)), ['E0301']);
  await client.stop();
});

test.after(killLeft);
