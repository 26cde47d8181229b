[
  (kind)
  (block)
  (fields)
  (list)
  (arguments)
  (block_comment)
] @fold
