// A folder of a test's own, for the files that it writes: made and removed by the setup and
// teardown of the group.
#ifndef TEST_IMAGE_FOLDER_H
#define TEST_IMAGE_FOLDER_H

#include <stdio.h>
#include <stdlib.h>

static char folder[] = "/tmp/scn_image_XXXXXX";

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char command[64];
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

// A file's path in the folder; kept until the next call.
static const char *path_of(const char *name)
{
    static char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

#endif
