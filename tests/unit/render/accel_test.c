// Rays through whole scenes: against all shapes one by one, without gaps or self-hits at every
// scale and far from the origin, instances against copies.
#include "../../trust.h"
#include "render/accel_parts.h"
#include "render/render.h"

#include "shapes.h"

static Scene *scene_new(void)
{
    Scene *scene = calloc(1, sizeof *scene);
    assert_non_null(scene);
    assert_true(scene_init(scene, render_schema(), NULL));
    return scene;
}
static void scene_drop(Scene *scene)
{
    scene_free(scene);
    free(scene);
}
static void add_plain(Scene *scene, Params p)
{
    add_shape(scene, &p, NULL, 0);
}

static uint32_t add_instance(Scene *scene, uint32_t prototype, const Affine *to)
{
    uint32_t transform = to ? scene_add_transform(scene, to) : 0;
    assert_int_not_equal(transform, NONE_ID);
    SceneInstance instance = {.prototype = prototype, .transform = transform, .material = NONE_ID};
    assert_true(array_push(&scene->instances, instance));
    return (uint32_t)scene->instances.count - 1;
}

static Ray through(Affine inverse, Ray ray)
{
    return ray_make(transform_point(&inverse, ray.origin),
                    transform_vector(&inverse, ray.direction), ray.tmin, ray.tmax);
}

// Möller, Trumbore in double, for a mesh.
static bool mesh_hit(const Mesh *mesh, const Ray *ray, ShapeHit *hit)
{
    bool found = false;
    double nearest = ray->tmax;
    for (uint32_t i = 0; i < mesh->triangle_count; ++i) {
        Vec3 c[3];
        for (int k = 0; k < 3; ++k) {
            const float *p = mesh->positions + 3 * (size_t)mesh->triangles[3 * i + (uint32_t)k];
            c[k] = add(mesh->origin, vec3((double)p[0], (double)p[1], (double)p[2]));
        }
        Vec3 u = sub(c[1], c[0]), v = sub(c[2], c[0]), h = cross(ray->direction, v);
        double det = dot(u, h);
        Vec3 s = sub(ray->origin, c[0]), q = cross(s, u);
        double a = dot(s, h) / det, b = dot(ray->direction, q) / det, t = dot(v, q) / det;
        if (a >= 0 && b >= 0 && a + b <= 1 && t > ray->tmin && t < nearest) {
            nearest = t;
            *hit = (ShapeHit){.t = t, .primitive = i, .u = a, .v = b};
            found = true;
        }
    }
    return found;
}

// One shape of one instance after the other.
static bool brute_hit(const Scene *scene, const Ray *ray, Hit *hit)
{
    bool found = false;
    Ray world = *ray;
    for (uint32_t i = 0; i < scene->nodes[CATEGORY_SHAPE].count; ++i) {
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, i);
        const ShapeClass *class = shape_class(scene, node);
        size_t places = node->prototype ? scene->instances.count : 1;
        for (size_t k = 0; k < places; ++k) {
            Ray local = world;
            if (node->prototype) {
                const SceneInstance *instance = &scene->instances.items[k];
                if (instance->prototype != node->prototype) {
                    continue;
                }
                local = through(scene->inverses.items[instance->transform], local);
            }
            local = through(scene->inverses.items[node->transform], local);
            ShapeHit at;
            const void *params = scene_params(scene, node);
            bool here = class->holding == HOLD_TRIANGLES
                            ? mesh_hit(&scene->meshes.items[((const MeshParams *)params)->mesh],
                                       &local, &at)
                            : class->intersect(params, &local, &at);
            if (here) {
                *hit = (Hit){.t = at.t,
                             .shape = i,
                             .instance = node->prototype ? (uint32_t)k : NONE_ID,
                             .local = at};
                world.tmax = at.t;
                found = true;
            }
        }
    }
    return found;
}

// Some of every kind, with and without transforms, in a cube of half edge `reach` about `center`.
static void fill_scene(Scene *scene, Random *r, Vec3 center, double reach, int count,
                       uint32_t prototype, bool transforms)
{
    Box3 box = {sub(center, vec3(reach, reach, reach)), add(center, vec3(reach, reach, reach))};
    double size = reach * 0.2;
    for (int i = 0; i < count; ++i) {
        Vec3 p = random_in_box(r, box), d = scale(random_direction(r), size);
        Vec3 e = scale(random_direction(r), size);
        Params params;
        switch (i % 10) {
        case 0:
            params = sphere_params_of(p, size * between(r, 0.1, 1));
            break;
        case 1:
            params = box_params_of(p, add(p, vec3(size * between(r, 0.2, 1), size, size * 0.5)));
            break;
        case 2:
            params = disc_params_of(p, d, size, size * 0.4);
            break;
        case 3:
        case 4:
            params = rectangle_params_of(p, d, e);
            break;
        case 5:
            params = triangle_params_of(p, add(p, d), add(p, e));
            break;
        case 6:
            params = cylinder_params_of(p, add(p, d), size * 0.2, i % 20 < 10);
            break;
        case 7:
            params = cone_params_of(p, add(p, d), size * 0.5, i % 20 < 10 ? 0 : size * 0.2, true);
            break;
        case 8:
            params = torus_params_of(p, d, size, size * 0.3);
            break;
        default:
            params = bumpy_mesh(scene, p, size, 6);
            break;
        }
        if (transforms && i % 3 == 0) {
            // About p, so that the shape stays in place.
            Affine about = random_affine(r, 0), back = affine_translation(p);
            Affine to = affine_translation(neg(p));
            about = affine_multiply(&about, &to);
            about = affine_multiply(&back, &about);
            add_shape(scene, &params, &about, prototype);
        } else {
            add_shape(scene, &params, NULL, prototype);
        }
    }
}

