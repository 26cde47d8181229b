#include "render/resume.h"

#include "base/io.h"
#include "render/renderer.h"

#include <string.h>
#include <xxhash.h>

enum { MOST_SHOWN = 200 };

// --- What must be the same -----------------------------------------------------------------------

typedef struct Identity {
    CheckpointText texts[CHECKPOINT_MOST_TEXTS];
    uint32_t count;
    char scene[24], files[24], size[32], seed[24], camera[24];
} Identity;

static void add_text(Identity *id, CheckpointKind kind, const char *name, const char *value)
{
    if (id->count < CHECKPOINT_MOST_TEXTS) {
        id->texts[id->count++] = (CheckpointText){kind, name, value};
    }
}

// Embree's kernels for AVX2 and those for AVX-512 round other than those for SSE and AVX, which
// agree: only a part of the rays is hit by that, and by a last place, but bytes differ then.
static const char *processor(void)
{
#if defined(__x86_64__)
    __builtin_cpu_init();
    return __builtin_cpu_supports("avx512f") ? "x86-64 with AVX-512"
           : __builtin_cpu_supports("avx2")  ? "x86-64 with AVX2"
                                             : "x86-64";
#else
    return "unknown";
#endif
}

// A digest of all that the camera's rays depend on.
static uint64_t camera_digest(const Camera *camera)
{
    const CameraParams *p = &camera->params;
    const double numbers[] = {
        p->projection,      p->fov, p->height, p->aperture, p->focus_distance, camera->half_width,
        camera->half_height};
    return XXH3_64bits_withSeed(&camera->to_world, sizeof camera->to_world,
                                XXH3_64bits(numbers, sizeof numbers));
}

// The names stand in messages: "is of another scene".
static void identify(const Renderer *r, Identity *id)
{
    const Scene *scene = r->scene;
    const uint64_t files = scene->sandbox ? atomic_load(&scene->sandbox->content_hash) : 0;
    id->count = 0;
    snprintf(id->scene, sizeof id->scene, "%016llx", (unsigned long long)scene->hash);
    snprintf(id->files, sizeof id->files, "%016llx", (unsigned long long)files);
    snprintf(id->size, sizeof id->size, "%u x %u", r->film.width, r->film.height);
    snprintf(id->seed, sizeof id->seed, "%lld", (long long)r->params.seed);
    snprintf(id->camera, sizeof id->camera, "%016llx",
             (unsigned long long)camera_digest(&r->camera));
    add_text(id, CHECKPOINT_IDENTITY, "version of scnrender", SCN_VERSION);
    add_text(id, CHECKPOINT_IDENTITY, "scene", id->scene);
    add_text(id, CHECKPOINT_IDENTITY, "state of the scene's files", id->files);
    add_text(id, CHECKPOINT_IDENTITY, "size", id->size);
    add_text(id, CHECKPOINT_IDENTITY, "seed", id->seed);
    add_text(id, CHECKPOINT_IDENTITY, "camera", id->camera);
    add_text(id, CHECKPOINT_IDENTITY, "integrator", r->integrator->name);
    add_text(id, CHECKPOINT_IDENTITY, "kind of sampling", r->rule ? "adaptive" : "even");
    add_text(id, CHECKPOINT_IDENTITY, "choice of layers", r->film.aovs ? "some" : "none");
    add_text(id, CHECKPOINT_NOTE, "processor", processor());
}

static uint32_t whole_samples(const Renderer *r)
{
    return r->options.whole_samples > 0 ? (uint32_t)r->options.whole_samples
                                        : r->film.first_sample + r->samples;
}

// --- What adaptive sampling keeps ----------------------------------------------------------------

enum { ADAPTIVE_PARTS = 5 };

typedef struct AdaptiveBytes {
    CheckpointBytes parts[ADAPTIVE_PARTS];
    uint32_t count;
    uint64_t size;
} AdaptiveBytes;

