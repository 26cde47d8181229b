#include "cli/progress.h"

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { FALLBACK_WIDTH = 80, MOST_WIDTH = 200, LONGEST_BAR = 40, SHORTEST_BAR = 8 };

static const double REDRAW_SECONDS = 0.1;

void duration_text(double seconds, char *text, size_t size)
{
    if (!(seconds >= 0) || seconds > 1e9) {
        snprintf(text, size, "?");
    } else if (seconds < 9.95) {
        snprintf(text, size, "%.1f s", seconds);
    } else if (seconds < 59.5) {
        snprintf(text, size, "%.0f s", seconds);
    } else {
        long whole = lround(seconds);
        if (whole < 3600) {
            snprintf(text, size, "%ld:%02ld", whole / 60, whole % 60);
        } else {
            snprintf(text, size, "%ld:%02ld:%02ld", whole / 3600, whole / 60 % 60, whole % 60);
        }
    }
}

void count_text(double count, char *text, size_t size)
{
    static const char *const suffixes[] = {"", " k", " M", " G", " T"};
    size_t i = 0;
    while (count >= 999.5 && i + 1 < sizeof suffixes / sizeof suffixes[0]) {
        count /= 1000;
        ++i;
    }
    int digits = i == 0 || count >= 99.95 ? 0 : count >= 9.995 ? 1 : 2;
    snprintf(text, size, "%.*f%s", digits, count, suffixes[i]);
}

void bar_text(const RenderProgress *progress, int width, char *text, size_t size)
{
    char left[32], rate[32], figures[160];
    duration_text(progress->seconds_left, left, sizeof left);
    count_text(progress->seconds > 0 ? (double)progress->rays / progress->seconds : 0, rate,
               sizeof rate);
    double pixels = (double)film_pixel_count(progress->film);
    snprintf(figures, sizeof figures, "%3.0f%%  %.0f samples  %s%srays/s  %s left",
             floor(progress->fraction * 100), floor((double)progress->samples / pixels), rate,
             strchr(rate, ' ') ? "" : " ", left);
    int room = width - (int)strlen(figures) - 4; // "[bar]  " and a free last column
    int length = room > LONGEST_BAR ? LONGEST_BAR : room;
    if (length < SHORTEST_BAR) {
        snprintf(text, size, "%.*s", width > 1 ? width - 1 : 0, figures);
        return;
    }
    char bar[LONGEST_BAR + 1];
    int full = (int)(progress->fraction * length);
    memset(bar, '.', (size_t)length);
    memset(bar, '#', (size_t)(full < 0 ? 0 : full > length ? length : full));
    snprintf(text, size, "[%.*s] %s", length, bar, figures);
}

static int terminal_width(void)
{
    struct winsize window;
    bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0;
    int width = known ? window.ws_col : FALLBACK_WIDTH;
    return width < MOST_WIDTH ? width : MOST_WIDTH;
}

void bar_begin(Bar *bar, bool wanted, const char *label)
{
    *bar = (Bar){.shown = wanted && isatty(STDERR_FILENO),
                 .drawn_at = -REDRAW_SECONDS,
                 .label = label ? label : ""};
}

void bar_draw(Bar *bar, const RenderProgress *progress)
{
    if (!bar->shown || progress->seconds - bar->drawn_at < REDRAW_SECONDS) {
        return;
    }
    char text[MOST_WIDTH + 1];
    const int width = terminal_width(), label = (int)strlen(bar->label);
    bar_text(progress, width > label ? width - label : 0, text, sizeof text);
    fprintf(stderr, "\r%s%s\x1b[K", bar->label, text); // erases what is left of a longer line
    fflush(stderr);
    bar->drawn = true;
    bar->drawn_at = progress->seconds;
}

void bar_end(Bar *bar)
{
    if (bar->drawn) {
        fputs("\r\x1b[K", stderr);
        fflush(stderr);
    }
    bar->drawn = false;
}
