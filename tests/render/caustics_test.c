// Caustics traced from the lights: the same light as path tracing finds by luck, for all kinds of
// casters, lamps, cameras and filters; and for lamps without a size, which paths can't find, the
// light of very small ones.
//
// Each scene is rendered REPLICATES times in both ways, each time by its own seed, and the means
// over all pixels are compared: Welch's t, at a level of ALPHA for the whole family (Šidák). "bias
// found" is the smallest relative bias of the picture's light that would have been found in 99 of
// 100 runs. Lamps are wide, so that paths, too, find them; and most of what the camera sees is the
// caustic.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "loaded.h"
#include "statistics.h"

enum { REPLICATES = 16 };
static const double ALPHA = 1e-3;

typedef struct Case {
    const char *name;
    const char *a, *b; // statements of both scenes
    const char *common;
    int samples; // of plain paths; those of photons are a quarter
    double bias; // that the test has to find
} Case;

#define PLAIN  "render { bounces: 8 }\n"
#define TRACED "render { bounces: 8, caustics: \"traced\" }\n"
#define FILM   "film { width: 24, height: 16, filter: \"box\" }\n"
// Sees a piece of the floor beside the ball.
#define CAMERA "camera { position: (0.4, 3, 3), look_at: (0.5, 0, 0), fov: 20deg }\n"
// Sees none of the ball.
#define BESIDE "camera { position: (2.5, 1, 1.5), look_at: (0.55, 0, 0), fov: 14deg }\n"
#define FLOOR  "plane { material: lambert { color: rgb(0.7, 0.6, 0.5) } }\n"
#define LAMP                                                                                       \
    "area_light { shape: rectangle { corner: (-2.2, 3, -0.4), u: (0.8, 0, 0), v: (0, 0, 0.8) }, "  \
    "radiance: 20 }\n"
#define BALL  "sphere { center: (0, 0.8, 0), radius: 0.5, material: fresnel { ior: 1.5 } }\n"
#define BALLS FILM CAMERA FLOOR LAMP BALL
#define BOTH  PLAIN, TRACED

