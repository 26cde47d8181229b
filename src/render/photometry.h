// Where the renderer's files have always found it.
#ifndef RENDER_PHOTOMETRY_H
#define RENDER_PHOTOMETRY_H

#include "schema/photometry.h"

#endif
