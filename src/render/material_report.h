#ifndef RENDER_MATERIAL_REPORT_H
#define RENDER_MATERIAL_REPORT_H

#include "base/diag.h"
#include "scene/scene.h"

// Warns of glass (W0950) on shapes that enclose nothing. A plane bounds half of space and a mesh
// may be closed: both pass.
void material_warn_open_glass(const Scene *scene, DiagSink *sink);

#endif
