// Each estimator against the others, for each material under each light: light sampling alone, BSDF
// sampling alone and both (`render { sampling: … }`) have one mean, and so has the integrator
// `direct` where nothing but direct light is to be found. An error in a weight, a density, an
// evaluation or a choice of lights moves one of them and not the others.
//
// An ordinary run takes a few pairs so that each material and each light comes up; a full run
// (SCN_TRUST=full) takes all. SCN_PAIRS=3/10 takes the fourth tenth of them.
#include "paired.h"

#include "base/mem.h"

extern const IntegratorClass direct_integrator;

static CheckTable table;

// --- Where it is seen ----------------------------------------------------------------------------

// The camera looks at a small square about the origin, from above, at 37 degrees from the normal;
// lamps stand where a mirror there would show them. Through glass it looks from below, at the angle
// that refraction makes of theirs.
static const Vec3 FROM = {0.6, 0.8, 0}, FROM_BELOW = {0.9, -0.43588989435406733, 0};
static const double WINDOW = 0.3, LAMP = 1.7;

// `context`: where from.
static double look(const void *context, const float n[4], Ray *ray)
{
    const Vec3 *from = context;
    const Vec3 at = vec3(WINDOW * ((double)n[0] - 0.5), 0, WINDOW * ((double)n[1] - 0.5));
    ray->origin = add_scaled(at, *from, 3);
    ray->direction = neg(*from);
    return 1;
}

// --- Materials -----------------------------------------------------------------------------------

typedef struct Maker {
    SceneMaker *m;
    uint32_t checker; // a texture to vary things by
} Maker;

static uint32_t lambert(const Maker *k)
{
    return PUT(k->m, "lambert", {"color", {0.7}});
}
static uint32_t textured(const Maker *k)
{
    return PUT(k->m, "lambert", {"color", {k->checker}, .texture = true});
}
static uint32_t phong(const Maker *k)
{
    return PUT(k->m, "phong", {"color", {0.6}}, {"diffuse", {0.5}}, {"specular", {0.5}},
               {"shininess", {20}});
}
static uint32_t blinn_phong(const Maker *k)
{
    return PUT(k->m, "blinn_phong", {"color", {0.6}}, {"diffuse", {0.5}}, {"specular", {0.5}},
               {"shininess", {30}});
}
static uint32_t burley(const Maker *k)
{
    return PUT(k->m, "burley", {"color", {0.7}}, {"roughness", {0.6}});
}
static uint32_t ggx(const Maker *k)
{
    return PUT(k->m, "ggx", {"f0", {0.8}}, {"alpha", {0.35}});
}
static uint32_t ggx_pair(const Maker *k)
{
    return PUT(k->m, "ggx", {"f0", {0.8}}, {"alpha", {0.5, 0.25}}, {"rotation", {0.6}});
}
static uint32_t ggx_preserve(const Maker *k)
{
    return PUT(k->m, "ggx", {"f0", {0.8}}, {"alpha", {0.6}}, {"energy", .text = "preserve"});
}
static uint32_t dielectric(const Maker *k)
{
    return PUT(k->m, "ggx", {"ior", {1.5}}, {"alpha", {0.4}});
}
static uint32_t mirror(const Maker *k)
{
    return PUT(k->m, "mirror", {"color", {0.9}});
}
static uint32_t glass(const Maker *k)
{
    return PUT(k->m, "fresnel", {"ior", {1.5}}, {"absorption", {0.1}});
}
static uint32_t frosted(const Maker *k)
{
    return PUT(k->m, "fresnel", {"ior", {1.5}}, {"alpha", {0.4}});
}
// Of which more is reflected: what goes through finds no lamp.
static uint32_t dense(const Maker *k)
{
    return PUT(k->m, "fresnel", {"ior", {2.6}}, {"alpha", {0.4}});
}
static uint32_t mixed(const Maker *k)
{
    return PUT(k->m, "mix", {"a", {lambert(k)}}, {"b", {mirror(k)}}, {"weight", {0.3}});
}
static uint32_t layered(const Maker *k)
{
    return PUT(k->m, "layered", {"coat", {dielectric(k)}}, {"base", {burley(k)}},
               {"thickness", {0.001}}, {"absorption", {50}});
}
static uint32_t lacquered(const Maker *k)
{
    return PUT(k->m, "layered", {"coat", {PUT(k->m, "fresnel", {"ior", {1.5}})}},
               {"base", {lambert(k)}});
}
static uint32_t mask(const Maker *k)
{
    return PUT(k->m, "mask", {"base", {ggx(k)}}, {"opacity", {0.6}});
}
static uint32_t normal_map(const Maker *k)
{
    return PUT(k->m, "normal_map", {"base", {ggx(k)}}, {"map", {0.56, 0.47, 0.97}});
}
static uint32_t bump_map(const Maker *k)
{
    const uint32_t waves = PUT(k->m, "noise", {"scale", {3}});
    return PUT(k->m, "bump_map", {"base", {lambert(k)}}, {"map", {waves}, .texture = true},
               {"strength", {0.1}});
}
static uint32_t two_sided(const Maker *k)
{
    return PUT(k->m, "two_sided", {"front", {burley(k)}}, {"back", {mirror(k)}});
}
static uint32_t glowing(const Maker *k)
{
    return PUT(k->m, "emissive", {"radiance", {0.2}}, {"base", {phong(k)}});
}

