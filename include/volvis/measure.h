/** @file
 * Measuring objects in volumes: how large they are, where they lie, and how sure that is.
 *
 * The object is what has values in a range, a label, or is marked in another field; all of it, or the connected piece
 * around a seed; inside a box of samples and on one side of planes. Two methods, which are never mixed: voxel counting,
 * where a sample fills a box of its own, and Marching Cubes, where the values between samples are interpolated. A grid
 * of n samples is n steps long for the first and n - 1 for the second.
 */
#ifndef VOLVIS_MEASURE_H
#define VOLVIS_MEASURE_H
#include <volvis/field.h>
VV_BEGIN_DECLS

typedef enum vv_object_kind {
    VV_OBJECT_RANGE, /**< values from lo to hi, both inclusive */
    VV_OBJECT_LABEL, /**< samples that are stored as this number */
    VV_OBJECT_MASK   /**< samples where another field on the same grid is not 0 */
} vv_object_kind;

typedef enum vv_measure_method {
    VV_MEASURE_AUTO,  /**< ranges of values by Marching Cubes, labels and masks by counting */
    VV_MEASURE_CUBES, /**< Marching Cubes */
    VV_MEASURE_COUNT  /**< voxel counting */
} vv_measure_method;

typedef enum vv_region_kind {
    VV_REGION_NONE,    /**< everything */
    VV_REGION_BOX,     /**< a rectangle where it is as thick as a slice */
    VV_REGION_ELLIPSE, /**< as thick along z: an elliptic cylinder */
    VV_REGION_POLYGON, /**< an outline, as thick along z; inside is what an odd number of its sides separates from far
                          away */
    VV_REGION_ELLIPSOID
} vv_region_kind;

/** A region in a frame of its own. Samples belong to it whose centres are inside: of two opposite sides of boxes,
 * thicknesses and outlines the lower one is part of it, so that regions side by side share no sample; ellipses and
 * ellipsoids have all of their border. */
typedef struct vv_region_shape {
    vv_region_kind kind;
    vv_affine frame;       /**< from its coordinates, whose origin is its middle, to the world */
    double half[3];        /**< half of its extent along each; of a polygon the last alone counts */
    const double *outline; /**< of a polygon: n_outline rows of x and y, at least 3 */
    size_t n_outline;
} vv_region_shape;

/** What is measured and how. Fill with vv_measure_options_init(), then change what you need. */
typedef struct vv_measure_options {
    size_t size; /**< set by init */
    int component;
    vv_object_kind object;
    double lo, hi; /**< default: all values */
    vv_label_id label;
    const vv_field *mask;   /**< its samples lie where the field's do, to a twentieth of a voxel; without spacing (unit
                               "voxels") as many are enough */
    vv_box box;             /**< of samples; n 0: all of them */
    const vv_plane *planes; /**< n_planes of them, in world space: what is kept has normal . p >= offset */
    size_t n_planes;
    bool seeded;     /**< only the piece around the seed: its voxels share faces; those outside, corners too */
    int64_t seed[3]; /**< index of a sample; the nearest one of the object within 2 samples is taken */
    bool closed;     /**< counting: faces where the object is cut off are part of its area */
    bool no_error;   /**< Marching Cubes: area_error and volume_error are not worked out, which saves an eighth */
    vv_measure_method method;
    const vv_region_shape *region; /**< only samples in it, which are counted: no Marching Cubes. What cuts the object
                                      off there is part of its surface. NULL: everything */
} vv_measure_options;

