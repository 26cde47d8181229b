-- The client of `scnrender lsp`, for Neovim 0.7 and later, and the picture of `scnrender watch`.
--
--   require('scnrender').setup({
--     cmd = { 'scnrender', 'lsp' },     -- the program
--     init_options = { evaluateAfter = 250, inlayHints = { values = true } },
--     on_attach = function(client, bufnr) … end,
--     autostart = true,                 -- false where vim.lsp.enable('scnrender') does it
--   })
local M = {}

M.config = {
  cmd = { 'scnrender', 'lsp' },
  init_options = vim.empty_dict and vim.empty_dict() or {},
  autostart = true,
}

-- Client ids by root folder (for 0.7, which has no vim.lsp.start).
local clients = {}

function M.setup(options)
  M.config = vim.tbl_extend('force', M.config, options or {})
end

-- The folder of the repository around a file, or its own.
local function root_of(bufnr)
  local file = vim.api.nvim_buf_get_name(bufnr)
  local folder = file ~= '' and vim.fn.fnamemodify(file, ':p:h') or vim.fn.getcwd()
  local git = vim.fn.finddir('.git', folder .. ';')
  return git ~= '' and vim.fn.fnamemodify(git, ':p:h:h') or folder
end

local function client_config(root)
  return {
    name = 'scnrender',
    cmd = M.config.cmd,
    root_dir = root,
    init_options = M.config.init_options,
    capabilities = M.config.capabilities or vim.lsp.protocol.make_client_capabilities(),
    on_attach = M.config.on_attach,
  }
end

local function is_enabled()
  return vim.lsp.is_enabled ~= nil and vim.lsp.is_enabled('scnrender')
end

-- Starts the server for a buffer's folder, where it doesn't run already.
function M.attach(bufnr)
  if not M.config.autostart or is_enabled() or vim.fn.executable(M.config.cmd[1]) == 0 then
    return nil
  end
  local root = root_of(bufnr)
  if vim.lsp.start then
    return vim.lsp.start(client_config(root), { bufnr = bufnr })
  end
  local id = clients[root]
  if not id or not vim.lsp.get_client_by_id(id) then
    id = vim.lsp.start_client(client_config(root))
    clients[root] = id
  end
  if id then
    vim.lsp.buf_attach_client(bufnr, id)
  end
  return id
end

-- --- The picture

local watches = {} -- jobs by file

local function open_address(address)
  if vim.ui and vim.ui.open then
    vim.ui.open(address)
  else
    local opener = vim.fn.has('mac') == 1 and 'open' or 'xdg-open'
    vim.fn.jobstart({ opener, address }, { detach = true })
  end
end

-- Shows the page of `scnrender watch` for the current scene in the browser; calls `ready` with its
-- address instead, where that is given. It ends with Neovim.
function M.preview(ready)
  local file = vim.api.nvim_buf_get_name(0)
  if file == '' then
    vim.notify('Save the scene first: its picture follows the file.')
    return
  end
  ready = ready or open_address
  if watches[file] and watches[file].address then
    ready(watches[file].address)
    return
  end
  local watch = { output = '' }
  watches[file] = watch
  watch.job = vim.fn.jobstart({ M.config.cmd[1], 'watch', file }, {
    on_stdout = function(_, lines)
      watch.output = watch.output .. table.concat(lines, '\n')
      local address = watch.output:match('https?://[^%s]+')
      if address and not watch.address and watch.output:find('\n', 1, true) then
        watch.address = address
        ready(address)
      end
    end,
    on_exit = function(_, code)
      watches[file] = nil
      if not watch.address then
        vim.notify('`scnrender watch` gives no picture: status ' .. code, vim.log.levels.ERROR)
      end
    end,
  })
end

-- --- Tree-sitter

-- For nvim-treesitter: where :TSInstall scn finds the grammar. `path` is the repository of scnrender.
function M.register_parser(path)
  local parsers = require('nvim-treesitter.parsers')
  local configs = parsers.get_parser_configs and parsers.get_parser_configs() or parsers
  configs.scn = {
    install_info = {
      url = path,
      path = path,
      location = 'grammar/tree-sitter-scn',
      files = { 'src/parser.c', 'src/scanner.c' },
    },
    filetype = 'scn',
  }
end

return M
