// Decimal numbers out of text, fast: mesh files hold millions of them.
#ifndef BASE_NUMBER_H
#define BASE_NUMBER_H

// Reads the longest number ([+-] digits [. digits] [e [+-] digits]) that [at, end) begins with,
// into *value, rounded correctly; returns what follows it, or NULL where none begins. A number
// beyond a double's range becomes infinite, one below it zero. Doesn't look at the locale.
const char *number_parse(const char *at, const char *end, double *value);

#endif