// At edges single and double precision may differ: rays that part are allowed to be few.
typedef struct Comparison {
    int rays, hits, parted;
} Comparison;

static void compare_ray(const Accel *accel, const Scene *scene, const Ray *ray, double size,
                        Comparison *c)
{
    Hit hit, expected;
    bool found = accel_intersect(accel, ray, &hit), wanted = brute_hit(scene, ray, &expected);
    ++c->rays;
    c->hits += wanted;
    bool same = found == wanted && accel_occluded(accel, ray) == found &&
                (!found || fabs(hit.t - expected.t) <= 1e-9 * size);
    if (!same) {
        ++c->parted;
        return;
    }
    if (!found) {
        return;
    }
    assert_int_equal(hit.shape, expected.shape);
    assert_int_equal(hit.instance, expected.instance);
    Surface s;
    accel_surface(accel, ray, &hit, &s);
    assert_true(length(sub(s.p, add_scaled(ray->origin, ray->direction, hit.t))) < 1e-6 * size);
    assert_int_equal(s.front, dot(s.geometric, ray->direction) < 0);
    assert_near(length(s.geometric), 1, 1e-12);
    assert_near(length(s.shading), 1, 1e-12);
    assert_true(s.error > 0);
}

static void hits_are_those_of_all_shapes_tried(void **state)
{
    (void)state;
    Random r = random_make("brute", 31);
    const double scales[] = {1, 1e-6, 1e6, 1};
    const Vec3 centers[] = {{0, 0, 0}, {1, 2, 3}, {0, 0, 0}, {148376, 1234, -223423}};
    Comparison c = {0, 0, 0};
    for (int round = 0; round < 4; ++round) {
        Scene *scene = scene_new();
        double size = scales[round];
        Vec3 center = round == 1 ? scale(centers[1], 1e-6) : centers[round];
        fill_scene(scene, &r, center, size, 100, 0, true);
        if (round == 0) {
            add_plain(scene, plane_params_of(add(center, vec3(0, -size, 0)), vec3(0.1, 1, 0.2)));
        }
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        Box3 bounds = accel_bounds(accel);
        for (int i = 0; i < 8000; ++i) {
            Vec3 far = add_scaled(center, random_direction(&r), size * pow(10, between(&r, -1, 4)));
            Vec3 from = i % 2 ? far : random_in_box(&r, bounds);
            Vec3 to = random_in_box(&r, bounds);
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            if (i % 5 == 0) {
                ray.tmin = length(sub(to, from)) * uniform(&r);
                ray.tmax = ray.tmin + size * uniform(&r);
            }
            compare_ray(accel, scene, &ray, size + length(from), &c);
        }
        accel_free(accel);
        scene_drop(scene);
    }
    print_message("  %d rays, %d hits, %d parted\n", c.rays, c.hits, c.parted);
    assert_true(c.hits > c.rays / 3);
    assert_true(c.parted <= 3);
}

// A prototype's shapes, in instances and as copies.
static void instances_equal_copies(void **state)
{
    (void)state;
    Random r = random_make("instances", 32);
    for (int round = 0; round < 3; ++round) {
        Scene *shared = scene_new();
        double away = round == 2 ? 1e5 : 0;
        uint32_t one = scene_add_prototype(shared, 0, (Span){0});
        uint32_t two = scene_add_prototype(shared, 0, (Span){0});
        fill_scene(shared, &r, vec3(away, 0, 0), 1, 40, one, true);
        fill_scene(shared, &r, vec3(0, 0, away), 1, 20, two, true);
        fill_scene(shared, &r, vec3(0, 0, 0), 4, 20, 0, false);
        Comparison c = {0, 0, 0};
        Scene *flat = scene_new();
        for (int i = 0; i < 12; ++i) {
            Affine to = random_affine(&r, 4);
            uint32_t prototype = i % 3 ? one : two;
            if (i % 2) { // mirrored
                Affine mirror = affine_scaling(vec3(-1, 1, 1));
                to = affine_multiply(&to, &mirror);
            }
            // Back near the world's origin.
            Vec3 was = prototype == one ? vec3(-away, 0, 0) : vec3(0, 0, -away);
            Affine back = affine_translation(was);
            to = affine_multiply(&to, &back);
            add_instance(shared, prototype, &to);
        }
        // The copies: nodes of the same parameters with the product of the transforms.
        flat->meshes = shared->meshes;
        for (uint32_t i = 0; i < shared->nodes[CATEGORY_SHAPE].count; ++i) {
            const SceneNode *node = scene_node(shared, CATEGORY_SHAPE, i);
            size_t places = node->prototype ? shared->instances.count : 1;
            for (size_t k = 0; k < places; ++k) {
                const SceneInstance *instance = &shared->instances.items[k];
                if (node->prototype && instance->prototype != node->prototype) {
                    continue;
                }
                Affine to = shared->transforms.items[node->transform];
                if (node->prototype) {
                    to = affine_multiply(&shared->transforms.items[instance->transform], &to);
                }
                uint32_t transform = scene_add_transform(flat, &to);
                scene_add_node(flat, node->type, scene_params(shared, node),
                               (SceneNode){.material = NONE_ID, .transform = transform});
            }
        }
        Accel *a = accel_build(shared, 1), *b = accel_build(flat, 1);
        assert_true(a && b);
        for (int i = 0; i < 20000; ++i) {
            Vec3 from = scale(random_direction(&r), between(&r, 0, 12));
            Vec3 to = scale(random_direction(&r), between(&r, 0, 6));
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            Hit ha, hb;
            bool fa = accel_intersect(a, &ray, &ha), fb = accel_intersect(b, &ray, &hb);
            ++c.rays;
            c.hits += fa;
            if (fa != fb || accel_occluded(a, &ray) != fa || (fa && fabs(ha.t - hb.t) > 1e-8)) {
                ++c.parted;
                continue;
            }
            if (fa) {
                Surface sa, sb;
                accel_surface(a, &ray, &ha, &sa);
                accel_surface(b, &ray, &hb, &sb);
                assert_true(length(sub(sa.p, sb.p)) < 1e-8);
                assert_true(length(sub(sa.geometric, sb.geometric)) < 1e-6);
                assert_true(length(sub(sa.shading, sb.shading)) < 1e-6);
                assert_int_equal(sa.primitive, sb.primitive);
                assert_int_equal(sa.front, sb.front);
                assert_near(sa.uv.x, sb.uv.x, 1e-5);
                if (scene_node(shared, CATEGORY_SHAPE, ha.shape)->prototype) {
                    assert_int_not_equal(ha.instance, NONE_ID);
                    Affine to_world = accel_to_world(a, ha.shape, ha.instance);
                    assert_true(length(sub(transform_point(&to_world, sa.object_p), sa.p)) < 1e-8);
                } else {
                    assert_int_equal(ha.instance, NONE_ID);
                }
            }
        }
        print_message("  %d rays, %d hits, %d parted\n", c.rays, c.hits, c.parted);
        assert_true(c.hits > 5000 && c.parted <= 4);
        accel_free(a);
        accel_free(b);
        flat->meshes.items = NULL;
        flat->meshes.count = flat->meshes.capacity = 0;
        scene_drop(flat);
        scene_drop(shared);
    }
}

