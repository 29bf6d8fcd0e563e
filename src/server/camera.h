/** @file
 * Between the camera of a view, the pose that a hand moves, and the texts that tell of both.
 */
#ifndef VVI_SERVER_CAMERA_H
#define VVI_SERVER_CAMERA_H
#include "core/result.h"
#include "manipulate/navigate.h"
#include <volvis/model.h>
#include <volvis/sys/registry.h>

/** A pose, and what directions are counted from. */
typedef struct vvi_stand {
    vvi_pose pose;
    vv_vec3 up;      /**< what a turntable turns about, length 1 */
    bool y_up;       /**< the World's up is y, not z */
    bool anatomical; /**< the front is seen against y, not along it */
} vvi_stand;

/** The pose that a view's camera comes to, with all that is automatic worked out: loads what the view shows. */
vv_status vvi_camera_stand(vvi_stand *out, vv_world *world, const char *view, vv_job *job);
/** Azimuth and elevation, in degrees, from which a pose looks. */
void vvi_camera_angles(double angles_out[2], const vvi_stand *stand);
/** The properties of a camera at a pose, as JSON, for a picture of that size. Yours to free(); NULL without memory. */
char *vvi_camera_json(const vvi_pose *pose, int32_t width, int32_t height);
/** Members "eye", "at", "up", "parallel", "fov" or "height" of what a page is told. */
void vvi_camera_tell(vvi_result *out, const vvi_pose *pose, int32_t width, int32_t height);
/** The World with a view of that size and, where pose is not NULL, that camera. */
vv_status vvi_camera_world(vv_world **out, const vv_world *world, const char *view, const vvi_pose *pose, int32_t width,
                           int32_t height);
/** Whether a view shows a plane (vv_renderer.plane), whose pictures are exact at once. */
bool vvi_camera_is_plane(const vv_world *world, const char *view, const vv_registry *registry);
/** The World with letters and lines of that view at their share of a picture that is `scale` times as large. */
vv_status vvi_camera_scale(vv_world **world, const char *view, double scale);
/** The World with that view drawn as quickly as can be: a ray where light changes; scaled as above. */
vv_status vvi_camera_quick(vv_world **world, const char *view, double scale);
#endif
