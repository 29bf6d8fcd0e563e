/** @file
 * How two pictures, volumes or meshes differ: what `volvis compare` tells.
 */
#ifndef VOLVIS_COMPARE_H
#define VOLVIS_COMPARE_H
#include <volvis/image.h>
#include <volvis/measuring.h>
VV_BEGIN_DECLS

/** How much may differ. Fill with vv_compare_limits_init(), then change what you need: NaN is no limit. */
typedef struct vv_compare_limits {
    size_t size;           /**< set by init */
    double psnr;           /**< of images and volumes: the least peak signal-to-noise ratio, in dB */
    double ssim;           /**< of images: the least structural similarity, at most 1 */
    double flip;           /**< of images: the largest mean FLIP error, 0 to 1 */
    double max_difference; /**< of images 0 to 1, of volumes in values; of meshes the largest distance, in a's unit */
} vv_compare_limits;

/** Nothing is limited. */
VV_API void vv_compare_limits_init(vv_compare_limits *limits, size_t size);

/**
 * Compare two things of a kind.
 *
 * An answer has "kind", what was found ("psnr", "max_difference", ...), "identical" and "differs"; its lines are for
 * people. PSNR counts the range of a over the root mean square of the differences; it is INFINITY (null in JSON) when
 * nothing differs, and NaN where it is not defined: all values of a are the same, or somewhere only one of the two is a
 * finite number.
 *
 * limits       NULL: none
 * exceeded_out a limit is exceeded, or the two are of different size; without that, what differs does not count here
 * Errors       VV_E_ARGUMENT, VV_E_READ, VV_E_MEMORY, VV_E_CANCELLED
 * Owns         *out is for vv_answer_release(), also when this fails; it borrows nothing
 * Threads      any; same answer for any thread count
 */
VV_API vv_status vv_compare_images(vv_answer **out, bool *exceeded_out, const vv_image *a, const vv_image *b,
                                   const vv_compare_limits *limits, vv_job *job);
/** One time step of each. Volumes whose axes run along the same lines of the world in another order or direction are
 * compared at the same places. Samples are read only if the sizes go together. */
VV_API vv_status vv_compare_files(vv_answer **out, bool *exceeded_out, vv_file *a, int64_t frame_a, vv_file *b,
                                  int64_t frame_b, const vv_compare_limits *limits, vv_job *job);
/** The same of samples in memory. */
VV_API vv_status vv_compare_fields(vv_answer **out, bool *exceeded_out, const vv_field *a, const vv_field *b,
                                   const vv_compare_limits *limits, vv_job *job);
/** Sizes, places and data of both, and the distances between their surfaces (vv_mesh_distance()). Lengths are in the
 * unit of a where both have real ones. */
VV_API vv_status vv_compare_meshes(vv_answer **out, bool *exceeded_out, const vv_mesh *a, const vv_mesh *b,
                                   const vv_compare_limits *limits, vv_job *job);

VV_END_DECLS
#endif
