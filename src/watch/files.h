// Which files a scene was made of, and when one of them changes.
//
// A file's size, times and inode are kept as they were when it was opened; it has changed when they
// differ, or it comes or goes. That decides, so that a file that is replaced by renaming another is
// noticed as one that is written in place. inotify says when to look; where there is none, or it
// sees nothing (files of another machine), a look once in a while finds it.
#ifndef WATCH_FILES_H
#define WATCH_FILES_H

#include <stdbool.h>

typedef struct FileWatch FileWatch;

// Calls changed(context), from a thread of its own, once after each call of file_watch_begin when
// any of the files that were added since has changed. polling: inotify isn't used. NULL without
// memory or a thread.
FileWatch *file_watch_new(void (*changed)(void *context), void *context, bool polling);
// Ends the thread. NULL is fine.
void file_watch_free(FileWatch *watch);

// Forgets all files: those that are added from now on count.
void file_watch_begin(FileWatch *watch);
// Adds a file, whether or not it is there; before it is opened. From any thread.
void file_watch_add(FileWatch *watch, const char *path);

#endif