/** Results. Areas and volumes are in the square and the cube of the grid's unit. */
typedef struct vv_measured {
    size_t size;                 /**< set by the caller */
    double area, area_error;     /**< of the object's surface; where it is cut off is left out unless `closed` */
    double volume, volume_error; /**< errors as docs/measurement.md says; NaN: not known */
    double cut_area;             /**< of the faces (counting: of voxels) where box, planes, border cut the object off */
    vv_vec3 centroid;            /**< world; NaN when there is nothing */
    vv_bounds bounds;            /**< world box of the object: of voxels with their extent, or of the surface */
    uint64_t voxels;             /**< samples of the object in the region */
    uint64_t unknown;            /**< Marching Cubes: cells left out for samples that are not a number */
    double raw_faces;            /**< counting: area of the voxels' outer faces, half too much on curved surfaces */
    double lindblad;             /**< counting: by weighted 2 x 2 x 2 configurations; NaN unless voxels are cubes */
    double crofton;              /**< counting: by crossings along 13 directions */
    int64_t euler; /**< counting, of all of the object: pieces - tunnels + cavities, where voxels share faces */
    bool steps;    /**< Marching Cubes of what has no ramp between inside and outside (labels, masks, two values): the
                      area is 8 % too large whatever the resolution, up to 25 % where voxels are not cubes */
    vv_vec3 centroid_error; /**< 0.8 V' / V of half the box's size, V' being volume_error: what is too much or too
                               little lies at the surface, whose root mean square distance from the centroid along an
                               axis is 0.58 (balls) to 0.75 (boxes) of half the size. NaN: V' is not known */
    vv_vec3 bounds_error; /**< of each side of the box. Counting: half a step and, since points and edges that stick out
                             pass between the samples, 0.65 of a mean voxel. Marching Cubes: V' / area (of a band of
                             values those of its lower surface), how far the
                             surface may be off, and 1.2 mean voxels for corners where a twentieth of the area or more
                             has edges; of steps half a step and 1.2. A side where the object is cut off is exact */
} vv_measured;

VV_API void vv_measure_options_init(vv_measure_options *options, size_t size);
/**
 * Area, volume, centroid and bounding box of an object.
 *
 * For Marching Cubes a range with two ends is what lies between the surfaces of both, be it thinner than a voxel; with
 * a seed it is what its samples say.
 *
 * Shapes   field: at least 2 samples along each axis for Marching Cubes
 * Errors   VV_E_ARGUMENT (no such channel, an invalid range, mask on another grid, box outside, seed outside the
 *          object, a region without extent or for Marching Cubes), VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. An empty
 * object is not an error: all is 0. Threads  any; same bytes for any thread count Memory   a few slices; with a seed
 * three bits a sample Source   Lindblad 2005 (weights of configurations); Crofton's formula with Voronoi weights of the
 * directions; Lorensen & Cline 1987, Nielson & Hamann 1991, volume by the divergence theorem in each cell
 */
VV_API vv_status vv_measure(vv_measured *out, const vv_field *field, const vv_measure_options *options, vv_job *job);

/** Volume and area of a region itself, as geometry has it: of an ellipsoid no area, and of a polygon that crosses
 * itself neither (NaN). The area is that of the outline, in the square of the world's unit. */
VV_API double vv_region_shape_volume(const vv_region_shape *region);
VV_API double vv_region_shape_area(const vv_region_shape *region);

/* Values ---------------------------------------------------------------------------------------------------------- */

/** Of which samples, and how finely. Fill with vv_values_options_init(), then change what you need. */
typedef struct vv_values_options {
    size_t size; /**< set by init */
    int component;
    const vv_measure_options *of; /**< only samples of this object (its component is of the choice); NULL: all */
    int64_t n_bins;               /**< 2 .. 65536; 0: at most 1024. At most so many where equally many whole numbers
                                     share each, which they do unless ends and number are both given */
    double lo, hi;                /**< ends of the bins; NaN: least and largest value */
} vv_values_options;

/** What values there are. Values, not stored numbers. */
typedef struct vv_values {
    size_t size;
    uint64_t count; /**< finite samples */
    uint64_t nan_count, infinite_count;
    double min, max, mean, deviation; /**< of finite samples; NaN when there are none */
    double median;                    /**< exact; of an even number of samples the mean of the two in the middle */
    double percentile[7];             /**< 0.1, 1, 25, 50, 75, 99, 99.9 %: exact; p at place p / 100 (n - 1) of the
                                         samples in rising order, in a straight line between two (numpy's "linear") */
    double mode;                      /**< the most frequent value; of bins of several, the middle of the fullest */
    double entropy;                   /**< bits, of the shares of the bins (Shannon 1948) */
    bool exact; /**< the mode is a value that occurs; else a sample of the fullest bin is within `within` of it */
    double within;
    double lo, hi; /**< ends of the bins */
    size_t n_bins;
    uint64_t below, above; /**< samples beyond the ends, which are in no bin */
    const uint64_t *bins;  /**< counts of equal bins, the last one closed above */
} vv_values;
#define VV_VALUES_PERCENTS                                                                                             \
    {                                                                                                                  \
        0.1, 1, 25, 50, 75, 99, 99.9                                                                                   \
    }

VV_API void vv_values_options_init(vv_values_options *options, size_t size);
/** Statistics and histogram. Samples of 8 and 16 bits are looked at once, those of 32 bits twice, of 64 four times.
 * Same numbers for any thread count. Errors: VV_E_ARGUMENT, VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. Free with
 * vv_values_free(). options NULL: all samples of channel 0. */
