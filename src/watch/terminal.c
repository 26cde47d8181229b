#include "watch/terminal.h"

#include "base/mem.h"
#include "base/module.h"
#include "base/number.h"
#include "watch/inspect.h"

#include <cjson/cJSON.h>
#include <math.h>
#include <string.h>

enum { FALLBACK_CELL_WIDTH = 10, FALLBACK_CELL_HEIGHT = 20, LONGEST_LINE = 400 };

struct Terminal {
    Session *session;
    const ChafaFunctions *chafa;
    TerminalMode mode;
    char said[LONGEST_LINE];
    bool help, explain; // shown: the keys; what stands in the middle
    size_t param;       // the one that is chosen
};

static const char help_line[] =
    "q quit  space pause  arrows turn, shift+arrows move, + - nearer  0 as it was  c camera  "
    "e E exposure  t tone  tab [ ] params  r reset  i what is it  s save  h less";
static const char short_help[] = "h keys  q quit";

// --- Beginning and end ---------------------------------------------------------------------------

static bool choose_mode(Terminal *terminal, const char *mode)
{
    static const char *const names[] = {
        [TERMINAL_BLOCKS] = "blocks", [TERMINAL_SIXEL] = "sixel", [TERMINAL_KITTY] = "kitty"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; ++i) {
        if (strcmp(mode, names[i]) == 0) {
            terminal->mode = (TerminalMode)i;
            return true;
        }
    }
    terminal->mode = terminal->chafa->detect();
    return !*mode;
}

Terminal *terminal_new(Session *session, const char *mode, char *message, size_t message_size)
{
    void *module = module_open("scn_chafa", message, message_size);
    const ChafaFunctions *chafa = module ? module_symbol(module, CHAFA_MODULE_SYMBOL) : NULL;
    if (!chafa || chafa->version != CHAFA_MODULE_VERSION) {
        if (module) {
            snprintf(message, message_size, "the module scn_chafa.so is of another version");
        }
        return NULL;
    }
    Terminal *terminal = mem_alloc_zeroed(1, sizeof *terminal);
    if (!terminal) {
        snprintf(message, message_size, "not enough memory");
        return NULL;
    }
    terminal->session = session;
    terminal->chafa = chafa;
    if (!choose_mode(terminal, mode)) {
        snprintf(message, message_size, "`--terminal` takes blocks, sixel or kitty, not `%s`",
                 mode);
        mem_free(terminal);
        return NULL;
    }
    return terminal;
}

void terminal_free(Terminal *terminal)
{
    mem_free(terminal);
}

// The other screen, no cursor.
void terminal_enter(Text *out)
{
    text_print(out, "\x1b[?1049h\x1b[?25l\x1b[2J");
}

void terminal_leave(Text *out)
{
    text_print(out, "\x1b[0m\x1b[?25h\x1b[?1049l");
}

void terminal_say(Terminal *terminal, const char *text)
{
    snprintf(terminal->said, sizeof terminal->said, "%s", text);
}

// --- Lines ---------------------------------------------------------------------------------------

// As much of a text as `columns` hold, control characters left out.
static void add_line(Text *out, int row, int columns, const char *style, const char *text)
{
    text_print(out, "\x1b[%d;1H\x1b[0m%s", row, style);
    int used = 0;
    for (const char *at = text; *at && *at != '\n'; ++at) {
        bool starts = ((unsigned char)*at & 0xc0) != 0x80;
        if (starts && used++ >= columns) {
            break;
        }
        if ((unsigned char)*at >= 0x20 && *at != 0x7f) {
            text_write(out, at, 1);
        }
    }
    text_print(out, "\x1b[0m\x1b[K");
}

static int count_lines(const Text *text)
{
    int lines = 0;
    for (size_t i = 0; i < text->length; ++i) {
        lines += text->bytes[i] == '\n';
    }
    return lines;
}

static void add_diagnostics(Text *out, int row, int rows, int columns, const Text *text)
{
    const char *at = text->bytes;
    for (int i = 0; at && *at && i < rows; ++i) {
        bool headline = strncmp(at, "error", 5) == 0;
        bool caret = at[strspn(at, " |")] == '^';
        add_line(out, row + i, columns, headline ? "\x1b[1;31m" : caret ? "\x1b[31m" : "", at);
        at = strchr(at, '\n');
        at += at ? 1 : 0;
    }
}