static AdaptiveBytes adaptive_bytes(Renderer *r)
{
    Adaptive *a = &r->adaptive;
    if (!r->rule) {
        return (AdaptiveBytes){.count = 0};
    }
    const uint64_t pixels = film_pixel_count(&r->film), cells = (uint64_t)a->columns * a->rows;
    AdaptiveBytes out = {.parts = {{&a->state, sizeof a->state},
                                   {a->cells, cells * sizeof *a->cells},
                                   {a->streams[0], pixels * sizeof(FilmPixel)},
                                   {a->streams[1], pixels * sizeof(FilmPixel)},
                                   {a->kept, pixels * sizeof(FilmPixel)}},
                         .count = ADAPTIVE_PARTS};
    for (int i = 0; i < ADAPTIVE_PARTS; ++i) {
        out.size += out.parts[i].size;
    }
    return out;
}

// --- Saving --------------------------------------------------------------------------------------

static CheckpointNumbers numbers_of(const Renderer *r, uint64_t more)
{
    return (CheckpointNumbers){
        .width = r->film.width,
        .height = r->film.height,
        .first_sample = r->film.first_sample,
        .samples = r->samples,
        .whole = whole_samples(r),
        .samples_done = r->film.samples_done,
        .block_count = r->film.block_count,
        .aovs = r->film.aovs != NULL,
        .rays = atomic_load(&r->rays),
        .shadow_rays = atomic_load(&r->shadow_rays),
        .samples_taken = atomic_load(&r->samples_done),
        .bad_samples = atomic_load(&r->bad_samples),
        .more = more,
        .seconds = r->render_seconds,
        .quantum = r->film.quantum,
        .reach = r->film.reach,
    };
}

bool renderer_save(Renderer *r, CheckpointTexts notes, const char *path, char *message,
                   size_t message_size)
{
    Identity id;
    identify(r, &id);
    for (uint32_t i = 0; i < notes.count; ++i) {
        add_text(&id, CHECKPOINT_NOTE, notes.items[i].name, notes.items[i].value);
    }
    const AdaptiveBytes more = adaptive_bytes(r);
    const CheckpointNumbers numbers = numbers_of(r, more.size);
    AtomicFile file;
    if (!atomic_file_open(&file, path, message, message_size)) {
        return false;
    }
    checkpoint_write(file.stream, (CheckpointTexts){id.texts, id.count}, &numbers, &r->film,
                     (CheckpointMore){more.parts, more.count});
    return atomic_file_commit(&file, message, message_size);
}

// --- Loading -------------------------------------------------------------------------------------

typedef struct Reason {
    const char *path;
    char *message;
    size_t size;
} Reason;

static CheckpointResult is_other(Reason reason, const char *what, const char *there,
                                 const char *here)
{
    snprintf(reason.message, reason.size,
             "the checkpoint `%.*s` is of another %s: %.40s, not %.40s", MOST_SHOWN, reason.path,
             what, there, here);
    return CHECKPOINT_OTHER;
}

// Another number of samples has other last blocks, and nothing else.
static bool range_fits(const Renderer *r, const CheckpointNumbers *n)
{
    const bool whole = n->first_sample == 0 && n->samples == n->whole;
    const bool wanted_whole = r->film.first_sample == 0 && r->samples == whole_samples(r);
    const bool same = n->first_sample == r->film.first_sample && n->samples == r->samples &&
                      n->whole == whole_samples(r);
    return same || (whole && wanted_whole && !r->rule);
}

static CheckpointResult check_head(const Renderer *r, const Checkpoint *checkpoint, Reason reason)
{
    Identity id;
    identify(r, &id);
    const CheckpointTexts wanted = {id.texts, id.count};
    const CheckpointNumbers *n = &checkpoint->numbers;
    const char *name = checkpoint_difference(wanted, checkpoint->texts);
    if (name) {
        const char *there = checkpoint_text(checkpoint->texts, name);
        const char *here = checkpoint_text(wanted, name);
        return is_other(reason, name, there ? there : "none", here ? here : "none");
    }
    if (n->width != r->film.width || n->height != r->film.height ||
        n->aovs != (r->film.aovs != NULL) || n->reach != r->film.reach) {
        return is_other(reason, "size", "its own", id.size); // it contradicts itself
    }
    if (!range_fits(r, n)) {
        char there[64], here[64];
        snprintf(there, sizeof there, "%u..%u of %u", n->first_sample,
                 n->first_sample + n->samples - 1, n->whole);
        snprintf(here, sizeof here, "%u..%u of %u", r->film.first_sample,
                 r->film.first_sample + r->samples - 1, whole_samples(r));
        return is_other(reason, "range of samples", there, here);
    }
    return CHECKPOINT_SOUND;
}

