// A document's text, and the positions of the protocol in it: a line and a column, counted from 0,
// the column in units of the encoding that was agreed on.
#ifndef LSP_BUFFER_H
#define LSP_BUFFER_H

#include "base/array.h"
#include "base/str.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum PositionEncoding { POSITIONS_UTF16, POSITIONS_UTF8, POSITIONS_UTF32 } PositionEncoding;

typedef struct Position {
    uint32_t line, column;
} Position;

// UTF-8 with the byte offsets of its lines' starts; a line ends with "\n", "\r\n" or "\r". Begin
// with zeros.
typedef struct Buffer {
    ARRAY(char) bytes;
    ARRAY(uint32_t) lines; // [0] is 0
} Buffer;

void buffer_free(Buffer *text);
// Each gives false without memory (then the text is as it was) and for texts of 2 GiB and more.
bool buffer_set(Buffer *text, Str content);
// Replaces bytes [begin, end).
bool buffer_replace(Buffer *text, uint32_t begin, uint32_t end, Str content);

static inline Str buffer_content(const Buffer *text)
{
    return (Str){text->bytes.items ? text->bytes.items : "", text->bytes.count};
}

// The byte that a position means: in the middle of a character its begin, beyond a line's end that
// end, beyond the last line the text's end.
uint32_t buffer_offset(const Buffer *text, Position position, PositionEncoding encoding);
// The position of a byte (beyond the text: its end). Bytes that aren't UTF-8 count as one unit.
Position buffer_position(const Buffer *text, uint32_t offset, PositionEncoding encoding);
// The number of the line that the byte stands in, from 0.
uint32_t buffer_line(const Buffer *text, uint32_t offset);
// Units of a run of text within one line.
uint32_t buffer_units(Str run, PositionEncoding encoding);

#endif