static void duration(double seconds, Text *out)
{
    if (!(seconds < 3600 * 100)) {
        text_print(out, "?");
    } else if (seconds < 59.5) {
        text_print(out, seconds < 9.95 ? "%.1f s" : "%.0f s", seconds);
    } else {
        text_print(out, "%ld:%02ld", lround(seconds) / 60, lround(seconds) % 60);
    }
}

static void status_line(const Terminal *terminal, const SessionStatus *status, Text *out)
{
    static const char *const phases[] = {[PHASE_EVALUATING] = "evaluating",
                                         [PHASE_RENDERING] = "rendering",
                                         [PHASE_DONE] = "done",
                                         [PHASE_PAUSED] = "paused",
                                         [PHASE_FAILED] = "no picture"};
    text_print(out, " %s  %.0f of %lld samples  ", phases[status->phase], floor(status->samples),
               (long long)status->wanted);
    if (status->rays_per_second > 0) {
        text_print(out, "%.2f Mrays/s  ", status->rays_per_second * 1e-6);
    }
    if (isfinite(status->error)) {
        text_print(out, "error %.2g %%  ", status->error * 100);
    }
    duration(status->seconds, out);
    if (status->phase == PHASE_RENDERING && isfinite(status->seconds_left)) {
        text_print(out, ", ");
        duration(status->seconds_left, out);
        text_print(out, " left");
    }
    text_print(out, "   %s", terminal->help ? "" : short_help);
}

// --- What stands in the middle -------------------------------------------------------------------

static void add_node(const cJSON *node, const char *before, Text *out)
{
    const char *kind = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(node, "kind"));
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(node, "name"));
    const char *file = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(node, "file"));
    const cJSON *line = cJSON_GetObjectItemCaseSensitive(node, "line");
    if (kind) {
        text_print(out, "%s%s%s%s", before, name ? name : "", name && *name ? " " : "", kind);
    }
    if (file && line) {
        const char *slash = strrchr(file, '/');
        text_print(out, " %s:%d", slash ? slash + 1 : file, (int)cJSON_GetNumberValue(line));
    }
}

static void explain_line(const Terminal *terminal, Text *out)
{
    SessionLook look;
    Snapshot *picture = session_picture(terminal->session, &look);
    Text text = {0};
    if (picture) {
        text = inspect_json(picture, 0.5, 0.5);
    }
    snapshot_release(picture);
    cJSON *json = text.bytes ? cJSON_ParseWithLength(text.bytes, text.length) : NULL;
    text_free(&text);
    const cJSON *object = cJSON_GetObjectItemCaseSensitive(json, "object");
    const cJSON *lights = cJSON_GetObjectItemCaseSensitive(json, "lights");
    text_print(out, " in the middle: ");
    add_node(object, "", out);
    text_print(out, object ? "" : "nothing");
    add_node(cJSON_GetObjectItemCaseSensitive(json, "material"), ", ", out);
    add_node(cJSON_GetArrayItem(lights, 0), ", lit by ", out);
    const cJSON *depth = cJSON_GetObjectItemCaseSensitive(json, "depth");
    if (depth) {
        text_print(out, ", depth %.4g m", cJSON_GetNumberValue(depth));
    }
    text_print(out, ", %.4g cd/m2",
               cJSON_GetNumberValue(cJSON_GetObjectItemCaseSensitive(json, "luminance")));
    cJSON_Delete(json);
}

// --- Params --------------------------------------------------------------------------------------

static cJSON *get_params(const Terminal *terminal)
{
    Text text = session_scene_json(terminal->session);
    cJSON *scene = text.failed ? NULL : cJSON_ParseWithLength(text.bytes, text.length);
    cJSON *params = cJSON_DetachItemFromObjectCaseSensitive(scene, "params");
    cJSON_Delete(scene);
    text_free(&text);
    return params;
}

