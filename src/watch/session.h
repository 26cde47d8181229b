// A scene that is watched: evaluated again when its files change, and rendered again as far as what
// changed asks for; with what those who show it want to know.
//
// A thread of the session's own evaluates and renders. Everybody else asks for changes and waits
// for news, from any thread. Requests that come while an earlier one is being worked on are taken
// together: the last word counts.
#ifndef WATCH_SESSION_H
#define WATCH_SESSION_H

#include "watch/loaded.h"
#include "watch/snapshot.h"

typedef struct Session Session;

typedef struct SessionOptions {
    SceneRequest scene;
    const char *camera; // name; NULL: the scene's first
    int width, height;  // 0: the scene's
    int64_t samples;    // 0: the scene's
    int64_t seed;       // -1: the scene's
    bool polling;       // look at the files now and then instead of being told
} SessionOptions;

// Starts watching. NULL, with a message, without memory or threads; a scene with errors is no
// reason. What the options point to must outlive the session.
Session *session_new(const SessionOptions *options, char *message, size_t message_size);
// Wakes all who wait, for the last time: session_wait returns false from now on.
void session_close(Session *session);
// Also closes it; nobody may be using it any more. NULL is fine.
void session_free(Session *session);

// --- News ----------------------------------------------------------------------------------------

// Counts of changes, by what has changed.
typedef struct SessionNews {
    uint64_t scene;   // diagnostics, params, cameras
    uint64_t view;    // the camera, exposure and tone curve, and the settings of params
    uint64_t status;  // how far rendering is
    uint64_t picture; // there is a newer picture, or it is to be developed otherwise
} SessionNews;

// Waits until anything is newer than *seen, which then is brought up to date, or `milliseconds` are
// over. False once the session is closed.
bool session_wait(Session *session, SessionNews *seen, int milliseconds);
// As JSON (docs/watch.md). NULL without memory; give it back with text_free.
Text session_scene_json(Session *session);
Text session_view_json(Session *session);
Text session_status_json(Session *session);

typedef enum SessionPhase {
    PHASE_EVALUATING, // or building the accelerator
    PHASE_RENDERING,
    PHASE_DONE,
    PHASE_PAUSED,
    PHASE_FAILED, // there is nothing to render: the scene never was sound
} SessionPhase;

typedef struct SessionStatus {
    SessionPhase phase;
    uint32_t width, height; // of the film
    double samples;         // done a pixel, in the mean
    int64_t wanted;         // samples a pixel that end it
    double fraction;
    double seconds, seconds_left, rays_per_second; // of rendering; left: INFINITY while unknown
    double error;              // of the picture (Snapshot.error); NAN while unknown
    double first_picture;      // seconds from the last change to the first picture after it; NAN
    uint64_t worlds;           // built so far: accelerators, lights and textures
    uint32_t errors, warnings; // of the scene as the files are now
} SessionStatus;
SessionStatus session_status(Session *session);

// How the picture is shown.
typedef struct SessionLook {
    double exposure; // stops
    ToneCurve tone;
} SessionLook;

// The last picture, with how it is to be shown; NULL while there is none. snapshot_release gives it
// back.
Snapshot *session_picture(Session *session, SessionLook *look);
// All diagnostics as text with carets, for a terminal.
Text session_diagnostics(Session *session);
// The command line that gives the picture.
Text session_command(Session *session);
// The moved camera as text; empty while it stands as the scene says.
Text session_camera_text(Session *session);

// --- Requests ------------------------------------------------------------------------------------
// Each returns false, with a message of one line, where it is refused.

// A param's value, as the command line's --set takes it; NULL: as the scene says.
bool session_set(Session *session, const char *name, const char *value, char *message,
                 size_t message_size);
// All params as the scene says.
void session_reset(Session *session);
// The camera of that number; also puts it back where the scene has it.
bool session_choose_camera(Session *session, uint32_t number, char *message, size_t message_size);

typedef enum CameraMoveKind {
    MOVE_ORBIT,
    MOVE_PAN,
    MOVE_DOLLY,
    MOVE_FOV,
    MOVE_APERTURE
} CameraMoveKind;
// orbit: radians to the right and up; pan: parts of the picture's height; dolly: a factor; fov:
// radians; aperture: metres, 0 for none (all but orbit and pan in x).
typedef struct CameraMove {
    CameraMoveKind kind;
    double x, y;
} CameraMove;
bool session_move_camera(Session *session, CameraMove move, char *message, size_t message_size);
// Puts what is seen at a place of the picture ((0, 0) top left, (1, 1) bottom right) in focus.
bool session_focus(Session *session, double x, double y, char *message, size_t message_size);
// NAN, or a negative tone: the scene's.
bool session_set_look(Session *session, double exposure, int tone, char *message,
                      size_t message_size);
void session_pause(Session *session, bool paused);
// Evaluates the files anew.
void session_reload(Session *session);

#endif