// Reference check 26, first half: a closed mesh far from the origin, rays from inside aimed at its
// vertices and at points of its edges, and from outside at vertices that face them: none gets
// through.
static void no_ray_slips_through_at_vertices(void **state)
{
    (void)state;
    Random r = random_make("vertices", 33);
    int all_misses = 0, all_rays = 0;
    const Vec3 centers[] = {{148376, 1234, -223423}, {0, 0, 0}, {1e6, -1e6, 3e5}};
    for (int round = 0; round < 6; ++round) {
        Vec3 center = centers[round % 3];
        double size = round < 3 ? 10 : pow(10, between(&r, -2, 3));
        Scene *scene = scene_new();
        Params p = bumpy_mesh(scene, center, size, 48);
        add_plain(scene, p);
        if (round % 2) { // a neighbour that makes the mesh small beside the scene
            add_plain(scene, sphere_params_of(add(center, vec3(0, -2000 * size, 0)), 1000 * size));
        }
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        const Mesh *mesh = &scene->meshes.items[0];
        int misses = 0, rays = 0;
        for (uint32_t i = 0; i < 3 * mesh->triangle_count; ++i) {
            uint32_t j = i % 3 == 2 ? i - 2 : i + 1;
            const float *a = mesh->positions + 3 * (size_t)mesh->triangles[i];
            const float *b = mesh->positions + 3 * (size_t)mesh->triangles[j];
            double w = i % 2 ? 0 : uniform(&r);
            Vec3 target = vec3(mesh->origin.x + (double)a[0] * (1 - w) + (double)b[0] * w,
                               mesh->origin.y + (double)a[1] * (1 - w) + (double)b[1] * w,
                               mesh->origin.z + (double)a[2] * (1 - w) + (double)b[2] * w);
            Vec3 inside = add_scaled(center, random_direction(&r), 0.5 * size);
            Vec3 outside = add_scaled(target, sub(target, center), between(&r, 0.1, 100));
            Hit hit;
            Ray out = ray_make(inside, normalize(sub(target, inside)), 0, INFINITY);
            misses += !accel_intersect(accel, &out, &hit);
            Ray in = ray_make(outside, normalize(sub(target, outside)), 0, INFINITY);
            misses += !accel_intersect(accel, &in, &hit);
            misses += !accel_occluded(accel, &in);
            rays += 3;
        }
        all_rays += rays;
        all_misses += misses;
        accel_free(accel);
        scene_drop(scene);
    }
    assert_true(trust_none("26 rays at vertices and edges of closed meshes that miss", all_misses,
                           all_rays));
}

// A direction on the normal's side, half of them grazing.
static Vec3 leaving(Random *r, Vec3 normal)
{
    Vec3 d = random_about(r, normal);
    if (random_bits(r) & 1) {
        double flat = pow(10, between(r, -10, 0)), up = dot(d, normal);
        d = normalize(add_scaled(d, normal, flat * up - up));
    }
    return d;
}

