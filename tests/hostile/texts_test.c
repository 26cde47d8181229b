// A mebibyte of text of the worst kinds that we could think of: no command that reads it takes more
// than a second of the processor or 256 MiB, crashes, or ends with another status than 0 or 1.
//     texts_test PROGRAM FOLDER        FOLDER: where the texts are written
#include "program.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIZE = 1 << 20, MOST_KIB = 256 << 10 };
static const double most_seconds = 4; // a second, on a machine that is four times slower than ours

typedef struct Text {
    const char *name;
    const char *begin;
    const char *unit; // repeated; a @ stands for the number of the repetition, so that names differ
    const char *end;
} Text;

#define LONG_NAME "a_name_of_fifty_letters_that_is_like_all_the_others"

static const Text texts[] = {
    // Nesting.
    {"parentheses", "let a = ", "(", ""},
    {"braces", "sphere ", "{", ""},
    {"brackets", "let a = ", "[", ""},
    {"closing_braces", "", "}", ""},
    {"closing_parentheses", "", ")", ""},
    {"all_brackets", "", "({[", ""},
    {"groups", "", "group{", ""},
    {"loops", "", "for (i in a) {", ""},
    {"ifs", "let a = ", "if (a) ", ""},
    {"else_ifs", "if (a) {} ", "else if (a) {} ", ""},
    {"functions", "let a = ", "fn(a)=", ""},
    {"calls", "let a = ", "f(", ""},
    {"minus", "let a = ", "-", "1"},
    {"not", "let a = ", "not ", "true"},
    {"power", "let a = ", "2^", "1"},
    // Chains.
    {"sum", "let a = 1", "+1", ""},
    {"and", "let a = true", " and true", ""},
    {"comparison", "let a = 1", "<1", ""},
    {"ranges", "let a = ", "1..", "1"},
    {"members", "let a = b", ".c", ""},
    {"indices", "let a = b", "[0]", ""},
    {"empty_calls", "let a = b", "()", ""},
    {"withs", "let a = b", " with{}", ""},
    {"texts", "let a = \"x\"", "+\"x\"", ""},
    {"shadows", "fn f(a) = ", "fn(a) = ", "1"},
    // Long tokens.
    {"long_name", "", "x", ""},
    {"long_number", "let a = ", "1", ""},
    {"long_fraction", "let a = 0.", "1", ""},
    {"long_exponent", "let a = 1e", "1", ""},
    {"long_string", "let a = \"", "x", "\""},
    {"open_string", "let a = \"", "x", ""},
    {"escapes", "let a = \"", "\\n", "\""},
    {"bad_escapes", "let a = \"", "\\q", "\""},
    {"line_comment", "//", "x", ""},
    {"block_comment", "/*", "*", "*/"},
    {"open_comments", "", "/*", ""},
    {"comments", "", "/**/", ""},
    {"long_path", "import \"", "a/", "\" as a"},
    // Characters that make no token, on one line or many.
    {"at_signs", "", "@", ""},
    {"spaced_at_signs", "", "@ ", ""},
    {"lines_of_at_signs", "", "@\n", ""},
    {"quotes", "", "\"", ""},
    {"open_strings", "", "\"a\n", ""},
    {"single_quotes", "", "'", ""},
    {"lines_of_single_quotes", "", "'\n", "'"},
    {"backticks", "", "`", ""},
    {"curly_quotes", "", "\xe2\x80\x9c", ""},
    {"far_curly_quote", "", "\xe2\x80\x9c", "\n\xe2\x80\x9d"},
    {"semicolons", "", ";", ""},
    {"commas", "", ",", ""},
    {"dots", "", ".", ""},
    {"hashes", "", "#", ""},
    {"control_characters", "", "\x01", ""},
    {"spaced_control_characters", "", "\x02 ", ""},
    {"invalid_bytes", "", "\xff", ""},
    {"spaced_invalid_bytes", "", "\xff ", ""},
    {"cut_characters", "", "\xf0\x9f", ""},
    {"byte_order_marks", "", "\xef\xbb\xbf", ""},
    {"letters", "", "\xc3\xa9", ""},
    {"spaced_letters", "", "\xc3\xa9 ", ""},
    {"wide_letters", "let a = ", "\xe6\xbc\xa2 ", ""},
    {"combining", "let a = \"", "\xcc\x81", ""},
    {"newlines", "", "\n", ""},
    {"carriage_returns", "", "\r", ""},
    {"line_ends", "", "\r\n", ""},
    {"tabs", "", "\t", "!"},
    {"signs_for_words", "", "&& ", ""},
    // Many errors of one kind.
    {"names", "", "a ", ""},
    {"different_names", "", "n@ ", ""},
    {"elses", "", "else ", ""},
    {"colors", "", "#ff ", ""},
    {"bad_units", "", "let a@ = 1q\n", ""},
    {"bad_units_of_a_list", "let a = [", "1mm2,", "1]"},
    {"unknown_names", "", "let a@=b@\n", ""},
    {"unknown_names_of_a_list", "let a = [", "b@,", "1]"},
    {"unknown_names_much_alike", "", "let " LONG_NAME "@=n" LONG_NAME "@\n", ""},
    {"unknown_names_a_little_alike", "", "let name_number_@=nome_nummer_@\n", ""},
    {"unknown_functions", "", "x@()\n", ""},
    {"unknown_kinds", "", "spher@{}\n", ""},
    {"unknown_fields", "sphere {", "radiu@: 1 ", "}"},
    {"unknown_arguments", "fn f(a) = a\nlet b = f(", "x@: 1,", "1)"},
    {"unknown_fields_of_with", "let a = sphere {} with {", "r@: 1 ", "}"},
    {"fields_twice", "sphere {", "radius: 1 ", "}"},
    {"names_twice", "", "let n=1\n", ""},
    {"parameters_twice", "fn f(", "a,", "a) = 1"},
    {"names_twice_in_a_group", "group {", "let a = 1 ", "}"},
    {"settings_twice", "", "film { width: 2 } ", ""},
    {"bad_types", "", "param p@: intt = 1\n", ""},
    {"missing_files", "", "import \"x@.scn\" as a@\n", ""},
    {"asserts", "", "assert(false)\n", ""},
    {"out_of_range", "", "sphere{radius:-1}\n", ""},
    {"wrong_types", "", "sphere{center:1}\n", ""},
    // Nothing wrong, but much of it.
    {"lets", "", "let n@=1\n", ""},
    {"params", "", "param p@: int = 1\n", ""},
    {"parameters", "fn f(", "a@,", "b) = 1"},
    {"arguments", "let a = sum(", "1,", "1)"},
    {"vector", "let a = (", "1,", "1)"},
    {"list", "let a = [", "1,", "1]"},
    {"spheres", "", "sphere{}\n", ""},
    {"spheres_of_one_line", "", "sphere{}", ""},
    {"materials", "", "sphere{material:lambert{color:hsv(@deg,1,1)}}\n", ""},
    {"lights", "", "point_light{power:1W}\n", ""},
    {"prints", "", "print(1)\n", ""},
    {"chain_of_lets", "let a = 1\n", "let b@ = a\n", ""},
};