VV_API vv_status vv_measure_values(vv_values **out, const vv_field *field, const vv_values_options *options,
                                   vv_job *job);
VV_API void vv_values_free(vv_values *values); /* NULL is fine */

/* Values and gradients -------------------------------------------------------------------------------------------- */

/** Fill with vv_joint_options_init(), then change what you need. */
typedef struct vv_joint_options {
    size_t size; /**< set by init */
    int component;
    const vv_measure_options *of;  /**< only samples of this object, as in vv_values_options; NULL: all */
    int64_t n_values, n_gradients; /**< bins, 2 .. 1024 each; 0: 256; of whole numbers at most one a number */
    double value_lo, value_hi;     /**< ends of the values' bins; NaN: least and largest value */
    double gradient_hi;            /**< end of the gradients' bins, which begin at 0; NaN: the longest one */
} vv_joint_options;

/** How often a value comes with a length of the gradient. */
typedef struct vv_joint {
    size_t size;
    uint64_t count;                     /**< samples that have both, in and beyond the bins */
    uint64_t unknown;                   /**< samples that are not a number, or have such a neighbour */
    uint64_t beyond;                    /**< of `count`: those in no bin */
    double gradient_mean, gradient_max; /**< in values per unit of length; NaN: there are none */
    double value_lo, value_hi, gradient_hi;
    size_t n_values, n_gradients;
    const uint64_t *bins; /**< n_gradients rows, from 0 up, of n_values counts; the last ones are closed above */
} vv_joint;

VV_API void vv_joint_options_init(vv_joint_options *options, size_t size);
/**
 * Joint histogram of values and lengths of gradients (Kindlmann & Durkin 1998): borders are arches between the values
 * that they part.
 *
 * Gradients are differences over two steps, at the border of the volume over one, in world space whatever the grid's
 * axes; along an axis of one sample there is none.
 *
 * Errors   VV_E_ARGUMENT (as vv_measure_values(); a grid whose axes lie in a plane), VV_E_MEMORY, VV_E_READ,
 *          VV_E_CANCELLED
 * Owns     free with vv_joint_free(). Same numbers for any thread count
 * Cost     the samples are looked at twice
 */
VV_API vv_status vv_measure_joint(vv_joint **out, const vv_field *field, const vv_joint_options *options, vv_job *job);
VV_API void vv_joint_free(vv_joint *joint); /* NULL is fine */

/* Labels ---------------------------------------------------------------------------------------------------------- */

/** Of which part, and with which values. Fill with vv_label_options_init(), then change what you need. */
typedef struct vv_label_options {
    size_t size;            /**< set by init */
    const vv_field *values; /**< another field on the same grid (as `mask`); NULL: none */
    int component;          /**< of the values */
    vv_box box;             /**< of samples; n 0: all of them */
    const vv_plane *planes; /**< n_planes of them, as in vv_measure_options */
    size_t n_planes;
    bool no_areas; /**< areas and what they say of volume_error are not worked out, which takes most of the time: NaN */
} vv_label_options;

/** What one label marks. Numbers of values are NaN without values, or where none is finite. */
typedef struct vv_label_measures {
    vv_label_id label;
    uint64_t count;              /**< samples */
    double volume, volume_error; /**< count times the volume of a voxel */
    double area, area_error;     /**< by counting, as vv_measure() has it of the label; NaN: no memory for it */
    vv_vec3 centroid;
    vv_bounds bounds;  /**< world box of its voxels with their extent */
    uint64_t n_values; /**< finite ones */
    double min, max, mean, deviation;
    double median, within; /**< of an even number the mean of the two in the middle, to within that: 0, exactly */
} vv_label_measures;

VV_API void vv_label_options_init(vv_label_options *options, size_t size);
/** Each label but 0, by ascending number. options NULL: all samples, no values.
 * *out is yours to vv_label_measures_free(). Same numbers for any thread count. Errors: VV_E_ARGUMENT (another grid,
 * box outside), VV_E_LIMIT (more labels than any segmentation has), VV_E_MEMORY, VV_E_READ, VV_E_CANCELLED. */
VV_API vv_status vv_measure_labels(vv_label_measures **out, size_t *n_out, const vv_field *labels,
                                   const vv_label_options *options, vv_job *job);
VV_API void vv_label_measures_free(vv_label_measures *measures); /* NULL is fine */

VV_END_DECLS
#endif
