// The TextMate grammar of editors/vscode, held to the language server's tokens over every scene of
// the repository that has no error of syntax; and the extension itself, with an editor made up.
'use strict';
const test = require('node:test');
const assert = require('node:assert/strict');
const fs = require('node:fs');
const path = require('node:path');
const Module = require('node:module');
const oniguruma = require('vscode-oniguruma');
const textmate = require('vscode-textmate');
const { Client, killLeft, CAPABILITIES } = require('./client');

const root = process.env.SOURCE_DIR;
const extension = path.join(root, 'editors/vscode');

async function loadGrammar() {
  const wasm = fs.readFileSync(require.resolve('vscode-oniguruma/release/onig.wasm'));
  await oniguruma.loadWASM(wasm.buffer.slice(wasm.byteOffset, wasm.byteOffset + wasm.length));
  const file = path.join(extension, 'syntaxes/scn.tmLanguage.json');
  const registry = new textmate.Registry({
    onigLib: Promise.resolve({
      createOnigScanner: (patterns) => new oniguruma.OnigScanner(patterns),
      createOnigString: (string) => new oniguruma.OnigString(string),
    }),
    loadGrammar: async () => textmate.parseRawGrammar(fs.readFileSync(file, 'utf8'), file),
  });
  return registry.loadGrammar('source.scn');
}

// For each line the innermost scope of each character, and whether an illegal one is around it.
function scopesOf(grammar, text) {
  let stack = textmate.INITIAL;
  return text.split('\n').map((line) => {
    const result = grammar.tokenizeLine(line, stack);
    stack = result.ruleStack;
    const scopes = new Array(line.length);
    for (const token of result.tokens) {
      scopes.fill(token.scopes.slice(1).join(' '), token.startIndex, token.endIndex);
    }
    return scopes;
  });
}

const expected = {
  comment: /^comment/,
  string: /^string/,
  number: /constant\.numeric|constant\.other\.color|keyword\.other\.unit/,
  keyword: /keyword|storage|constant\.language/,
  type: /entity\.name\.type|support\.type/,
  function: /function|variable\.other/, // a function may be passed on as a value
  operator: /keyword\.operator/,
};

function scenes(folder) {
  return fs.readdirSync(folder, { withFileTypes: true }).flatMap((entry) => {
    const file = path.join(folder, entry.name);
    return entry.isDirectory() ? (entry.name === 'node_modules' ? [] : scenes(file))
      : entry.name.endsWith('.scn') ? [file] : [];
  });
}

test('every word of every scene has the scope of what it is', async () => {
  const grammar = await loadGrammar();
  const client = await new Client({ options: { evaluate: false } }).start();
  const { legend } = client.info.capabilities.semanticTokensProvider;
  let files = 0, words = 0;
  const wrong = [];
  for (const file of ['examples', 'tests', 'compare'].flatMap((f) => scenes(path.join(root, f)))) {
    const bytes = fs.readFileSync(file), text = bytes.toString('utf8');
    if (!Buffer.from(text).equals(bytes) || text.includes('\0')) continue;
    const name = `file${++files}.scn`;
    await client.open(name, text);
    const list = await client.current(name);
    const { data } = await client.request('textDocument/semanticTokens/full', name);
    await client.close(name);
    if (list.some((item) => /^E0[12]/.test(item.code))) continue;
    const lines = text.split('\n'), scopes = scopesOf(grammar, text);
    for (const [row, line] of scopes.entries()) {
      const illegal = line.findIndex((scope) => scope.includes('illegal'));
      if (illegal >= 0) wrong.push(`${file}:${row + 1}: illegal`);
    }
    for (let i = 0, row = 0, column = 0; i < data.length; i += 5) {
      column = data[i] ? data[i + 1] : column + data[i + 1];
      row += data[i];
      const word = lines[row].slice(column, column + data[i + 2]).replace(/\r$/, '');
      const type = legend.tokenTypes[data[i + 3]];
      if (!expected[type] || word === 'of') continue;
      ++words;
      for (let k = column; k < column + word.length; ++k) {
        if (!expected[type].test(scopes[row][k] || '')) {
          wrong.push(`${file}:${row + 1}: \`${word}\` is a ${type}, not ${scopes[row][k]}`);
          break;
        }
      }
    }
  }
  assert.deepEqual(wrong.slice(0, 20), []);
  assert.ok(files > 100 && words > 5000, `${files} files, ${words} words`);
  assert.equal(await client.stop(), 0);
});

