// A real luminaire, by its photometric file.
#include "render/attenuation.h"
#include "render/world.h"
#include "scene/ies.h"
#include "schema/photometry.h"

typedef struct PhotometricLight {
    const char *file;
    Vec3 position, direction, up;
    double scale;
    uint32_t attenuation;
    const IesWeb *web; // derived: in the scene's arena
    Rgb per_candela;   // derived: W/sr for each cd of the file, `scale` counted in
} PhotometricLight;

enum { FILE_NAME, POSITION, DIRECTION, UP, SCALE, ATTENUATION };

static const Param PARAMS[] = {
    [FILE_NAME] = {.name = "file",
                   .type = PARAM_FILE,
                   PARAM_AT(PhotometricLight, file),
                   .flags = PARAM_REQUIRED,
                   .doc = "A photometric file: IESNA LM-63 of 1986, 1991, 1995, 2002 or 2019, "
                          "photometry of type A, B or C (`.ies`)."},
    [POSITION] = {.name = "position",
                  .type = PARAM_VEC3,
                  PARAM_AT(PhotometricLight, position),
                  .dims = DIM_BIT(DIM_LENGTH),
                  .flags = PARAM_REQUIRED,
                  .doc = "Where it is: all light comes from this point."},
    [DIRECTION] = {.name = "direction",
                   .type = PARAM_VEC3,
                   PARAM_AT(PhotometricLight, direction),
                   .flags = PARAM_UNIT_VECTOR,
                   .default_text = "(0, -1, 0)",
                   .doc = "Where both angles of the file are 0: below a ceiling lamp, ahead of a "
                          "floodlight."},
    [UP] = {.name = "up",
            .type = PARAM_VEC3,
            PARAM_AT(PhotometricLight, up),
            .flags = PARAM_NO_DEFAULT | PARAM_UNIT_VECTOR,
            .doc = "How the luminaire is turned about its direction: type C has its half-plane of "
                   "horizontal angle 0 on this side, types A and B their positive vertical angles. "
                   "If left out it is (0, 1, 0), or (1, 0, 0) for a light that points up or down."},
    [SCALE] = {.name = "scale",
               .type = PARAM_NUMBER,
               PARAM_AT(PhotometricLight, scale),
               .min = 0,
               .max = INFINITY,
               .default_text = "1",
               .doc = "A factor on the file's intensities, for a dimmed lamp or another one."},
    [ATTENUATION] = {.name = "attenuation",
                     .type = PARAM_NODE,
                     PARAM_AT(PhotometricLight, attenuation),
                     .category = CATEGORY_ATTENUATION,
                     .default_text = "inverse_square {}",
                     .doc = "How the light falls off with distance."},
};

// The same file is often used by many lights, one after another: looks at the last few.
static const IesWeb *find_loaded(const NodeFinish *finish, const char *file)
{
    const Schema *schema = finish->scene->schema;
    int type = schema_find(schema, str_from(finish->type->name));
    if (type < 0) {
        return NULL;
    }
    const SceneTable *table = &finish->scene->tables[type];
    const PhotometricLight *lights = (const PhotometricLight *)(const void *)table->items;
    for (size_t i = 0; i < table->count && i < 16; ++i) {
        const PhotometricLight *light = &lights[table->count - 1 - i];
        if (strcmp(light->file, file) == 0) {
            return light->web;
        }
    }
    return NULL;
}

static const IesWeb *load(NodeFinish *finish, const char *file)
{
    const char *slash = strrchr(file, '/'), *name = slash ? slash + 1 : file;
    FileBytes bytes;
    IoError io = sandbox_read(finish->scene->sandbox, file, &bytes);
    if (io != IO_OK) {
        finish->report(finish, FILE_NAME, E0938, "`%s` can't be read: %s", name, io_error_text(io));
        return NULL;
    }
    IesError error;
    const IesWeb *web = ies_read(&finish->scene->arena, (Str){bytes.bytes, bytes.size}, &error);
    file_bytes_free(&bytes);
    if (!web && error.line == 0) {
        finish->report(finish, FILE_NAME, E0001, "no memory for the photometric file");
    } else if (!web) {
        finish->report(finish, FILE_NAME, E0939, "`%s`, line %u: %s", name, error.line,
                       error.message);
    }
    return web;
}

// Without `up`, y, unless the light points along it.
static bool choose_up(NodeFinish *finish, PhotometricLight *light)
{
    const double parallel = 1e-6;
    if (!(finish->set & (1u << UP))) {
        bool vertical = length(cross(light->direction, vec3(0, 1, 0))) < parallel;
        light->up = vertical ? vec3(1, 0, 0) : vec3(0, 1, 0);
    } else if (length(cross(light->direction, light->up)) < parallel) {
        finish->report(finish, UP, E0937, "`up` is parallel to the light's direction");
        return false;
    }
    return true;
}

static bool finish(NodeFinish *finish)
{
    PhotometricLight *light = finish->params;
    if (!choose_up(finish, light)) {
        return false;
    }
    light->web = find_loaded(finish, light->file);
    if (!light->web) {
        light->web = load(finish, light->file);
    }
    if (!light->web) {
        return false;
    }
    Quantity candela = {light->scale, DIM_LUMINOUS_INTENSITY};
    if (!quantity_to_rgb(candela, finish->color, &light->per_candela)) {
        finish->report(finish, -1, E0932, "a black light can't have an intensity in candela");
        return false;
    }
    return true;
}

