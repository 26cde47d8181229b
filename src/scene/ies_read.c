// Reads IESNA LM-63 photometric files. They come from anywhere: nothing in them is trusted.
#include "scene/ies.h"

#include "base/number.h"

#include <stdarg.h>
#include <stdio.h>

typedef struct Reader {
    const char *at, *end;
    uint32_t line;
    Arena *arena;
    IesError *error;
} Reader;

__attribute__((format(printf, 2, 3))) static bool fail(Reader *r, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(r->error->message, sizeof r->error->message, format, arguments);
    va_end(arguments);
    r->error->line = r->line;
    return false;
}

static bool out_of_memory(Reader *r)
{
    fail(r, "not enough memory");
    r->error->line = 0;
    return false;
}

// --- Text ----------------------------------------------------------------------------------------

static bool is_line_end(char c)
{
    return c == '\n' || c == '\r';
}

// What stands between numbers; a control-Z ends files of the eighties.
static bool is_separator(char c)
{
    return c == ' ' || c == '\t' || c == ',' || c == '\f' || c == '\v' || c == '\x1a' ||
           is_line_end(c);
}

// Lines end by "\n", "\r\n" or "\r".
static void pass_line_end(Reader *r)
{
    bool carriage = *r->at++ == '\r';
    r->at += carriage && r->at < r->end && *r->at == '\n';
    ++r->line;
}

// The rest of the line, without blanks around it.
static Str take_line(Reader *r)
{
    const char *begin = r->at;
    while (r->at < r->end && !is_line_end(*r->at)) {
        ++r->at;
    }
    const char *end = r->at;
    if (r->at < r->end) {
        pass_line_end(r);
    }
    while (begin < end && is_separator(*begin)) {
        ++begin;
    }
    while (begin < end && is_separator(end[-1])) {
        --end;
    }
    return (Str){begin, (size_t)(end - begin)};
}

static char upper(char c)
{
    return c >= 'a' && c <= 'z' ? (char)(c - 'a' + 'A') : c;
}

static bool has_prefix(Str text, const char *prefix)
{
    size_t length = strlen(prefix);
    if (text.length < length) {
        return false;
    }
    for (size_t i = 0; i < length; ++i) {
        if (upper(text.at[i]) != prefix[i]) {
            return false;
        }
    }
    return true;
}

static Str drop_blanks(Str text)
{
    while (text.length > 0 && is_separator(*text.at)) {
        ++text.at;
        --text.length;
    }
    return text;
}

static Str drop(Str text, size_t count)
{
    return drop_blanks((Str){text.at + count, text.length - count});
}

static bool pass_blanks(Reader *r)
{
    while (r->at < r->end && is_separator(*r->at)) {
        if (is_line_end(*r->at)) {
            pass_line_end(r);
        } else {
            ++r->at;
        }
    }
    return r->at < r->end;
}

// A word for a message: short, and without bytes that could do harm.
static void quote(const char *at, const char *end, char out[28])
{
    int length = 0;
    for (; at < end && !is_separator(*at) && length < 24; ++at) {
        out[length++] = *at >= ' ' && *at <= '~' ? *at : '?';
    }
    out[length] = '\0';
}

// --- Numbers -------------------------------------------------------------------------------------

static bool take_number(Reader *r, const char *what, double *out)
{
    if (!pass_blanks(r)) {
        return fail(r, "the file ends where %s should stand", what);
    }
    const char *after = number_parse(r->at, r->end, out);
    if (!after || (after < r->end && !is_separator(*after)) || !isfinite(*out)) {
        char word[28];
        quote(r->at, r->end, word);
        return fail(r, "`%s` stands where %s should", word, what);
    }
    r->at = after;
    return true;
}

static bool take_positive(Reader *r, const char *what, double *out)
{
    return take_number(r, what, out) && (*out >= 0 || fail(r, "%s is negative: %.9g", what, *out));
}

// A count of things of which each takes two bytes of the file at least.
static bool take_count(Reader *r, const char *what, uint32_t least, uint32_t *out)
{
    double value;
    if (!take_number(r, what, &value)) {
        return false;
    }
    if (value != floor(value) || value < least) {
        return fail(r, "%s is %.9g", what, value);
    }
    double most = (double)(r->end - r->at) / 2 + 1;
    if (value > most || value > 1e8) {
        return fail(r, "%s is %.9g, but only %.0f bytes follow", what, value,
                    (double)(r->end - r->at));
    }
    *out = (uint32_t)value;
    return true;
}

static bool take_choice(Reader *r, const char *what, int most, int *out)
{
    double value;
    if (!take_number(r, what, &value)) {
        return false;
    }
    if (value != floor(value) || value < 1 || value > most) {
        return fail(r, "%s is %.9g; it should be 1 to %d", what, value, most);
    }
    *out = (int)value;
    return true;
}

