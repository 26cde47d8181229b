#include "lang/format_internal.h"

uint32_t format_token_from(const Formatter *f, uint32_t i)
{
    while (i < f->atoms.count && atom_is_comment(&f->atoms.items[i])) {
        ++i;
    }
    return i;
}

bool format_has_comma(const Formatter *f, uint32_t i)
{
    uint32_t next = format_token_from(f, i + 1);
    if (next == f->atoms.count || !f->atoms.items[next].element) {
        return false;
    }
    if (format_is_brace(f, f->atoms.items[next].group)) {
        for (uint32_t k = i + 1; k <= next; ++k) {
            if (f->atoms.items[k].breaks) {
                return false;
            }
        }
    }
    return true;
}

// --- Reading -------------------------------------------------------------------------------------

typedef struct Reader {
    Formatter *f;
    Lexer lexer;
    Token token;
    DiagSink nowhere; // the parser has reported everything
    Arena arena;
    jmp_buf on_oom;
    uint32_t at, column; // how far the columns are counted
    uint32_t comments;   // that are atoms already
    uint32_t last;       // token
} Reader;

static bool begins_character(char c)
{
    return ((unsigned char)c & 0xc0) != 0x80;
}

// Counts columns up to byte `to`; returns the line ends on the way.
static uint32_t advance_to(Reader *r, uint32_t to)
{
    uint32_t newlines = 0;
    for (; r->at < to; ++r->at) {
        if (r->f->text[r->at] == '\n') {
            ++newlines;
            r->column = 0;
        } else {
            r->column += begins_character(r->f->text[r->at]);
        }
    }
    return newlines;
}

static void add_atom(Reader *r, uint8_t kind, uint32_t begin, uint32_t end)
{
    const char *text = r->f->text;
    uint32_t newlines = advance_to(r, begin);
    Atom atom = {.begin = begin,
                 .end = end,
                 .column = r->column,
                 .match = ATOM_NONE,
                 .group = ATOM_NONE,
                 .kind = kind,
                 .newlines = (uint8_t)(newlines < 2 ? newlines : 2)};
    atom.wide = begin >= 2 && newlines == 0 &&
                (text[begin - 1] == ' ' || text[begin - 1] == '\t') &&
                (text[begin - 2] == ' ' || text[begin - 2] == '\t');
    bool first_line = true;
    for (uint32_t i = begin; i < end; ++i) {
        if (text[i] == '\n') {
            first_line = false;
            atom.tail = 0;
        } else if (begins_character(text[i])) {
            ++atom.tail;
            atom.width += first_line;
        }
    }
    advance_to(r, end);
    if (!array_push(&r->f->atoms, atom)) {
        longjmp(r->on_oom, 1);
    }
}

static void add_comments(Reader *r)
{
    for (; r->comments < r->f->comments.count; ++r->comments) {
        uint32_t begin = r->f->comments.items[r->comments].begin;
        uint32_t end = r->f->comments.items[r->comments].end;
        bool line = r->f->text[begin + 1] == '/';
        while (line && (r->f->text[end - 1] == ' ' || r->f->text[end - 1] == '\t' ||
                        r->f->text[end - 1] == '\r' || r->f->text[end - 1] == '\n')) {
            --end;
        }
        add_atom(r, line ? ATOM_LINE_COMMENT : ATOM_BLOCK_COMMENT, begin, end);
    }
}

static void read_atoms(Reader *r)
{
    do {
        lexer_next(&r->lexer, &r->token);
        add_comments(r);
        if (r->token.kind == TOKEN_COMMA) {
            if (r->last != ATOM_NONE) {
                r->f->atoms.items[r->last].comma = true;
            }
        } else if (r->token.kind != TOKEN_END) {
            r->last = (uint32_t)r->f->atoms.count;
            add_atom(r, r->token.kind, r->token.begin, r->token.end);
        }
    } while (r->token.kind != TOKEN_END);
}

static bool read_guarded(Reader *r, const Source *source, uint32_t file, Interner *names)
{
    if (setjmp(r->on_oom) != 0) {
        return false;
    }
    lexer_init(&r->lexer, source, file, names, &r->nowhere, &r->f->comments, &r->on_oom);
    read_atoms(r);
    return true;
}

static size_t mark_length(Str text) // of the byte order mark
{
    return text.length >= 3 && memcmp(text.at, "\xef\xbb\xbf", 3) == 0 ? 3 : 0;
}

static bool read_source(Formatter *f, const Source *source, uint32_t file, Interner *names)
{
    // A byte order mark takes no column, neither here nor where lines are laid out.
    Reader r = {.f = f, .last = ATOM_NONE, .at = (uint32_t)mark_length(source->text)};
    diag_sink_init(&r.nowhere, &r.arena);
    bool good = read_guarded(&r, source, file, names);
    lexer_free(&r.lexer);
    diag_sink_free(&r.nowhere);
    arena_free(&r.arena);
    return good;
}

// --- Writing -------------------------------------------------------------------------------------

static bool put(FormatText *out, const char *text, size_t length)
{
    if (!array_reserve(out, length)) {
        return false;
    }
    if (length > 0) {
        memcpy(out->items + out->count, text, length);
        out->count += length;
    }
    return true;
}

static bool put_spaces(FormatText *out, size_t count)
{
    if (!array_reserve(out, count)) {
        return false;
    }
    if (count > 0) {
        memset(out->items + out->count, ' ', count);
        out->count += count;
    }
    return true;
}

static bool put_line(FormatText *out, const Formatter *f, const Line *line)
{
    bool good = (!line->blank || put(out, "\n", 1)) && put_spaces(out, line->indent);
    for (uint32_t i = line->begin; good && i < line->end; ++i) {
        const Atom *atom = &f->atoms.items[i];
        size_t spaces = i > line->begin ? (size_t)atom->space + atom->pad : 0;
        good = put_spaces(out, spaces) &&
               put(out, f->text + atom->begin, atom->end - atom->begin) &&
               (atom_is_comment(atom) || !format_has_comma(f, i) || put(out, ",", 1));
    }
    return good && put(out, "\n", 1);
}

static bool put_lines(FormatText *out, const Formatter *f, Str source)
{
    bool good = put(out, source.at, mark_length(source));
    for (size_t i = 0; good && i < f->lines.count; ++i) {
        good = put_line(out, f, &f->lines.items[i]);
    }
    return good;
}

bool format_source(FormatText *out, const Sources *sources, uint32_t file, Interner *names,
                   ParseLimits limits, DiagSink *sink)
{
    Ast ast;
    bool good = parse(&ast, sources, file, names, limits, false, sink);
    ast_free(&ast);
    if (!good) {
        return false;
    }
    const Source *source = source_get(sources, file);
    Formatter f = {.text = source->text.at};
    good = read_source(&f, source, file, names);
    if (good) {
        format_roles(&f);
        format_breaks(&f);
        good = format_lines(&f) && format_align(&f) && put_lines(out, &f, source->text);
    }
    array_free(&f.atoms);
    array_free(&f.lines);
    array_free(&f.comments);
    if (!good) {
        diag_report(sink, E0001, (Span){0}, "not enough memory");
    }
    return good;
}