// --- Making them -------------------------------------------------------------------------------

// A sign alone is itself; beside letters it is a number.
static bool has_number(const Text *text)
{
    return strpbrk(text->unit, "abcdefghijklmnopqrstuvwxyz") != NULL;
}

static size_t put_unit(char *out, const Text *text, unsigned number)
{
    size_t length = 0;
    for (const char *at = text->unit; *at; ++at) {
        if (*at == '@' && has_number(text)) {
            length += (size_t)sprintf(out + length, "%x", number);
        } else {
            out[length++] = *at;
        }
    }
    return length;
}

static size_t make(const Text *text, char *out)
{
    size_t length = 0, end = strlen(text->end);
    length += (size_t)sprintf(out, "%s", text->begin);
    for (unsigned number = 0; length + end + 200 < SIZE; ++number) {
        length += put_unit(out + length, text, number);
    }
    memcpy(out + length, text->end, end);
    return length + end;
}

// Bytes, printable characters, brackets, words.
static size_t make_random(int kind, char *out)
{
    static const char *const words[] = {
        "let ",  "fn ", "if ",  "else ",   "for ", "in ",     "(",      ")",
        "{",     "}",   "[",    "]",       ",",    ":",       "=",      "+",
        "-",     "a ",  "b ",   "sphere ", "1 ",   "2m ",     "\"x\"",  "radius ",
        "#fff ", "..<", "and ", "not ",    "\n",   "import ", "param ", "."};
    uint64_t random = 1;
    size_t length = 0;
    while (length + 16 < SIZE) {
        uint32_t r = program_random(&random);
        if (kind == 3) {
            length +=
                (size_t)sprintf(out + length, "%s", words[r % (sizeof words / sizeof words[0])]);
        } else {
            out[length++] = kind == 0   ? (char)(unsigned char)r
                            : kind == 1 ? (char)(32 + r % 95)
                                        : "(){}[],:=+-*/\"\n .a1"[r % 19];
        }
    }
    return length;
}

