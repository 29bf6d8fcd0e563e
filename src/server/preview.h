/** @file
 * What an operation would make of the part of a World that a view shows, before all of it is made.
 */
#ifndef VVI_SERVER_PREVIEW_H
#define VVI_SERVER_PREVIEW_H
#include "run/made.h"
#include <volvis/image.h>
#include <volvis/sys/scene.h>

/** What is wanted. All is borrowed. */
typedef struct vvi_preview_wish {
    vv_world *world; /**< its view has its size and its camera */
    const char *view;
    const char *volume; /**< whose data the first input is, and in whose place the result is drawn */
    bool tells_before;  /**< a picture of the input too: the volume shows something else now */
    const char *made;   /**< id of the dataset that is looked at: that would be made, which nothing shows, or the end */
    const char *inserted; /**< of what would be made on the way to that end; NULL: nothing */
    bool whole;           /**< all of it, where parts cannot be made, however large that is */
    double part_s;        /**< about how long a part may take, seconds */
    uint64_t whole_most;  /**< voxels and triangles of the inputs that are worked on as a whole without being asked, and
                             without a trial that says that part_s is enough */
    int64_t samples_most; /**< of a box that is no slice */
} vvi_preview_wish;

/** What was made of it; zeroed is valid to finish. */
typedef struct vvi_preview {
    vv_image *image;    /**< NULL: it has to be made as a whole, and nobody asked for that */
    vv_image *input;    /**< where that is wanted; else NULL */
    bool whole;         /**< parts cannot be made */
    bool full;          /**< all that the view shows of it is in the box */
    vv_box box;         /**< that was made; of a mesh nothing */
    vv_field_info info; /**< of the whole, as planned; of meshes of the input */
    uint64_t bytes;     /**< that the whole takes beside its inputs, and the inputs */
    double seconds;     /**< about how long the whole takes, where that was tried; NaN: nobody knows */
    bool has_window;    /**< slices: the values from black to white */
    double window[2];
    bool has_value; /**< at the sample next to the cross-hair, before and after */
    double before, after;
} vvi_preview;

/** Errors: those of the operation, with paths; VV_E_NOT_FOUND (no such volume);
 * VV_E_ARGUMENT (nothing of it is seen in this view). *out is for vvi_preview_finish(), also on failure. */
vv_status vvi_preview_make(vvi_preview *out, const vvi_preview_wish *wish, vv_job *job);
void vvi_preview_finish(vvi_preview *preview);
/** About how long it takes to make a time step of a dataset of the World, whose inputs are worked out first; NaN:
 * nobody knows, as of meshes. Errors: those of the operation. */
vv_status vvi_preview_seconds(double *out, const vv_world *world, const char *made, int64_t frame, vv_job *job);

/** What a volume says of labels by their numbers, below VVI_LABELS_PATH; NULL ends it. */
extern const char *const vvi_label_properties[];
#define VVI_LABELS_PATH "segmentation.labels."

/** Of a picture of a plane: the box of samples that it shows, with `margin` more to each side; false: it shows none. */
bool vvi_preview_seen(vv_box *out, const vv_scene *scene, vv_affine index_to_world, const int64_t dims[3], int margin);
/** A box in another that has at most `most` samples and has an index in its middle as far as it can: what is thin stays
 * as thick as it is. */
vv_box vvi_preview_smaller(const vv_box *box, const double middle[3], double most);
#endif
