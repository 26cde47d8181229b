; What is what in a scene, by the names that Neovim, Helix and tree-sitter share.

(identifier) @variable

["import" "as" "scn"] @keyword.import
["let" "param" "fn" "expect" "within" "of" "with"] @keyword
["for" "in"] @keyword.repeat
["if" "else"] @keyword.conditional
["and" "or" "not"] @keyword.operator

(let name: (identifier) @variable)
(param name: (identifier) @variable.parameter)
(param type: (type) @type.builtin)
(import name: (identifier) @module)
(fn name: (identifier) @function)
(parameter name: (identifier) @variable.parameter)
(argument name: (identifier) @variable.parameter)

(call function: (identifier) @function.call)
(call function: (member name: (identifier) @function.call))
((call function: (identifier) @function.builtin)
  (#match? @function.builtin "^(abs|acos|asin|assert|atan|atan2|blackbody|blinn_phong|bounds|burley|ceil|clamp|concat|contains|cos|coverage|cross|distance|dot|exp|filter|floor|fold|fract|fresnel|ggx|gray|hsv|hypot|len|length|lerp|log|log10|log2|look_at|luminance|map|matrix|max|min|mix|mod|noise|normalize|object|phong|picture|pow|print|radiance|random|range|ray|reflect|refract|region|reverse|rgb|rotate|rotate_x|rotate_y|rotate_z|round|scale|schlick|sign|sin|smoothstep|sort|sqrt|srgb|step|str|sum|tan|translate|zip)$"))

(kind name: (identifier) @type)
(field name: (identifier) @property)
(member name: (identifier) @property)
((identifier) @constant.builtin
  (#match? @constant.builtin "^(frame|pi|tau|time)$"))

(number) @number
(unit) @type.qualifier
(color) @constant
(version) @number
(boolean) @boolean
(string) @string
(import path: (string) @string.special.path)
(escape) @string.escape

(line_comment) @comment
(block_comment) @comment

["=" "==" "!=" "<" "<=" ">" ">=" "+" "-" "*" "/" "%" "^" ".." "..<"] @operator
["{" "}" "(" ")" "[" "]"] @punctuation.bracket
["," ":" "."] @punctuation.delimiter