// A number of the language as JSON has it: 3, "0.2m"; its unit in *unit.
static bool number_of(const cJSON *value, double *number, char *unit, size_t unit_size)
{
    snprintf(unit, unit_size, "%s", "");
    if (cJSON_IsNumber(value)) {
        *number = value->valuedouble;
        return true;
    }
    const char *text = cJSON_GetStringValue(value);
    const char *rest = text ? number_parse(text, text + strlen(text), number) : NULL;
    if (!rest) {
        return false;
    }
    snprintf(unit, unit_size, "%s", rest);
    return true;
}

static void value_text(const cJSON *value, Text *out)
{
    if (cJSON_IsString(value)) {
        text_print(out, "%s", value->valuestring);
    } else if (cJSON_IsNumber(value)) {
        text_print(out, "%.10g", value->valuedouble);
    } else {
        text_print(out, "%s", cJSON_IsTrue(value) ? "true" : cJSON_IsFalse(value) ? "false" : "?");
    }
}

// The value that is one step on; false where the param has no steps.
static bool step_value(const cJSON *param, int by, Text *out)
{
    const cJSON *value = cJSON_GetObjectItemCaseSensitive(param, "value");
    const cJSON *choices = cJSON_GetObjectItemCaseSensitive(param, "choices");
    if (cJSON_IsBool(value)) {
        text_print(out, cJSON_IsTrue(value) ? "false" : "true");
        return true;
    }
    if (choices) {
        int count = cJSON_GetArraySize(choices), at = 0;
        while (at < count && !cJSON_Compare(cJSON_GetArrayItem(choices, at), value, true)) {
            ++at;
        }
        value_text(cJSON_GetArrayItem(choices, count > 0 ? (at + by + count) % count : 0), out);
        return count > 0;
    }
    double number, min, max;
    char unit[40], ignored[40];
    if (!number_of(value, &number, unit, sizeof unit) ||
        !number_of(cJSON_GetObjectItemCaseSensitive(param, "min"), &min, ignored, sizeof ignored) ||
        !number_of(cJSON_GetObjectItemCaseSensitive(param, "max"), &max, ignored, sizeof ignored)) {
        return false;
    }
    const char *type = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(param, "type"));
    double step = type && strcmp(type, "int") == 0 ? 1 : (max - min) / 40;
    text_print(out, "%.6g%s", fmax(min, fmin(max, number + by * step)), unit);
    return true;
}

static void step_param(Terminal *terminal, int by)
{
    cJSON *params = get_params(terminal);
    const cJSON *param = cJSON_GetArrayItem(params, (int)terminal->param);
    const char *name = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(param, "name"));
    Text value = {0};
    char message[200] = "this param has no range to step through; the page can set it";
    if (!name) {
        terminal_say(terminal, "the scene has no params");
    } else if (!step_value(param, by, &value) ||
               !session_set(terminal->session, name, value.bytes, message, sizeof message)) {
        terminal_say(terminal, message);
    } else {
        snprintf(terminal->said, sizeof terminal->said, "%s = %s", name, value.bytes);
    }
    text_free(&value);
    cJSON_Delete(params);
}

static void choose_param(Terminal *terminal, int by)
{
    cJSON *params = get_params(terminal);
    int count = cJSON_GetArraySize(params);
    if (count > 0) {
        terminal->param = (size_t)(((int)terminal->param + by + count) % count);
        const cJSON *param = cJSON_GetArrayItem(params, (int)terminal->param);
        Text text = {0};
        text_print(&text, "[ ] changes %s = ",
                   cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(param, "name")));
        value_text(cJSON_GetObjectItemCaseSensitive(param, "value"), &text);
        text_print(&text, "   %s",
                   cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(param, "description")));
        terminal_say(terminal, text.bytes ? text.bytes : "");
        text_free(&text);
    } else {
        terminal_say(terminal, "the scene has no params");
    }
    cJSON_Delete(params);
}

// --- The screen ----------------------------------------------------------------------------------