typedef struct PhotometricData {
    Vec3 position;
    Vec3 d, u, s;    // the file's axes in the world, orthonormal; see ies.h
    Rgb per_candela; // W/sr, the tilt counted in
} PhotometricData;

// The luminaire keeps its shape whatever the transform; a mirroring one mirrors it.
static void place_axes(PhotometricData *data, const Affine *to_world,
                       const PhotometricLight *params)
{
    data->d = normalize(transform_vector(to_world, params->direction));
    Vec3 up = transform_vector(to_world, params->up);
    data->u = normalize(add_scaled(up, data->d, -dot(up, data->d)));
    data->s = cross(data->d, data->u);
    if (affine_determinant(to_world) < 0) {
        data->s = neg(data->s);
    }
}

// How far the luminaire is tilted from the position in which it was measured: its photometric zero
// straight down, which is at a vertical angle of -90° for type A, at 0 for the others.
static double tilt(const PhotometricData *data, const IesWeb *web)
{
    Vec3 zero = web->type == IES_TYPE_A ? neg(data->u) : data->d;
    return acos(fmin(fmax(-zero.y, -1), 1));
}

static bool prepare(const LightPrepare *prepare)
{
    Light *light = prepare->light;
    const PhotometricLight *params = light->params;
    const IesWeb *web = params->web;
    PhotometricData *data = ARENA_NEW(prepare->arena, PhotometricData);
    if (!data) {
        return false;
    }
    data->position = transform_point(&light->to_world, params->position);
    place_axes(data, &light->to_world, params);
    data->per_candela =
        rgb_scale(params->per_candela, (float)ies_tilt_factor(web, tilt(data, web)));
    light->data = data;
    light->power = (double)luminance(data->per_candela) * ies_lumens(web);
    light->bounds = box3_add(box3_empty(), data->position);
    // As bright everywhere within its reach.
    double reach = ies_reach(web), solid_angle = 2 * PI * (1 - cos(reach));
    light->cone = (LightCone){data->d, reach, 0};
    light->intensity = solid_angle > 0 ? light->power / solid_angle : 0;
    return true;
}

static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                   double u2, LightSample *out)
{
    (void)u0, (void)u1, (void)u2;
    const PhotometricLight *params = light->params;
    const PhotometricData *data = light->data;
    Vec3 from = sub(reference, data->position);
    double r = length(from);
    if (!(r > 0)) {
        return false;
    }
    from = scale(from, 1 / r);
    double candela =
        ies_candela(params->web, dot(from, data->d), dot(from, data->u), dot(from, data->s));
    float factor = candela > 0
                       ? (float)(candela * attenuation_factor(world->scene, params->attenuation, r))
                       : 0;
    *out = (LightSample){.direction = neg(from),
                         .distance = r,
                         .point = data->position,
                         .value = rgb_scale(data->per_candela, factor),
                         .pdf = 1,
                         .delta = true};
    return factor > 0;
}

static bool begin(const World *world, const Light *light, double u0, double u1, double u2,
                  LightOrigin *out)
{
    (void)world, (void)u0, (void)u1, (void)u2;
    const PhotometricData *data = light->data;
    *out = (LightOrigin){.surface.point.p = data->position, .point = true, .pdf = 1};
    return true;
}

static Rgb leaving(const World *world, const Light *light, const LightOrigin *origin,
                   Vec3 direction)
{
    (void)world, (void)origin;
    const PhotometricLight *params = light->params;
    const PhotometricData *data = light->data;
    const double candela = ies_candela(params->web, dot(direction, data->d),
                                       dot(direction, data->u), dot(direction, data->s));
    return rgb_scale(data->per_candela, (float)candela);
}

const LightClass photometric_light_light = {
    .node = {.name = "photometric_light",
             .category = CATEGORY_LIGHT,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(PhotometricLight),
             .doc =
                 "A real luminaire: the intensity in each direction from a photometric file (the "
                 "slides' photometric lights). Multipliers and ballast factors of the file count; "
                 "of TILT=INCLUDE the factor for the angle from straight down does. `color` only "
                 "tints: the candelas are the file's.",
             .formula = "E = I(vertical, horizontal) f(r) cos θ, I bilinear between the file's "
                        "angles and 0 outside them",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "plane { material: lambert { color: gray(0.6) } }\n"
                        "plane { point: (0, 0, -1), normal: (0, 0, 1), material: lambert { color: "
                        "gray(0.6) } }\n"
                        "for (i in 0..2) {\n"
                        "  photometric_light {\n"
                        "    file: \"slides/photometric/\" + [\"narrow\", \"downlight\", "
                        "\"batwing\"][i] + \".ies\"\n"
                        "    position: (1.1 * (i - 1), 1.35, -0.8), scale: 0.5\n"
                        "  }\n"
                        "}",
             .finish = finish},
    .prepare = prepare,
    .sample = sample,
    .begin = begin,
    .leaving = leaving,
};