static const Case cases[] = {
    {"glass ball", BOTH, BALLS, 256, 0.035},
    {"mirror ball", BOTH,
     FILM CAMERA FLOOR LAMP "sphere { center: (0, 0.8, 0), radius: 0.5, material: mirror {} }", 128,
     0.04},
    {"mirror ring", BOTH,
     FILM "camera { position: (0, 3, 3), look_at: (0, 0, 0), fov: 18deg }\n" FLOOR LAMP
          "cylinder { from: (0, 0, 0), to: (0, 0.4, 0), radius: 0.8, caps: false\n"
          "  material: mirror { color: rgb(0.9, 0.7, 0.4) } }",
     128, 0.04},
    {"colored glass", BOTH,
     FILM CAMERA FLOOR LAMP
     "sphere { center: (0, 0.8, 0), radius: 0.5, material: fresnel { ior: 1.5, color: rgb(0.9, "
     "0.8, 0.7), absorption: rgb(0.2, 1, 2) } }",
     256, 0.025},
    // An octahedron whose shading normals are a ball's.
    {"smooth mesh of glass", BOTH,
     FILM CAMERA FLOOR LAMP
     "mesh {\n"
     "  vertices: [(0.5, 0.8, 0), (-0.5, 0.8, 0), (0, 1.3, 0), (0, 0.3, 0), (0, 0.8, 0.5), (0, "
     "0.8, -0.5)]\n"
     "  normals: [(1, 0.5, 0), (-1, 0.5, 0), (0, 1, 0), (0, -1, 0), (0, 0.5, 1), (0, 0.5, -1)]\n"
     "  faces: [[0, 2, 4], [4, 2, 1], [1, 2, 5], [5, 2, 0], [4, 3, 0], [1, 3, 4], [5, 3, 1], [0, "
     "3, 5]]\n"
     "  material: fresnel { ior: 1.3 }\n"
     "}",
     256, 0.035},
    {"bumpy mirror", BOTH,
     FILM CAMERA FLOOR LAMP
     "sphere { center: (0, 0.8, 0), radius: 0.5\n"
     "  material: bump_map { base: mirror {}, map: noise { scale: 6 }, strength: 0.03 } }",
     128, 0.035},
    // The floor mirrors, too, and photons go on from there.
    {"mixed ball and floor", BOTH,
     FILM CAMERA LAMP
     "rectangle { corner: (-5, 0, 5), u: (10, 0, 0), v: (0, 0, -10), material: mix { a: lambert { "
     "color: gray(0.6) }, b: mirror {}, weight: 0.3 } }\n"
     "sphere { center: (0, 0.8, 0), radius: 0.5, material: mix { a: lambert {}, b: mirror {}, "
     "weight: 0.6 } }",
     256, 0.11},
    {"rough metal floor", BOTH,
     FILM CAMERA LAMP BALL "plane { material: ggx { f0: gray(0.8), alpha: 0.5 } }", 256, 0.05},
    {"through a cut-out", BOTH,
     BALLS "rectangle { corner: (-2, 2, -1), u: (3, 0, 0), v: (0, 0, 2), material: mask { base: "
           "lambert {}, opacity: checker { a: gray(0.2), b: gray(0.8), space: \"uv\", scale: 8 } } "
           "}",
     256, 0.07},
    {"lens", BOTH,
     FILM "camera { position: (0.4, 3, 3), look_at: (0.5, 0, 0), fov: 20deg, aperture: 10cm, "
          "focus_distance: 3 }\n" FLOOR LAMP BALL,
     256, 0.045},
    {"orthographic", BOTH,
     FILM "camera { position: (0.4, 3, 3), look_at: (0.5, 0, 0), projection: \"orthographic\", "
          "height: 1.2, aperture: 10cm, focus_distance: 3 }\n" FLOOR LAMP BALL,
     256, 0.045},
    {"fisheye", BOTH,
     FILM "camera { position: (0.6, 0.5, 0.5), look_at: (0.5, 0, 0), fov: 150deg, projection: "
          "\"fisheye\" }\n" FLOOR LAMP BALL,
     256, 0.06},
    {"panorama", BOTH,
     FILM "camera { position: (0.6, 0.2, 0.3), look_at: (0.5, 0.3, 0), projection: \"panorama\" "
          "}\n" FLOOR LAMP BALL,
     256, 0.09},
    {"stretched camera", BOTH,
     FILM "camera { position: (0.4, 3, 3), look_at: (0.5, 0, 0), fov: 20deg, transform: "
          "scale((1.1, 1, 0.9)) }\n" FLOOR LAMP BALL,
     256, 0.05},
    {"blackman_harris", BOTH, "film { width: 24, height: 16 }\n" CAMERA FLOOR LAMP BALL, 256, 0.04},
    {"tent", BOTH,
     "film { width: 24, height: 16, filter: \"tent\", filter_width: 5 }\n" CAMERA FLOOR LAMP BALL,
     512, 0.045},
    {"camera behind the ball", BOTH,
     FILM "camera { position: (-0.9, 1.6, 0), look_at: (0.4, 0, 0), fov: 30deg }\n" FLOOR LAMP BALL,
     256, 0.15},
    {"lamp in glass", BOTH,
     FILM CAMERA FLOOR BALL
     "area_light { shape: sphere { center: (0, 0.9, 0), radius: 0.1 }, radiance: 8 }",
     128, 0.06},
    {"a sun", BOTH,
     FILM CAMERA FLOOR BALL
     "directional_light { direction: (2, -3, 0), irradiance: 3, angle: 20deg }",
     128, 0.03},
    {"glowing sphere, instances", BOTH,
     FILM CAMERA FLOOR
     "sphere { center: (-2, 3, 0), radius: 0.4, material: emissive { radiance: 20 } }\n"
     "let ball = group { sphere { radius: 0.25, material: fresnel {} } }\n"
     "for (i in 0..<4) { instance { of: ball, transform: translate((0.35 * i - 0.3, 0.6, 0)) } }",
     256, 0.075},
    {"under water", BOTH,
     FILM "camera { position: (0.4, 0.8, 1.2), look_at: (0.5, 0, 0), fov: 30deg }\n"
          "box { min: (-3, 0.001, -3), max: (3, 1, 3), material: fresnel { ior: 1.33, absorption: "
          "rgb(0.5, 0.1, 0.05) } }\n" FLOOR
          "directional_light { direction: (1, -2, 0), irradiance: 3, angle: 30deg }",
     128, 0.15},
    // Lamps without a size, which paths find nothing of behind glass, and very small ones.
    {"point light", TRACED "point_light { position: (-2, 3, 0), power: 50W }\n",
     TRACED "area_light { shape: sphere { center: (-2, 3, 0), radius: 0.01 }, power: 50W }\n",
     FILM BESIDE FLOOR BALL, 256, 0.012},
    {"sunlight", TRACED "directional_light { direction: (2, -3, 0), irradiance: 3 }\n",
     TRACED "directional_light { direction: (2, -3, 0), irradiance: 3, angle: 0.2deg }\n",
     FILM BESIDE FLOOR BALL, 256, 0.01},
};

