// UTF-8: decoding, and how wide a character stands on a terminal.
#ifndef BASE_UTF8_H
#define BASE_UTF8_H

#include <stdbool.h>
#include <stdint.h>

// What is decoded from a byte that begins no well-formed character.
#define UTF8_INVALID UINT32_MAX

// Decodes the character at `at` (< end) into *code and returns its length in bytes, 1 to 4.
// Ill-formed input (overlong forms, surrogates, beyond U+10FFFF, cut short: table 3-7 of the
// Unicode standard) gives UTF8_INVALID and length 1.
static inline int utf8_decode(const char *at, const char *end, uint32_t *code)
{
    const unsigned char *s = (const unsigned char *)at;
    uint32_t first = s[0];
    *code = first;
    if (first < 0x80) {
        return 1;
    }
    int length = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    *code = UTF8_INVALID;
    if (first < 0xc2 || first > 0xf4 || end - at < length) {
        return 1;
    }
    uint32_t value = first & (0x7fu >> length);
    for (int i = 1; i < length; ++i) {
        if ((s[i] & 0xc0) != 0x80) {
            return 1;
        }
        value = value << 6 | (s[i] & 0x3fu);
    }
    bool overlong = (length == 3 && value < 0x800) || (length == 4 && value < 0x10000);
    if (overlong || value > 0x10ffff || (value >= 0xd800 && value <= 0xdfff)) {
        return 1;
    }
    *code = value;
    return length;
}

// Writes `code` (a scalar value) to `out` and returns the number of bytes, 1 to 4.
static inline int utf8_encode(uint32_t code, char out[4])
{
    if (code < 0x80) {
        out[0] = (char)code;
        return 1;
    }
    int length = code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (int i = length - 1; i > 0; --i, code >>= 6) {
        out[i] = (char)(0x80 | (code & 0x3f));
    }
    out[0] = (char)(uint8_t)((0xf00u >> length) | code);
    return length;
}

// Columns that a character takes on a terminal: 0 (combining), 1 or 2 (East Asian wide, emoji).
int utf8_width(uint32_t code);
// True for what must not reach a terminal: control characters, and those that change the direction
// of the text around them (CVE-2021-42574).
bool utf8_is_control(uint32_t code);

#endif
