// The flat scene as JSON, driven by the schema: {"film": {…}, "shapes": [{"kind", "fields", …}]}.
#ifndef SCENE_DUMP_H
#define SCENE_DUMP_H

#include "scene/scene.h"

#include <stdio.h>

// Writes the whole scene; places as "file:line:column" through `sources`. False on a write error.
bool scene_dump_json(const Scene *scene, Sources *sources, FILE *out);

#endif
