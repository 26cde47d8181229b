// What session.c (requests and answers), refine.c (the thread that renders) and messages.c share.
#ifndef WATCH_SESSION_INTERNAL_H
#define WATCH_SESSION_INTERNAL_H

#include "base/array.h"
#include "watch/pose.h"
#include "watch/session.h"

// What has to be done again; each brings along the smaller ones.
typedef enum Change {
    CHANGE_NOTHING,
    CHANGE_CAMERA, // the world stays
    CHANGE_SCENE,  // everything is evaluated anew
} Change;

// Values of the renderer's stop flag.
enum { GO_ON, STOP_FOR_REQUEST, STOP_FOR_PICTURE };

typedef struct Override { // a param that is set from outside
    char *name, *value;   // mem
} Override;
typedef ARRAY(Override) OverrideArray;

typedef struct Session {
    SessionOptions options;
    FileWatch *files;
    pthread_t thread;
    bool started;
    atomic_int stop;        // of the renderer at work
    atomic_int closing;     // for what is not to be stopped by requests
    atomic_int outdated;    // an evaluation under way is of no use any more
    pthread_mutex_t lock;   // of all below
    pthread_cond_t changed; // of `change` and `news`
    // requests
    Change change;
    bool files_changed; // it is a file that asks for CHANGE_SCENE, not only a setting
    double asked_at;    // when the oldest unanswered request came
    bool paused;
    OverrideArray overrides;
    uint32_t camera; // number of the scene's; NONE_ID: as the options say
    bool moved;
    CameraPose pose; // where moved
    double exposure; // NAN: the scene's
    int tone;        // -1: the scene's
    // answers
    SessionNews news;
    SessionStatus status;
    Loaded *loaded; // the last version, sound or not; NULL at first
    Loaded *shown;  // the last sound version; NULL: none was
    Snapshot *picture;
    Text params; // JSON of the last version whose params could be read
} Session;

// The settings in force, and the camera that was chosen; called with the lock held.
uint32_t session_camera(const Session *session, const Scene *scene);

// Keeps those overrides that have a setting of the same name, and no others; called with the lock
// held.
void session_keep_overrides(Session *session, const ParamSetting *settings, size_t count);

// Were all params read, though maybe not all evaluated?
bool session_params_are_whole(const Text *params);
// Does the scene have a param of that name, whose setting it took?
bool session_param_is_good(const Loaded *loaded, Str name);

// The command line that gives what is rendered of `loaded`, but for the exposure and the tone
// curve: `pose` is the moved camera's text, or "".
Text session_command_of(const SessionOptions *options, const Loaded *loaded, uint32_t camera,
                        const char *pose);
// The exposure and tone curve that aren't the film's (NAN, and -1: they are), as further words of
// it.
void session_command_look(Text *text, const FilmParams *film, double exposure, int tone);

// The thread.
void *session_work(void *session);

#endif
