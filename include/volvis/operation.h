/** @file
 * One operation on data in memory: find it by name, set its parameters, run it. The rows themselves are in
 * <volvis/sys/registry.h>; <volvis/run.h> runs them on files, all time steps, streamed where memory does not hold them.
 */
#ifndef VOLVIS_OPERATION_H
#define VOLVIS_OPERATION_H
#include <volvis/field.h>
#include <volvis/mesh.h>
#include <volvis/property.h>
VV_BEGIN_DECLS

typedef struct vv_operation vv_operation;

/** What data an operation takes or makes; bits of a set. */
typedef enum vv_data_is { VV_IS_FIELD = 1, VV_IS_MESH = 2 } vv_data_is;

/** Data of one of these: the others are NULL. */
typedef struct vv_data {
    vv_field *field;
    vv_mesh *mesh;
} vv_data;

/** By the name that it has on the command line, of those that the job's runtime has (job NULL: those that are built
 * in). NULL, and an error with the nearest real name, when there is none. It lives as long as the runtime. */
VV_API const vv_operation *vv_operation_find(const char *name, const vv_job *job);
/** Its parameters, all as they are by default; change them by vv_path_set_number() and its siblings. Yours, for
 * vv_object_release(). `volvis NAME --help` tells what they are. */
VV_API vv_status vv_operation_new_params(vv_object **out, const vv_operation *operation);
/** What lengths among the parameters mean on this data: bare numbers are in its unit, and "2vox" are two of its voxels.
 * Valid as long as the data. */
VV_API vv_property_context vv_data_context(const vv_data *data);

/**
 * Run an operation on data in memory.
 *
 * inputs  in the order of the operation's; an optional one that is left out is {0}
 * params  of vv_operation_new_params(); what they leave open is decided by the samples
 * Errors  VV_E_ARGUMENT (a number of inputs that it does not take, other data, parameters that it refuses),
 * VV_E_MEMORY, VV_E_LIMIT, VV_E_CANCELLED, those of reading Owns    *out is yours, for vv_data_release(); on error it
 * is empty Threads same bytes for any thread count
 */
VV_API vv_status vv_operation_make(vv_data *out, const vv_operation *operation, const vv_data *inputs, size_t n_inputs,
                                   const vv_object *params, vv_job *job);
/** The same for operations that make fields from fields. VV_E_ARGUMENT for others. */
VV_API vv_status vv_operation_run(vv_field **out, const vv_operation *operation, const vv_field *const *inputs,
                                  size_t n_inputs, const vv_object *params, vv_job *job);
VV_API vv_data_is vv_operation_makes(const vv_operation *operation);
/** How many inputs it takes, the fewest and the most. */
VV_API size_t vv_operation_least(const vv_operation *operation);
VV_API size_t vv_operation_most(const vv_operation *operation);
VV_API void vv_data_release(vv_data *data); /* leaves it empty */

VV_END_DECLS
#endif
