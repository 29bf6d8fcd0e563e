/** @file
 * A structure set on its way to labels: dicom_contours.c reads its contours, dicom_contour_grid.c finds the grid that
 * they get (that of the images on which they were drawn by dicom_contour_series.c), dicom_contour_frames.c says which
 * contours each slice shows, dicom_contour_pixels.c draws them. From then on it is a segmentation whose frames are one
 * region of interest in one slice each.
 */
#ifndef VVI_IO_DICOM_CONTOURS_H
#define VVI_IO_DICOM_CONTOURS_H
#include "io/formats/dicom/dicom.h"

/** A closed contour. */
typedef struct vvi_dicom_contour {
    double *at; /* n_points times x, y, z: mm, RAS */
    size_t n_points;
    size_t roi;        /* of the segments of the image */
    size_t number;     /* as they came */
    double depth, off; /* along the normal of the slices: its middle, and how far the farthest point is from that */
} vvi_dicom_contour;

/** What one region of interest is in one slice. */
typedef struct vvi_dicom_drawing {
    int32_t slice;
    uint16_t label;
    size_t first, n; /* of the contours */
} vvi_dicom_drawing;

typedef struct vvi_dicom_structures {
    vvi_dicom_contour *contour;
    size_t n_contours;
    double thickness; /* of the slabs that contours stand for; 0: the file does not say */
    vv_grid grid;
    vv_affine to_index; /* of the grid */
    vv_vec3 normal;     /* of its slices, length 1 */
    vvi_dicom_drawing *frame;
    size_t n_frames;
} vvi_dicom_structures;

void vvi_dicom_structures_free(vvi_dicom_structures *structures); /* NULL is fine */
/** Fills image->structures with the contours that can be drawn, and the segments with what is said of them; what is
 * left out is told. */
vv_status vvi_dicom_contours_read(vvi_dicom_image *image, vv_source *source, vv_notes *notes, vv_job *job);
/** Makes frames of the contours of the image of a stack, and slices of them: what vvi_dicom_arrange_segments() needs.
 */
vv_status vvi_dicom_draw(vvi_dicom_plan *plan, vvi_dicom_stack *stack, vv_source *source, vv_notes *notes, vv_job *job);
/** The grid of the images on which the contours were drawn, or that share their places: in the folder, or beside the
 * file. *found: whether there is one in whose slices they lie. */
vv_status vvi_dicom_series_grid(vv_grid *out, bool *found, const vvi_dicom_plan *plan, const vvi_dicom_image *image,
                                vv_source *source, vv_notes *notes, vv_job *job);
/** A grid of the contours' own: slices in their planes. */
vv_status vvi_dicom_own_grid(vv_grid *out, const vvi_dicom_image *image, const char *name, vv_notes *notes,
                             vv_job *job);
/** The direction at right angles to a contour, as long as twice its area. */
vv_vec3 vvi_dicom_contour_normal(const vvi_dicom_contour *contour);
/** That of the largest contour, length 1; false: none has an area. */
bool vvi_dicom_contours_normal(vv_vec3 *out, const vvi_dicom_structures *structures);
/** Middle and reach of each contour along a direction. */
void vvi_dicom_find_depths(vvi_dicom_structures *structures, vv_vec3 normal);
/** The most frequent distance of n sorted depths that are farther apart than a trifle: the mean of those that are as
 * good as equal to it, the least of equally frequent ones; *n_out how many distances there are. 0: none. */
double vvi_dicom_usual_distance(const double *depth, size_t n, double *distances, size_t *n_out);
/** Orders the contours by region and depth, and says which are seen where. */
vv_status vvi_dicom_find_frames_drawn(vvi_dicom_image *image, const char *name, vv_notes *notes, vv_job *job);
/** One frame: 1 inside, else 0. */
vv_status vvi_dicom_draw_frame(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_job *job);
#endif