typedef struct Material {
    const char *name;
    uint32_t (*make)(const Maker *);
    bool below;  // is seen from below, with the lamps in it
    bool walked; // is evaluated by random walks: noisy, and slow
} Material;

static const Material MATERIALS[] = {
    {"lambert", lambert, false, false},
    {"lambert, checkered", textured, false, false},
    {"phong", phong, false, false},
    {"blinn_phong", blinn_phong, false, false},
    {"burley", burley, false, false},
    {"ggx", ggx, false, false},
    {"ggx, a pair", ggx_pair, false, false},
    {"ggx, preserve", ggx_preserve, false, false},
    {"ggx, ior", dielectric, false, false},
    {"mirror", mirror, false, false},
    {"fresnel, above", glass, false, false},
    {"fresnel, below", glass, true, false},
    {"fresnel, rough, above", dense, false, false},
    {"fresnel, rough, below", frosted, true, false},
    {"mix", mixed, false, false},
    {"layered", layered, false, true},
    {"layered, smooth", lacquered, false, true},
    {"mask", mask, false, false},
    {"normal_map", normal_map, false, false},
    {"bump_map", bump_map, false, false},
    {"two_sided", two_sided, false, false},
    {"emissive base", glowing, false, false},
};

// --- Lights --------------------------------------------------------------------------------------

static Vec3 lamp_place(void)
{
    return vec3(-LAMP * FROM.x, LAMP * FROM.y, 0);
}