static void add_picture(const Terminal *terminal, TerminalSize size, int rows, Text *out)
{
    SessionLook look;
    Snapshot *picture = session_picture(terminal->session, &look);
    unsigned char *rgba = picture ? mem_alloc((size_t)picture->width * picture->height, 4) : NULL;
    if (rgba && rows > 0) {
        snapshot_develop(picture, look.exposure, look.tone, rgba);
        ChafaPicture drawn = {
            .mode = terminal->mode,
            .rgba = rgba,
            .width = (int)picture->width,
            .height = (int)picture->height,
            .columns = size.columns,
            .rows = rows,
            .cell_width = size.width > 0 ? size.width / size.columns : FALLBACK_CELL_WIDTH,
            .cell_height = size.height > 0 ? size.height / size.rows : FALLBACK_CELL_HEIGHT,
        };
        if (terminal->mode == TERMINAL_KITTY) {
            text_print(out, "\x1b_Ga=d\x1b\\"); // pictures lie in layers there
        }
        if (terminal->chafa->draw(&drawn)) {
            int column = (size.columns - drawn.drawn_columns) / 2 + 1;
            const char *at = drawn.bytes, *end = drawn.bytes + drawn.size;
            for (int row = 1; at < end; ++row) { // lines of blocks; one line of graphics
                const char *line_end = memchr(at, '\n', (size_t)(end - at));
                line_end = line_end ? line_end : end;
                text_print(out, "\x1b[%d;%dH", row, column > 0 ? column : 1);
                text_write(out, at, (size_t)(line_end - at));
                at = line_end + 1;
            }
            terminal->chafa->release(&drawn);
        }
    }
    mem_free(rgba);
    snapshot_release(picture);
}

void terminal_draw(Terminal *terminal, TerminalSize size, bool whole, Text *out)
{
    if (size.columns < 4 || size.rows < 4) {
        return;
    }
    SessionStatus status = session_status(terminal->session);
    Text diagnostics = {0}, line = {0};
    if (status.errors > 0) {
        diagnostics = session_diagnostics(terminal->session);
    }
    int most = size.rows / 2, wrong = count_lines(&diagnostics);
    wrong = wrong < most ? wrong : most;
    int picture_rows = size.rows - 2 - wrong;
    text_print(out, "\x1b[?2026h%s", whole ? "\x1b[0m\x1b[2J" : "");
    add_picture(terminal, size, picture_rows, out);
    add_diagnostics(out, picture_rows + 1, wrong, size.columns, &diagnostics);
    status_line(terminal, &status, &line);
    add_line(out, size.rows - 1, size.columns, "\x1b[7m", line.bytes ? line.bytes : "");
    text_free(&line);
    if (terminal->explain) {
        explain_line(terminal, &line);
    }
    const char *last = *terminal->said     ? terminal->said
                       : terminal->explain ? line.bytes
                       : terminal->help    ? help_line
                                           : "";
    add_line(out, size.rows, size.columns, "", last ? last : "");
    text_print(out, "\x1b[?2026l");
    text_free(&line);
    text_free(&diagnostics);
}

// --- Keys ----------------------------------------------------------------------------------------

static TerminalWish camera_key(Terminal *terminal, CameraMove move)
{
    char message[200];
    if (!session_move_camera(terminal->session, move, message, sizeof message)) {
        terminal_say(terminal, message);
    }
    return WISH_REDRAW;
}

static TerminalWish next_camera(Terminal *terminal)
{
    char message[200];
    static const uint32_t first = 0;
    Text view = session_view_json(terminal->session);
    cJSON *json = view.failed ? NULL : cJSON_ParseWithLength(view.bytes, view.length);
    const cJSON *camera = cJSON_GetObjectItemCaseSensitive(json, "camera");
    uint32_t next = cJSON_IsNumber(camera) ? (uint32_t)camera->valuedouble + 1 : first;
    if (!session_choose_camera(terminal->session, next, message, sizeof message) &&
        !session_choose_camera(terminal->session, first, message, sizeof message)) {
        terminal_say(terminal, message);
    }
    cJSON_Delete(json);
    text_free(&view);
    return WISH_REDRAW;
}

static TerminalWish put_camera_back(Terminal *terminal)
{
    char message[200];
    Text view = session_view_json(terminal->session);
    cJSON *json = view.failed ? NULL : cJSON_ParseWithLength(view.bytes, view.length);
    const cJSON *camera = cJSON_GetObjectItemCaseSensitive(json, "camera");
    session_choose_camera(terminal->session,
                          cJSON_IsNumber(camera) ? (uint32_t)camera->valuedouble : NONE_ID, message,
                          sizeof message);
    cJSON_Delete(json);
    text_free(&view);
    return WISH_REDRAW;
}

