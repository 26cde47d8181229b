// Photometric files: IESNA LM-63 of 1986, 1991, 1995 and 2002 (and 2019, which reads the same), as
// a table of luminous intensity over two angles.
#ifndef SCENE_IES_H
#define SCENE_IES_H

#include "base/arena.h"
#include "base/str.h"
#include "base/vec.h"

#include <stdbool.h>
#include <stdint.h>

// The three coordinate systems, by the numbers that files use. All have an axis d (where both
// angles are 0), a direction u perpendicular to it, and the right-hand side s = d × u:
// C: vertical angle γ from d, horizontal angle C about d, counter-clockwise for whoever looks along
//    d: cos γ d + sin γ (cos C u - sin C s). A ceiling lamp's d is straight down.
// B: planes through s: cos H (cos V d + sin V u) + sin H s. Floodlights.
// A: planes through u: cos V (cos H d + sin H s) + sin V u. Headlights, signals.
typedef enum IesType { IES_TYPE_C = 1, IES_TYPE_B = 2, IES_TYPE_A = 3 } IesType;

// How the horizontal angles of the table stand for all others.
typedef enum IesSymmetry {
    IES_FULL,       // they are all there
    IES_ROTATIONAL, // one for all
    IES_QUADRANT,   // C: 0 to 90
    IES_HALF,       // C: 0 to 180, mirrored at the plane of 0 and 180. A, B: 0 to 90, mirrored at 0
    IES_HALF_90,    // C: 90 to 270, mirrored at the plane of 90 and 270
} IesSymmetry;

typedef struct IesWeb {
    int edition; // year
    IesType type;
    IesSymmetry symmetry;
    bool mirror_vertical; // A, B: vertical angles from 0 on stand for those below, too
    uint32_t vertical_count, horizontal_count;
    const double *vertical, *horizontal; // rad, ascending
    // cd, all multipliers and ballast factors counted in: a row of vertical_count for each
    // horizontal angle.
    const double *candela;
    double lamps, lumens_per_lamp; // lumens_per_lamp = -1: absolute photometry
    double watts;                  // input
    // TILT=INCLUDE: factors of the intensity by the luminaire's tilt.
    uint32_t tilt_count;
    const double *tilt_angles, *tilt_factors; // rad, ascending
} IesWeb;

typedef struct IesError {
    uint32_t line; // from 1; 0: memory ran out
    char message[240];
} IesError;

// Reads the bytes of a file. NULL with *error filled. All that is returned lies in the arena (whose
// on_oom must be NULL).
const IesWeb *ies_read(Arena *arena, Str bytes, IesError *error);

// The intensity in cd towards a unit direction, its parts along d, u and s; bilinear in the angles.
double ies_candela(const IesWeb *web, double d, double u, double s);
// The flux in lm: the integral of ies_candela over all directions, exact.
double ies_lumens(const IesWeb *web);
// The angle from d, rad, beyond which there is no light.
double ies_reach(const IesWeb *web);
// The factor for a tilt of `angle` rad, linear between those of the file; 1 for TILT=NONE.
double ies_tilt_factor(const IesWeb *web, double angle);

#endif