// --- Running them --------------------------------------------------------------------------------

static bool check(const char *program, const char *folder, const char *name, Worst *worst)
{
    static const char *const commands[][5] = {
        {"check", "text.scn"},
        {"check", "--diagnostics=json", "text.scn"},
        {"fmt", "--check", "text.scn"},
        {"--dump", "ast", "text.scn"},
    };
    bool good = true;
    for (size_t i = 0; i < sizeof commands / sizeof commands[0]; ++i) {
        ProgramRun run;
        program_run(program, commands[i], folder, (unsigned)(60 * slower), &run);
        bool fine = (run.status == 0 || run.status == 1) &&
                    run.cpu_seconds <= most_seconds * slower &&
                    (!counts_memory || run.peak_kib <= MOST_KIB);
        if (!fine) {
            printf("%s, %s: status %d, %.2f s, %ld KiB\n%.500s\n", name, commands[i][0], run.status,
                   run.cpu_seconds, run.peak_kib, run.status < 0 ? "" : run.errors);
        }
        good = good && fine;
        char what[100];
        snprintf(what, sizeof what, "%s of %s", commands[i][0], name);
        worst_take(worst, &run, what);
    }
    return good;
}

int main(int argc, char **argv)
{
    char *bytes = malloc(2 * SIZE);
    if (argc < 3 || !bytes) {
        fputs("usage: texts_test PROGRAM FOLDER\n", stderr);
        return 2;
    }
    Worst worst = {0};
    unsigned number = 0;
    int count = 0, failed = 0;
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; ++i) {
        if (!program_takes(argc, argv, number++)) {
            continue;
        }
        ++count;
        program_write(argv[2], "text.scn", bytes, make(&texts[i], bytes));
        failed += !check(argv[1], argv[2], texts[i].name, &worst);
    }
    for (int kind = 0; kind < 4; ++kind) {
        if (!program_takes(argc, argv, number++)) {
            continue;
        }
        ++count;
        static const char *const names[] = {"random_bytes", "random_characters", "random_brackets",
                                            "random_words"};
        program_write(argv[2], "text.scn", bytes, make_random(kind, bytes));
        failed += !check(argv[1], argv[2], names[kind], &worst);
    }
    free(bytes);
    printf("%d texts of a mebibyte, %d failed; the slowest was %s (%.2f s of the processor), the "
           "largest "
           "%s (%ld KiB)\n",
           count, failed, worst.slowest, worst.seconds, worst.largest, worst.kib);
    return failed ? 1 : 0;
}
