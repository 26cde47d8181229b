// The furnace as a picture: a panel for each material, written as SVG. Colors are classes, of which
// a page in dark has its own.
#include "cli/furnace_report.h"

#include "base/utf8.h"

#include <math.h>

enum {
    PANEL_WIDTH = 330,
    PANEL_HEIGHT = 290,
    MOST_COLUMNS = 3,
    LEFT = 52, // of a panel's plot
    TOP = 58,
    PLOT_WIDTH = 260,
    PLOT_HEIGHT = 170,
    HEAD = 34, // above all panels
    FOOT = 52, // below them
    LONGEST_TITLE = 40,
};

typedef struct Panel {
    FILE *out;
    double x, y; // of the plot's upper left corner
    double top;  // the value there
} Panel;

// --- Text ----------------------------------------------------------------------------------------

static void put_escaped(FILE *out, const char *text, int longest)
{
    Str rest = str_from(text);
    const char *at = rest.at, *end = at + rest.length;
    for (int i = 0; at < end; ++i) {
        uint32_t code;
        int length = utf8_decode(at, end, &code);
        bool bad = code == UTF8_INVALID || utf8_is_control(code);
        if (i == longest) {
            fputs("…", out);
            return;
        }
        if (code == '&' || code == '<' || code == '>' || code == '"') {
            fprintf(out, "&#%u;", (unsigned)code);
        } else if (bad) {
            fputs("\xef\xbf\xbd", out);
        } else {
            fwrite(at, 1, (size_t)length, out);
        }
        at += length;
    }
}

static void begin_picture(FILE *out, int width, int height, const char *title)
{
    fprintf(out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%d\" height=\"%d\" "
            "viewBox=\"0 0 %d %d\" font-family=\"sans-serif\">\n",
            width, height, width, height);
    fputs("<style>\n"
          ".paper { fill: #ffffff } .ink { fill: #24292f } .faint { fill: #59636e }\n"
          ".grid { stroke: #d8dee4; stroke-width: 1 } .axis { stroke: #59636e; stroke-width: 1 }\n"
          ".one { stroke: #24292f; stroke-width: 1.2 }\n"
          ".line { fill: none; stroke-width: 1.8 } .band { opacity: 0.2; stroke: none }\n"
          ".behind { stroke-width: 1.1; opacity: 0.75 }\n"
          ".s0 { stroke: #cf222e } .s1 { stroke: #1a7f37 } .s2 { stroke: #0969da }\n"
          ".s3 { stroke: #24292f }\n"
          ".f0 { fill: #cf222e } .f1 { fill: #1a7f37 } .f2 { fill: #0969da } .f3 { fill: #24292f "
          "}\n"
          ".bad { fill: #9a6700 }\n"
          "@media (prefers-color-scheme: dark) {\n"
          ".paper { fill: #0d1117 } .ink { fill: #e6edf3 } .faint { fill: #9198a1 }\n"
          ".grid { stroke: #2d333b } .axis { stroke: #9198a1 } .one { stroke: #e6edf3 }\n"
          ".s0 { stroke: #ff7b72 } .s1 { stroke: #56d364 } .s2 { stroke: #79c0ff }\n"
          ".s3 { stroke: #e6edf3 }\n"
          ".f0 { fill: #ff7b72 } .f1 { fill: #56d364 } .f2 { fill: #79c0ff } .f3 { fill: #e6edf3 "
          "}\n"
          ".bad { fill: #d29922 }\n"
          "}\n</style>\n",
          out);
    fprintf(out, "<rect class=\"paper\" width=\"%d\" height=\"%d\"/>\n", width, height);
    fputs("<text class=\"ink\" x=\"14\" y=\"23\" font-size=\"15\" font-weight=\"bold\">", out);
    put_escaped(out, title, 80);
    fputs(": what comes back of light from all around</text>\n", out);
}

// --- Axes ----------------------------------------------------------------------------------------

static double place_x(const Panel *panel, double degrees)
{
    return panel->x + degrees / 90 * PLOT_WIDTH;
}

static double place_y(const Panel *panel, double value)
{
    return panel->y + (1 - value / panel->top) * PLOT_HEIGHT;
}

// The least of 1, 1.2, 1.4, … that holds all of it.
static double highest(const FurnaceReport *report)
{
    double most = 1;
    for (int side = 0; side <= report->both_sides; ++side) {
        for (int i = 0; i < FURNACE_ANGLES; ++i) {
            for (int c = 0; c < 3; ++c) {
                most = fmax(most, report->sides[side][i].total[c]);
            }
        }
    }
    return most > 1.005 ? fmin(ceil(most * 5 + 0.01) / 5, 10) : 1;
}

