/** @file
 * What is known of data: what `volvis info` tells of files, meshes and scenes, as answers with items for people and for
 * programs.
 */
#ifndef VOLVIS_ABOUT_H
#define VOLVIS_ABOUT_H
#include <volvis/measuring.h>
VV_BEGIN_DECLS

/** What is told of a file of volumes; bits of a set. */
typedef enum vv_about {
    VV_ABOUT_HEADER = 1,     /**< format, samples, place in the world, units, metadata, warnings */
    VV_ABOUT_PARTS = 2,      /**< the data sets that it holds */
    VV_ABOUT_NAMES = 4,      /**< channels and labels by name, without a look at samples */
    VV_ABOUT_RANGE = 8,      /**< the least and largest value and the mean of each component, for people alone */
    VV_ABOUT_STATISTICS = 16 /**< checksum, statistics and names of each component, counts of labels */
} vv_about;

/** Fill with vv_about_options_init(), then change what you need. */
typedef struct vv_about_options {
    size_t size;           /**< set by init */
    unsigned what;         /**< any of vv_about; default VV_ABOUT_HEADER */
    const vv_field *field; /**< of RANGE and STATISTICS: the samples of the time step that is told of */
    const char *id;        /**< of HEADER: of its volume in a World; default NULL: not told */
    bool all;              /**< people get lists in full, and the file's metadata; default: 64 lines of a list */
    const char *more;      /**< said after "and 12 more" of a list that was cut; default "" */
} vv_about_options;

VV_API void vv_about_options_init(vv_about_options *options, size_t size);

/**
 * What a file says of its data, and what its samples are.
 *
 * options  NULL: the header
 * Errors   VV_E_ARGUMENT (RANGE or STATISTICS without a field), VV_E_READ, VV_E_LIMIT (more labels than any
 * segmentation has), VV_E_MEMORY, VV_E_CANCELLED Owns     *out is for vv_answer_release(), also when this fails; it
 * borrows nothing
 */
VV_API vv_status vv_about_file(vv_answer **out, vv_file *file, const vv_about_options *options, vv_job *job);
/** What a header says of samples and of their place, wherever they come from. Owns as above. */
VV_API vv_status vv_about_samples(vv_answer **out, const vv_field_info *info);
/** Size, topology, area and volume of a mesh. Errors: VV_E_MEMORY, VV_E_CANCELLED. Owns as above. */
VV_API vv_status vv_about_mesh(vv_answer **out, const vv_mesh *mesh, vv_job *job);
/** Meshes in a folder, and folders in it that are volumes by their names; none of what is no folder or cannot be
 * listed. Volumes that are files of the folder, or parts of it, are told by vv_about_file(). Errors: VV_E_MEMORY. Owns
 * as above. */
VV_API vv_status vv_about_folder(vv_answer **out, size_t *n_meshes_out, size_t *n_volumes_out, const char *path,
                                 const vv_about_options *options, vv_job *job);
/** What a World has: ids of its things, how data that are made are made, what is measured. Owns as above. */
VV_API vv_status vv_about_world(vv_answer **out, const vv_world *world);

VV_END_DECLS
#endif
