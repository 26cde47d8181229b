#include "lsp/uri.h"

#include <string.h>
#include <strings.h>

static int hex(char c)
{
    return c >= '0' && c <= '9'                     ? c - '0'
           : (c | 0x20) >= 'a' && (c | 0x20) <= 'f' ? (c | 0x20) - 'a' + 10
                                                    : -1;
}

// RFC 8089: file:///path, file://localhost/path and file:/path.
const char *uri_to_path(Arena *arena, Str uri)
{
    if (uri.length < 6 || strncasecmp(uri.at, "file:", 5) != 0 || uri.at[5] != '/') {
        return NULL;
    }
    const char *at = uri.at + 5, *end = uri.at + uri.length;
    if (end - at >= 2 && at[1] == '/') {
        const char *host = at + 2;
        at = memchr(host, '/', (size_t)(end - host));
        bool here =
            at && (at == host || (at - host == 9 && strncasecmp(host, "localhost", 9) == 0));
        if (!here) {
            return NULL;
        }
    }
    char *path = arena_alloc(arena, (size_t)(end - at) + 1), *out = path;
    while (path && at < end && *at != '?' && *at != '#') {
        if (*at != '%') {
            *out++ = *at++;
            continue;
        }
        int high = end - at > 2 ? hex(at[1]) : -1, low = end - at > 2 ? hex(at[2]) : -1;
        if (high < 0 || low < 0 || high + low == 0) {
            return NULL;
        }
        *out++ = (char)(high << 4 | low);
        at += 3;
    }
    if (path) {
        *out = '\0';
    }
    return path;
}

static bool is_plain(char c)
{
    return (c >= '0' && c <= '9') || ((c | 0x20) >= 'a' && (c | 0x20) <= 'z') ||
           (c != '\0' && strchr("-._~/", c));
}

const char *uri_from_path(Arena *arena, const char *path)
{
    static const char digits[] = "0123456789ABCDEF";
    size_t length = strlen(path);
    char *uri = arena_alloc(arena, length * 3 + 8), *out = uri;
    if (!uri) {
        return NULL;
    }
    memcpy(out, "file://", 7);
    out += 7;
    for (; *path; ++path) {
        if (is_plain(*path)) {
            *out++ = *path;
        } else {
            *out++ = '%';
            *out++ = digits[(unsigned char)*path >> 4];
            *out++ = digits[(unsigned char)*path & 15];
        }
    }
    *out = '\0';
    return uri;
}