static void draw_axes(const Panel *panel)
{
    FILE *out = panel->out;
    double step = panel->top > 2 ? 1 : 0.2;
    for (int i = 0; i * step <= panel->top + 1e-9; ++i) {
        double y = place_y(panel, i * step);
        bool one = fabs(i * step - 1) < 1e-9;
        fprintf(out, "<line class=\"%s\" x1=\"%g\" y1=\"%.1f\" x2=\"%g\" y2=\"%.1f\"/>\n",
                i == 0 ? "axis"
                : one  ? "one"
                       : "grid",
                panel->x, y, panel->x + PLOT_WIDTH, y);
        fprintf(out,
                "<text class=\"faint\" x=\"%g\" y=\"%.1f\" font-size=\"11\" "
                "text-anchor=\"end\">%.1f</text>\n",
                panel->x - 6, y + 4, i * step);
    }
    for (int degrees = 0; degrees <= 90; degrees += 15) {
        double x = place_x(panel, degrees);
        fprintf(out, "<line class=\"axis\" x1=\"%.1f\" y1=\"%g\" x2=\"%.1f\" y2=\"%g\"/>\n", x,
                panel->y + PLOT_HEIGHT, x, panel->y + PLOT_HEIGHT + 4);
        if (degrees % 30 == 0) {
            fprintf(out,
                    "<text class=\"faint\" x=\"%.1f\" y=\"%g\" font-size=\"11\" "
                    "text-anchor=\"middle\">%d°</text>\n",
                    x, panel->y + PLOT_HEIGHT + 17, degrees);
        }
    }
    fprintf(out,
            "<text class=\"faint\" x=\"%g\" y=\"%g\" font-size=\"11\" "
            "text-anchor=\"middle\">angle from the normal</text>\n",
            panel->x + PLOT_WIDTH / 2.0, panel->y + PLOT_HEIGHT + 33);
    fprintf(out,
            "<text class=\"faint\" transform=\"translate(%g %g) rotate(-90)\" font-size=\"11\" "
            "text-anchor=\"middle\">part of the light</text>\n",
            panel->x - 36, panel->y + PLOT_HEIGHT / 2.0);
}

// --- Curves --------------------------------------------------------------------------------------

static const char *const dashes[] = {
    [CURVE_REFLECTED] = "none", [CURVE_TRANSMITTED] = "7 4", [CURVE_TOTAL] = "2 3"};

static void draw_band(const Panel *panel, const FurnacePoint *points, FurnaceCurve curve,
                      int channel, int color)
{
    fprintf(panel->out, "<path class=\"band f%d\" d=\"", color);
    for (int i = 0; i < 2 * FURNACE_ANGLES; ++i) {
        bool up = i < FURNACE_ANGLES;
        const FurnacePoint *p = &points[up ? i : 2 * FURNACE_ANGLES - 1 - i];
        double half = furnace_half_width(p, curve, channel);
        double value = furnace_value(p, curve, channel) + (up ? half : -half);
        fprintf(panel->out, "%c%.1f %.2f", i ? 'L' : 'M', place_x(panel, p->angle * 180 / PI),
                place_y(panel, fmax(value, 0)));
    }
    fputs("Z\"/>\n", panel->out);
}

static void draw_curve(const Panel *panel, const FurnacePoint *points, FurnaceCurve curve,
                       int channel, int color, bool behind)
{
    fprintf(panel->out, "<path class=\"line s%d%s\" stroke-dasharray=\"%s\" d=\"", color,
            behind ? " behind" : "", dashes[curve]);
    for (int i = 0; i < FURNACE_ANGLES; ++i) {
        fprintf(panel->out, "%c%.1f %.2f", i ? 'L' : 'M',
                place_x(panel, points[i].angle * 180 / PI),
                place_y(panel, furnace_value(&points[i], curve, channel)));
    }
    fputs("\"/>\n", panel->out);
}

static void draw_curves(const Panel *panel, const FurnaceReport *report)
{
    bool colored = furnace_is_colored(report);
    int last = furnace_transmits(report) ? CURVE_TOTAL : CURVE_REFLECTED;
    for (int side = report->both_sides; side >= 0; --side) {
        for (int curve = 0; curve <= last; ++curve) {
            for (int c = 0; c < (colored ? 3 : 1); ++c) {
                int color = colored ? c : side ? 2 : 3; // without color, the back is blue
                draw_band(panel, report->sides[side], (FurnaceCurve)curve, c, color);
                draw_curve(panel, report->sides[side], (FurnaceCurve)curve, c, color, side == 1);
            }
        }
    }
}

