// Shared libraries that are loaded on first use, because loading them costs more than most runs
// need: `scn_oiio` (images), `scn_assimp` (meshes) and others.
#ifndef BASE_MODULE_H
#define BASE_MODULE_H

#include <stdbool.h>
#include <stddef.h>

// Loads NAME.so, where `name` is a bare name ("scn_assimp"), from the first of these folders that
// has it: those of $SCNRENDER_MODULES (separated by colons; ignored for programs with raised
// rights), then lib/scnrender, lib64/scnrender and lib/TRIPLET/scnrender beside the folder of the
// running program. Loading it again is cheap and gives the same handle; it stays loaded until the
// program ends, so there is nothing to give back. May be called from any thread. NULL, with a
// message that names the places tried or the loader's complaint.
void *module_open(const char *name, char *message, size_t message_size);

// True when one of these folders has it, whether or not it can be loaded.
bool module_exists(const char *name);

// The address of a symbol of a loaded module; NULL where there is none.
void *module_symbol(void *module, const char *symbol);

// The folder called `name` of the data that come with the program ("std"), absolute: below the one
// that the environment's SCNRENDER_DATA names (ignored for programs with raised rights), else below
// share/scnrender beside the program's own folder. False where there is none.
bool data_folder(const char *name, char *out, size_t size);

#endif