// Reference check 26, second half: rays that leave the outside of convex bodies hit nothing, rays
// that go inside hit the other side, at scales from 1e-6 to 1e6, near and far from the origin.
static void respawned_rays_neither_stick_nor_leak(void **state)
{
    (void)state;
    Random r = random_make("respawn", 34);
    int spawned = 0, passed = 0, steep = 0, stuck_rays = 0, leaked = 0;
    for (int round = 0; round < 26; ++round) {
        double size = pow(10, round % 13 - 6);
        Vec3 center = round < 13 ? vec3(0, 0, 0)
                                 : scale(random_direction(&r), size * pow(10, between(&r, 0, 6)));
        for (int kind = 0; kind < 4; ++kind) {
            Scene *scene = scene_new();
            Affine turn = random_affine(&r, 0), to = affine_translation(center);
            Affine grow = affine_scaling(vec3(size, size, size));
            to = affine_multiply(&to, &grow);
            turn = affine_multiply(&to, &turn);
            Params p;
            if (kind == 0) {
                p = sphere_params_of(vec3(0.1, 0.2, 0.3), 0.9);
            } else if (kind == 1) {
                p = box_params_of(vec3(-1, -0.5, -0.3), vec3(0.5, 0.7, 0.9));
            } else if (kind == 2) {
                p = cylinder_params_of(vec3(-1, -0.5, -0.3), vec3(0.5, 0.7, 0.9), 0.4, true);
            } else { // a convex mesh
                Vec3 v[8];
                for (int k = 0; k < 8; ++k) {
                    v[k] = vec3(k & 1 ? 1 : -1, k & 2 ? 0.9 : -1, k & 4 ? 0.8 : -0.7);
                }
                const uint32_t f[36] = {0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4,
                                        2, 6, 7, 2, 7, 3, 0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6};
                p = mesh_params_of(scene, v, 8, f, 12);
            }
            add_shape(scene, &p, &turn, 0);
            Accel *accel = accel_build(scene, 1);
            assert_non_null(accel);
            Box3 box = accel_bounds(accel);
            for (int i = 0; i < 12000; ++i) {
                Vec3 from = add_scaled(box3_center(box), random_direction(&r), 20 * size);
                Vec3 at = random_in_box(&r, box);
                Ray ray = ray_make(from, normalize(sub(at, from)), 0, INFINITY);
                Hit hit;
                if (!accel_intersect(accel, &ray, &hit)) {
                    continue;
                }
                Surface s;
                accel_surface(accel, &ray, &hit, &s);
                double scale_up = max_component(sub(box.max, box.min));
                if (!s.front) { // an edge beside the ray
                    Vec3 beside = sub(s.p, add_scaled(ray.origin, ray.direction, hit.t));
                    assert_true(kind == 3 && length(beside) < scale_up * 0x1p-18);
                    ++passed;
                    continue;
                }
                Vec3 way = i % 2 ? leaving(&r, s.geometric) : random_about(&r, s.geometric);
                Ray out = surface_spawn(&s, way);
                bool stuck = accel_intersect(accel, &out, &hit);
                assert_int_equal(accel_occluded(accel, &out), stuck);
                if (stuck) {
                    // Only an edge that the ray passes by, nearer than documented, may be hit.
                    Surface other;
                    accel_surface(accel, &out, &hit, &other);
                    Vec3 beside = sub(other.p, add_scaled(out.origin, out.direction, hit.t));
                    if (kind != 3 || hit.t < scale_up * 0x1p-17 ||
                        length(beside) > scale_up * 0x1p-18) {
                        print_message("kind %d of size %g at %g: stuck at %g\n", kind, size,
                                      length(center), hit.t);
                        ++stuck_rays;
                    }
                    assert_true(dot(way, s.geometric) < 0.2);
                    ++passed;
                    steep += i % 2 == 0;
                }
                Ray in = surface_spawn(&s, leaving(&r, neg(s.geometric)));
                bool found = accel_intersect(accel, &in, &hit);
                double offset = 4 * s.error;
                if (!found) {
                    // Only from within the offset of an edge may a ray get out.
                    Ray back = ray_make(add_scaled(s.p, s.geometric, -1e3 * offset), in.direction,
                                        0, INFINITY);
                    Hit other;
                    if (accel_intersect(accel, &back, &other) && other.t > 1e5 * offset) {
                        print_message("kind %d of size %g at %g: leaked\n", kind, size,
                                      length(center));
                        ++leaked;
                    }
                }
                spawned += 2;
            }
            accel_free(accel);
            scene_drop(scene);
        }
    }
    print_message(
        "  %d rays spawned; %d that ran along a face and %d others hit an edge beside them\n",
        spawned, passed - steep, steep);
    assert_true(trust_none("26 respawned rays that hit where they began", stuck_rays, spawned));
    assert_true(
        trust_none("26 respawned rays that leaked by more than the offset", leaked, spawned));
    assert_true(steep < spawned / 10000);
    assert_true(spawned > 1000000);
}

// Whether what a ray ought to hit is what single precision may miss by its documented limits: a
// plane that is met at a very flat angle or right at the start, and there very near to the start or
// to the edge.
static bool may_be_missed(const Accel *accel, const Scene *scene, const Ray *ray, double size,
                          double piece)
{
    Hit hit;
    Surface s;
    if (!brute_hit(scene, ray, &hit)) {
        return false;
    }
    accel_surface(accel, ray, &hit, &s);
    const double cosine = fabs(dot(s.geometric, ray->direction)), limit = 2 * size * 0x1p-19;
    const double edge = fmin(fmin(s.uv.x, 1 - s.uv.x), fmin(s.uv.y, 1 - s.uv.y));
    const double diagonal = fmin(edge, fabs(1 - s.uv.x - s.uv.y));
    return (cosine < 0x1p-9 || hit.t < 16 * limit) &&
           (cosine * hit.t < limit || diagonal * piece < limit);
}

// The walls of a room between c and c + x + y + z as a mesh, each of n × n squares.
static Params room_mesh(Scene *scene, Vec3 c, Vec3 x, Vec3 y, Vec3 z, uint32_t n)
{
    const uint32_t row = n + 1, vertex_count = row * row * row, triangle_count = 12 * n * n;
    Vec3 *vertices = malloc(vertex_count * sizeof *vertices);
    uint32_t *triangles = malloc(3 * (size_t)triangle_count * sizeof *triangles), *t = triangles;
    assert_true(vertices && triangles);
    for (uint32_t i = 0; i < vertex_count; ++i) { // a lattice, of which the walls are used
        const double a[3] = {i % row / (double)n, i / row % row / (double)n,
                             i / row / row / (double)n};
        vertices[i] = add(add_scaled(add_scaled(c, x, a[0]), y, a[1]), scale(z, a[2]));
    }
    const uint32_t steps[3] = {1, row, row * row};
    for (int wall = 0; wall < 6; ++wall) {
        const uint32_t along = steps[wall % 3], across = steps[(wall + 1) % 3];
        const uint32_t first = wall < 3 ? 0 : n * steps[(wall + 2) % 3];
        for (uint32_t i = 0; i < n * n; ++i) {
            const uint32_t a = first + i % n * along + i / n * across;
            const uint32_t corners[6] = {a, a + along,          a + along + across,
                                         a, a + along + across, a + across};
            memcpy(t, corners, sizeof corners);
            t += 6;
        }
    }
    Params p = mesh_params_of(scene, vertices, vertex_count, triangles, triangle_count);
    free(vertices);
    free(triangles);
    return p;
}

