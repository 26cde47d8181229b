// A camera that is moved by hand: where it stands and what it turns about, in world space, and the
// same as text of the language. The text is what counts: a picture is taken with what it says, so
// that pasting it into the scene gives the same picture.
#ifndef WATCH_POSE_H
#define WATCH_POSE_H

#include "render/camera.h"
#include "schema/schema.h"
#include "watch/text.h"

typedef struct CameraPose {
    Vec3 position;
    Vec3 target; // what it looks at and turns about
    Vec3 up;     // unit
    double fov, height, aperture;
    int32_t projection;
    double focus_distance; // 0: the distance to the target
} CameraPose;

// The pose of a camera that turns about a point at `distance` (> 0) along its view. Where the
// camera's node has a transform that stretches, the pose is the nearest one without.
CameraPose pose_from_camera(const Camera *camera, double distance);
// How far the camera's own `look_at` is along its view; 0 where it was given a direction.
double pose_own_distance(const Camera *camera);

// Turns about the target by angles in radians: to the right about `up`, and up as far as the poles.
void pose_orbit(CameraPose *pose, double right, double up);
// Moves camera and target by parts of the picture's height at the target.
void pose_pan(CameraPose *pose, double right, double up);
// Moves the camera to `factor` (> 0) times its distance from the target. An orthographic one shows
// as much more or less.
void pose_dolly(CameraPose *pose, double factor);

// "camera { position: …, look_at: … }", with as many digits as the distance to the target asks for.
void pose_text(const CameraPose *pose, const Schema *schema, Text *text);

// The parameters of the one camera that a text describes, in world space. False, with a message of
// one line, where it describes no camera, or more.
bool camera_from_text(const Schema *schema, const char *text, CameraParams *out, char *message,
                      size_t message_size);

#endif
