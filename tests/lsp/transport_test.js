// The base protocol, from below: frames cut anywhere, things that are no messages, cancelled
// requests, and how the server ends.
'use strict';
const test = require('node:test');
const assert = require('node:assert/strict');
const { spawn } = require('node:child_process');

const started = [];

class Raw {
  constructor(args = ['lsp']) {
    this.process = spawn(process.env.SCNRENDER || 'scnrender', args,
      { stdio: ['pipe', 'pipe', 'inherit'] });
    started.push(this.process);
    this.exited = new Promise((resolve) => this.process.on('exit', resolve));
    this.received = Buffer.alloc(0);
    this.messages = [];
    this.waiting = [];
    this.process.stdout.on('data', (data) => this.take(data));
  }

  take(data) {
    this.received = Buffer.concat([this.received, data]);
    for (;;) {
      const stop = this.received.indexOf('\r\n\r\n');
      if (stop < 0) return;
      const length = Number(/Content-Length: (\d+)/.exec(this.received.subarray(0, stop))[1]);
      if (this.received.length < stop + 4 + length) return;
      this.messages.push(JSON.parse(this.received.subarray(stop + 4, stop + 4 + length)));
      this.received = this.received.subarray(stop + 4 + length);
      this.waiting = this.waiting.filter((wait) => !wait());
    }
  }

  // The first message for which `holds` is true, now or later.
  message(holds) {
    return new Promise((resolve, reject) => {
      const look = () => {
        const found = this.messages.find(holds);
        if (found) {
          clearTimeout(timer);
          resolve(found);
        }
        return Boolean(found);
      };
      const timer = setTimeout(
        () => reject(new Error('not received; there is ' + JSON.stringify(this.messages))), 20000);
      if (!look()) this.waiting.push(look);
    });
  }

  answer(id) {
    return this.message((m) => m.id === id && m.method === undefined);
  }

  bytes(data) {
    this.process.stdin.write(data);
  }

  send(message) {
    const body = Buffer.from(JSON.stringify({ jsonrpc: '2.0', ...message }));
    this.bytes(Buffer.concat([Buffer.from(`Content-Length: ${body.length}\r\n\r\n`), body]));
  }

  async start() {
    this.send({ id: 0, method: 'initialize', params: { capabilities: {} } });
    const { result } = await this.answer(0);
    this.send({ method: 'initialized', params: {} });
    return result;
  }

  async stop() {
    this.send({ id: 'end', method: 'shutdown' });
    await this.answer('end');
    this.send({ method: 'exit' });
    return this.exited;
  }
}

test('shutdown and exit end with 0, exit alone or a closed pipe with 1', async () => {
  const polite = new Raw();
  const result = await polite.start();
  assert.equal(result.capabilities.positionEncoding, 'utf-16');
  assert.equal(result.serverInfo.name, 'scnrender');
  assert.equal(await polite.stop(), 0);
  const hasty = new Raw();
  await hasty.start();
  hasty.send({ method: 'exit' });
  assert.equal(await hasty.exited, 1);
  const gone = new Raw();
  await gone.start();
  gone.process.stdin.end();
  assert.equal(await gone.exited, 1);
});

test('requests out of place are refused', async () => {
  const server = new Raw();
  server.send({ id: 1, method: 'shutdown' });
  assert.equal((await server.answer(1)).error.code, -32002);
  await server.start();
  server.send({ id: 2, method: 'initialize', params: {} });
  assert.equal((await server.answer(2)).error.code, -32600);
  server.send({ id: 3, method: 'textDocument/unheardOf', params: {} });
  assert.equal((await server.answer(3)).error.code, -32601);
  server.send({ id: 4 });
  assert.equal((await server.answer(4)).error.code, -32600);
  server.send({ method: '$/unheardOf' });
  server.send({ id: 'five', method: 'shutdown' });
  assert.equal((await server.answer('five')).result, null);
  server.send({ id: 6, method: 'shutdown' });
  assert.equal((await server.answer(6)).error.code, -32600);
  server.send({ method: 'exit' });
  assert.equal(await server.exited, 0);
});

test('what is no message is answered, and the next one is read', async () => {
  const server = new Raw();
  await server.start();
  server.bytes('Content-Length: 7\r\n\r\n{"id":}');
  assert.equal((await server.message((m) => m.id === null && m.error)).error.code, -32700);
  server.bytes('Content-Length: x\r\n\r\n');
  server.bytes('Content-Type: application/vscode-jsonrpc; charset=utf-8\r\n\r\n');
  server.bytes('nonsense '.repeat(20000) + '\r\n\r\n');
  server.bytes(`Content-Length: ${1 << 30}\r\n\r\n`);
  server.bytes(Buffer.alloc(1 << 20, 'x'));
  server.process.stdin.end();
  assert.equal(await server.exited, 1);
  assert.ok(server.messages.filter((m) => m.error && m.error.code === -32700).length >= 4);
});

test('frames arrive in any pieces', async () => {
  const server = new Raw();
  const body = JSON.stringify({ jsonrpc: '2.0', id: 0, method: 'initialize', params: {} });
  for (const byte of `content-length:${body.length}\r\nOther: 1\r\n\r\n${body}`) {
    server.bytes(byte);
    await new Promise(setImmediate);
  }
  assert.ok((await server.answer(0)).result);
  assert.equal(await server.stop(), 0);
});

test('a request that waits can be cancelled', async () => {
  const server = new Raw();
  await server.start();
  const frame = (message) => {
    const body = JSON.stringify({ jsonrpc: '2.0', ...message });
    return `Content-Length: ${Buffer.byteLength(body)}\r\n\r\n${body}`;
  };
  server.bytes(frame({ id: 'first', method: 'a/b' }) + frame({ id: 'second', method: 'a/b' }) +
    frame({ method: '$/cancelRequest', params: { id: 'second' } }) +
    frame({ method: '$/cancelRequest', params: { id: 'unknown' } }) +
    frame({ method: '$/cancelRequest' }));
  assert.equal((await server.answer('first')).error.code, -32601);
  assert.equal((await server.answer('second')).error.code, -32800);
  assert.equal(await server.stop(), 0);
});

test('params of the wrong shape do no harm', async () => {
  const server = new Raw();
  await server.start();
  for (const params of [null, 1, 'x', [], {}, { textDocument: 1 }, { textDocument: { uri: 1 } },
    { textDocument: { uri: 'file:///nowhere.scn', text: 1 } },
    { textDocument: { uri: 'untitled:Untitled-1', text: 'sphere {' }, contentChanges: 1 },
    { textDocument: { uri: 'untitled:Untitled-1' }, contentChanges: [1, {}, { text: 1 },
      { range: 1, text: 'x' }, { range: { start: { line: -1, character: 1e300 } }, text: '€' }] },
    { settings: { scnrender: { evaluateAfter: 'x' } } }, { changes: [1] }, { event: 1 }]) {
    for (const method of ['textDocument/didOpen', 'textDocument/didChange',
      'textDocument/didSave', 'textDocument/didClose', 'workspace/didChangeConfiguration',
      'workspace/didChangeWatchedFiles', 'workspace/didChangeWorkspaceFolders',
      'textDocument/didOpen', 'textDocument/didChange']) {
      server.send({ method, params });
    }
  }
  assert.equal(await server.stop(), 0);
});

test.after(() => started.forEach((server) => server.kill()));