// Where other samples are asked for than then, pixels must end where blocks do.
static CheckpointResult check_samples(const Renderer *r, const CheckpointNumbers *n, Reason reason)
{
    if (n->samples == r->samples) {
        return CHECKPOINT_SOUND;
    }
    uint32_t most = 0, cut = 0;
    for (size_t p = 0; p < film_pixel_count(&r->film); ++p) {
        const uint32_t samples = r->film.pixels[p].samples;
        most = samples > most ? samples : most;
        cut = samples > SAMPLE_BLOCK && samples % SAMPLE_BLOCK != 0 ? samples : cut;
    }
    if (most > r->samples) {
        snprintf(reason.message, reason.size,
                 "the checkpoint `%.*s` has more samples a pixel than are asked for: %u, not %u",
                 MOST_SHOWN, reason.path, most, r->samples);
        return CHECKPOINT_OTHER;
    }
    if (cut > 0) {
        snprintf(reason.message, reason.size,
                 "the checkpoint `%.*s` ends within a block of %d samples, at %u: no more can be "
                 "added",
                 MOST_SHOWN, reason.path, SAMPLE_BLOCK, cut);
        return CHECKPOINT_OTHER;
    }
    return CHECKPOINT_SOUND;
}

static void take_numbers(Renderer *r, const CheckpointNumbers *n)
{
    if (r->film.gains) {
        share_use_quantum(r, n->quantum); // another processor's may differ
    }
    atomic_store(&r->rays, n->rays);
    atomic_store(&r->shadow_rays, n->shadow_rays);
    atomic_store(&r->samples_done, n->samples_taken);
    atomic_store(&r->bad_samples, n->bad_samples);
    r->render_seconds = n->seconds >= 0 ? n->seconds : 0;
}

static CheckpointResult load(Renderer *r, Checkpoint *checkpoint, Reason reason)
{
    CheckpointResult result = check_head(r, checkpoint, reason);
    const AdaptiveBytes more = adaptive_bytes(r);
    if (result == CHECKPOINT_SOUND && checkpoint->numbers.more != more.size) {
        result = is_other(reason, "size", "its own", "this one's"); // it contradicts itself
    }
    if (result == CHECKPOINT_SOUND) {
        result =
            checkpoint_read_film(checkpoint, &r->film, (CheckpointMore){more.parts, more.count},
                                 reason.message, reason.size);
    }
    if (result == CHECKPOINT_SOUND) {
        result = check_samples(r, &checkpoint->numbers, reason);
    }
    if (result != CHECKPOINT_SOUND) {
        return result;
    }
    take_numbers(r, &checkpoint->numbers);
    const char *there = checkpoint_text(checkpoint->texts, "processor");
    if (there && strcmp(there, processor()) != 0) {
        snprintf(reason.message, reason.size,
                 "the checkpoint `%.*s` was begun on another processor (%.40s, not %s): the last "
                 "places of some samples may differ from an uninterrupted run's",
                 MOST_SHOWN, reason.path, there, processor());
    }
    return CHECKPOINT_SOUND;
}

CheckpointResult renderer_load(Renderer *r, const char *path, char *message, size_t message_size)
{
    const Reason reason = {path, message, message_size};
    Checkpoint checkpoint;
    CheckpointResult result = checkpoint_open(&checkpoint, path, message, message_size);
    if (result == CHECKPOINT_SOUND) {
        message[0] = '\0';
        result = load(r, &checkpoint, reason);
        checkpoint_close(&checkpoint);
    }
    return result;
}