static TerminalWish change_look(Terminal *terminal, double stops, bool next_tone)
{
    SessionLook look;
    Snapshot *picture = session_picture(terminal->session, &look);
    if (picture) {
        int tone = next_tone ? (look.tone == TONE_FILMIC ? 0 : (int)look.tone + 1) : (int)look.tone;
        char message[200];
        if (session_set_look(terminal->session, look.exposure + stops, tone, message,
                             sizeof message)) {
            snprintf(message, sizeof message, "exposure %.3g, tone curve %s", look.exposure + stops,
                     tone_names[tone]);
        }
        terminal_say(terminal, message);
    }
    snapshot_release(picture);
    return WISH_REDRAW;
}

static TerminalWish toggle_pause(Terminal *terminal)
{
    SessionStatus status = session_status(terminal->session);
    session_pause(terminal->session, status.phase != PHASE_PAUSED);
    return WISH_REDRAW;
}

static TerminalWish plain_key(Terminal *terminal, char key)
{
    *terminal->said = '\0';
    switch (key) {
    case 'q':
    case 3: // Ctrl-C, where the terminal makes no signal of it
        return WISH_QUIT;
    case ' ':
        return toggle_pause(terminal);
    case '+':
    case '=':
        return camera_key(terminal, (CameraMove){MOVE_DOLLY, 0.9, 0});
    case '-':
        return camera_key(terminal, (CameraMove){MOVE_DOLLY, 1 / 0.9, 0});
    case '0':
        return put_camera_back(terminal);
    case 'c':
        return next_camera(terminal);
    case 'e':
        return change_look(terminal, 1.0 / 3, false);
    case 'E':
        return change_look(terminal, -1.0 / 3, false);
    case 't':
        return change_look(terminal, 0, true);
    case '\t':
        choose_param(terminal, 1);
        return WISH_REDRAW;
    case '[':
        step_param(terminal, -1);
        return WISH_REDRAW;
    case ']':
        step_param(terminal, 1);
        return WISH_REDRAW;
    case 'r':
        session_reset(terminal->session);
        return WISH_REDRAW;
    case 'i':
        terminal->explain = !terminal->explain;
        return WISH_REDRAW;
    case 'h':
    case '?':
        terminal->help = !terminal->help;
        return WISH_REDRAW;
    case 's':
        return WISH_SAVE;
    default:
        return WISH_NOTHING;
    }
}

// "A" to "D" of an arrow's sequence, "Z" of Shift-Tab.
static TerminalWish sequence_key(Terminal *terminal, char last, bool shift)
{
    static const double step = 5 * PI / 180;
    double x = last == 'C' ? 1 : last == 'D' ? -1 : 0, y = last == 'A' ? 1 : last == 'B' ? -1 : 0;
    *terminal->said = '\0';
    if (last == 'Z') {
        choose_param(terminal, -1);
        return WISH_REDRAW;
    }
    if (x == 0 && y == 0) {
        return WISH_NOTHING;
    }
    return camera_key(terminal, shift ? (CameraMove){MOVE_PAN, x * 0.05, y * 0.05}
                                      : (CameraMove){MOVE_ORBIT, x * step, y * step});
}

TerminalWish terminal_keys(Terminal *terminal, const char *bytes, size_t length, size_t *used)
{
    TerminalWish wish = WISH_NOTHING;
    for (*used = 0; *used < length && wish < WISH_QUIT;) {
        TerminalWish now;
        if (bytes[*used] != '\x1b') {
            now = plain_key(terminal, bytes[(*used)++]);
        } else {
            // ESC [ parameters letter, or ESC O letter
            size_t at = *used + 1;
            bool csi = at < length && (bytes[at] == '[' || bytes[at] == 'O');
            at += csi;
            size_t begin = at;
            while (csi && at < length && (unsigned char)bytes[at] < 0x40) {
                ++at;
            }
            if (csi && at >= length) {
                break; // the rest is still on its way
            }
            bool shift = csi && at - begin >= 3 && memcmp(bytes + begin, "1;2", 3) == 0;
            now = csi ? sequence_key(terminal, bytes[at], shift) : WISH_NOTHING;
            *used = csi ? at + 1 : at;
        }
        wish = now > wish ? now : wish;
    }
    return wish;
}
