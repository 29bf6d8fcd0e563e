/** @file
 * From a camera's angles, points and openings to a lens that makes rays.
 */
#ifndef VVI_SCENE_LENS_H
#define VVI_SCENE_LENS_H
#include "core/status.h"
#include "core/vec.h"
#include <volvis/sys/scene.h>

#define VVI_FIT_MARGIN 0.05

/** What a view has to fit: places in the World, such as corners of boxes. */
typedef struct vvi_fit {
    const vv_vec3 *corner;
    size_t n_corners;
    vv_space space; /**< says where the front is */
    vv_up up;
    double margin; /**< that is left on each side, of half the image */
    bool centred;  /**< left open, `at` lies so that they reach equally near to opposite sides of the picture */
} vvi_fit;

/** All that was worked out, lens and the points a person may want to keep. */
typedef struct vvi_aim {
    vv_lens lens;
    vv_vec3 at;
    vv_vec3 up;    /**< what a turntable turns about: the World's, where the camera stands level, else the camera's */
    double height; /**< of the image at `at`, before zoom */
} vvi_aim;

/**
 * With z up, front looks along -y in anatomical space (the viewer stands before the face) and along +y otherwise; with
 * y up, along +z and -z. Azimuth turns the eye about up, counter-clockwise seen from above; elevation lifts it; roll
 * turns the camera about its line of sight, its up towards its right. Left open, `at` is the middle of what is fitted
 * (or of its picture: `centred`), and the distance (perspective) or height (parallel) is the smallest that leaves every
 * corner inside the image by the margin. Errors: VV_E_ARGUMENT with `path` (of the camera) in front: the eye on what it
 * looks at, an up of no length, places too far away to compute with.
 */
vv_status vvi_aim_camera(vvi_aim *out, const vv_camera *camera, int32_t width, int32_t height, const vvi_fit *fit,
                         const char *path);

/** The same for a parallel picture with given directions, length 1 and at right angles, of the plane through a point:
 * of the camera its `at`, moved into that plane, and its height, zoom and roll count. */
vv_status vvi_aim_plane(vvi_aim *out, const vv_camera *camera, int32_t width, int32_t height, const vvi_fit *fit,
                        vv_vec3 right, vv_vec3 up, vv_vec3 through, const char *path);

/** The box around all corners; false: there are none. */
bool vvi_fit_box(vv_vec3 *lo_out, vv_vec3 *hi_out, const vvi_fit *fit);
/** The middle of it; 0 where there are none. */
vv_vec3 vvi_fit_middle(const vvi_fit *fit);

/** Ray through pixel coordinates (px, py), (0.5, 0.5) being the centre of the top left one; direction has length 1. */
static inline void vvi_lens_ray(vv_vec3 *origin_out, vv_vec3 *direction_out, const vv_lens *lens, int32_t width,
                                int32_t height, double px, double py)
{
    const double x = (px / width * 2 - 1) * lens->half_width, y = (1 - py / height * 2) * lens->half_height;
    const vv_vec3 across = vvi_add(vvi_scaled(lens->right, x), vvi_scaled(lens->up, y));
    if (lens->parallel) {
        *origin_out = vvi_add(lens->eye, across);
        *direction_out = lens->forward;
        return;
    }
    *origin_out = lens->eye;
    *direction_out = vvi_add(lens->forward, across);
    *direction_out = vvi_scaled(*direction_out, 1 / vvi_length(*direction_out));
}

#endif
