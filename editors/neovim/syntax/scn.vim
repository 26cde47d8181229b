" Scenes of scnrender, for Vim and Neovim without tree-sitter.
if exists('b:current_syntax')
  finish
endif

syntax case match
syntax match scnName /\<[A-Za-z_][A-Za-z0-9_]*\>/
syntax match scnField /\<[A-Za-z_][A-Za-z0-9_]*\>\ze\s*:/
syntax match scnKind /\<[A-Za-z_][A-Za-z0-9_]*\>\ze\s*{/
syntax match scnCall /\<[A-Za-z_][A-Za-z0-9_]*\>\ze(/
syntax match scnBuiltin /\<\%(abs\|acos\|asin\|assert\|atan\|atan2\|blackbody\|blinn_phong\|bounds\|burley\|ceil\|clamp\|concat\|contains\|cos\|coverage\|cross\|distance\|dot\|exp\|filter\|floor\|fold\|fract\|fresnel\|ggx\|gray\|hsv\|hypot\|len\|length\|lerp\|log\|log10\|log2\|look_at\|luminance\|map\|matrix\|max\|min\|mix\|mod\|noise\|normalize\|object\|phong\|picture\|pow\|print\|radiance\|random\|range\|ray\|reflect\|refract\|region\|reverse\|rgb\|rotate\|rotate_x\|rotate_y\|rotate_z\|round\|scale\|schlick\|sign\|sin\|smoothstep\|sort\|sqrt\|srgb\|step\|str\|sum\|tan\|translate\|zip\)\>\ze(/
syntax keyword scnInclude import as
syntax keyword scnStatement let param fn expect within with
syntax keyword scnRepeat for in
syntax keyword scnConditional if else
syntax keyword scnOperator and or not
syntax keyword scnBoolean true false
syntax match scnConstant /\<\%(frame\|pi\|tau\|time\)\>\%(\s*:\)\@!/
syntax match scnHeader /\%^\_s*scn\s\+1\>/
syntax match scnNumber /\<\d\%(_\?\d\)*\%(\.\d\%(_\?\d\)*\)\?\%([eE][+-]\?\d\+\)\?/ nextgroup=scnUnit
syntax match scnUnit /\%(deg\|rad\|turn\|km\|cm\|mm\|um\|nm\|ms\|lm\|cd\|lx\|nit\|kW\|m\|s\|K\|W\)\>/ contained
syntax match scnColor /#\%(\x\{6}\|\x\{3}\)\>/
syntax match scnEscape /\\\%([nt"\\]\|u{\x\{1,6}}\)/ contained
syntax region scnString start=/"/ skip=/\\./ end=/"\|$/ contains=scnEscape,@Spell
syntax keyword scnTodo TODO FIXME NOTE contained
syntax match scnComment "//.*$" contains=scnTodo,@Spell
syntax region scnComment start="/\*" end="\*/" contains=scnComment,scnTodo,@Spell

highlight default link scnField Identifier
highlight default link scnKind Type
highlight default link scnCall Function
highlight default link scnBuiltin Function
highlight default link scnInclude Include
highlight default link scnStatement Keyword
highlight default link scnRepeat Repeat
highlight default link scnConditional Conditional
highlight default link scnOperator Operator
highlight default link scnBoolean Boolean
highlight default link scnConstant Constant
highlight default link scnHeader PreProc
highlight default link scnNumber Number
highlight default link scnUnit Special
highlight default link scnColor Constant
highlight default link scnString String
highlight default link scnEscape SpecialChar
highlight default link scnTodo Todo
highlight default link scnComment Comment

let b:current_syntax = 'scn'
