#include "render/picture_cache.h"

#include "base/array.h"

#include <pthread.h>

typedef struct Kept {
    SharedPicture *picture;
    bool asked; // since the last turn
} Kept;

struct PictureCache {
    pthread_mutex_t lock;
    ARRAY(Kept) kept;
};

SharedPicture *shared_picture_new(int width, int height)
{
    SharedPicture *picture = mem_alloc_zeroed(1, sizeof *picture);
    if (!picture || width <= 0 || height <= 0) {
        mem_free(picture);
        return NULL;
    }
    atomic_init(&picture->references, 1);
    picture->image.width = width;
    picture->image.height = height;
    picture->image.texels = mem_alloc((size_t)width * (size_t)height, sizeof(Rgb));
    if (!picture->image.texels) {
        mem_free(picture);
        return NULL;
    }
    return picture;
}

void shared_picture_release(SharedPicture *picture)
{
    if (picture && atomic_fetch_sub(&picture->references, 1) == 1) {
        mem_free(picture->image.texels);
        mem_free(picture);
    }
}

PictureCache *picture_cache_new(void)
{
    PictureCache *cache = mem_alloc_zeroed(1, sizeof *cache);
    if (cache) {
        pthread_mutex_init(&cache->lock, NULL);
    }
    return cache;
}

void picture_cache_free(PictureCache *cache)
{
    if (!cache) {
        return;
    }
    for (size_t i = 0; i < cache->kept.count; ++i) {
        shared_picture_release(cache->kept.items[i].picture);
    }
    array_free(&cache->kept);
    pthread_mutex_destroy(&cache->lock);
    mem_free(cache);
}

void picture_cache_turn(PictureCache *cache)
{
    if (!cache) {
        return;
    }
    pthread_mutex_lock(&cache->lock);
    size_t kept = 0;
    for (size_t i = 0; i < cache->kept.count; ++i) {
        SharedPicture *picture = cache->kept.items[i].picture;
        if (cache->kept.items[i].asked) {
            cache->kept.items[kept++] = (Kept){picture, false};
        } else {
            shared_picture_release(picture);
        }
    }
    cache->kept.count = kept;
    pthread_mutex_unlock(&cache->lock);
}

SharedPicture *picture_cache_find(PictureCache *cache, const uint64_t digest[2], int32_t encoding)
{
    SharedPicture *found = NULL;
    if (!cache) {
        return NULL;
    }
    pthread_mutex_lock(&cache->lock);
    for (size_t i = 0; !found && i < cache->kept.count; ++i) {
        Kept *kept = &cache->kept.items[i];
        SharedPicture *picture = kept->picture;
        if (picture->digest[0] == digest[0] && picture->digest[1] == digest[1] &&
            picture->encoding == encoding) {
            kept->asked = true;
            found = picture;
            atomic_fetch_add(&picture->references, 1);
        }
    }
    pthread_mutex_unlock(&cache->lock);
    return found;
}

void picture_cache_add(PictureCache *cache, SharedPicture *picture)
{
    if (!cache) {
        return;
    }
    pthread_mutex_lock(&cache->lock);
    if (array_push(&cache->kept, (Kept){picture, true})) {
        atomic_fetch_add(&picture->references, 1);
    }
    pthread_mutex_unlock(&cache->lock);
}