// Editors' files must list names themselves; they are held to the program's tables. For functions
// and quantities, tools/docs writes them anew.
test('the names that the grammars list are the program\'s', () => {
  const read = (file) => fs.readFileSync(path.join(root, file), 'utf8');
  const all = (text, pattern) => [...text.matchAll(pattern)].map((match) => match[1]).sort();
  const builtins = all(read('src/lang/builtins.def'), /^BUILTIN\((\w+),/gm);
  const constants = all(read('src/lang/builtins.def'), /^(?:CONSTANT|MOMENT)\((\w+),/gm);
  const units = all(read('src/schema/schema.c'), /\{"(\w+)", DIM_\w+, /g);
  const keywords = all(read('src/lang/lexer.h'), /KEYWORD\(\w+, "(\w+)"\)/g);
  assert.ok(builtins.length > 50 && units.length > 15 && keywords.length > 15);
  const textmate = JSON.parse(read('editors/vscode/syntaxes/scn.tmLanguage.json')).repository;
  const vim = read('editors/neovim/syntax/scn.vim');
  const treeSitter = read('grammar/tree-sitter-scn/grammar.js');
  const words = (text) => text.match(/[A-Za-z_][A-Za-z0-9_]*/g).sort();
  const named = (patterns, name) => patterns.find((pattern) => pattern.name === name).match;
  const inside = (text, pattern) => pattern.exec(text)[1].split(/\\?\|/).sort();
  assert.deepEqual(inside(named(textmate.name.patterns, 'support.function.scn'), /\((\w+\|[\w|]+)\)/),
    builtins);
  assert.deepEqual(inside(vim, /scnBuiltin [^]*?%\(([\w\\|]+)\\\)/), builtins);
  assert.deepEqual(inside(read('grammar/tree-sitter-scn/queries/highlights.scm'),
    /function\.builtin "\^\(([\w|]+)\)\$"/), builtins);
  assert.deepEqual(inside(named(textmate.name.patterns, 'support.constant.scn'), /\((\w+\|[\w|]+)\)/),
    constants);
  assert.deepEqual(inside(vim, /scnConstant [^]*?%\(([\w\\|]+)\\\)/), constants);
  assert.deepEqual(inside(read('grammar/tree-sitter-scn/queries/highlights.scm'),
    /constant\.builtin "\^\(([\w|]+)\)\$"/), constants);
  assert.deepEqual(inside(textmate.number.match, /\((deg[\w|]+)\)/), units);
  assert.deepEqual(inside(vim, /scnUnit \/\\%\(([\w\\|]+)\\\)/), units);
  assert.deepEqual(words(/unit: \(\) =>\s*token\.immediate\(choice\(([^)]*)/.exec(treeSitter)[1]), units);
  const tm = textmate.word.patterns.flatMap((pattern) => inside(pattern.match, /\)\(([\w|]+)\)/));
  assert.deepEqual([...new Set(tm)].sort(), keywords);
  const kate = read('editors/kate/scn.xml');
  assert.deepEqual(all(kate, /<item>(\w+)<\/item>/g), keywords);
  assert.deepEqual(inside(kate, /"\((deg[\w|]+)\)/), units);
  const vimWords = all(vim, /^syntax keyword scn(?!Todo)\w+ (.*)$/gm).flatMap((line) => line.split(' '));
  assert.deepEqual(vimWords.sort(), keywords);
});

test('units, declarations, calls and fields are told apart', async () => {
  const grammar = await loadGrammar();
  const line = 'fn lamp(at) = point_light { power: max(1_000.5e-3kW, 2W) } // end';
  const [scopes] = scopesOf(grammar, line);
  const at = (word, shift = 0) => scopes[line.indexOf(word) + shift];
  for (const [scope, expectedScope] of [[at('fn'), 'storage.type.function.scn'],
    [at('lamp'), 'entity.name.function.scn'], [at('point_light'), 'entity.name.type.scn'],
    [at('power'), 'variable.other.property.scn'], [at('max'), 'support.function.scn'],
    [at('1_000.5e-3'), 'constant.numeric.scn'], [at('kW'), 'keyword.other.unit.scn'],
    [at('W,'), 'keyword.other.unit.scn'], [at('// end', 3), 'comment.line.double-slash.scn']]) {
    assert.equal(scope, expectedScope);
  }
});

test('the extension starts the server, and shows the page of watch', async () => {
  const folder = fs.mkdtempSync(path.join(require('node:os').tmpdir(), 'scnrender-vscode-'));
  const scene = path.join(folder, 'a.scn');
  fs.writeFileSync(scene, 'camera { position: (0, 0, 5), look_at: (0, 0, 0) }\nsphere {}\n' +
    'film { width: 16, height: 16 }\nenvironment_light {}\n');
  const commands = {}, errors = [], shown = [];
  let html, disposed, received, client;
  const uri = (text) => ({ toString: () => text });
  const document = { languageId: 'scn', uri: { scheme: 'file', fsPath: scene }, lineCount: 4,
    lineAt: (row) => ({ text: fs.readFileSync(scene, 'utf8').split('\n')[row] }) };
  const vscode = {
    workspace: {
      getConfiguration: () => ({
        get: (key) => ({ path: process.env.SCNRENDER, allowPaths: ['/tmp'] })[key] }),
      onDidChangeConfiguration: () => ({ dispose() {} }),
      openTextDocument: async (file) => (assert.equal(file, scene), document),
    },
    window: {
      activeTextEditor: { document },
      visibleTextEditors: [],
      showErrorMessage: async (text) => void errors.push(text),
      showInformationMessage: (text) => errors.push(text),
      showTextDocument: async (_, options) => void shown.push(options.selection),
      createWebviewPanel: () => ({
        webview: {
          set html(text) { html = text; },
          onDidReceiveMessage: (handler) => { received = handler; },
        },
        onDidDispose: (handler) => { disposed = handler; },
        reveal() {}, dispose() { disposed(); },
      }),
    },
    commands: { registerCommand: (name, run) => ((commands[name] = run), { dispose() {} }) },
    env: { asExternalUri: async (address) => uri(`${address}/`) },
    Uri: { parse: uri },
    ViewColumn: { One: 1, Beside: -2 },
    Position: class { constructor(line, character) { Object.assign(this, { line, character }); } },
    Range: class { constructor(start, end) { Object.assign(this, { start, end }); } },
  };
  class LanguageClient {
    constructor(id, name, server, options) { Object.assign(this, { server, options }); client = this; }
    async start() { this.started = true; }
    async stop() { this.started = false; }
  }
  const load = Module._load;
  Module._load = (request, ...rest) => (request === 'vscode' ? vscode
    : request === 'vscode-languageclient/node' ? { LanguageClient } : load(request, ...rest));
  const { activate, deactivate } = require(path.join(extension, 'extension.js'));
  Module._load = load;
  await activate({ subscriptions: [] });
  assert.ok(client.started);
  assert.deepEqual(client.server.args, ['lsp', '--allow-path', '/tmp']);
  assert.deepEqual(Object.keys(commands).sort(),
    JSON.parse(fs.readFileSync(path.join(extension, 'package.json'), 'utf8'))
      .contributes.commands.map((command) => command.command).sort());
  await commands['scnrender.preview']();
  assert.deepEqual(errors, []);
  const address = /<iframe src="(http:\/\/127\.0\.0\.1:\d+\/[0-9a-f]+\/)"/.exec(html)[1];
  assert.ok(html.includes(`frame-src ${new URL(address).origin};`));
  const answer = await fetch(address);
  assert.equal(answer.status, 200);
  received({ source: 'scnrender', type: 'reveal', file: 'a.scn', line: 2, column: 3 });
  for (let i = 0; i < 100 && !shown.length; ++i) await new Promise((r) => setTimeout(r, 10));
  assert.deepEqual({ ...shown[0].start }, { line: 1, character: 2 });
  await deactivate();
  assert.equal(client.started, false);
  for (let i = 0; ; ++i) { // the panel's process ends with it
    const gone = await fetch(address).then(() => false, () => true);
    if (gone) break;
    assert.ok(i < 500);
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  fs.rmSync(folder, { recursive: true });
});

test.after(killLeft);
