// The page's files, put into the program by embed.cmake.
#ifndef WATCH_PAGE_H
#define WATCH_PAGE_H

#include <stddef.h>

typedef struct PageFile {
    const char *name, *type; // "page.js", "text/javascript; charset=utf-8"
    const unsigned char *bytes;
    size_t size;
} PageFile;

extern const PageFile page_files[];
extern const size_t page_file_count;

#endif
