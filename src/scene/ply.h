// PLY files: their header, and their numbers one after another. The format is Greg Turk's "The PLY
// Polygon File Format" (Stanford, 1994).
#ifndef SCENE_PLY_H
#define SCENE_PLY_H

#include "base/str.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum PlyType {
    PLY_NONE,
    PLY_INT8,
    PLY_UINT8,
    PLY_INT16,
    PLY_UINT16,
    PLY_INT32,
    PLY_UINT32,
    PLY_FLOAT32,
    PLY_FLOAT64,
    PLY_TYPE_COUNT
} PlyType;

typedef struct PlyTypeInfo {
    const char *name, *other_name;
    uint8_t size;
    bool whole; // a whole number between min and max
    double min, max;
} PlyTypeInfo;

const PlyTypeInfo *ply_type_info(PlyType type);

// What we want of an element's properties.
typedef enum PlyRole {
    ROLE_X,
    ROLE_Y,
    ROLE_Z,
    ROLE_NX,
    ROLE_NY,
    ROLE_NZ,
    ROLE_U,
    ROLE_V,
    ROLE_RED,
    ROLE_GREEN,
    ROLE_BLUE,
    ROLE_INDICES, // a list
    ROLE_COUNT,
    ROLE_OTHER = ROLE_COUNT
} PlyRole;

typedef enum PlyElementKind { PLY_OTHER, PLY_VERTEX, PLY_FACE, PLY_STRIPS } PlyElementKind;

typedef struct PlyProperty {
    Str name;
    PlyType type;
    PlyType count_type; // of a list; PLY_NONE for a single number
    PlyRole role;
} PlyProperty;

typedef struct PlyElement {
    Str name;
    PlyElementKind kind;
    uint64_t count;
    uint32_t first, property_count; // in Ply.properties
    size_t stride;                  // bytes in a binary file; 0 when a list makes it vary
    const char *start;              // where its data begins, and in which line
    uint64_t line;
} PlyElement;

enum { PLY_MOST_ELEMENTS = 64, PLY_MOST_PROPERTIES = 512 };

typedef struct Ply {
    const char *bytes, *end;
    const char *at;       // read so far
    const char *line_end; // of the line at hand; NULL when `at` is a line's beginning
    const char *newline;  // the next \n; found once, also where lines end with \r
    uint64_t line;        // its number, from 1
    bool in_body, ascii, big_endian;
    PlyElement elements[PLY_MOST_ELEMENTS];
    PlyProperty properties[PLY_MOST_PROPERTIES];
    uint32_t element_count, property_count;
    char *message;
    size_t message_size;
} Ply;

// Writes "line 12: …" or "byte 345: …" into the message, and returns false.
bool ply_fail(Ply *ply, const char *format, ...) __attribute__((format(printf, 2, 3)));

// Reads the header; at the end ply->at is the first byte of the data.
bool ply_read_header(Ply *ply);

// ASCII: leaves the line at hand, so that ply->at is where the next one begins.
void ply_leave_line(Ply *ply);
// ASCII: moves to the next line that isn't blank and sets ply->at to its beginning; false (without
// a message) at the end of the file.
bool ply_next_line(Ply *ply);
// The next number: in binary the next bytes, in ASCII the next word of the line at hand. The
// property is named in messages.
bool ply_number(Ply *ply, PlyType type, const PlyProperty *property, double *value);
// The count of a list that is about to be read; in binary its items are known to be there.
bool ply_list_count(Ply *ply, const PlyProperty *property, uint32_t *count);
// Passes over `count` numbers.
bool ply_skip(Ply *ply, const PlyProperty *property, uint64_t count);
// ASCII: nothing may be left in the line.
bool ply_end_of_line(Ply *ply, const PlyElement *element);

#endif