static double mean_luminance(Loaded *l, int64_t samples, int64_t seed)
{
    const RenderOptions options = {.samples = samples, .seed = seed};
    Renderer *r = renderer_new(&l->scene, &options, &l->lang.sink);
    RenderStats stats;
    if (!r || !renderer_run(r, &stats) || stats.stopped || stats.bad_samples > 0) {
        abort();
    }
    const Film *film = renderer_film(r);
    double sum = 0;
    for (size_t p = 0; p < film_pixel_count(film); ++p) {
        sum += film_luminance(&film->pixels[p]);
    }
    sum /= (double)film_pixel_count(film);
    renderer_free(r);
    return sum;
}

static Running means(const char *first, const char *second, int64_t samples, int64_t seed)
{
    char text[4096];
    snprintf(text, sizeof text, "%s%s", first, second);
    Loaded l;
    load(&l, text);
    Running mean = {0};
    for (int i = 0; i < REPLICATES; ++i) {
        running_add(&mean, mean_luminance(&l, samples, seed + i));
    }
    unload(&l);
    return mean;
}

static bool judge(const Case *c, int family)
{
    const Running a = means(c->a, c->common, c->samples, 100);
    const Running b = means(c->b, c->common, c->samples / 4, 200);
    const double error = hypot(running_error(&a), running_error(&b)), freedom = REPLICATES - 1;
    const double limit = student_quantile(sidak(ALPHA, family), freedom);
    const double found = (limit + student_quantile(0.02, freedom)) * error / a.mean;
    const double t = (b.mean - a.mean) / error;
    const bool wrong = !(fabs(t) <= limit), weak = !(found <= c->bias);
    printf("%-28s %10.6f %10.6f %9.2g %9.2g %7.2f %9.4f%%%s%s\n", c->name, a.mean, b.mean,
           running_error(&a), running_error(&b), t, 100 * found, wrong ? "  WRONG" : "",
           weak ? "  TOO WEAK" : "");
    return !wrong && !weak;
}

int main(int argc, char **argv)
{
    const int family = sizeof cases / sizeof *cases;
    int failures = 0;
    printf("%-28s %10s %10s %9s %9s %7s %10s\n", "scene", "paths", "photons", "error", "error", "t",
           "bias found");
    for (int i = 0; i < family; ++i) {
        if (argc < 2 || strstr(cases[i].name, argv[1])) {
            failures += !judge(&cases[i], family);
        }
    }
    return failures > 0;
}