// Ascending angles in degrees within [least, most], stored in radians.
static bool take_angles(Reader *r, const char *what, uint32_t count, double least, double most,
                        const double **out)
{
    double *angles = arena_array(r->arena, count, sizeof *angles), before = 0;
    if (!angles) {
        return out_of_memory(r);
    }
    for (uint32_t i = 0; i < count; ++i) {
        double angle;
        if (!take_number(r, what, &angle)) {
            return false;
        }
        if (angle < least || angle > most) {
            return fail(r, "%s is %.9g; it should lie in %g to %g", what, angle, least, most);
        }
        if (i > 0 && angle <= before) {
            return fail(r, "%s %.9g follows %.9g: they should ascend", what, angle, before);
        }
        before = angle;
        angles[i] = angle * PI / 180;
    }
    *out = angles;
    return true;
}

// --- The parts of a file -------------------------------------------------------------------------

// The first line names the edition; files of 1986 have no such line.
static int read_edition(Reader *r)
{
    if (r->end - r->at >= 3 && memcmp(r->at, "\xef\xbb\xbf", 3) == 0) {
        r->at += 3; // a byte order mark
    }
    Reader ahead = *r;
    Str line = take_line(&ahead);
    int edition = has_prefix(line, "IESNA:LM-63-2002")   ? 2002
                  : has_prefix(line, "IESNA:LM-63-1995") ? 1995
                  : has_prefix(line, "IES:LM-63-2019")   ? 2019
                  : has_prefix(line, "IESNA91")          ? 1991
                  : has_prefix(line, "IESNA:LM-63-19")   ? 1991
                  : has_prefix(line, "IES")              ? 2002 // a later one, we hope
                                                         : 1986;
    if (edition != 1986) {
        *r = ahead;
    }
    return edition;
}

// Label and keyword lines up to TILT=. What they say doesn't matter here: keywords may be missing,
// unknown, or stand in blocks.
static bool find_tilt(Reader *r, Str *tilt, uint32_t *line_number)
{
    while (r->at < r->end) {
        *line_number = r->line;
        Str line = take_line(r);
        if (has_prefix(line, "TILT")) {
            Str rest = drop(line, strlen("TILT"));
            if (rest.length > 0 && *rest.at == '=') {
                *tilt = drop(rest, 1);
                return true;
            }
        }
    }
    return fail(r, "there is no line `TILT=`; is this an IESNA LM-63 file?");
}

static bool is_word(Str text, const char *word)
{
    return text.length == strlen(word) && has_prefix(text, word);
}

static bool read_tilt(Reader *r, IesWeb *web)
{
    Str tilt = {0};
    uint32_t line = 0;
    if (!find_tilt(r, &tilt, &line)) {
        return false;
    }
    if (is_word(tilt, "NONE")) {
        return true;
    }
    if (!is_word(tilt, "INCLUDE")) {
        char name[28];
        quote(tilt.at, tilt.at + tilt.length, name);
        fail(r,
             "`TILT=%s` refers to another file, which isn't read; write `TILT=INCLUDE` and its "
             "content below, or `TILT=NONE`",
             name);
        r->error->line = line;
        return false;
    }
    int geometry;
    if (!take_choice(r, "the lamp-to-luminaire geometry", 3, &geometry) ||
        !take_count(r, "the number of tilt angles", 1, &web->tilt_count) ||
        !take_angles(r, "a tilt angle", web->tilt_count, 0, 360, &web->tilt_angles)) {
        return false;
    }
    double *factors = arena_array(r->arena, web->tilt_count, sizeof *factors);
    if (!factors) {
        return out_of_memory(r);
    }
    for (uint32_t i = 0; i < web->tilt_count; ++i) {
        if (!take_positive(r, "a tilt factor", &factors[i])) {
            return false;
        }
    }
    web->tilt_factors = factors;
    return true;
}

// *multiplier: what all intensities are multiplied by.
static bool read_head(Reader *r, IesWeb *web, double *multiplier)
{
    double size, candela_multiplier, ballast, photometric;
    int type, units;
    bool good = take_positive(r, "the number of lamps", &web->lamps) &&
                take_number(r, "the lumens of each lamp", &web->lumens_per_lamp) &&
                take_positive(r, "the candela multiplier", &candela_multiplier) &&
                take_count(r, "the number of vertical angles", 2, &web->vertical_count) &&
                take_count(r, "the number of horizontal angles", 1, &web->horizontal_count) &&
                take_choice(r, "the photometric type", 3, &type) &&
                take_choice(r, "the type of units", 2, &units) &&
                take_number(r, "the width of the luminous opening", &size) &&
                take_number(r, "the length of the luminous opening", &size) &&
                take_number(r, "the height of the luminous opening", &size) &&
                take_positive(r, "the ballast factor", &ballast) &&
                take_positive(r, "the ballast-lamp photometric factor", &photometric) &&
                take_number(r, "the input watts", &web->watts);
    if (!good) {
        return false;
    }
    if (web->lumens_per_lamp < 0 && web->lumens_per_lamp != -1) {
        return fail(r,
                    "the lumens of each lamp are %.9g; negative is only -1, for absolute "
                    "photometry",
                    web->lumens_per_lamp);
    }
    uint64_t values = (uint64_t)web->vertical_count * web->horizontal_count;
    if (values > (uint64_t)(r->end - r->at) / 2 + 1) {
        return fail(r,
                    "%u vertical times %u horizontal angles are promised, but only %.0f bytes "
                    "follow",
                    web->vertical_count, web->horizontal_count, (double)(r->end - r->at));
    }
    web->type = (IesType)type;
    *multiplier = candela_multiplier * ballast * photometric;
    return true;
}

