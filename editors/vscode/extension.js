// The client of `scnrender lsp`, and a panel with the page of `scnrender watch`.
'use strict';
const { spawn } = require('child_process');
const crypto = require('crypto');
const path = require('path');
const vscode = require('vscode');
const { LanguageClient } = require('vscode-languageclient/node');

let client;
const previews = new Map(); // by the scene's path

const settings = () => vscode.workspace.getConfiguration('scnrender');
const program = () => settings().get('path') || 'scnrender';
const allowed = () => settings().get('allowPaths').flatMap((folder) => ['--allow-path', folder]);

// --- The language server ---------------------------------------------------------------------------

async function start() {
  client = new LanguageClient('scnrender', 'scnrender',
    { command: program(), args: ['lsp', ...allowed()] },
    {
      documentSelector: [{ language: 'scn', scheme: 'file' }, { language: 'scn', scheme: 'untitled' }],
      synchronize: { configurationSection: 'scnrender' },
      initializationOptions: JSON.parse(JSON.stringify(settings())),
    });
  try {
    await client.start();
  } catch (error) {
    client = undefined;
    const choice = await vscode.window.showErrorMessage(
      `\`${program()}\` can't be started: ${error.message}. Is it installed?`, 'Settings');
    if (choice) {
      vscode.commands.executeCommand('workbench.action.openSettings', 'scnrender.path');
    }
  }
}

async function stop() {
  const running = client;
  client = undefined;
  await running?.stop().catch(() => {});
}

// --- The picture -----------------------------------------------------------------------------------

function page(panel, url) {
  const nonce = crypto.randomBytes(16).toString('hex');
  const address = new URL(url);
  // What the page says of places goes on to the extension; from nobody else.
  return `<!DOCTYPE html>
<html>
<head>
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; frame-src ${address.origin};
 style-src 'nonce-${nonce}'; script-src 'nonce-${nonce}'">
<style nonce="${nonce}">html, body, iframe { margin: 0; padding: 0; border: 0; width: 100%; height: 100vh; }
body { overflow: hidden; }</style>
</head>
<body>
<iframe src="${address.href.replace(/&/g, '&amp;').replace(/"/g, '&quot;')}" title="The picture"
 allow="clipboard-write"></iframe>
<script nonce="${nonce}">
const editor = acquireVsCodeApi();
window.addEventListener('message', (event) => {
  if (event.origin === ${JSON.stringify(address.origin)} && event.data?.source === 'scnrender') {
    editor.postMessage(event.data);
  }
});
</script>
</body>
</html>`;
}

async function reveal(folder, { file, line, column }) {
  if (typeof file !== 'string' || !Number.isFinite(line)) {
    return;
  }
  const document = await vscode.workspace.openTextDocument(path.resolve(folder, file));
  const row = Math.min(Math.max(line - 1, 0), document.lineCount - 1);
  // Columns count characters, not the editor's units.
  const before = [...document.lineAt(row).text].slice(0, Math.max((column || 1) - 1, 0)).join('');
  const at = new vscode.Position(row, before.length);
  const shown = vscode.window.visibleTextEditors.find((editor) => editor.document === document);
  await vscode.window.showTextDocument(document,
    { viewColumn: shown?.viewColumn ?? vscode.ViewColumn.One, selection: new vscode.Range(at, at) });
}

// The address that `scnrender watch` prints first, whatever else stands on the line.
function watch(file, folder) {
  const process = spawn(program(), ['watch', ...allowed(), file], { cwd: folder });
  const address = new Promise((resolve, reject) => {
    let output = '', complaints = '';
    process.stdout.setEncoding('utf8').on('data', (text) => {
      output += text;
      const found = /https?:\/\/[^\s"'<>]+/.exec(output);
      if (found && output.length > found.index + found[0].length) {
        resolve(found[0]);
      }
    });
    process.stderr.setEncoding('utf8').on('data', (text) => {
      complaints = (complaints + text).slice(-2000);
    });
    process.on('error', reject);
    process.on('exit', (code) => reject(new Error(complaints.trim() || `it ended with status ${code}`)));
  });
  return { process, address };
}

async function preview() {
  const document = vscode.window.activeTextEditor?.document;
  if (document?.languageId !== 'scn' || document.uri.scheme !== 'file') {
    vscode.window.showInformationMessage('Save the scene first: its picture follows the file.');
    return;
  }
  const file = document.uri.fsPath, folder = path.dirname(file);
  if (previews.has(file)) {
    previews.get(file).reveal();
    return;
  }
  const panel = vscode.window.createWebviewPanel('scnrender.preview', path.basename(file, '.scn'),
    { viewColumn: vscode.ViewColumn.Beside, preserveFocus: true },
    { enableScripts: true, retainContextWhenHidden: true });
  previews.set(file, panel);
  const { process, address } = watch(file, folder);
  panel.onDidDispose(() => {
    previews.delete(file);
    process.kill();
  });
  panel.webview.onDidReceiveMessage((message) => {
    if (message.type === 'reveal') {
      reveal(folder, message).catch(() => {});
    }
  });
  try {
    const url = new URL(await address);
    const outside = await vscode.env.asExternalUri(vscode.Uri.parse(url.origin));
    const base = new URL(outside.toString(true));
    panel.webview.html = page(panel, `${base.origin}${url.pathname}${url.search}`);
  } catch (error) {
    panel.dispose();
    vscode.window.showErrorMessage(`\`scnrender watch\` gives no picture: ${error.message}`);
  }
}

function render() {
  const document = vscode.window.activeTextEditor?.document;
  if (document?.uri.scheme === 'file') {
    const terminal = vscode.window.createTerminal({ name: 'scnrender', shellPath: program(),
      shellArgs: [...allowed(), document.uri.fsPath] });
    terminal.show(true);
  }
}

// --- The extension ---------------------------------------------------------------------------------

exports.activate = async (context) => {
  context.subscriptions.push(
    vscode.commands.registerCommand('scnrender.preview', preview),
    vscode.commands.registerCommand('scnrender.render', render),
    vscode.commands.registerCommand('scnrender.restart', async () => {
      await stop();
      await start();
    }),
    vscode.workspace.onDidChangeConfiguration(async (event) => {
      if (event.affectsConfiguration('scnrender.path') ||
          event.affectsConfiguration('scnrender.allowPaths')) {
        await stop();
        await start();
      }
    }));
  await start();
};

exports.deactivate = async () => {
  for (const panel of previews.values()) {
    panel.dispose();
  }
  await stop();
};

exports.page = page; // for the test
