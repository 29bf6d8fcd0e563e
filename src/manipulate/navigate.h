/** @file
 * The Navigator's control laws: how drags, wheels and sticks move a camera. Pure functions of poses; who calls them
 * knows of devices and of the World.
 *
 * Lengths of drags are in units of the viewport's smaller side, x to the right and y up. Places in the viewport are
 * counted from its middle in half of that: (1, 0) lies on the right edge of a square.
 */
#ifndef VVI_MANIPULATE_NAVIGATE_H
#define VVI_MANIPULATE_NAVIGATE_H
#include "manipulate/quaternion.h"

/** A camera and what it turns about. The camera looks along -z of its own axes, y up. */
typedef struct vvi_pose {
    vv_vec3 eye;
    vvi_quaternion turn; /**< camera axes to the World's */
    vv_vec3 pivot;       /**< before the eye */
    bool parallel;
    double fov;    /**< of the viewport's smaller side, perspective */
    double height; /**< of the smaller side in the World, parallel */
} vvi_pose;

/** What a pose and others need to know of it. */
vv_vec3 vvi_pose_right(const vvi_pose *pose);
vv_vec3 vvi_pose_up(const vvi_pose *pose);
vv_vec3 vvi_pose_forward(const vvi_pose *pose);
double vvi_pose_distance(const vvi_pose *pose);
/** World length of the viewport's smaller side at the pivot. */
double vvi_pose_extent(const vvi_pose *pose);

bool vvi_pose_equal(const vvi_pose *a, const vvi_pose *b);

/** Everything turns about the pivot as a rigid body: the camera the other way. */
vvi_pose vvi_pose_turned(const vvi_pose *pose, vvi_quaternion world_turn);

/** Turntable: a drag across turns by 360 degrees about `up` (of the World, a unit vector), a drag up or down by 180
 * degrees, to at most 89.9 degrees above and below the horizon. */
vvi_pose vvi_orbit(const vvi_pose *pose, double dx, double dy, vv_vec3 up);
/** Arcball (Shoemake 1992): from one place to another; from the middle to the edge is half a turn, and what comes of a
 * closed path is no turn. */
vvi_pose vvi_arcball(const vvi_pose *pose, const double from[2], const double to[2]);
/** Trackball whose ball ends in a hyperbolic sheet (Bell), so that places outside turn it too. */
vvi_pose vvi_trackball(const vvi_pose *pose, const double from[2], const double to[2]);
/** The plane of the pivot follows the pointer. */
vvi_pose vvi_pan(const vvi_pose *pose, double dx, double dy);
/** Nearer by exp(2 amount), keeping what lies under the place `at` (NULL: the middle) in the plane of the pivot. */
vvi_pose vvi_zoom(const vvi_pose *pose, double amount, const double at[2]);
/** About the line of sight; the picture turns counter-clockwise. */
vvi_pose vvi_roll(const vvi_pose *pose, double angle);
/** Flight for `seconds` at steady rates, both in camera axes: speed (x right, y up, z back; world units a second) and
 * spin (radians a second about them). Exact on the group of rigid motions, so that many short steps lead where one long
 * one does. The pivot flies along. */
vvi_pose vvi_fly(const vvi_pose *pose, vv_vec3 speed, vv_vec3 spin, double seconds);
/** Response of a stick u in [-1, 1] with a dead zone below 1: none in it, then the cube of what is left. */
double vvi_stick(double u, double dead_zone);
/** Between two poses at t in [0, 1]: turn and pivot steadily, distances and openings by their ratio. */
vvi_pose vvi_pose_between(const vvi_pose *a, const vvi_pose *b, double t);
#endif