// A room of six rectangles, or as a mesh of a few, many or very many triangles: from every wall,
// and as near to its edges as one likes, every ray hits another wall.
static void rooms_are_tight(void **state)
{
    (void)state;
    Random r = random_make("rooms", 35);
    int64_t rays = 0, leaks = 0, stuck = 0, flat = 0, flat_pieces = 0;
    for (int round = 0; round < 52; ++round) {
        double size = pow(10, round % 13 - 6);
        Vec3 center = round < 26 ? vec3(0, 0, 0)
                                 : scale(random_direction(&r), size * pow(10, between(&r, 0, 6)));
        Affine turn = random_rotation(&r);
        Vec3 x = transform_vector(&turn, vec3(2 * size, 0, 0));
        Vec3 y = transform_vector(&turn, vec3(0, 1.5 * size, 0));
        Vec3 z = transform_vector(&turn, vec3(0, 0, size)), c = center;
        Scene *scene = scene_new();
        const uint32_t parts[4] = {0, 1, 5, 20};
        const uint32_t n = parts[(round + round / 13) % 4];
        if (n) {
            add_plain(scene, room_mesh(scene, c, x, y, z, n));
        } else {
            add_plain(scene, rectangle_params_of(c, y, x));
            add_plain(scene, rectangle_params_of(c, x, z));
            add_plain(scene, rectangle_params_of(c, z, y));
            add_plain(scene, rectangle_params_of(add(c, x), y, z));
            add_plain(scene, rectangle_params_of(add(c, y), z, x));
            add_plain(scene, rectangle_params_of(add(c, z), x, y));
        }
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        Vec3 middle = add(c, scale(add(x, add(y, z)), 0.5));
        for (int i = 0; i < 6000; ++i) {
            // A target near an edge or a corner of the room.
            double a[3];
            for (int k = 0; k < 3; ++k) {
                a[k] = uniform(&r) < 0.5 ? uniform(&r) : pow(10, between(&r, -9, 0));
                a[k] = random_bits(&r) & 1 ? a[k] : 1 - a[k];
            }
            Vec3 at = add(add_scaled(add_scaled(c, x, a[0]), y, a[1]), scale(z, a[2]));
            Ray ray = ray_make(middle, normalize(sub(at, middle)), 0, INFINITY);
            Hit hit, next;
            if (!accel_intersect(accel, &ray, &hit)) {
                ++leaks;
                continue;
            }
            Surface s;
            accel_surface(accel, &ray, &hit, &s);
            Vec3 inwards = s.front ? s.geometric : neg(s.geometric);
            Ray on = surface_spawn(&s, leaving(&r, inwards));
            if (!accel_intersect(accel, &on, &next)) {
                bool excused = may_be_missed(accel, scene, &on, size, n ? size / n : size);
                leaks += !excused;
                // Of many pieces in a plane each lies a little otherwise, by rounding.
                *(n > 1 ? &flat_pieces : &flat) += excused;
            } else if (next.shape == hit.shape && next.local.primitive == hit.local.primitive) {
                ++stuck;
            }
            rays += 2;
        }
        accel_free(accel);
        scene_drop(scene);
    }
    print_message("  %d rays, %d leaks, %d stuck, %d and %d too flat\n", (int)rays, (int)leaks,
                  (int)stuck, (int)flat, (int)flat_pieces);
    assert_int_equal(flat, 0);
    assert_true(flat_pieces < rays / 1000);
    assert_int_equal(stuck, 0);
    assert_int_equal(leaks, 0);
}

// A mesh of size 1 on a globe of radius 1e6: its hits are as good as in double
// precision, because it gets its own single-precision space.
static void small_meshes_beside_large_shapes_stay_exact(void **state)
{
    (void)state;
    Random r = random_make("pocket", 36);
    Scene *scene = scene_new();
    add_plain(scene, sphere_params_of(vec3(0, -1e6, 0), 1e6));
    add_plain(scene, bumpy_mesh(scene, vec3(0, 1, 0), 1, 24));
    add_plain(scene, bumpy_mesh(scene, vec3(3e5, 1e-3, 3e5), 1e-3, 24));
    add_plain(scene, triangle_params_of(vec3(5, 0, 0), vec3(5, 1e-3, 0), vec3(5, 0, 1e-3)));
    Accel *accel = accel_build(scene, 1);
    assert_non_null(accel);
    Comparison c = {0, 0, 0};
    for (int i = 0; i < 20000; ++i) {
        Vec3 centers[3] = {{0, 1, 0}, {3e5, 1e-3, 3e5}, {5, 2e-4, 2e-4}};
        double sizes[3] = {1, 1e-3, 4e-4};
        int k = i % 3;
        Vec3 from = add_scaled(centers[k], random_direction(&r), sizes[k] * 30);
        Vec3 to = add_scaled(centers[k], random_direction(&r), sizes[k] * 1.2);
        Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
        Hit hit, expected;
        bool found = accel_intersect(accel, &ray, &hit), wanted = brute_hit(scene, &ray, &expected);
        ++c.rays;
        c.hits += wanted && expected.shape != 0;
        if (found != wanted || (found && hit.shape != expected.shape)) {
            ++c.parted;
        } else if (found && expected.shape != 0) {
            c.parted += fabs(hit.t - expected.t) > 1e-7 * sizes[k];
        }
    }
    print_message("  %d rays, %d hits, %d parted\n", c.rays, c.hits, c.parted);
    assert_true(c.hits > 5000 && c.parted <= 2);
    accel_free(accel);
    scene_drop(scene);
}