// --- Panels --------------------------------------------------------------------------------------

static const char *law_word(FurnaceVerdict verdict, const char *holds, const char *broken)
{
    return verdict == FURNACE_BROKEN ? broken : verdict == FURNACE_HOLDS ? holds : "";
}

static void draw_titles(const Panel *panel, Loading *loading, const FurnaceSubject *subject)
{
    const FurnaceReport *report = &subject->report;
    FILE *out = panel->out;
    fprintf(out, "<text class=\"ink\" x=\"%g\" y=\"%g\" font-size=\"13\" font-weight=\"bold\">",
            panel->x, panel->y - 31);
    if (*subject->name) {
        put_escaped(out, subject->name, LONGEST_TITLE);
    } else {
        Place place = source_place(&loading->lang.sources, subject->at.file, subject->at.begin);
        fprintf(out, "line %u", (unsigned)place.line);
    }
    fprintf(out, "<tspan class=\"faint\" font-weight=\"normal\"> %s</tspan></text>\n",
            subject->kind);
    bool broken = report->energy == FURNACE_BROKEN || report->reciprocity == FURNACE_BROKEN ||
                  report->sampling == FURNACE_BROKEN;
    const char *reciprocal = law_word(report->reciprocity, ", reciprocal", ", not reciprocal");
    const char *sampled = law_word(report->sampling, "", ", sampled wrongly");
    fprintf(out, "<text class=\"%s\" x=\"%g\" y=\"%g\" font-size=\"11\">%s%s%s</text>\n",
            broken ? "bad" : "faint", panel->x, panel->y - 15,
            law_word(report->energy, "energy kept", "gains energy"), reciprocal, sampled);
}

static void draw_panel(FILE *out, Loading *loading, const FurnaceSubject *subject, int column,
                       int row)
{
    Panel panel = {out, column * PANEL_WIDTH + LEFT, HEAD + row * PANEL_HEIGHT + TOP,
                   highest(&subject->report)};
    draw_titles(&panel, loading, subject);
    draw_axes(&panel);
    draw_curves(&panel, &subject->report);
}

static void draw_key(FILE *out, double x, double y, const char *classes, const char *dash,
                     const char *text)
{
    fprintf(out,
            "<line class=\"line %s\" stroke-dasharray=\"%s\" x1=\"%g\" y1=\"%g\" x2=\"%g\" "
            "y2=\"%g\"/>\n",
            classes, dash, x, y - 4, x + 26, y - 4);
    fprintf(out, "<text class=\"ink\" x=\"%g\" y=\"%g\" font-size=\"11\">%s</text>\n", x + 32, y,
            text);
}

// What the lines mean, as far as there are such ones. In two rows, for a single column, too.
static void draw_legend(FILE *out, const FurnaceSubjects *subjects, double y)
{
    bool transmits = false, sides = false, colored = false;
    for (size_t i = 0; i < subjects->count; ++i) {
        const FurnaceReport *report = &subjects->items[i].report;
        transmits |= furnace_transmits(report);
        sides |= report->both_sides;
        colored |= furnace_is_colored(report);
    }
    draw_key(out, 16, y, "s3", dashes[CURVE_REFLECTED], "reflected");
    if (transmits) {
        draw_key(out, 120, y, "s3", dashes[CURVE_TRANSMITTED], "transmitted");
        draw_key(out, 232, y, "s3", dashes[CURVE_TOTAL], "together");
    }
    if (sides) {
        draw_key(out, 16, y + 19, "s2 behind", "none", "thin: from behind");
    }
    if (colored) {
        static const char *const names[] = {"red", "green", "blue"};
        for (int c = 0; c < 3; ++c) {
            char classes[] = {'s', (char)('0' + c), '\0'};
            draw_key(out, 160 + 80 * c - (sides ? 0 : 144), y + 19, classes, "none", names[c]);
        }
    }
}

static const char *base_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

void furnace_write_svg(FILE *out, Loading *loading, const FurnaceSubjects *subjects)
{
    int count = (int)subjects->count, columns = count < MOST_COLUMNS ? count : MOST_COLUMNS;
    int rows = (count + columns - 1) / columns;
    int width = columns * PANEL_WIDTH + 14;
    begin_picture(out, width < 420 ? 420 : width, HEAD + rows * PANEL_HEIGHT + FOOT,
                  base_name(loading->shown));
    for (int i = 0; i < count; ++i) {
        draw_panel(out, loading, &subjects->items[i], i % columns, i / columns);
    }
    draw_legend(out, subjects, HEAD + rows * PANEL_HEIGHT + 20);
    fputs("</svg>\n", out);
}
