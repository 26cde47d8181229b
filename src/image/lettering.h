// Text on pictures: labels, with one built-in font, so that they look the same everywhere.
#ifndef IMAGE_LETTERING_H
#define IMAGE_LETTERING_H

#include <stddef.h>

// Of a character at scale 1, its free edges counted in.
enum { LETTER_WIDTH = 6, LETTER_HEIGHT = 13 };

// A picture in the making.
typedef struct Canvas {
    int width, height;
    float *pixels; // 3 * width * height, RGB, rows from the top
} Canvas;

// Fills a rectangle, as far as it lies on the canvas.
void canvas_fill(const Canvas *canvas, int x, int y, int width, int height, const float color[3]);

// How many characters a text has (UTF-8; what is ill-formed counts byte by byte).
size_t letter_count(const char *text);
// Draws a text (UTF-8) with its upper left corner at (x, y), each of the font's pixels `scale`
// pixels a side, as far as it lies on the canvas. The font has ASCII and ° ² ³ µ · × – …; other
// characters become a mark of something missing.
void letter_text(const Canvas *canvas, int x, int y, int scale, const char *text,
                 const float color[3]);
// Copies a text to `out`, shortened so that it has at most `most` characters: its end gives way
// to "…".
void letter_shorten(const char *text, size_t most, char *out, size_t size);

#endif
