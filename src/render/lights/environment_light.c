// Light from infinitely far away, all around.
#include "base/angle.h"
#include "render/distribution.h"
#include "render/texture_image.h"
#include "render/world.h"
#include "schema/photometry.h"

typedef struct EnvironmentLight {
    const char *image;
    Emission radiance;
    double rotation;
    bool has_image; // derived
    Rgb strength;   // derived: what the image or 1 is multiplied by, W/m²/sr
} EnvironmentLight;

enum { IMAGE, RADIANCE, ROTATION };

static const Param PARAMS[] = {
    [IMAGE] = {.name = "image",
               .type = PARAM_FILE,
               PARAM_AT(EnvironmentLight, image),
               .flags = PARAM_NO_DEFAULT,
               .doc =
                   "A latitude-longitude picture, its top row straight up (+y). Its middle column "
                   "lies towards -z, where a new camera looks, and what is right of it towards "
                   "+x. Without one the surroundings are of one color."},
    [RADIANCE] = {.name = "radiance",
                  .type = PARAM_EMISSION,
                  PARAM_AT(EnvironmentLight, radiance),
                  .dims = DIM_BIT(DIM_NONE) | DIM_BIT(DIM_LUMINANCE),
                  .si = "W/m²/sr",
                  .min = 0,
                  .max = INFINITY,
                  .default_text = "1",
                  .doc = "The radiance where the picture is white: a number (times `color`) or a "
                         "color. It may be a texture, laid out as the picture."},
    [ROTATION] = {.name = "rotation",
                  .type = PARAM_NUMBER,
                  PARAM_AT(EnvironmentLight, rotation),
                  .dims = DIM_BIT(DIM_ANGLE),
                  .default_text = "0deg",
                  .doc = "About the y axis, counter-clockwise seen from above."},
};

static bool finish(NodeFinish *finish)
{
    EnvironmentLight *light = finish->params;
    light->has_image = finish->set & (1u << IMAGE);
    if (light->has_image && light->radiance.texture != NONE_ID) {
        finish->report(
            finish, RADIANCE, E0930,
            "`environment_light` takes either an `image` or a texture as `radiance`, not "
            "both");
        return false;
    }
    if (!emission_to_rgb(&light->radiance, finish->color, &light->strength)) {
        finish->report(finish, RADIANCE, E0932, "a black light can't have a photometric radiance");
        return false;
    }
    return true;
}

// Sizes of the tables: of a texture's (which is tabulated), and the largest of a picture's.
enum { TEXTURE_WIDTH = 1024, TEXTURE_HEIGHT = 512, MAX_GRID = 2048 };

// Latitude rows are of equal angle; within a cell directions are uniform by solid angle, so that
// the density is the cell's chance over the cell's solid angle, exactly.
typedef struct EnvironmentData {
    const TextureImage *image; // NULL: constant, or a texture
    uint32_t texture;
    bool even; // constant
    Rgb strength;
    Affine to_world, to_local; // rotations
    Grid grid;
    double *row_cosines; // grid.height + 1: of the rows' borders, from the top
    double *row_pdfs;    // grid.height: 1 / (solid angle of a cell * the grid's total)
} EnvironmentData;

// Only rotations (with uniform scaling, which means nothing here) keep solid angles.
static bool rotation_part(const Affine *a, Affine *out)
{
    Vec3 x = vec3(a->m[0][0], a->m[1][0], a->m[2][0]);
    Vec3 y = vec3(a->m[0][1], a->m[1][1], a->m[2][1]);
    Vec3 z = vec3(a->m[0][2], a->m[1][2], a->m[2][2]);
    double l = length(x);
    double skew = fabs(dot(x, y)) + fabs(dot(y, z)) + fabs(dot(z, x));
    if (!(l > 0) || skew > 1e-6 * l * l || fabs(length(y) - l) > 1e-6 * l ||
        fabs(length(z) - l) > 1e-6 * l) {
        return false;
    }
    x = normalize(x);
    y = normalize(y);
    z = normalize(z);
    *out = (Affine){{{x.x, y.x, z.x, 0}, {x.y, y.y, z.y, 0}, {x.z, y.z, z.z, 0}}};
    return true;
}

