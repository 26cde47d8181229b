// A session on a terminal: what to send to it, and what its keys do.
#ifndef WATCH_TERMINAL_H
#define WATCH_TERMINAL_H

#include "watch/chafa_module.h"
#include "watch/session.h"

typedef struct TerminalSize {
    int columns, rows;
    int width, height; // pixels; 0: the terminal doesn't tell
} TerminalSize;

typedef struct Terminal Terminal;

// `mode` is "" (the best that the terminal can show), "blocks", "sixel" or "kitty". NULL with a
// message where there is no such mode, or libchafa's module is missing.
Terminal *terminal_new(Session *session, const char *mode, char *message, size_t message_size);
void terminal_free(Terminal *terminal); // NULL is fine

// Appends what makes the screen ready, and what leaves it as it was.
void terminal_enter(Text *out);
void terminal_leave(Text *out);
// Appends the screen as it is to be now: the picture, what is wrong with the scene, figures.
// `whole`: nothing of what was drawn before is there any more.
void terminal_draw(Terminal *terminal, TerminalSize size, bool whole, Text *out);

typedef enum TerminalWish { WISH_NOTHING, WISH_REDRAW, WISH_QUIT, WISH_SAVE } TerminalWish;
// What came from the keyboard: `length` bytes, of which *used are of whole keys. Keys until the
// first wish are used.
TerminalWish terminal_keys(Terminal *terminal, const char *bytes, size_t length, size_t *used);
// Shows a line until the next key.
void terminal_say(Terminal *terminal, const char *text);

#endif
