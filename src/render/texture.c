#include "render/texture.h"

#include "base/mem.h"
#include "image/image.h"
#include "render/picture_cache.h"

#include <string.h>
#include <xxhash.h>

typedef struct LoadedImage {
    const char *path;
    int32_t encoding;
    SharedPicture *picture; // NULL: reading failed and was reported
} LoadedImage;

struct TextureSet {
    const Scene *scene;
    Arena arena;
    const void **data; // by texture id
    ARRAY(LoadedImage *) images;
};

// Linear RGB from what was decoded: one channel is gray, two gray and alpha, four RGB and alpha;
// alpha is left out. Texels that aren't finite become black and are counted.
static uint64_t convert_texels(const Image *image, bool srgb, TextureImage *out)
{
    size_t count = (size_t)image->width * (size_t)image->height, channels = (size_t)image->channels;
    uint64_t bad = 0;
    double sum[3] = {0};
    for (size_t i = 0; i < count; ++i) {
        const float *in = image->pixels + i * channels;
        Rgb c = channels < 3 ? rgb_gray(in[0]) : rgb(in[0], in[1], in[2]);
        if (srgb) {
            c = rgb(srgb_decode(c.r), srgb_decode(c.g), srgb_decode(c.b));
        }
        if (!rgb_is_finite(c)) {
            c = rgb_gray(0);
            ++bad;
        }
        out->texels[i] = c;
        sum[0] += (double)c.r;
        sum[1] += (double)c.g;
        sum[2] += (double)c.b;
    }
    double n = (double)count;
    out->mean = rgb((float)(sum[0] / n), (float)(sum[1] / n), (float)(sum[2] / n));
    return bad;
}

// The picture in a file's bytes. NULL after a report.
static SharedPicture *decode(const LoadedImage *loaded, const FileBytes *bytes, DiagSink *sink,
                             Span at)
{
    Image image;
    char message[256] = "";
    if (!image_read(loaded->path, bytes->bytes, bytes->size, (ImageLimits){TEXTURE_MAX_PIXELS},
                    &image, message, sizeof message)) {
        diag_report(sink, E0940, at, "can't read the image `%s`: %s", loaded->path, message);
        return NULL;
    }
    SharedPicture *picture =
        image.channels > 0 ? shared_picture_new(image.width, image.height) : NULL;
    if (picture) {
        bool srgb = loaded->encoding == ENCODING_SRGB ||
                    (loaded->encoding == ENCODING_AUTO && image.srgb_encoded);
        picture->encoding = loaded->encoding;
        picture->bad_texels = convert_texels(&image, srgb, &picture->image);
    } else {
        diag_report(sink, E0001, at, "no memory for the image `%s`", loaded->path);
    }
    image_free(&image);
    return picture;
}

// The same, or one that was decoded of the same bytes before.
static SharedPicture *find_or_decode(const Scene *scene, const LoadedImage *loaded,
                                     const FileBytes *bytes, DiagSink *sink, Span at)
{
    if (!scene->pictures) {
        return decode(loaded, bytes, sink, at);
    }
    const XXH128_hash_t hash = XXH3_128bits(bytes->bytes, bytes->size);
    const uint64_t digest[2] = {hash.low64, hash.high64};
    SharedPicture *picture = picture_cache_find(scene->pictures, digest, loaded->encoding);
    if (!picture) {
        picture = decode(loaded, bytes, sink, at);
        if (picture) {
            memcpy(picture->digest, digest, sizeof digest);
            picture_cache_add(scene->pictures, picture);
        }
    }
    return picture;
}

static bool load(const Scene *scene, LoadedImage *loaded, DiagSink *sink, Span at)
{
    FileBytes bytes;
    IoError error = sandbox_read(scene->sandbox, loaded->path, &bytes);
    if (error != IO_OK) {
        diag_report(sink, E0940, at, "can't read the image `%s`: %s", loaded->path,
                    io_error_text(error));
        return false;
    }
    loaded->picture = find_or_decode(scene, loaded, &bytes, sink, at);
    file_bytes_free(&bytes);
    if (loaded->picture && loaded->picture->bad_texels) {
        diag_report(sink, W0941, at, "%llu texels of `%s` are not finite and are taken as black",
                    (unsigned long long)loaded->picture->bad_texels, loaded->path);
    }
    return loaded->picture != NULL;
}

const TextureImage *texture_set_image(TextureSet *set, const Scene *scene, const char *path,
                                      int32_t encoding, DiagSink *sink, Span at)
{
    for (size_t i = 0; i < set->images.count; ++i) {
        LoadedImage *known = set->images.items[i];
        if (known->encoding == encoding && strcmp(known->path, path) == 0) {
            return known->picture ? &known->picture->image : NULL;
        }
    }
    LoadedImage *loaded = ARENA_NEW(&set->arena, LoadedImage);
    if (!loaded || !array_push(&set->images, loaded)) {
        diag_report(sink, E0001, at, "no memory for the image `%s`", path);
        return NULL;
    }
    loaded->path = path;
    loaded->encoding = encoding;
    return load(scene, loaded, sink, at) ? &loaded->picture->image : NULL;
}

static bool prepare_all(TextureSet *set, DiagSink *sink)
{
    const Scene *scene = set->scene;
    uint32_t errors = sink->errors;
    for (size_t i = 0; i < scene->nodes[CATEGORY_TEXTURE].count; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_TEXTURE, (uint32_t)i);
        const TextureClass *class = (const TextureClass *)scene_node_type(scene, node);
        TexturePrepare prepare = {scene, set, &set->arena, sink, node->at};
        if (class->prepare && !class->prepare(&prepare, scene_params(scene, node), &set->data[i]) &&
            sink->errors == errors) {
            diag_report(sink, E0001, node->at, "no memory for a texture");
        }
    }
    return sink->errors == errors;
}

TextureSet *texture_set_build(const Scene *scene, DiagSink *sink)
{
    TextureSet *set = mem_alloc_zeroed(1, sizeof *set);
    if (!set) {
        diag_report(sink, E0001, (Span){0}, "no memory for textures");
        return NULL;
    }
    set->scene = scene;
    size_t count = scene->nodes[CATEGORY_TEXTURE].count;
    set->data = arena_array(&set->arena, count + 1, sizeof *set->data);
    if (!set->data) {
        diag_report(sink, E0001, (Span){0}, "no memory for textures");
        texture_set_free(set);
        return NULL;
    }
    memset(set->data, 0, (count + 1) * sizeof *set->data);
    if (!prepare_all(set, sink)) {
        texture_set_free(set);
        return NULL;
    }
    return set;
}

void texture_set_free(TextureSet *set)
{
    if (!set) {
        return;
    }
    for (size_t i = 0; i < set->images.count; ++i) {
        shared_picture_release(set->images.items[i]->picture);
    }
    array_free(&set->images);
    arena_free(&set->arena);
    mem_free(set);
}

Rgb texture_color(const TextureSet *set, uint32_t id, const Surface *surface)
{
    const SceneNode *node = scene_node(set->scene, CATEGORY_TEXTURE, id);
    const TextureClass *class = (const TextureClass *)scene_node_type(set->scene, node);
    return class->color(set, scene_params(set->scene, node), set->data[id], surface);
}

Rgb texture_mean(const TextureSet *set, uint32_t id)
{
    const SceneNode *node = scene_node(set->scene, CATEGORY_TEXTURE, id);
    const TextureClass *class = (const TextureClass *)scene_node_type(set->scene, node);
    return class->mean ? class->mean(set, scene_params(set->scene, node), set->data[id])
                       : rgb_gray(0.5f);
}
