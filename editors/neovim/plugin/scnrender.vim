if exists('g:loaded_scnrender') || !has('nvim')
  finish
endif
let g:loaded_scnrender = 1
command! ScnPreview lua require('scnrender').preview()
