-- For Neovim 0.11 and later: vim.lsp.enable('scnrender')
return {
  cmd = { 'scnrender', 'lsp' },
  filetypes = { 'scn' },
  root_markers = { '.git' },
}
