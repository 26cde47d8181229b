// Loading of texts and files with the tests' schema.
#ifndef LANG_FIXTURE_H
#define LANG_FIXTURE_H

#include "lang/lang.h"
#include "test_schema.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

typedef struct Fixture {
    Sandbox sandbox;
    Lang lang;
    Scene scene;
    bool good;
    char *diagnostics, *printed;
    size_t diagnostics_size, printed_size;
} Fixture;

typedef struct Setup {
    Limits limits;
    const ParamSetting *settings;
    size_t setting_count;
    size_t stack; // Lang.stack
} Setup;

static inline void prepare(Fixture *f, const Setup *setup, const char *folder)
{
    *f = (Fixture){0};
    sandbox_init(&f->sandbox);
    if (folder) {
        assert_int_equal(sandbox_allow(&f->sandbox, folder), IO_OK);
    }
    assert_true(lang_init(&f->lang, &test_schema, &f->sandbox));
    assert_true(scene_init(&f->scene, &test_schema, &f->sandbox));
    f->lang.limits = setup->limits;
    f->lang.stack = setup->stack;
    f->lang.settings = setup->settings;
    f->lang.setting_count = setup->setting_count;
    f->lang.print_to = open_memstream(&f->printed, &f->printed_size);
}

static inline void collect(Fixture *f)
{
    fclose(f->lang.print_to);
    f->lang.print_to = NULL;
    FILE *out = open_memstream(&f->diagnostics, &f->diagnostics_size);
    diag_write_text(&f->lang.sink, &f->lang.sources, out, DIAG_PLAIN);
    fclose(out);
}

static inline Fixture load_with(const char *text, Setup setup)
{
    Fixture f;
    prepare(&f, &setup, NULL);
    f.good = lang_load_text(&f.lang, str_from(text), NULL, "test.scn", &f.scene);
    collect(&f);
    return f;
}

static inline Fixture load(const char *text)
{
    return load_with(text, (Setup){.limits = limits_default()});
}

static inline Fixture load_file(const char *folder, const char *name)
{
    Fixture f;
    char path[512];
    prepare(&f, &(Setup){.limits = limits_default()}, folder);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    f.good = lang_load(&f.lang, path, name, &f.scene);
    collect(&f);
    return f;
}

static inline void unload(Fixture *f)
{
    free(f->diagnostics);
    free(f->printed);
    scene_free(&f->scene);
    lang_free(&f->lang);
    sandbox_free(&f->sandbox);
}

static inline void write_file(const char *folder, const char *name, const char *text)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    fputs(text, out);
    fclose(out);
}

static inline void remove_folder(const char *folder)
{
    DIR *listing = opendir(folder);
    for (struct dirent *entry; listing && (entry = readdir(listing)) != NULL;) {
        char path[1024];
        snprintf(path, sizeof path, "%s/%s", folder, entry->d_name);
        unlink(path);
    }
    if (listing) {
        closedir(listing);
    }
    rmdir(folder);
}

#endif
