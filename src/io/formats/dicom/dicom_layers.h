/** @file
 * A segmentation on its way to a plan, shared by dicom_layers.c (which begins it, and ends it), dicom_overlap.c and
 * dicom_layer_names.c.
 */
#ifndef VVI_IO_DICOM_LAYERS_H
#define VVI_IO_DICOM_LAYERS_H
#include "io/formats/dicom/dicom.h"

typedef struct vvi_dicom_layers {
    vvi_dicom_plan *plan;
    const vvi_dicom_image *image;
    vvi_dicom_slice *slice; /* frames, by place */
    size_t n;
    size_t *place; /* where each place begins in them; n_places + 1 */
    size_t n_places;
    size_t *slice_of; /* each place */
    size_t n_slices;
    uint16_t *number;                    /* of the segments, ascending; n_segments */
    uint16_t *index;                     /* by number */
    const vvi_dicom_segment **described; /* by number; NULL: the file does not */
    size_t *n_frames;                    /* of each segment */
    size_t *layer;                       /* of each segment */
    size_t n_segments, n_layers;
    size_t alone;     /* the segment that a part names, without the others of its layer; SIZE_MAX: the whole layer */
    uint8_t *overlap; /* bit i * n_segments + j, both ways: i and j share a sample */
    const char *name;
    vv_source *source;
    vv_notes *notes;
    vv_job *job;
} vvi_dicom_layers;

/** Zeroed memory for n items; NULL with the failure said. */
void *vvi_dicom_layers_room(vvi_dicom_layers *l, size_t n, size_t bytes);
/** Which of the segments a frame is of. */
size_t vvi_dicom_segment_of(const vvi_dicom_layers *l, int32_t frame);
/** Name and colour of a segment. */
vv_label vvi_dicom_label_of(const vvi_dicom_layers *l, size_t segment);
/** Fills layer and n_layers: each segment goes to the first layer in which it overlaps none. */
vv_status vvi_dicom_find_layers(vvi_dicom_layers *l);
/** The layer that a part is, layer0 where it is NULL; all are noted. A part may be a segment as well, by "segment2" or
 * by its name: l->alone is it then. */
vv_status vvi_dicom_choose_layer(size_t *out, vvi_dicom_layers *l, const vvi_dicom_stack *stack, const char *part);
/** Of fractions each segment is a part: by "segment2" or by its name; the first that has frames where it is NULL. */
vv_status vvi_dicom_choose_segment(size_t *out, const vvi_dicom_layers *l, const vvi_dicom_stack *stack,
                                   const char *part);
#endif