// Where a local direction lies on the picture, u to the right, v upwards, in [0, 1].
static Vec2 direction_to_uv(Vec3 d)
{
    const double across = sqrt(larger(0, 1 - d.y * d.y));
    const AnglePair angles = two_angles((AnglePair){-d.z, d.y}, (AnglePair){d.x, across});
    const double u = 0.5 + angles[0] * (0.5 / PI);
    return (Vec2){u < 1 ? larger(u, 0) : 0, 1 - angles[1] * (1 / PI)};
}

static Rgb radiance_at(const World *world, const EnvironmentData *data, Vec2 uv)
{
    Rgb value = rgb_gray(1);
    if (data->image) {
        value = texture_image_look_up(data->image, uv.x, uv.y, FILTER_BILINEAR, WRAP_REPEAT,
                                      WRAP_CLAMP);
    } else if (data->texture != NONE_ID) {
        Surface surface = {.uv = uv, .color = rgb_gray(1)};
        value = texture_color(world->textures, data->texture, &surface);
    }
    return positive_color(rgb_mul(value, data->strength));
}

static double cell_solid_angle(const EnvironmentData *data, uint32_t y)
{
    return 2 * PI / data->grid.width * (data->row_cosines[y] - data->row_cosines[y + 1]);
}

// The density of directions in a cell.
static float cell_pdf(const EnvironmentData *data, uint32_t x, uint32_t y)
{
    const double *row = data->grid.cells + y * ((size_t)data->grid.width + 1);
    return (float)((row[x + 1] - row[x]) * data->row_pdfs[y]);
}

// How many texels a cell has along one axis: the smallest divisor of `size` that leaves at most
// MAX_GRID cells, so that cells end where texels do.
static int texels_per_cell(int size)
{
    int per_cell = (size + MAX_GRID - 1) / MAX_GRID;
    while (size % per_cell != 0) {
        ++per_cell;
    }
    return per_cell;
}

// Luminance under the bilinear filter, summed over one cell along x: whole texels inside, seven
// eighths of those at the ends and an eighth of the neighbours' (for one texel: 1/8, 6/8, 1/8). So
// a cell has weight wherever the filtered picture isn't black.
static double cell_row(const EnvironmentData *data, int y, int x0, int per_cell)
{
    const TextureImage *image = data->image;
    int rows_y = y < 0 ? 0 : y >= image->height ? image->height - 1 : y;
    const Rgb *row = image->texels + (size_t)rows_y * (size_t)image->width;
    double sum = 0;
    for (int i = -1; i <= per_cell; ++i) {
        int x = (x0 + i + image->width) % image->width;
        double weight = i < 0 || i == per_cell
                            ? 0.125
                            : 1 - (i == 0 ? 0.125 : 0) - (i == per_cell - 1 ? 0.125 : 0);
        sum += weight * (double)luminance(positive_color(rgb_mul(row[x], data->strength)));
    }
    return sum / per_cell;
}

static double image_cell(const EnvironmentData *data, int cell_x, int cell_y, int nx, int ny)
{
    double sum = 0;
    for (int i = -1; i <= ny; ++i) {
        double weight =
            i < 0 || i == ny ? 0.125 : 1 - (i == 0 ? 0.125 : 0) - (i == ny - 1 ? 0.125 : 0);
        sum += weight * cell_row(data, cell_y * ny + i, cell_x * nx, nx);
    }
    return sum / ny;
}

// A texture is taken at the middle of each cell, and no cell is left without a little weight, since
// what lies between isn't known.
static double texture_cell(const World *world, const EnvironmentData *data, uint32_t x, uint32_t y)
{
    Vec2 uv = {(x + 0.5) / data->grid.width, 1 - (y + 0.5) / data->grid.height};
    return (double)luminance(radiance_at(world, data, uv));
}

static double fill_grid(const World *world, EnvironmentData *data, int nx, int ny)
{
    Grid *grid = &data->grid;
    double total = 0;
    for (uint32_t y = 0; y < grid->height; ++y) {
        double *row = grid->cells + y * ((size_t)grid->width + 1) + 1;
        double solid_angle = cell_solid_angle(data, y);
        for (uint32_t x = 0; x < grid->width; ++x) {
            double value = data->image                ? image_cell(data, (int)x, (int)y, nx, ny)
                           : data->texture != NONE_ID ? texture_cell(world, data, x, y)
                                                      : (double)luminance(data->strength);
            row[x] = value * solid_angle;
            total += row[x];
        }
    }
    return total;
}