// A sun and a planet at their true sizes, and ordinary things: these have a hierarchy of their own
// scale, instances included.
static void outliers_leave_the_others_their_precision(void **state)
{
    (void)state;
    Random r = random_make("outliers", 40);
    for (int round = 0; round < 3; ++round) {
        Scene *scene = scene_new();
        add_plain(scene, sphere_params_of(vec3(1e11, 1.1e11, 0), 6.96e8));
        add_plain(scene, sphere_params_of(vec3(0, -6.371e6, 0), 6.371e6));
        fill_scene(scene, &r, vec3(0, 2, 0), 2, 60, 0, true);
        uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
        if (round) {
            fill_scene(scene, &r, vec3(0, 0, 0), 1, 10, prototype, true);
            for (int i = 0; i < 5; ++i) {
                // Among the things, or so far apart that they belong to the sun.
                double away = round == 1 ? 3 : 1e9;
                Affine to = affine_translation(scale(random_direction(&r), away));
                add_instance(scene, prototype, &to);
            }
        }
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        assert_true(accel->groups[0].scale > 1e10 && accel->groups[0].kind_count == 1);
        assert_int_equal(accel->groups[0].instance_count, round == 2 ? 5 : 0);
        bool ordinary = false;
        for (uint32_t i = 2; i < accel->group_count; ++i) {
            ordinary =
                ordinary || (accel->groups[i].kind_count > 5 && accel->groups[i].scale <= 16);
        }
        assert_true(ordinary);
        Comparison c = {0, 0, 0};
        for (int i = 0; i < 4000; ++i) {
            Vec3 from = add(vec3(0, 2, 0), scale(random_direction(&r), between(&r, 0, 9)));
            Vec3 to = vec3(between(&r, -3, 3), between(&r, -1, 5), between(&r, -3, 3));
            Ray ray = ray_make(from, normalize(sub(to, from)), 0, INFINITY);
            if (i % 8 == 0) {
                ray.direction =
                    normalize(add_scaled(vec3(1e11, 1.1e11, 0), random_direction(&r), 6e8));
            }
            compare_ray(accel, scene, &ray, 1e3, &c);
        }
        print_message("  %d rays, %d hits, %d parted\n", c.rays, c.hits, c.parted);
        assert_true(c.hits > 2000 && c.parted <= 2);
        accel_free(accel);
        scene_drop(scene);
    }
}

static void unbounded_shapes_stand_in_instances(void **state)
{
    (void)state;
    Scene *scene = scene_new();
    uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
    Params plane = plane_params_of(vec3(0, 0, 0), vec3(0, 1, 0));
    uint32_t shape = add_shape(scene, &plane, NULL, prototype);
    Affine up = affine_translation(vec3(0, 3, 0)), down = affine_translation(vec3(0, -3, 0));
    uint32_t first = add_instance(scene, prototype, &up);
    uint32_t second = add_instance(scene, prototype, &down);
    Accel *accel = accel_build(scene, 1);
    assert_non_null(accel);
    assert_true(box3_is_empty(accel_bounds(accel)));
    Hit hit;
    Ray ray = ray_make(vec3(0, 0, 0), vec3(0, 1, 0), 0, INFINITY);
    assert_true(accel_intersect(accel, &ray, &hit));
    assert_near(hit.t, 3, 1e-15);
    assert_int_equal(hit.shape, shape);
    assert_int_equal(hit.instance, first);
    ray.direction = vec3(0, -1, 0);
    assert_true(accel_intersect(accel, &ray, &hit) && accel_occluded(accel, &ray));
    assert_int_equal(hit.instance, second);
    ray.tmax = 2.9;
    assert_false(accel_intersect(accel, &ray, &hit) || accel_occluded(accel, &ray));
    accel_free(accel);
    scene_drop(scene);
}

static void materials_come_from_the_shape_or_its_instance(void **state)
{
    (void)state;
    Scene *scene = scene_new();
    uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
    Params a = sphere_params_of(vec3(0, 0, 0), 1), b = sphere_params_of(vec3(3, 0, 0), 1);
    add_shape(scene, &a, NULL, prototype);
    add_shape(scene, &b, NULL, prototype);
    scene->nodes[CATEGORY_SHAPE].items[1].material = 7;
    add_instance(scene, prototype, NULL);
    scene->instances.items[0].material = 5;
    Accel *accel = accel_build(scene, 1);
    for (int i = 0; i < 2; ++i) {
        Ray ray = ray_make(vec3(3 * i, 0, 9), vec3(0, 0, -1), 0, INFINITY);
        Hit hit;
        Surface s;
        assert_true(accel_intersect(accel, &ray, &hit));
        accel_surface(accel, &ray, &hit, &s);
        assert_int_equal(s.material, i ? 7 : 5);
    }
    accel_free(accel);
    scene_drop(scene);
}

