// The writers, one file (or family of files) a target.
#ifndef EXPORT_TARGETS_H
#define EXPORT_TARGETS_H

#include "export/export.h"

void povray_write(Export *e);
void blender_write(Export *e);
void json_write(Export *e);

#endif
