(source_file) @local.scope
(block) @local.scope
(kind) @local.scope
(fn) @local.scope
(function) @local.scope
(for) @local.scope
(element_for) @local.scope

(let name: (identifier) @local.definition)
(param name: (identifier) @local.definition)
(fn name: (identifier) @local.definition)
(import name: (identifier) @local.definition)
(parameter name: (identifier) @local.definition)
(for variable: (identifier) @local.definition)
(element_for variable: (identifier) @local.definition)

(identifier) @local.reference