// The way to a light's point is free, and ends before the light; something on it is
// found.
static void ways_to_points_end_before_them(void **state)
{
    (void)state;
    Random r = random_make("ways", 37);
    for (int round = 0; round < 39; ++round) {
        double size = pow(10, round % 13 - 6);
        Vec3 center = round < 13 ? vec3(0, 0, 0)
                                 : scale(random_direction(&r), size * pow(10, between(&r, 0, 5)));
        Affine place = affine_translation(center), grow = affine_scaling(vec3(size, size, size));
        place = affine_multiply(&place, &grow);
        Scene *scene = scene_new();
        Params shapes[5] = {
            rectangle_params_of(vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2)),
            sphere_params_of(vec3(0, 3, 0), 0.5),
            disc_params_of(vec3(0, 2, 0), vec3(0.1, -1, 0), 1, 0),
            bumpy_mesh(scene, vec3(0, 3, 0), 0.8, 12),
            torus_params_of(vec3(0, 3, 0), vec3(1, 1, 0), 0.8, 0.2),
        };
        int kind = round % 5;
        Params floor = rectangle_params_of(vec3(-9, 0, -9), vec3(0, 0, 18), vec3(18, 0, 0));
        add_shape(scene, &floor, &place, 0);
        uint32_t light = add_shape(scene, &shapes[kind], &place, 0);
        Accel *accel = accel_build(scene, 1);
        assert_non_null(accel);
        const ShapeClass *class = class_of(&shapes[kind]);
        Arena arena = {0};
        const void *params = scene_params(scene, scene_node(scene, CATEGORY_SHAPE, light));
        void *table =
            class->prepare_sampling ? class->prepare_sampling(scene, params, &place, &arena) : NULL;
        int free_ways = 0;
        for (int i = 0; i < 3000; ++i) {
            Vec3 target = vec3(between(&r, -3, 3), 0, between(&r, -3, 3));
            Vec3 above = transform_point(&place, vec3(between(&r, -3, 3), 1, between(&r, -3, 3)));
            Ray down = ray_make(above, normalize(sub(transform_point(&place, target), above)), 0,
                                INFINITY);
            Hit hit, other;
            assert_true(accel_intersect(accel, &down, &hit) && hit.shape == 0);
            Surface s;
            accel_surface(accel, &down, &hit, &s);
            ShapeSample sample;
            class->sample_area(scene, params, &place, table, uniform(&r), uniform(&r), uniform(&r),
                               &sample);
            bool on_flat = class->holding != HOLD_USER;
            Vec3 to_light = sub(sample.point.p, s.p);
            double distance = length(to_light);
            double facing_cosine =
                on_flat ? fabs(dot(sample.point.geometric, to_light)) / distance : 0;
            Ray way =
                surface_spawn_to(&s, sample.point.p, distance, sample.point.error, facing_cosine);
            bool facing = dot(sample.point.geometric, way.direction) < -1e-3;
            bool flat = kind == 0 || kind == 2;
            if (flat || (facing && kind == 1)) {
                if (accel_occluded(accel, &way)) {
                    fail_msg("kind %d of size %g at %g stands in its own way", kind, size,
                             length(center));
                }
                ++free_ways;
            }
            // Further on there is the light itself.
            way.tmax = 1.001 * distance;
            // (A ray so flat may be lifted past the mesh's outline.)
            if (!(kind == 3 && facing_cosine < 0.05)) {
                assert_true(accel_intersect(accel, &way, &other) && other.shape == light);
            }
        }
        assert_true(kind > 2 || free_ways > 1000);
        arena_free(&arena);
        accel_free(accel);
        scene_drop(scene);
    }
}

static void bad_geometry_is_counted(void **state)
{
    (void)state;
    Scene *scene = scene_new();
    add_plain(scene, sphere_params_of(vec3(0, 0, 0), 1));
    add_plain(scene, sphere_params_of(vec3(NAN, 0, 0), 1));
    add_plain(scene, sphere_params_of(vec3(0, INFINITY, 0), 1));
    // Finite by itself, but not where its transform brings it; flat after rounding.
    Params large = triangle_params_of(vec3(0, 0, 0), vec3(1e70, 0, 0), vec3(0, 1e70, 0));
    Affine shear = affine_identity();
    shear.m[2][0] = 1e300;
    add_shape(scene, &large, &shear, 0);
    Params small = triangle_params_of(vec3(0, 0, 0), vec3(1e-3, 0, 0), vec3(0, 1e-3, 0));
    Affine away = affine_translation(vec3(1e20, 0, 0));
    add_shape(scene, &small, &away, 0);
    Accel *accel = accel_build(scene, 1);
    assert_non_null(accel);
    AccelIssues issues = accel_issues(accel);
    assert_int_equal(issues.not_finite, 3);
    assert_int_equal(issues.degenerate, 1);
    Hit hit;
    Ray ray = ray_make(vec3(0.1, 0.1, 9), vec3(0, 0, -1), 0, INFINITY);
    assert_true(accel_intersect(accel, &ray, &hit));
    assert_int_equal(hit.shape, 0);
    accel_free(accel);
    scene_drop(scene);
}

static void an_empty_scene_is_never_hit(void **state)
{
    (void)state;
    Scene *scene = scene_new();
    uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
    add_instance(scene, prototype, NULL);
    Accel *accel = accel_build(scene, 0);
    assert_non_null(accel);
    Hit hit;
    Ray ray = ray_make(vec3(0, 0, 0), vec3(0, 0, 1), 0, INFINITY);
    assert_false(accel_intersect(accel, &ray, &hit) || accel_occluded(accel, &ray));
    assert_true(box3_is_empty(accel_bounds(accel)));
    accel_free(accel);
    scene_drop(scene);
}

// Without memory the build fails cleanly, wherever it runs out.
static void building_survives_lack_of_memory(void **state)
{
    (void)state;
    Random r = random_make("memory", 38);
    Scene *scene = scene_new();
    uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
    fill_scene(scene, &r, vec3(0, 0, 0), 1, 30, 0, true);
    fill_scene(scene, &r, vec3(0, 0, 0), 1e-3, 20, prototype, true);
    add_plain(scene, bumpy_mesh(scene, vec3(0, 0, 0), 1e-3, 6)); // a pocket
    add_plain(scene, sphere_params_of(vec3(1e9, 0, 0), 1));      // which makes another
    Params plane = plane_params_of(vec3(0, 0, 0), vec3(0, 1, 0));
    add_shape(scene, &plane, NULL, prototype);
    add_instance(scene, prototype, NULL);
    bool built = false;
    int failures = 0;
    for (uint64_t allowed = 0; !built; ++allowed) {
        mem_fail_after(allowed);
        Accel *accel = accel_build(scene, 1);
        mem_fail_after(UINT64_MAX);
        built = accel != NULL;
        failures += !built;
        accel_free(accel);
    }
    assert_true(failures > 8);
    scene_drop(scene);
}