static void lift_grid(EnvironmentData *data, double mean)
{
    Grid *grid = &data->grid;
    for (uint32_t y = 0; y < grid->height; ++y) {
        double *row = grid->cells + y * ((size_t)grid->width + 1) + 1;
        for (uint32_t x = 0; x < grid->width; ++x) {
            row[x] += 0.1 * mean * cell_solid_angle(data, y);
        }
    }
}

// Of what is about as bright as the mean, rays scattered by surfaces find enough by chance: lights
// are sampled the more where it is brighter (Karlík et al. 2019, "MIS Compensation: Optimizing
// Sampling Techniques in Multiple Importance Sampling"). Unlike there no cell is left out, so that
// the density needs no other beside it.
static void compensate(EnvironmentData *data, double mean)
{
    Grid *grid = &data->grid;
    for (uint32_t y = 0; y < grid->height; ++y) {
        double *row = grid->cells + y * ((size_t)grid->width + 1) + 1;
        const double common = mean * cell_solid_angle(data, y);
        for (uint32_t x = 0; x < grid->width; ++x) {
            row[x] = larger(row[x] - common, 0.05 * row[x]);
        }
    }
}

static bool make_tables(const LightPrepare *prepare, EnvironmentData *data)
{
    int nx = 1, ny = 1;
    uint32_t width = 1, height = 1;
    if (data->image) {
        nx = texels_per_cell(data->image->width);
        ny = texels_per_cell(data->image->height);
        width = (uint32_t)(data->image->width / nx);
        height = (uint32_t)(data->image->height / ny);
    } else if (data->texture != NONE_ID) {
        width = TEXTURE_WIDTH;
        height = TEXTURE_HEIGHT;
    }
    data->row_cosines = arena_array(prepare->arena, height + 1, sizeof *data->row_cosines);
    data->row_pdfs = arena_array(prepare->arena, height, sizeof *data->row_pdfs);
    if (!data->row_cosines || !data->row_pdfs ||
        !grid_allocate(&data->grid, prepare->arena, width, height)) {
        return false;
    }
    for (uint32_t y = 0; y <= height; ++y) {
        data->row_cosines[y] = cos(PI * y / height);
    }
    double total = fill_grid(prepare->world, data, nx, ny);
    if (!data->image && data->texture != NONE_ID) {
        lift_grid(data, total / (4 * PI));
    }
    if (prepare->world->sampling == SAMPLING_MIS) {
        compensate(data, total / (4 * PI));
    }
    grid_sum(&data->grid);
    const double weight = data->grid.rows[height];
    for (uint32_t y = 0; y < height; ++y) {
        data->row_pdfs[y] = weight > 0 ? 1 / (cell_solid_angle(data, y) * weight) : 0;
    }
    double radius = world_radius(prepare->world);
    // The flux through the scene's largest section, from everywhere.
    prepare->light->power = total * PI * radius * radius;
    prepare->light->intensity = total / 4; // the mean irradiance over all normals
    return true;
}

static bool prepare(const LightPrepare *prepare)
{
    const EnvironmentLight *params = prepare->light->params;
    EnvironmentData *data = ARENA_NEW(prepare->arena, EnvironmentData);
    if (!data) {
        return false;
    }
    prepare->light->data = data;
    data->texture = params->radiance.texture;
    data->strength = params->strength;
    Affine turn = affine_rotation(vec3(0, 1, 0), params->rotation);
    Affine whole = affine_multiply(&prepare->light->to_world, &turn);
    if (!rotation_part(&whole, &data->to_world)) {
        diag_report(prepare->sink, E0934, prepare->at,
                    "an `environment_light` can be rotated, not stretched or sheared");
        return false;
    }
    data->to_local = data->to_world;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            data->to_local.m[i][j] = data->to_world.m[j][i];
        }
    }
    if (params->has_image) {
        data->image = texture_set_image(prepare->world->textures, prepare->world->scene,
                                        params->image, ENCODING_AUTO, prepare->sink, prepare->at);
        if (!data->image) {
            return false;
        }
    }
    data->even = !data->image && data->texture == NONE_ID;
    return make_tables(prepare, data);
}

