// Between terminal.c and the module that draws on terminals (module_chafa.c, with libchafa): the
// module links nothing of ours.
#ifndef WATCH_CHAFA_MODULE_H
#define WATCH_CHAFA_MODULE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CHAFA_MODULE_VERSION = 1 }; // to be raised with every change here

typedef enum TerminalMode { TERMINAL_BLOCKS, TERMINAL_SIXEL, TERMINAL_KITTY } TerminalMode;

typedef struct ChafaPicture {
    TerminalMode mode;
    const unsigned char *rgba;
    int width, height;
    int columns, rows;           // room for it, in cells
    int cell_width, cell_height; // pixels of a cell
    // Filled: what it takes of the room, and what to send, to be given back with release.
    int drawn_columns, drawn_rows;
    char *bytes;
    size_t size;
} ChafaPicture;

typedef struct ChafaFunctions {
    uint32_t version;
    // The best that the terminal can show, by what the environment says of it.
    TerminalMode (*detect)(void);
    bool (*draw)(ChafaPicture *picture);
    void (*release)(ChafaPicture *picture);
} ChafaFunctions;

#define CHAFA_MODULE_SYMBOL "scn_chafa_functions"

#endif
