#include "lang/lang.h"

Limits limits_default(void)
{
    return (Limits){
#define LIMIT(id, value, text) .id = (uint64_t)(value),
        LIMITS(LIMIT)
#undef LIMIT
    };
}

static bool parse_count(Str text, uint64_t *out)
{
    uint64_t number = 0;
    for (size_t i = 0; i < text.length; ++i) {
        char c = text.at[i];
        if (c == '_' && i > 0) {
            continue;
        }
        if (c < '0' || c > '9' || __builtin_mul_overflow(number, 10u, &number) ||
            __builtin_add_overflow(number, (uint64_t)(c - '0'), &number)) {
            return false;
        }
    }
    *out = number;
    return text.length > 0;
}

bool limits_set(Limits *limits, Str assignment)
{
    const char *equals = memchr(assignment.at, '=', assignment.length);
    if (!equals) {
        return false;
    }
    Str name = {assignment.at, (size_t)(equals - assignment.at)};
    Str value = {equals + 1, assignment.length - name.length - 1};
#define LIMIT(id, standard, text)                                                                  \
    if (str_equal(name, STR(#id))) {                                                               \
        return parse_count(value, &limits->id);                                                    \
    }
    LIMITS(LIMIT)
#undef LIMIT
    return false;
}
