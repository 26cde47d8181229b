// The neutral flat scene, for anybody's tools: docs/scene.schema.json says what it holds.
#include "export/targets.h"

#include "scene/dump.h"

void json_write(Export *e)
{
    if (!e->collecting) { // it has a place for everything
        scene_export_json(e->scene, e->sources, e->out);
    }
}