static bool sample(const World *world, const Light *light, Vec3 reference, double u0, double u1,
                   double u2, LightSample *out)
{
    (void)reference, (void)u2;
    const EnvironmentData *data = light->data;
    const Grid *grid = &data->grid;
    uint32_t x, y;
    double in_x, in_y;
    if (!grid_choose(grid, u0, u1, &x, &y, &in_x, &in_y)) {
        return false;
    }
    const double top = data->row_cosines[y], bottom = data->row_cosines[y + 1];
    const double cos_theta = top + (bottom - top) * in_y;
    const double sin_theta = sqrt(larger(0, 1 - cos_theta * cos_theta));
    const double u = (x + in_x) / grid->width;
    const Vec2 around = circle_point(u); // from +z, by way of -x
    const Vec3 local = vec3(-sin_theta * around.y, cos_theta, sin_theta * around.x);
    out->direction = renormalize(transform_vector(&data->to_world, local));
    out->distance = INFINITY;
    out->point = vec3(0, 0, 0);
    out->error = 0;
    out->target = 0;
    out->facing = 0;
    out->value = data->strength;
    if (!data->even) {
        const AnglePair theta = two_angles((AnglePair){cos_theta, 1}, (AnglePair){sin_theta, 0});
        out->value = radiance_at(world, data, (Vec2){u, 1 - theta[0] * (1 / PI)});
    }
    out->pdf = cell_pdf(data, x, y);
    out->delta = false;
    return out->pdf > 0;
}

static float pdf_at(const EnvironmentData *data, Vec2 uv)
{
    const Grid *grid = &data->grid;
    const double x = smaller(uv.x * grid->width, grid->width - 1.0);
    const double y = smaller((1 - uv.y) * grid->height, grid->height - 1.0);
    return cell_pdf(data, (uint32_t)x, (uint32_t)y);
}

static float pdf(const World *world, const Light *light, Vec3 reference, Vec3 direction,
                 const Surface *hit)
{
    (void)world, (void)reference, (void)hit;
    const EnvironmentData *data = light->data;
    return pdf_at(data, direction_to_uv(transform_vector(&data->to_local, direction)));
}

static Rgb escaped(const World *world, const Light *light, Vec3 direction, float *pdf_out)
{
    const EnvironmentData *data = light->data;
    if (data->even && !pdf_out) {
        return data->strength;
    }
    const Vec2 uv = direction_to_uv(transform_vector(&data->to_local, direction));
    if (pdf_out) {
        *pdf_out = pdf_at(data, uv);
    }
    return data->even ? data->strength : radiance_at(world, data, uv);
}

const LightClass environment_light_light = {
    .node = {.name = "environment_light",
             .category = CATEGORY_LIGHT,
             .params = PARAMS,
             .param_count = sizeof PARAMS / sizeof *PARAMS,
             .size = sizeof(EnvironmentLight),
             .doc = "Light from infinitely far away all around: of one color, or a picture of the "
                    "surroundings.",
             .formula = "u = 1/2 + atan2(d.x, -d.z) / 2π from the left, v = acos(d.y) / π from the "
                        "top, d the direction looked in",
             .example = "camera { position: (0, 1.2, 4), look_at: (0, 0.55, 0), fov: 30deg }\n"
                        "environment_light { image: \"textures/sky.exr\", rotation: 40deg }\n"
                        "plane {\n"
                        "  material: lambert { color: checker { a: gray(0.6), b: gray(0.35), "
                        "space: \"world\", scale: 2 } }\n"
                        "}\n"
                        "sphere { center: (-0.55, 0.5, 0), radius: 0.5, material: mirror { color: "
                        "gray(0.9) } }\n"
                        "sphere { center: (0.55, 0.5, 0), radius: 0.5, material: lambert { color: "
                        "gray(0.8) } }",
             .finish = finish},
    .infinite = true,
    .prepare = prepare,
    .sample = sample,
    .pdf = pdf,
    .escaped = escaped,
};
