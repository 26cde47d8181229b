-- Neovim as a client, without a window: nvim --headless -u NONE -c 'luafile neovim_test.lua'
local source = vim.env.SOURCE_DIR
local folder = vim.fn.tempname()
vim.fn.mkdir(folder, 'p')
vim.opt.runtimepath:prepend(source .. '/editors/neovim')

local function finish(message)
  if message then
    io.stderr:write(message .. '\n')
  end
  vim.fn.delete(folder, 'rf')
  vim.cmd(message and 'cquit 1' or 'qall!')
end

local function check(good, what)
  if not good then
    error(what, 2)
  end
end

local function wait_for(what, condition)
  check(vim.wait(20000, condition, 20), 'waited in vain: ' .. what .. '; diagnostics: ' ..
    vim.inspect(vim.diagnostic.get(0)))
end

local function request(method, params)
  local answers = vim.lsp.buf_request_sync(0, method, params, 20000)
  check(answers, method .. ' has no answer')
  for _, answer in pairs(answers) do
    check(not answer.error, method .. ': ' .. vim.inspect(answer.error))
    return answer.result
  end
end

local function position(line, character)
  return { textDocument = vim.lsp.util.make_text_document_params(),
    position = { line = line, character = character } }
end

local function clients()
  return (vim.lsp.get_clients or vim.lsp.buf_get_clients)(vim.lsp.get_clients and { bufnr = 0 } or 0)
end

local function run()
  vim.fn.writefile({ '// Warm.', 'let warm = rgb(0.8, 0.5, 0.3)' }, folder .. '/lib.scn')
  vim.fn.writefile({ 'import "lib.scn" as lib', '// größe 𝒔',
    'plane{material:lambert{color:lib.warm}}', '/* 𝒔 */ sphere { radus: 25cm }' }, folder .. '/a.scn')
  vim.cmd('filetype plugin on')
  vim.cmd('syntax on')
  require('scnrender').setup({ cmd = { vim.env.SCNRENDER, 'lsp' },
    init_options = { evaluateAfter = 20 } })
  vim.cmd('edit ' .. folder .. '/a.scn')
  check(vim.bo.filetype == 'scn', 'the type of the file is ' .. vim.bo.filetype)
  check(vim.bo.commentstring == '// %s', 'no commentstring')
  wait_for('the client', function()
    for _, client in pairs(clients()) do
      return client.name == 'scnrender' and (client.initialized or client.server_capabilities)
    end
  end)
  wait_for('diagnostics', function()
    return #vim.diagnostic.get(0) > 0
  end)
  local found = vim.diagnostic.get(0)[1]
  check(found.code == 'E0301' and found.lnum == 3, vim.inspect(found))
  -- Columns are bytes to Neovim, units of UTF-16 on the way.
  check(found.col == #'/* 𝒔 */ sphere { ', 'column ' .. found.col)

  local hover = request('textDocument/hover', position(2, 2))
  check(hover.contents.value:find('point', 1, true), vim.inspect(hover))
  local definition = request('textDocument/definition', position(2, 34))
  check(definition.uri:match('lib%.scn$') and definition.range.start.line == 1,
    vim.inspect(definition))
  local list = request('textDocument/completion', position(3, 20))
  local names = vim.tbl_map(function(item) return item.label end, list.items)
  check(vim.tbl_contains(names, 'radius'), vim.inspect(names))

  -- The quick fix, as Neovim applies edits.
  local params = vim.tbl_extend('force', position(3, 18), {
    range = { start = { line = 3, character = 18 }, ['end'] = { line = 3, character = 18 } },
    context = { diagnostics = {} } })
  local actions = request('textDocument/codeAction', params)
  check(actions[1].title == 'Change `radus` to `radius`', vim.inspect(actions))
  vim.lsp.util.apply_workspace_edit(actions[1].edit, 'utf-16')
  check(vim.fn.getline(4) == '/* 𝒔 */ sphere { radius: 25cm }', vim.fn.getline(4))
  wait_for('no diagnostics', function()
    return #vim.diagnostic.get(0) == 0
  end)

  if vim.lsp.buf.format then
    vim.lsp.buf.format({ timeout_ms = 20000 })
  else
    vim.lsp.buf.formatting_sync({}, 20000)
  end
  check(vim.fn.getline(3) == 'plane { material: lambert { color: lib.warm } }', vim.fn.getline(3))

  -- Highlighting without tree-sitter.
  vim.cmd('syntax sync fromstart')
  local function group(line, column)
    return vim.fn.synIDattr(vim.fn.synID(line, column, 1), 'name')
  end
  check(group(1, 1) == 'scnInclude', group(1, 1))
  check(group(3, 1) == 'scnKind', group(3, 1))
  check(group(3, 9) == 'scnField', group(3, 9))
  local at = vim.fn.getline(4):find('25cm', 1, true)
  check(group(4, at) == 'scnNumber', group(4, at))
  check(group(4, at + 2) == 'scnUnit', group(4, at + 2))
  check(group(4, 1) == 'scnComment', group(4, 1))

  -- The address of the picture's page.
  local address
  vim.cmd('silent write')
  require('scnrender').preview(function(found_address) address = found_address end)
  wait_for('the page of watch', function() return address end)
  check(address:match('^http://127%.0%.0%.1:%d+/%x+/$'), address)

  for _, client in pairs(clients()) do
    client.stop()
  end
  wait_for('the end of the server', function()
    return vim.tbl_isempty(clients())
  end)
end

local good, message = xpcall(run, debug.traceback)
finish(not good and message or nil)
