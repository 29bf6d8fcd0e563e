/** @file
 * Structuring elements: which samples around each one morphology looks at.
 */
#ifndef VVI_FILTER_ELEMENT_H
#define VVI_FILTER_ELEMENT_H
#include "filter/window.h"

typedef enum vvi_element_shape { VVI_ELEMENT_BALL, VVI_ELEMENT_BOX, VVI_ELEMENT_CROSS } vvi_element_shape;

/** What is told of an element: all of a filter's parameters, or the first member of them. */
typedef struct vvi_element_params {
    vvi_window_params window;
    int shape;
} vvi_element_params;

extern const char *const vvi_element_shape_names[];

/** Their rows, the first three of the class. */
#define VVI_ELEMENT_PROPERTIES                                                                                         \
    {VV_PROP(vvi_window_params, radius),                                                                               \
     .kind = VV_KIND_F64,                                                                                              \
     .quantity = VV_Q_LENGTH,                                                                                          \
     .limited = true,                                                                                                  \
     .min = 0,                                                                                                         \
     .max = 1e12,                                                                                                      \
     .automatic = "one voxel along each axis",                                                                         \
     .doc = "how far the element reaches, a length: 1.5mm, 2vox; a ball has in it what lies no farther away, boxes "   \
            "and crosses are rounded to whole voxels of each axis; 0 changes nothing"},                                \
        {VV_PROP(vvi_window_params, radius_voxels), .kind = VV_KIND_VEC3, .automatic = "from radius",                  \
         .doc = "instead of radius: whole voxels along x, y, z"},                                                      \
    {                                                                                                                  \
        VV_PROP(vvi_element_params, shape), .kind = VV_KIND_ENUM, .names = vvi_element_shape_names,                    \
                                            .doc = "of the element; a cross has in it what lies along the axes alone"  \
    }

/** Samples side by side along x, at (lo .. lo + length - 1, y, z) from the middle. */
typedef struct vvi_chord {
    int64_t y, z, lo, length;
    int table; /**< length is lengths[table] */
} vvi_chord;

/** The middle is in it, and with each offset its opposite. */
typedef struct vvi_element {
    int64_t radius[3]; /**< how far it reaches; less than the grid's dims */
    bool box;          /**< all within radius: no chords */
    vvi_chord *chords; /**< by ascending z */
    size_t n_chords;
    int64_t *lengths; /**< ascending from 1, each at most twice the one before; of chords, and what leads to them */
    int n_lengths;
} vvi_element;

/** `name`: of the filter. VV_E_ARGUMENT for boxes that reach farther than 1000 voxels, others than 100. */
vv_status vvi_element_init(vvi_element *out, const vv_field_info *info, const vv_object *params, const char *name,
                           vv_job *job);
void vvi_element_finish(vvi_element *element); /* zeroed is fine */
/** Whether the parameters make sense for such a field, as vvi_element_init() says it. */
vv_status vvi_element_check(const vv_field_info *info, const vv_object *params, const char *name);
/** The part of it along one axis of a box. */
vvi_element vvi_element_along(const vvi_element *box, int axis);
#endif
