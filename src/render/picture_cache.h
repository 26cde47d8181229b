// Decoded pictures that outlive the scene that named them: where a scene is evaluated again and
// again, its pictures are decoded once for as long as their files' bytes stay the same.
#ifndef RENDER_PICTURE_CACHE_H
#define RENDER_PICTURE_CACHE_H

#include "render/texture_image.h"

#include <stdatomic.h>

// One decoded picture, shared by counting; nothing changes it.
typedef struct SharedPicture {
    atomic_uint references;
    uint64_t digest[2]; // of the file's bytes
    int32_t encoding;   // TextureEncoding that it was decoded with
    TextureImage image;
    uint64_t bad_texels; // that weren't finite
} SharedPicture;

// Its texels are the caller's to fill. NULL without memory.
SharedPicture *shared_picture_new(int width, int height);
void shared_picture_release(SharedPicture *picture); // NULL is fine

typedef struct PictureCache PictureCache;

// A Scene's `pictures` may point to one; it must then outlive the world's building. All functions
// may be called from any thread, and with a cache of NULL, which keeps nothing.
PictureCache *picture_cache_new(void);
void picture_cache_free(PictureCache *cache);
// Before a scene is made ready: what the last one didn't ask for is dropped.
void picture_cache_turn(PictureCache *cache);
// A picture that the caller releases; NULL where it isn't known.
SharedPicture *picture_cache_find(PictureCache *cache, const uint64_t digest[2], int32_t encoding);
void picture_cache_add(PictureCache *cache, SharedPicture *picture);

#endif