static bool near_degrees(double angle, double degrees)
{
    return fabs(angle * 180 / PI - degrees) < 1e-6;
}

// Some files leave out 360°, the same as 0°: the table is then closed by a copy.
static bool is_open_circle(const IesWeb *web)
{
    const double *h = web->horizontal;
    uint32_t n = web->horizontal_count;
    double gap = 2 * PI - h[n - 1];
    return n >= 3 && h[n - 1] > PI + 1e-6 &&
           (fabs(gap - (h[1] - h[0])) < 1e-6 || fabs(gap - (h[n - 1] - h[n - 2])) < 1e-6);
}

static bool find_symmetry_c(Reader *r, IesWeb *web, bool *close)
{
    double first = web->horizontal[0], last = web->horizontal[web->horizontal_count - 1];
    *close = false;
    if (web->horizontal_count == 1) {
        web->symmetry = IES_ROTATIONAL;
        return true;
    }
    if (near_degrees(first, 90) && near_degrees(last, 270)) {
        web->symmetry = IES_HALF_90;
        return true;
    }
    if (near_degrees(first, 0)) {
        web->symmetry = near_degrees(last, 90)    ? IES_QUADRANT
                        : near_degrees(last, 180) ? IES_HALF
                                                  : IES_FULL;
        *close = web->symmetry == IES_FULL && !near_degrees(last, 360);
        if (!*close || is_open_circle(web)) {
            return true;
        }
    }
    return fail(r,
                "the horizontal angles run from %.9g to %.9g; they should end at 0, 90, 180 or "
                "360, or run from 90 to 270",
                first * 180 / PI, last * 180 / PI);
}

static bool read_angles(Reader *r, IesWeb *web, bool *close)
{
    bool c = web->type == IES_TYPE_C;
    double vertical = web->type == IES_TYPE_B ? 180 : 90;
    double horizontal = web->type == IES_TYPE_A ? 180 : 90;
    *close = false;
    if (!take_angles(r, "a vertical angle", web->vertical_count, c ? 0 : -vertical,
                     c ? 180 : vertical, &web->vertical) ||
        !take_angles(r, "a horizontal angle", web->horizontal_count, c ? 0 : -horizontal,
                     c ? 360 : horizontal, &web->horizontal)) {
        return false;
    }
    if (c) {
        return find_symmetry_c(r, web, close);
    }
    if (web->horizontal_count < 2) {
        return fail(r, "photometry of type A or B needs two horizontal angles at least");
    }
    web->symmetry = near_degrees(web->horizontal[0], 0) ? IES_HALF : IES_FULL;
    web->mirror_vertical = near_degrees(web->vertical[0], 0);
    return true;
}

static bool close_circle(Reader *r, IesWeb *web, double *candela)
{
    uint32_t n = web->horizontal_count;
    double *angles = arena_array(r->arena, (size_t)n + 1, sizeof *angles);
    if (!angles) {
        return out_of_memory(r);
    }
    memcpy(angles, web->horizontal, n * sizeof *angles);
    angles[n] = 2 * PI;
    memcpy(candela + (size_t)n * web->vertical_count, candela,
           web->vertical_count * sizeof *candela);
    web->horizontal = angles;
    web->horizontal_count = n + 1;
    return true;
}

static bool read_candela(Reader *r, IesWeb *web, double multiplier, bool close)
{
    size_t values = (size_t)web->vertical_count * web->horizontal_count;
    double *candela =
        arena_array(r->arena, values + (close ? web->vertical_count : 0), sizeof *candela);
    if (!candela) {
        return out_of_memory(r);
    }
    for (size_t i = 0; i < values; ++i) {
        if (!take_positive(r, "an intensity", &candela[i])) {
            return false;
        }
        candela[i] *= multiplier;
        if (!isfinite(candela[i])) {
            return fail(r, "an intensity times its multipliers is too large");
        }
    }
    web->candela = candela;
    return !close || close_circle(r, web, candela);
}

// Numbers beyond the last intensity mean that a count is wrong.
static bool check_end(Reader *r)
{
    double more;
    if (pass_blanks(r) && number_parse(r->at, r->end, &more)) {
        return fail(r, "more numbers follow than the counts of angles promise");
    }
    return true;
}

const IesWeb *ies_read(Arena *arena, Str bytes, IesError *error)
{
    *error = (IesError){0};
    Reader r = {bytes.at, bytes.at + bytes.length, 1, arena, error};
    IesWeb *web = ARENA_NEW(arena, IesWeb);
    double multiplier = 1;
    bool close = false;
    if (!web) {
        out_of_memory(&r);
        return NULL;
    }
    web->edition = read_edition(&r);
    bool good = read_tilt(&r, web) && read_head(&r, web, &multiplier) &&
                read_angles(&r, web, &close) && read_candela(&r, web, multiplier, close) &&
                check_end(&r);
    return good ? web : NULL;
}
