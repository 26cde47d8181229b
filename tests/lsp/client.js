// A client of `scnrender lsp`, over the protocol's own library, for the tests.
'use strict';
const { spawn } = require('node:child_process');
const fs = require('node:fs');
const os = require('node:os');
const path = require('node:path');
const { pathToFileURL } = require('node:url');
const rpc = require('vscode-languageserver-protocol/node');

// A test that fails leaves its server behind, and Node would wait for it: the last thing that a
// file of tests does after them is to call killLeft.
const started = [];
const killLeft = () => started.forEach((server) => server.kill());

const CAPABILITIES = {
  general: { positionEncodings: ['utf-16'] },
  textDocument: {
    completion: {
      completionItem: { snippetSupport: true, documentationFormat: ['markdown', 'plaintext'] },
    },
    hover: { contentFormat: ['markdown', 'plaintext'] },
    documentSymbol: { hierarchicalDocumentSymbolSupport: true },
    publishDiagnostics: { relatedInformation: true, versionSupport: true },
  },
  workspace: { didChangeWatchedFiles: { dynamicRegistration: true } },
};

// A text with marks: `|` (or `[[` … `]]`) is taken out and its place told.
function marked(text) {
  const at = text.indexOf('|');
  return { text: text.slice(0, at) + text.slice(at + 1), offset: at };
}

function positionOf(text, offset) {
  const before = text.slice(0, offset).split('\n');
  return { line: before.length - 1, character: before[before.length - 1].length };
}

function offsetOf(text, position) {
  const lines = text.split('\n');
  let offset = position.character;
  for (let i = 0; i < position.line; ++i) {
    offset += lines[i].length + 1;
  }
  return offset;
}

// Edits of the protocol, applied from the last to the first.
function applyEdits(text, edits) {
  const sorted = [...edits].sort(
    (a, b) => offsetOf(text, b.range.start) - offsetOf(text, a.range.start));
  for (const edit of sorted) {
    text = text.slice(0, offsetOf(text, edit.range.start)) + edit.newText +
      text.slice(offsetOf(text, edit.range.end));
  }
  return text;
}

class Client {
  constructor({ capabilities = CAPABILITIES, options = {}, args = [] } = {}) {
    this.folder = fs.realpathSync(fs.mkdtempSync(path.join(os.tmpdir(), 'scnrender-lsp-')));
    this.capabilities = capabilities;
    this.options = { evaluateAfter: 20, ...options };
    this.process = spawn(process.env.SCNRENDER || 'scnrender', ['lsp', '--stdio', ...args],
      { stdio: ['pipe', 'pipe', 'inherit'], cwd: this.folder });
    started.push(this.process);
    this.exited = new Promise((resolve) => this.process.on('exit', resolve));
    this.connection = rpc.createProtocolConnection(
      new rpc.StreamMessageReader(this.process.stdout),
      new rpc.StreamMessageWriter(this.process.stdin));
    this.published = new Map(); // by URI, the last
    this.waiting = [];
    this.registered = [];
    this.connection.onNotification(rpc.PublishDiagnosticsNotification.type, (params) => {
      this.published.set(params.uri, params);
      this.waiting = this.waiting.filter((wait) => !wait(params));
    });
    this.connection.onRequest(rpc.RegistrationRequest.type, (params) => {
      this.registered.push(...params.registrations);
    });
    this.connection.onNotification(rpc.LogMessageNotification.type, () => {});
    this.connection.listen();
    this.versions = new Map();
  }

  async start() {
    this.info = await this.connection.sendRequest(rpc.InitializeRequest.type, {
      processId: process.pid,
      rootUri: pathToFileURL(this.folder).href,
      workspaceFolders: [{ uri: pathToFileURL(this.folder).href, name: 'test' }],
      capabilities: this.capabilities,
      initializationOptions: this.options,
    });
    await this.connection.sendNotification(rpc.InitializedNotification.type, {});
    return this;
  }

  uri(name) {
    return pathToFileURL(path.join(this.folder, name)).href;
  }

  write(name, text) {
    const file = path.join(this.folder, name);
    fs.mkdirSync(path.dirname(file), { recursive: true });
    fs.writeFileSync(file, text);
  }

  open(name, text) {
    this.versions.set(name, 1);
    return this.connection.sendNotification(rpc.DidOpenTextDocumentNotification.type, {
      textDocument: { uri: this.uri(name), languageId: 'scn', version: 1, text },
    });
  }

  change(name, contentChanges) {
    const version = this.versions.get(name) + 1;
    this.versions.set(name, version);
    return this.connection.sendNotification(rpc.DidChangeTextDocumentNotification.type, {
      textDocument: { uri: this.uri(name), version }, contentChanges,
    });
  }

  close(name) {
    return this.connection.sendNotification(rpc.DidCloseTextDocumentNotification.type,
      { textDocument: { uri: this.uri(name) } });
  }

  request(method, name, params = {}) {
    return this.connection.sendRequest(method,
      { textDocument: { uri: this.uri(name) }, ...params });
  }

  // The next (or last) diagnostics of the file for which `test` holds.
  diagnostics(name, test = () => true, milliseconds = 20000) {
    const uri = this.uri(name);
    const last = this.published.get(uri);
    if (last && test(last.diagnostics, last)) {
      return Promise.resolve(last.diagnostics);
    }
    return new Promise((resolve, reject) => {
      const timer = setTimeout(() => reject(new Error(`no such diagnostics of ${name}; last: ` +
        JSON.stringify(this.published.get(uri)))), milliseconds);
      this.waiting.push((params) => {
        if (params.uri !== uri || !test(params.diagnostics, params)) {
          return false;
        }
        clearTimeout(timer);
        resolve(params.diagnostics);
        return true;
      });
    });
  }

  // Those of the version that was sent last.
  current(name, test = () => true) {
    const version = this.versions.get(name);
    return this.diagnostics(name, (list, params) => params.version === version && test(list));
  }

  async stop() {
    await this.connection.sendRequest(rpc.ShutdownRequest.type);
    await this.connection.sendNotification(rpc.ExitNotification.type);
    const code = await this.exited;
    this.connection.dispose();
    fs.rmSync(this.folder, { recursive: true });
    return code;
  }
}

module.exports = { Client, killLeft, CAPABILITIES, rpc, marked, positionOf, offsetOf, applyEdits };
