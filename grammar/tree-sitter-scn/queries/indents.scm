[
  (kind)
  (block)
  (fields)
  (list)
  (vector)
  (arguments)
  (parameters)
] @indent.begin @indent

["}" "]" ")"] @indent.branch @outdent
