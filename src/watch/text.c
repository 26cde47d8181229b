#include "watch/text.h"

#include "base/mem.h"

#include <stdarg.h>
#include <string.h>
#include <sys/types.h>

static bool reserve(Text *text, size_t more)
{
    if (text->failed || more >= SIZE_MAX / 2 - text->length) {
        text->failed = true;
        return false;
    }
    if (text->length + more < text->capacity) {
        return true;
    }
    size_t capacity = text->capacity * 2 + more + 64;
    char *grown = mem_realloc(text->bytes, capacity, 1);
    if (!grown) {
        text->failed = true;
        return false;
    }
    text->bytes = grown;
    text->capacity = capacity;
    return true;
}

void text_write(Text *text, const char *bytes, size_t length)
{
    if (reserve(text, length)) {
        memcpy(text->bytes + text->length, bytes, length);
        text->length += length;
        text->bytes[text->length] = '\0';
    }
}

void text_print(Text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    int length = vsnprintf(NULL, 0, format, arguments);
    va_end(arguments);
    if (length < 0 || !reserve(text, (size_t)length)) {
        text->failed = true;
        return;
    }
    va_start(arguments, format);
    vsnprintf(text->bytes + text->length, (size_t)length + 1, format, arguments);
    va_end(arguments);
    text->length += (size_t)length;
}

void text_shell_word(Text *text, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_-./=:,+@%";
    if (text->length > 0) {
        text_print(text, " ");
    }
    if (*word && strspn(word, plain) == strlen(word)) {
        text_print(text, "%s", word);
        return;
    }
    text_print(text, "'");
    for (const char *at = word; *at; ++at) {
        text_print(text, *at == '\'' ? "'\\''" : "%c", *at);
    }
    text_print(text, "'");
}

static ssize_t write_cookie(void *cookie, const char *bytes, size_t length)
{
    Text *text = cookie;
    text_write(text, bytes, length);
    return text->failed ? 0 : (ssize_t)length;
}

FILE *text_stream(Text *text)
{
    return fopencookie(text, "w", (cookie_io_functions_t){.write = write_cookie});
}

void text_free(Text *text)
{
    mem_free(text->bytes);
    *text = (Text){0};
}
