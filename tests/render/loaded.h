// A scene made of .scn text.
#ifndef TEST_LOADED_H
#define TEST_LOADED_H

#include "lang/lang.h"
#include "render/render.h"

#include <stdio.h>
#include <stdlib.h>

typedef struct Loaded {
    Sandbox sandbox;
    Lang lang;
    Scene scene;
} Loaded;

// Ends the program, with the diagnostics, where the text has errors or warnings.
static inline void load(Loaded *l, const char *text)
{
    sandbox_init(&l->sandbox);
    if (!lang_init(&l->lang, render_schema(), &l->sandbox) ||
        !scene_init(&l->scene, render_schema(), &l->sandbox)) {
        abort();
    }
    const bool ok = lang_load_text(&l->lang, str_from(text), "/test.scn", "test.scn", &l->scene);
    if (!ok || l->lang.sink.count > 0) {
        diag_write_text(&l->lang.sink, &l->lang.sources, stderr, DIAG_PLAIN);
        abort();
    }
}

static inline void unload(Loaded *l)
{
    scene_free(&l->scene);
    lang_free(&l->lang);
    sandbox_free(&l->sandbox);
}

#endif
