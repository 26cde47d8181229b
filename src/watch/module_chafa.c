// The module scn_chafa.so: pictures as text for terminals, through libchafa.
#include "watch/chafa_module.h"

#include <chafa.h>
#include <string.h>

static ChafaTermInfo *terminal_info(void)
{
    gchar **environment = g_get_environ();
    ChafaTermInfo *info = chafa_term_db_detect(chafa_term_db_get_default(), environment);
    g_strfreev(environment);
    return info;
}

static TerminalMode detect(void)
{
    ChafaTermInfo *info = terminal_info();
    TerminalMode mode =
        chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_BEGIN_KITTY_IMMEDIATE_IMAGE_V1)
            ? TERMINAL_KITTY
        : chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_BEGIN_SIXELS) ? TERMINAL_SIXEL
                                                                      : TERMINAL_BLOCKS;
    chafa_term_info_unref(info);
    return mode;
}

// As many colours as the terminal has.
static ChafaCanvasMode colors_of(ChafaTermInfo *info)
{
    return chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_SET_COLOR_FGBG_DIRECT)
               ? CHAFA_CANVAS_MODE_TRUECOLOR
           : chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_SET_COLOR_FGBG_256)
               ? CHAFA_CANVAS_MODE_INDEXED_240
           : chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_SET_COLOR_FGBG_16)
               ? CHAFA_CANVAS_MODE_INDEXED_16
           : chafa_term_info_have_seq(info, CHAFA_TERM_SEQ_INVERT_COLORS)
               ? CHAFA_CANVAS_MODE_FGBG_BGFG
               : CHAFA_CANVAS_MODE_FGBG;
}

// What was asked for may not be known of the terminal; it is sent all the same.
static ChafaTermInfo *info_with_all(void)
{
    ChafaTermInfo *info = terminal_info();
    ChafaTermInfo *fallback = chafa_term_db_get_fallback_info(chafa_term_db_get_default());
    chafa_term_info_supplement(info, fallback);
    chafa_term_info_unref(fallback);
    return info;
}

static ChafaCanvasConfig *make_config(const ChafaPicture *picture, ChafaCanvasMode colors)
{
    static const ChafaPixelMode modes[] = {[TERMINAL_BLOCKS] = CHAFA_PIXEL_MODE_SYMBOLS,
                                           [TERMINAL_SIXEL] = CHAFA_PIXEL_MODE_SIXELS,
                                           [TERMINAL_KITTY] = CHAFA_PIXEL_MODE_KITTY};
    ChafaCanvasConfig *config = chafa_canvas_config_new();
    ChafaSymbolMap *symbols = chafa_symbol_map_new();
    chafa_symbol_map_add_by_tags(symbols, CHAFA_SYMBOL_TAG_HALF | CHAFA_SYMBOL_TAG_SPACE |
                                              CHAFA_SYMBOL_TAG_SOLID);
    chafa_canvas_config_set_symbol_map(config, symbols);
    chafa_symbol_map_unref(symbols);
    chafa_canvas_config_set_pixel_mode(config, modes[picture->mode]);
    chafa_canvas_config_set_canvas_mode(config, colors);
    chafa_canvas_config_set_geometry(config, picture->drawn_columns, picture->drawn_rows);
    chafa_canvas_config_set_cell_geometry(config, picture->cell_width, picture->cell_height);
    chafa_canvas_config_set_work_factor(config, 0.2f);
    return config;
}

static bool draw(ChafaPicture *picture)
{
    picture->drawn_columns = picture->columns;
    picture->drawn_rows = picture->rows;
    chafa_calc_canvas_geometry(
        picture->width, picture->height, &picture->drawn_columns, &picture->drawn_rows,
        (float)picture->cell_width / (float)picture->cell_height, TRUE, FALSE);
    ChafaTermInfo *info = terminal_info();
    ChafaCanvasMode colors =
        picture->mode == TERMINAL_BLOCKS ? colors_of(info) : CHAFA_CANVAS_MODE_TRUECOLOR;
    chafa_term_info_unref(info);
    ChafaCanvasConfig *config = make_config(picture, colors);
    ChafaCanvas *canvas = chafa_canvas_new(config);
    chafa_canvas_draw_all_pixels(canvas, CHAFA_PIXEL_RGBA8_UNASSOCIATED, picture->rgba,
                                 picture->width, picture->height, picture->width * 4);
    info = info_with_all();
    GString *text = chafa_canvas_print(canvas, info);
    chafa_term_info_unref(info);
    chafa_canvas_unref(canvas);
    chafa_canvas_config_unref(config);
    picture->size = text ? text->len : 0;
    picture->bytes = text ? g_string_free(text, FALSE) : NULL;
    return picture->bytes != NULL;
}

static void release(ChafaPicture *picture)
{
    g_free(picture->bytes);
    picture->bytes = NULL;
}

extern const ChafaFunctions scn_chafa_functions;
const ChafaFunctions scn_chafa_functions = {CHAFA_MODULE_VERSION, detect, draw, release};