static void point(const Maker *k)
{
    const Vec3 p = lamp_place();
    PUT(k->m, "point_light", {"position", {p.x, p.y, p.z}}, {"intensity", {5}});
}
static void spot_cone(const Maker *k)
{
    const Vec3 p = lamp_place();
    PUT(k->m, "spot_light", {"position", {p.x, p.y, p.z}}, {"direction", {-p.x, -p.y, 0.1}},
        {"intensity", {5}},
        {"falloff", {PUT(k->m, "smooth_cone", {"inner", {0.02}}, {"outer", {0.5}})}});
}
static void spot_lobe(const Maker *k)
{
    const Vec3 p = lamp_place();
    PUT(k->m, "spot_light", {"position", {p.x, p.y, p.z}}, {"direction", {-p.x, -p.y, 0.4}},
        {"intensity", {5}}, {"falloff", {PUT(k->m, "cosine_lobe", {"exponent", {9}})}});
}
static void photometric(const Maker *k)
{
    static char file[512];
    const Vec3 p = lamp_place();
    snprintf(file, sizeof file, "%s/examples/slides/photometric/batwing.ies", SCN_SOURCE_DIR);
    PUT(k->m, "photometric_light", {"file", .text = file}, {"position", {p.x, p.y, p.z}},
        {"direction", {0.3, -1, 0.2}}, {"scale", {30}});
}
static void directional(const Maker *k)
{
    PUT(k->m, "directional_light", {"direction", {0.5, -1, 0.2}}, {"irradiance", {2}});
}
static void sun(const Maker *k)
{
    const Vec3 p = lamp_place();
    PUT(k->m, "directional_light", {"direction", {-p.x, -p.y, 0}}, {"irradiance", {2}},
        {"angle", {0.8}});
}
static void environment(const Maker *k)
{
    PUT(k->m, "environment_light", {"radiance", {1}});
}
static void sky(const Maker *k)
{
    const uint32_t cells = PUT(k->m, "checker", {"a", {2}}, {"b", {0.4}}, {"scale", {4, 3, 0}});
    PUT(k->m, "environment_light", {"radiance", {cells}, .texture = true});
}
static void area(const Maker *k, uint32_t shape)
{
    PUT(k->m, "area_light", {"shape", {shape}}, {"radiance", {3}}, {"two_sided", {1}});
}
static void ball(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "sphere", {"center", {p.x, p.y, p.z}}, {"radius", {0.7}}));
}
static void panel(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "rectangle", {"corner", {p.x - 0.6, p.y - 0.5, -0.8}},
                            {"u", {1.2, 1, 0}}, {"v", {0, 0, 1.6}}));
}
static void disc(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "disc", {"center", {p.x, p.y, p.z}}, {"normal", {1, -1, 0.2}},
                            {"radius", {0.8}}));
}
static void triangle(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "triangle", {"a", {p.x - 1, p.y - 0.5, -1}},
                            {"b", {p.x + 1, p.y + 0.7, -0.8}}, {"c", {p.x, p.y, 1.5}}));
}
static void box(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "box", {"min", {p.x - 0.6, p.y - 0.4, -0.6}},
                            {"max", {p.x + 0.6, p.y + 0.5, 0.7}}));
}
static void cylinder(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "cylinder", {"from", {p.x, p.y, -1}}, {"to", {p.x, p.y, 1}},
                            {"radius", {0.6}}));
}
static void cone(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "cone", {"from", {p.x, p.y, -1}}, {"to", {p.x, p.y, 1}},
                            {"radius_from", {0.9}}, {"radius_to", {0.4}}));
}
static void torus(const Maker *k)
{
    const Vec3 p = lamp_place();
    area(k, PUT_LIGHT_SHAPE(k->m, "torus", {"center", {p.x, p.y, p.z}}, {"axis", {1, -1, 0}},
                            {"major_radius", {0.5}}, {"minor_radius", {0.4}}));
}
static uint32_t tent(const Maker *k, bool light, uint32_t material)
{
    static Vec3 vertices[5];
    static const uint32_t FACES[12] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
    const Vec3 p = lamp_place();
    for (int i = 0; i < 4; ++i) {
        vertices[i] = add(p, vec3(i % 3 ? 0.8 : -0.8, 0.4, i / 2 ? 0.8 : -0.8));
    }
    vertices[4] = add(p, vec3(0.1, -0.5, 0));
    return light ? PUT_LIGHT_SHAPE(k->m, "mesh", {"vertices", .list = vertices, .count = 5},
                                   {"faces", .list = FACES, .count = 12}, {"smooth", {0}})
                 : PUT(k->m, "mesh", {"vertices", .list = vertices, .count = 5},
                       {"faces", .list = FACES, .count = 12}, {"smooth", {0}},
                       {"material", {material}});
}
static void mesh(const Maker *k)
{
    area(k, tent(k, true, NONE_ID));
}
static void glowing_mesh(const Maker *k)
{
    const uint32_t glow = PUT(k->m, "emissive", {"radiance", {3}});
    tent(k, false, PUT(k->m, "two_sided", {"front", {glow}}, {"back", {glow}}));
}
static void glowing_texture(const Maker *k)
{
    const uint32_t cells = PUT(k->m, "checker", {"a", {4}}, {"b", {1}}, {"scale", {3, 2, 0}});
    const uint32_t glow = PUT(k->m, "emissive", {"radiance", {cells}, .texture = true});
    const Vec3 p = lamp_place();
    PUT(k->m, "rectangle", {"corner", {p.x - 0.6, p.y - 0.5, -0.8}}, {"u", {1.2, 1, 0}},
        {"v", {0, 0, 1.6}},
        {"material", {PUT(k->m, "two_sided", {"front", {glow}}, {"back", {glow}})}});
}
// More than the integrators look at one by one.
static void crowd(const Maker *k)
{
    for (int i = 0; i < 40; ++i) {
        const double x = -3 + 0.9 * (i % 8), z = -2 + (double)(i / 8);
        const uint32_t shape = PUT_LIGHT_SHAPE(
            k->m, "sphere", {"center", {x, 1.6 + 0.1 * (i % 3), z}}, {"radius", {0.35}});
        PUT(k->m, "area_light", {"shape", {shape}}, {"radiance", {1 + i % 4}});
    }
    point(k);
    sky(k);
}

