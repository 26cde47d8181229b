// Built-in functions of light and reflection: the slides' models over vectors.
#include "lang/builtins.h"

#include "base/fresnel.h"
#include "base/shading_models.h"

// --- Arguments -----------------------------------------------------------------------------------

// How far a unit vector's squared length may be from 1: what rounding leaves, not what an author's
// 0.7071 does.
static const double UNIT_TOLERANCE = 1e-6;

// A formula for unit vectors gives a wrong number for others, and nobody would notice.
static bool arg_unit(Call *call, uint32_t i, Vec3 *out)
{
    if (!arg_vec3(call, i, out)) {
        return false;
    }
    if (call->args[i].dim != DIM_NONE) {
        arg_wrong(call, i, "a vector of bare numbers");
        return false;
    }
    if (!(fabs(length_squared(*out) - 1) <= UNIT_TOLERANCE)) {
        Diag *diag = report(call->ev, E0410, arg_span(call, i),
                            "`%s` takes a vector of length 1 here, and this one's is %.9g",
                            call->name, length(*out));
        diag_note(call->ev->sink, diag, "`normalize` makes the length 1");
        return false;
    }
    return true;
}

// Whether a number is `good`, which is reported where it isn't.
static bool check(Call *call, bool good, uint32_t i, const char *wanted, double found,
                  const char *unit)
{
    if (!good) {
        report(call->ev, E0410, arg_span(call, i), "`%s` takes %s here, not %.9g%s", call->name,
               wanted, found, unit);
    }
    return good;
}

static bool arg_not_negative(Call *call, uint32_t i, const char *wanted, double *out)
{
    return arg_bare(call, i, out) && check(call, *out >= 0, i, wanted, *out, "");
}

static bool arg_positive(Call *call, uint32_t i, const char *wanted, double *out)
{
    return arg_bare(call, i, out) && check(call, *out > 0, i, wanted, *out, "");
}

// The cosine of an angle of incidence: the angle itself, or a bare number.
static bool arg_cosine(Call *call, uint32_t i, double *out)
{
    Value v = call->args[i];
    if (v.type == VALUE_NUMBER && v.dim == DIM_ANGLE) {
        *out = fmax(0, cos(v.number));
        return check(call, v.number >= 0 && v.number <= PI / 2 * (1 + 1e-12), i,
                     "an angle from 0deg to 90deg", v.number * (180 / PI), "deg");
    }
    if (!is_bare(v)) {
        arg_wrong(call, i, "an angle or its cosine");
        return false;
    }
    *out = v.number;
    return check(call, v.number >= 0 && v.number <= 1, i, "an angle, or its cosine from 0 to 1",
                 v.number, "");
}

// Indices of refraction, as their quotient nt/ni.
static bool arg_media(Call *call, uint32_t i, double *eta)
{
    static const char INDEX[] = "an index of refraction above 0";
    double ni, nt;
    if (!arg_positive(call, i, INDEX, &ni) || !arg_positive(call, i + 1, INDEX, &nt)) {
        return false;
    }
    *eta = nt / ni;
    return true;
}

// --- Highlights ----------------------------------------------------------------------------------

static Value highlight(Call *call, double (*model)(Vec3, Vec3, Vec3, double, double))
{
    Vec3 n, v, l;
    double e, k;
    if (!arg_unit(call, 0, &n) || !arg_unit(call, 1, &v) || !arg_unit(call, 2, &l) ||
        !arg_not_negative(call, 3, "an exponent of at least 0", &e) || !arg_bare(call, 4, &k)) {
        return value_error();
    }
    return number_result(call, model(n, v, l, e, k), DIM_NONE);
}

Value builtin_phong(Call *call)
{
    return highlight(call, phong_model);
}

Value builtin_blinn_phong(Call *call)
{
    return highlight(call, blinn_phong_model);
}

// --- BRDFs ---------------------------------------------------------------------------------------

Value builtin_burley(Call *call)
{
    Vec3 n, wi, wo;
    double roughness, k;
    if (!arg_unit(call, 0, &n) || !arg_unit(call, 1, &wi) || !arg_unit(call, 2, &wo) ||
        !arg_bare(call, 3, &roughness) ||
        !check(call, roughness >= 0 && roughness <= 1, 3, "a roughness from 0 to 1", roughness,
               "") ||
        !arg_bare(call, 4, &k)) {
        return value_error();
    }
    return number_result(call, burley_model(n, wi, wo, roughness, k), DIM_NONE);
}

static bool right_angles(Call *call, Frame frame)
{
    double worst = fmax(fmax(fabs(dot(frame.s, frame.t)), fabs(dot(frame.s, frame.n))),
                        fabs(dot(frame.t, frame.n)));
    if (!(worst <= UNIT_TOLERANCE)) {
        report(call->ev, E0410, arg_span(call, 2),
               "`ggx` takes tangents and a normal at right angles to each other");
        return false;
    }
    return true;
}

Value builtin_ggx(Call *call)
{
    Vec3 wi, wo;
    Frame frame;
    Ggx ggx;
    double f0 = 1;
    if (!arg_unit(call, 0, &wi) || !arg_unit(call, 1, &wo) || !arg_unit(call, 2, &frame.s) ||
        !arg_unit(call, 3, &frame.t) || !arg_unit(call, 4, &frame.n) ||
        !right_angles(call, frame) || !arg_positive(call, 5, "a roughness above 0", &ggx.alpha_x) ||
        !arg_positive(call, 6, "a roughness above 0", &ggx.alpha_y) ||
        (call->count > 7 && !arg_bare(call, 7, &f0))) {
        return value_error();
    }
    return number_result(call, ggx_model(wi, wo, frame, ggx, f0), DIM_NONE);
}

// --- Interfaces ----------------------------------------------------------------------------------

Value builtin_fresnel(Call *call)
{
    double cos_i, eta;
    return arg_cosine(call, 0, &cos_i) && arg_media(call, 1, &eta)
               ? number_result(call, fresnel_dielectric(cos_i, eta, NULL), DIM_NONE)
               : value_error();
}

Value builtin_schlick(Call *call)
{
    double cos_i, eta;
    return arg_cosine(call, 0, &cos_i) && arg_media(call, 1, &eta)
               ? number_result(call, fresnel_schlick(fresnel_f0(eta), cos_i), DIM_NONE)
               : value_error();
}

Value builtin_refract(Call *call)
{
    Vec3 v, n, out = {0, 0, 0};
    double r;
    if (!arg_unit(call, 0, &v) || !arg_unit(call, 1, &n) ||
        !arg_positive(call, 2, "a quotient of indices above 0", &r)) {
        return value_error();
    }
    if (dot(v, n) > 0) {
        Diag *diag = report(call->ev, E0410, arg_span(call, 1),
                            "`refract` takes the normal of the side that v comes from");
        diag_note(call->ev->sink, diag, "v leads to the surface, so v·n is not above 0");
        return value_error();
    }
    refract(neg(v), n, 1 / r, &out);
    return make_vector(call->ev, (const double[]){out.x, out.y, out.z}, 3, DIM_NONE);
}