// So small a picture of so much is given hierarchies that are built quickly.
static void ask_for_few_pixels(Scene *scene)
{
    FilmParams film = scene_film(scene);
    film.width = film.height = 4;
    const int type = schema_find(scene->schema, STR("film"));
    assert_int_not_equal(scene_add_node(scene, (uint16_t)type, &film, (SceneNode){0}), NONE_ID);
    assert_int_equal(scene_film(scene).width, 4);
}

// Rays that graze spheres hit them through the hierarchy if and only if they do so by themselves.
static void check_grazing(const Accel *accel, const Scene *scene, uint32_t spheres, Random *r)
{
    int hits = 0;
    for (int k = 0; k < 20000; ++k) {
        const uint32_t number = 1 + (uint32_t)(uniform(r) * spheres);
        const SceneNode *node = scene_node(scene, CATEGORY_SHAPE, number);
        double radius;
        const Vec3 middle = shape_class(scene, node)->ball(scene_params(scene, node), &radius);
        const double around = between(r, 0, 2 * PI), aside = pow(10, between(r, -16, -5));
        const Vec3 along = vec3(cos(around), 0, sin(around));
        Vec3 from = add_scaled(middle, vec3(0, 1, 0), radius * (1 + (k % 2 ? aside : -aside)));
        from = add_scaled(from, along, -radius);
        const Ray ray = ray_make(from, along, 0, 2 * radius);
        ShapeHit own;
        Hit hit;
        const bool met = shape_class(scene, node)->intersect(scene_params(scene, node), &ray, &own);
        assert_int_equal(accel_occluded(accel, &ray), met);
        assert_int_equal(accel_intersect(accel, &ray, &hit), met);
        assert_true(!met || (hit.t == own.t && hit.shape == number));
        hits += met;
    }
    assert_true(hits > 9000 && hits < 11000);
}

// Many instances and many spheres are few geometries; hits in them are found by
// number, in hierarchies of either make.
static void check_many(bool few_pixels)
{
    Random r = random_make("many", 39);
    Scene *scene = scene_new();
    if (few_pixels) {
        ask_for_few_pixels(scene);
    }
    uint32_t prototype = scene_add_prototype(scene, 0, (Span){0});
    Params unit = sphere_params_of(vec3(0, 0, 0), 0.4);
    add_shape(scene, &unit, NULL, prototype);
    enum { SIDE = 150 };
    for (int i = 0; i < SIDE; ++i) {
        for (int j = 0; j < SIDE; ++j) {
            Affine to = affine_translation(vec3(i, 0, j));
            add_instance(scene, prototype, &to);
            add_plain(scene, sphere_params_of(vec3(i, 2, j), 0.4));
        }
    }
    Accel *accel = accel_build(scene, 2);
    assert_non_null(accel);
    for (int k = 0; k < 20000; ++k) {
        int i = (int)(uniform(&r) * SIDE), j = (int)(uniform(&r) * SIDE);
        Ray ray = ray_make(vec3(i, 1, j), vec3(0, k & 1 ? -1 : 1, 0), 0, INFINITY);
        Hit hit;
        assert_true(accel_intersect(accel, &ray, &hit));
        assert_near(hit.t, 0.6, 1e-12);
        uint32_t number = (uint32_t)(i * SIDE + j);
        assert_int_equal(hit.instance, k & 1 ? number : NONE_ID);
        assert_int_equal(hit.shape, k & 1 ? 0 : number + 1);
    }
    // Rows of spheres are in runs there, which end with their rows.
    const AccelKind *spheres = &accel->groups[0].kinds[0];
    assert_int_equal(spheres->runs != NULL, few_pixels);
    assert_int_equal(accel_primitive_count(spheres),
                     few_pixels ? SIDE * ((SIDE + 3) / 4) : SIDE * SIDE);
    assert_int_equal(spheres->balls != NULL, few_pixels);
    check_grazing(accel, scene, SIDE * SIDE, &r);
    Comparison c = {0, 0, 0};
    for (int k = 0; k < 200; ++k) {
        const Vec3 from = random_in_box(&r, accel_bounds(accel));
        const Ray ray = ray_make(add_scaled(from, vec3(0, 1, 0), k % 8), random_direction(&r), 0,
                                 k % 3 ? INFINITY : 5);
        compare_ray(accel, scene, &ray, SIDE, &c);
    }
    assert_true(c.hits > 50 && c.parted == 0);
    accel_free(accel);
    scene_drop(scene);
}

static void many_instances_and_spheres(void **state)
{
    (void)state;
    check_many(false);
    check_many(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(hits_are_those_of_all_shapes_tried),
        cmocka_unit_test(instances_equal_copies),
        cmocka_unit_test(no_ray_slips_through_at_vertices),
        cmocka_unit_test(respawned_rays_neither_stick_nor_leak),
        cmocka_unit_test(rooms_are_tight),
        cmocka_unit_test(small_meshes_beside_large_shapes_stay_exact),
        cmocka_unit_test(outliers_leave_the_others_their_precision),
        cmocka_unit_test(unbounded_shapes_stand_in_instances),
        cmocka_unit_test(materials_come_from_the_shape_or_its_instance),
        cmocka_unit_test(ways_to_points_end_before_them),
        cmocka_unit_test(bad_geometry_is_counted),
        cmocka_unit_test(an_empty_scene_is_never_hit),
        cmocka_unit_test(building_survives_lack_of_memory),
        cmocka_unit_test(many_instances_and_spheres),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