typedef struct LightKind {
    const char *name;
    void (*put)(const Maker *);
} LightKind;

static const LightKind LIGHTS[] = {
    {"point_light", point},
    {"spot, cone", spot_cone},
    {"spot, lobe", spot_lobe},
    {"photometric", photometric},
    {"directional", directional},
    {"sun's disc", sun},
    {"environment", environment},
    {"environment, texture", sky},
    {"sphere", ball},
    {"rectangle", panel},
    {"disc", disc},
    {"triangle", triangle},
    {"box", box},
    {"cylinder", cylinder},
    {"cone", cone},
    {"torus", torus},
    {"mesh", mesh},
    {"emissive mesh", glowing_mesh},
    {"emissive, texture", glowing_texture},
    {"42 lights", crowd},
};

enum {
    MATERIAL_COUNT = sizeof MATERIALS / sizeof *MATERIALS,
    LIGHT_COUNT = sizeof LIGHTS / sizeof *LIGHTS,
};

// --- Pairs ---------------------------------------------------------------------------------------

static World *make_world(SceneMaker *maker, const Material *material, const LightKind *light,
                         const char *sampling)
{
    maker_init(maker);
    PUT(maker, "render", {"sampling", {0}, sampling});
    Maker k = {.m = maker};
    k.checker = PUT(maker, "checker", {"a", {0.8}}, {"b", {0.3}}, {"scale", {7, 5, 0}});
    const uint32_t id = material->make(&k);
    const double side = material->below ? -1 : 1; // where its front is
    PUT(maker, "rectangle", {"corner", {-1, 0, side}}, {"u", {2, 0, 0}}, {"v", {0, 0, -2 * side}},
        {"material", {id}});
    if (material->make == mask) { // what is seen through it
        PUT(maker, "rectangle", {"corner", {-1, -0.3, 1}}, {"u", {2, 0, 0}}, {"v", {0, 0, -2}},
            {"material", {lambert(&k)}});
    }
    light->put(&k);
    World *world = world_build(&maker->scene, 1, &maker->sink);
    if (!world || maker->errors) {
        fprintf(stderr, "%s under %s can't be built\n", material->name, light->name);
        abort();
    }
    world->bounces = 1;
    world->russian_roulette = false;
    return world;
}

