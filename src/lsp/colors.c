// Swatches of the colors that are written out, and the ways to write one that was picked.
#include "lsp/features.h"
#include "lsp/tree.h"

#include <math.h>

// IEC 61966-2-1, for what a screen can show.
static double encode(double c)
{
    c = c <= 0.0031308 ? 12.92 * c : 1.055 * pow(c, 1 / 2.4) - 0.055;
    return c < 0 ? 0 : c > 1 ? 1 : c;
}

static double decode(double c)
{
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// What components above 1 are divided by to be shown: light may be brighter than a screen.
static double brightness(const double color[3])
{
    double most = fmax(fmax(color[0], color[1]), color[2]);
    return most > 1 ? most : 1;
}

// --- Swatches ------------------------------------------------------------------------------------

static void add_swatch(Server *server, const Document *document, const AstNode *node,
                       const double color[3], cJSON *list)
{
    static const char *const names[] = {"red", "green", "blue"};
    double scale = brightness(color);
    cJSON *swatch = cJSON_CreateObject(), *shown = cJSON_AddObjectToObject(swatch, "color");
    for (int i = 0; i < 3; ++i) {
        cJSON_AddNumberToObject(shown, names[i], encode(color[i] / scale));
    }
    cJSON_AddNumberToObject(shown, "alpha", 1);
    cJSON_AddItemToObject(swatch, "range",
                          json_range(server, &document->text, node->begin, node->end));
    cJSON_AddItemToArray(list, swatch);
}

cJSON *feature_colors(Server *server, Document *document, const cJSON *params)
{
    (void)params;
    cJSON *list = cJSON_CreateArray();
    const Analysis *analysis = document_analysis(server, document);
    const Ast *ast = analysis ? survey_ast(analysis->survey, 0) : NULL;
    for (AstId id = 1; ast && id < ast->nodes.count; ++id) {
        const AstNode *node = ast_node(ast, id);
        double color[3];
        if ((node->tag == AST_COLOR || node->tag == AST_CALL) &&
            survey_color(analysis->survey, 0, id, color)) {
            add_swatch(server, document, node, color, list);
        }
    }
    return list;
}

// --- Presentations -------------------------------------------------------------------------------

enum { FORM_SIZE = 96 };
typedef enum Form { FORM_HEX, FORM_RGB, FORM_SRGB, FORM_HSV, FORM_GRAY, FORM_COUNT } Form;

// Hue in degrees, saturation and value of linear components, as hsv() takes them.
static void to_hsv(const double c[3], double hsv[3])
{
    double most = fmax(fmax(c[0], c[1]), c[2]), least = fmin(fmin(c[0], c[1]), c[2]);
    double range = most - least, hue = 0;
    if (range > 0) {
        hue = most == c[0]   ? (c[1] - c[2]) / range
              : most == c[1] ? 2 + (c[2] - c[0]) / range
                             : 4 + (c[0] - c[1]) / range;
    }
    hsv[0] = (hue < 0 ? hue + 6 : hue) * 60;
    hsv[1] = most > 0 ? range / most : 0;
    hsv[2] = most;
}

// False where the form can't say the color.
static bool write_form(Form form, const double picked[3], double scale, char text[FORM_SIZE])
{
    double c[3], hsv[3];
    for (int i = 0; i < 3; ++i) {
        c[i] = decode(picked[i]) * scale;
    }
    switch (form) {
    case FORM_HEX:
        snprintf(text, FORM_SIZE, "#%02x%02x%02x", (unsigned)lround(picked[0] * 255),
                 (unsigned)lround(picked[1] * 255), (unsigned)lround(picked[2] * 255));
        return scale == 1;
    case FORM_RGB:
        snprintf(text, FORM_SIZE, "rgb(%.4g, %.4g, %.4g)", c[0], c[1], c[2]);
        return true;
    case FORM_SRGB:
        snprintf(text, FORM_SIZE, "srgb(%.4g, %.4g, %.4g)", picked[0], picked[1], picked[2]);
        return scale == 1;
    case FORM_HSV:
        to_hsv(c, hsv);
        snprintf(text, FORM_SIZE, "hsv(%.4gdeg, %.4g, %.4g)", hsv[0], hsv[1], hsv[2]);
        return true;
    case FORM_GRAY:
        snprintf(text, FORM_SIZE, "gray(%.4g)", c[0]);
        return picked[0] == picked[1] && picked[1] == picked[2];
    case FORM_COUNT:
        break;
    }
    return false;
}

// How the color is written now.
static Form written_form(Str text)
{
    static const char *const names[] = {"#", "rgb", "srgb", "hsv", "gray"};
    for (int i = 0; i < FORM_COUNT; ++i) {
        if (text.length >= strlen(names[i]) && memcmp(text.at, names[i], strlen(names[i])) == 0) {
            return (Form)i;
        }
    }
    return FORM_RGB;
}

// How much brighter than a screen the color at a place is.
static double written_scale(const Analysis *analysis, uint32_t begin, uint32_t end)
{
    const Ast *ast = survey_ast(analysis->survey, 0);
    TreePath path;
    tree_path(ast, begin, &path);
    for (size_t i = path.count; i-- > 0;) {
        const AstNode *node = ast_node(ast, path.nodes[i]);
        double color[3];
        if (node->begin == begin && node->end == end &&
            survey_color(analysis->survey, 0, path.nodes[i], color)) {
            return brightness(color);
        }
    }
    return 1;
}

static void add_presentation(const Server *server, const Document *document, uint32_t begin,
                             uint32_t end, const char *text, cJSON *list)
{
    cJSON *presentation = cJSON_CreateObject();
    cJSON_AddStringToObject(presentation, "label", text);
    cJSON_AddItemToObject(presentation, "textEdit",
                          json_edit(server, &document->text, begin, end, str_from(text)));
    cJSON_AddItemToArray(list, presentation);
}

cJSON *feature_color_presentations(Server *server, Document *document, const cJSON *params)
{
    const Analysis *analysis = document_analysis(server, document);
    double picked[] = {json_get_number(params, "color.red", 0),
                       json_get_number(params, "color.green", 0),
                       json_get_number(params, "color.blue", 0)};
    for (int i = 0; i < 3; ++i) {
        picked[i] = picked[i] > 0 ? fmin(picked[i], 1) : 0;
    }
    uint32_t begin, end;
    server_range(server, document, json_at(params, "range"), &begin, &end);
    Str text = buffer_content(&document->text);
    Form first = written_form((Str){text.at + begin, end - begin});
    double scale = analysis ? written_scale(analysis, begin, end) : 1;
    cJSON *list = cJSON_CreateArray();
    char form[FORM_SIZE];
    if (write_form(first, picked, scale, form)) {
        add_presentation(server, document, begin, end, form, list);
    }
    for (int i = 0; i < FORM_COUNT; ++i) {
        if ((Form)i != first && write_form((Form)i, picked, scale, form)) {
            add_presentation(server, document, begin, end, form, list);
        }
    }
    return list;
}
