/** @file
 * Picking: what is at a pixel of a view.
 */
#ifndef VOLVIS_PICK_H
#define VOLVIS_PICK_H
#include <volvis/model.h>
VV_BEGIN_DECLS

/** (0, 0) is the top left one. */
typedef struct vv_pixel {
    int32_t x, y;
} vv_pixel;

#define VV_NO_TRIANGLE UINT32_MAX

/** What is seen through the middle of a pixel. Without a hit all but pixel and colour is empty. */
typedef struct vv_picked {
    vv_pixel pixel;
    bool hit;           /**< something is there: the renderer gave the pixel a depth */
    const char *volume; /**< id in world.volumes, which owns it; NULL: what is there is not a volume */
    uint32_t id;        /**< as in vv_image: 1 + number among the visible volumes; 0: none */
    double depth;       /**< from the eye, World's unit */
    vv_vec3 world;
    vv_vec3 index;    /**< sample coordinates of the volume's data */
    double value;     /**< of the data there, between samples as the volume is shown */
    vv_vec3 gradient; /**< value by world length */
    vv_vec3 normal;   /**< towards the eye, length 1, as in the layer; 0 where the values do not change */
    bool labelled;    /**< the volume shows labels */
    vv_label_id label;
    bool is_mesh;        /**< the volume shows a mesh: index is a place in its own space, value that of its vertices, or
                              NaN, there are no gradient and label */
    uint32_t triangle;   /**< of the mesh, from 0; VV_NO_TRIANGLE on the face of a cut */
    char part[64];       /**< name of the part that it is of; "" without one */
    float rgba[4];       /**< light of the pixel before the background: linear, premultiplied */
    bool label_unsigned; /**< the label is the bits of uint64_t */
} vv_picked;

/**
 * What n pixels of a view show, by the view's own renderer: one ray each, no picture.
 *
 * view     id in world.views; NULL: the first
 * out      n of them
 * Where    half of the light is gone (composite), the largest value is (maximum), or the surface; of several volumes
 *          the one with the largest extinction there. A thin cloud is not hit; of translucent meshes with nothing
 *          behind them that leave more than half, the first is.
 * Errors   VV_E_ARGUMENT (a pixel outside the view), and those of vv_render()
 * Threads  any; same numbers for any thread count
 */
VV_API vv_status vv_pick(vv_picked *out, const vv_pixel *pixels, size_t n, vv_world *world, const char *view,
                         vv_job *job);

VV_END_DECLS
#endif