static void try_pair(const Material *material, const LightKind *light, uint32_t samples,
                     double wanted)
{
    static const Way OTHERS[] = {{"direct", &direct_integrator, SAMPLING_MIS, false},
                                 {"light", &path_integrator, SAMPLING_LIGHT, false},
                                 {"bsdf", &path_integrator, SAMPLING_BSDF, false}};
    SceneMaker maker, light_maker;
    static Rivals rivals;
    rivals = (Rivals){.world = make_world(&maker, material, light, "mis"),
                      .light_world = make_world(&light_maker, material, light, "light"),
                      .ray = look,
                      .context = material->below ? &FROM_BELOW : &FROM,
                      .first = MIS,
                      .samples = samples,
                      .seconds = 40};
    full_bias = material->walked ? 5e-3 : 1e-3;
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; ++i) {
        char name[64];
        snprintf(name, sizeof name, "7 %s, %s: %s", material->name, light->name, OTHERS[i].name);
        rivals_compare(&table, &rivals, name, &OTHERS[i], wanted);
    }
    world_free(rivals.world);
    world_free(rivals.light_world);
    maker_free(&maker);
    maker_free(&light_maker);
}

// Does an ordinary run take this pair? Each material comes up twice, and so does each light.
static bool is_chosen(int material, int light)
{
    return (light + 3 * material) % LIGHT_COUNT == 6 || (light + 7 * material) % LIGHT_COUNT == 13;
}

// Light that is a little too bright: what such a comparison is for.
static float lie;
static Rgb lying_radiance(const World *world, const Ray *ray, Sampler *sampler, AovSample *aov,
                          IntegratorStats *stats)
{
    return rgb_scale(path_integrator.radiance(world, ray, sampler, aov, stats), 1 + lie);
}
static const IntegratorClass liar = {
    .name = "liar", .doc = "of the test", .radiance = lying_radiance};

// A lie of 1 % is found by an ordinary run, of 0.1 % by a full one; by light sampling, so that it
// has noise of its own.
static bool a_liar_is_found(void)
{
    static const Way LIAR = {"liar", &liar, SAMPLING_LIGHT, false};
    static CheckTable liars;
    static Rivals rivals;
    SceneMaker maker;
    full_bias = 1e-3;
    lie = full_run() ? 1e-3f : 1e-2f;
    rivals =
        (Rivals){.world = make_world(&maker, &MATERIALS[5], &LIGHTS[9], "mis"), // ggx, a rectangle
                 .ray = look,
                 .context = &FROM,
                 .first = MIS,
                 .samples = 1 << 10,
                 .seconds = 40};
    rivals_compare(&liars, &rivals, "a lie", &LIAR, 1);
    world_free(rivals.world);
    maker_free(&maker);
    const Check *c = &liars.checks[0];
    const double z = (c->mean - 1) / c->error;
    printf("light that is %g times as bright as it should be: %.5f +- %.2g, z = %.1f\n",
           1 + (double)lie, c->mean, c->error, z);
    return fabs(z) > student_quantile(sidak(ALPHA, 3 * MATERIAL_COUNT * LIGHT_COUNT), c->freedom);
}

int main(void)
{
    if (!a_liar_is_found()) {
        fprintf(stderr, "it isn't found\n");
        return EXIT_FAILURE;
    }
    int part = 0, parts = 1, number = 0;
    const char *text = getenv("SCN_PAIRS");
    if (text && (sscanf(text, "%d/%d", &part, &parts) != 2 || parts < 1)) {
        return 2;
    }
    char name[64] = "estimators";
    if (text) {
        snprintf(name, sizeof name, "estimators_%04d", part);
        trust_part = name + strlen("estimators");
        table.family = 3 * MATERIAL_COUNT * LIGHT_COUNT;
    }
    for (int m = 0; m < MATERIAL_COUNT; ++m) {
        for (int l = 0; l < LIGHT_COUNT; ++l) {
            if ((full_run() || text || is_chosen(m, l)) && number++ % parts == part) {
                try_pair(&MATERIALS[m], &LIGHTS[l], 1 << 10, 0.1);
            }
        }
    }
    return check_judge(&table, name) ? EXIT_FAILURE : EXIT_SUCCESS;
}
