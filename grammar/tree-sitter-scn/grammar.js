// The scn language for tree-sitter, after grammar/scn.ebnf. It accepts a little more (chained
// comparisons, `1..2..3`): what is wrong is the language server's to say. Generated with
// tree-sitter 0.20 (ABI 14); src/ is what editors compile.
module.exports = grammar({
  name: 'scn',

  // `%` in front of `of` makes a percentage of a tolerance.
  externals: ($) => [$.block_comment, $._percent],
  extras: ($) => [/\s/, $.line_comment, $.block_comment],
  word: ($) => $.identifier,
  inline: ($) => [$._item, $._block_item],
  supertypes: ($) => [$._expression],

  rules: {
    source_file: ($) => seq(optional(seq($.header, optional(','))), repeat(seq($._file_item, optional(',')))),

    header: ($) => seq('scn', $.version),
    version: () => /[0-9]+/,

    _file_item: ($) => choice($.import, $.param, $._item),

    import: ($) => seq('import', field('path', $.string), 'as', field('name', $.identifier)),

    param: ($) =>
      prec.right(seq(
        'param',
        field('name', $.identifier),
        ':',
        field('type', alias($.identifier, $.type)),
        '=',
        field('default', $._expression),
        optional(seq('in', field('range', $._expression))),
        optional(field('description', $.string)),
      )),

    // --- Items

    _item: ($) => choice($.let, $.fn, $.for, $.if_statement, $.expect, $.emit),

    let: ($) => seq('let', field('name', $.identifier), '=', field('value', $._expression)),

    fn: ($) =>
      seq(
        'fn',
        field('name', $.identifier),
        field('parameters', $.parameters),
        choice(seq('=', field('body', $._expression)), field('body', $.block)),
      ),

    for: ($) =>
      seq('for', '(', field('variable', $.identifier), 'in', field('sequence', $._expression), ')',
        field('body', $.block)),

    if_statement: ($) =>
      prec.right(seq('if', '(', field('condition', $._expression), ')', field('then', $.block),
        optional(seq('else', field('else', choice($.block, $.if_statement)))))),

    expect: ($) =>
      prec.right(seq('expect', field('value', $._expression),
        optional(seq('within', field('tolerance', $._operand), optional(alias($._percent, '%')), 'of',
          field('target', $._expression))))),

    emit: ($) => choice($.if_expression, $._emitted),
    _emitted: ($) =>
      choice(
        $.identifier,
        $.kind,
        alias($._emitted_member, $.member),
        alias($._emitted_index, $.index),
        alias($._emitted_call, $.call),
        alias($._emitted_with, $.with),
      ),
    _emitted_member: ($) => prec.left(12, seq(field('value', $._emitted), '.', field('name', $.identifier))),
    _emitted_index: ($) => prec.left(12, seq(field('value', $._emitted), '[', field('index', $._expression), ']')),
    _emitted_call: ($) => prec.left(12, seq(field('function', $._emitted), field('arguments', $.arguments))),
    _emitted_with: ($) => prec.left(12, seq(field('value', $._emitted), 'with', field('fields', $.fields))),

    block: ($) => seq('{', repeat($._block_item), '}'),
    _block_item: ($) => seq($._item, optional(',')),

    parameters: ($) => seq('(', optional(seq(commas($.parameter), optional(','))), ')'),
    parameter: ($) => seq(field('name', $.identifier), optional(seq('=', field('default', $._expression)))),

    // --- Expressions

    _expression: ($) => choice($.if_expression, $.function, $._operand),
    // As an operand an `if` or `fn` needs parentheses; in a list an `if` is an element's, whose
    // branches may be loops.
    _operand: ($) =>
      choice(
        $.unary,
        $.binary,
        $.range,
        $.member,
        $.index,
        $.call,
        $.with,
        $.number,
        $.string,
        $.color,
        $.boolean,
        $.identifier,
        $.kind,
        $.vector,
        $.list,
        $.parenthesized,
      ),

    if_expression: ($) =>
      prec.right(seq('if', '(', field('condition', $._expression), ')', field('then', $._expression),
        'else', field('else', $._expression))),

    function: ($) =>
      prec.right(seq('fn', field('parameters', $.parameters),
        choice(seq('=', field('body', $._expression)), field('body', $.block)))),

    unary: ($) =>
      choice(prec.right(3, seq(field('operator', 'not'), $._operand)),
        prec.right(9, seq(field('operator', '-'), $._operand))),

    binary: ($) =>
      choice(
        ...[
          ['or', 1],
          ['and', 2],
          ['==', 4],
          ['!=', 4],
          ['<', 4],
          ['<=', 4],
          ['>', 4],
          ['>=', 4],
          ['+', 6],
          ['-', 6],
          ['*', 7],
          ['/', 7],
          ['%', 7],
        ].map(([operator, power]) =>
          prec.left(power, seq(field('left', $._operand), field('operator', operator),
            field('right', $._operand)))),
        prec.right(10, seq(field('left', $._operand), field('operator', '^'),
          field('right', $._operand))),
      ),

    range: ($) =>
      prec.left(5, seq(field('from', $._operand), field('operator', choice('..', '..<')),
        field('to', $._operand))),

    member: ($) => prec.left(12, seq(field('value', $._operand), '.', field('name', $.identifier))),
    index: ($) => prec.left(12, seq(field('value', $._operand), '[', field('index', $._expression), ']')),
    call: ($) => prec.left(12, seq(field('function', $._operand), field('arguments', $.arguments))),
    with: ($) => prec.left(12, seq(field('value', $._operand), 'with', field('fields', $.fields))),

    arguments: ($) => seq('(', optional(seq(commas(choice($._expression, $.argument)), optional(','))), ')'),
    argument: ($) => seq(field('name', $.identifier), ':', field('value', $._expression)),
    fields: ($) => seq('{', repeat(seq($.field, optional(','))), '}'),
    field: ($) => seq(field('name', $.identifier), ':', field('value', $._expression)),

    kind: ($) =>
      prec(13, seq(field('name', $.identifier), '{', repeat(seq(choice($.field, $._item), optional(','))), '}')),

    parenthesized: ($) => seq('(', $._expression, ')'),
    vector: ($) =>
      seq('(', $._expression, ',', $._expression,
        optional(seq(',', $._expression, optional(seq(',', $._expression)))), optional(','), ')'),

    list: ($) => seq('[', optional(seq(commas($._element), optional(','))), ']'),
    _element: ($) => choice($.element_for, $.element_if, $.function, $._operand),
    element_for: ($) =>
      seq('for', '(', field('variable', $.identifier), 'in', field('sequence', $._expression), ')',
        field('body', $._element)),
    element_if: ($) =>
      prec.right(1, seq('if', '(', field('condition', $._expression), ')', field('then', $._element),
        optional(seq('else', field('else', $._element))))),

    // --- Tokens

    identifier: () => /[A-Za-z_][A-Za-z0-9_]*/,
    boolean: () => choice('true', 'false'),

    number: ($) => seq($._digits, optional($.unit)),
    _digits: () => /[0-9](_?[0-9])*(\.[0-9](_?[0-9])*)?([eE][+-]?[0-9]+)?/,
    unit: () =>
      token.immediate(choice('deg', 'rad', 'turn', 'km', 'm', 'cm', 'mm', 'um', 'nm', 's', 'ms', 'K', 'W',
        'kW', 'lm', 'cd', 'lx', 'nit')),

    color: () => /#([0-9A-Fa-f]{3}){1,2}/,

    string: ($) => seq('"', repeat(choice($._characters, $.escape)), token.immediate('"')),
    _characters: () => token.immediate(prec(1, /[^"\\\r\n]+/)),
    escape: () => token.immediate(/\\([nt"\\]|u\{[0-9A-Fa-f]{1,6}\})/),

    line_comment: () => token(seq('//', /[^\n]*/)),
  },
});

function commas(rule) {
  return seq(rule, repeat(seq(',', rule)));
}
