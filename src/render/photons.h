// Caustics that the camera sees on matt things, from the lights' side: photons leave the lights
// towards what mirrors and refracts (casters.h), and wherever they come to something matt after one
// or more such scatterings they are seen by the camera, or go on (particle tracing: Arvo 1986,
// "Backward Ray Tracing"; Dutré, Lafortune and Willems 1993, "Monte Carlo Light Tracing with Direct
// Computation of Pixel Intensities"; the adjoints of scattering are those of Veach 1997, chapter
// 5).
//
// Photons alone find the light of paths
//
//     camera, a scattering by a smooth lobe, any others, one by a delta lobe, light
//
// from the lights of photons_of_lights, by way of a bounded shape next to the light; the path
// tracer leaves those out, and finds all else. So each path is found once, in one way, and the
// picture's mean stays what it is; but light of lamps without a size, which no ray finds, is found
// in addition.
#ifndef RENDER_PHOTONS_H
#define RENDER_PHOTONS_H

#include "render/camera.h"
#include "render/integrator.h"

typedef struct Photons Photons;

// *out is NULL where there is nothing to be found so. False when memory runs out. `world` is ready
// and has to live as long; give *out back with photons_free.
bool photons_new(const World *world, Photons **out);
void photons_free(Photons *photons);
// By light: whether photons leave it.
const bool *photons_of_lights(const Photons *photons);

// What the camera sees of a photon: at the place (x, y) of the film, as for camera_ray, `light`,
// which is radiance (W/m²/sr) times a part of the film, the whole being 1.
typedef struct PhotonSplat {
    double x, y;
    Rgb light;
} PhotonSplat;

// Where on the film photons are looked for.
typedef struct PhotonFilm {
    const Camera *camera;
    double margin_x, margin_y; // beyond its edges, in parts of the film
} PhotonFilm;

// Follows one photon by the numbers of `sampler`, from dimension 0 on. False where the camera sees
// nothing of it. The mean of splats is the light on the film.
bool photon_trace(const Photons *photons, const PhotonFilm *film, Sampler *sampler,
                  IntegratorStats *stats, PhotonSplat *out);

#endif
