/** @file
 * Mesh files: read whole, written whole. The table of formats is in <volvis/sys/registry.h>.
 */
#ifndef VOLVIS_MESH_FILE_H
#define VOLVIS_MESH_FILE_H
#include <volvis/mesh.h>
VV_BEGIN_DECLS

/** Options of vv_mesh_read(). Fill with vv_mesh_read_options_init(), then change what you need. */
typedef struct vv_mesh_read_options {
    size_t size;        /**< set by init */
    const char *format; /**< a name from the table of mesh formats; NULL: by content first and suffix second */
    const char *unit;   /**< of lengths, where the file does not say it, or says no more than "units" or "voxels";
                           NULL: "units" */
    const char *part;   /**< read this part alone: by its name, or by its number from 0; NULL: all of the mesh */
} vv_mesh_read_options;

VV_API void vv_mesh_read_options_init(vv_mesh_read_options *options, size_t size);

/**
 * Read a mesh file.
 *
 * path    a file of any mesh format of the table; "-" is standard input; .gz, .bz2 and .zst are read through
 * Shapes  polygons become triangles; vertices of STL that lie at the same place, bit for bit, become one
 * Units   as the file says them; glTF's metres and y axis are turned back where VolVis wrote the file
 * Errors  VV_E_READ, VV_E_FORMAT (place, expected, found), VV_E_UNSUPPORTED, VV_E_LIMIT, VV_E_MEMORY, VV_E_CANCELLED,
 *         VV_E_NOT_FOUND (no such part: which there are)
 * Owns    *out is yours; on error it is NULL. What was left out or repaired is a warning in the job's log
 */
VV_API vv_status vv_mesh_read(vv_mesh **out, const char *path, const vv_mesh_read_options *options, vv_job *job);

/** Options of vv_mesh_write(). Fill with vv_mesh_write_options_init(), then change what you need. */
typedef struct vv_mesh_write_options {
    size_t size;          /**< set by init */
    const char *format;   /**< NULL: by the suffix of the path */
    const char *encoding; /**< one that the format has; NULL: its default */
    int level;            /**< of compression, 1..9; 0: the default */
    const char *unit;     /**< lengths are written in this one; NULL: in the mesh's own */
    bool spare_inputs;    /**< nothing that this job has read is replaced: VV_E_ARGUMENT instead */
} vv_mesh_write_options;

VV_API void vv_mesh_write_options_init(vv_mesh_write_options *options, size_t size);
/** Written beside the target, synced and renamed: never half a file. What the format cannot hold is a warning in the
 * job's log. Errors: VV_E_ARGUMENT (no such format, encoding or unit), VV_E_WRITE, VV_E_CANCELLED. */
VV_API vv_status vv_mesh_write(const char *path, const vv_mesh *mesh, const vv_mesh_write_options *options,
                               vv_job *job);
/** Whether a mesh could be written there with these options (NULL: defaults), to ask before long work:
 * VV_E_ARGUMENT, VV_E_UNSUPPORTED. Says nothing of disks and folders. */
VV_API vv_status vv_mesh_check(const char *path, const vv_mesh_write_options *options, vv_job *job);

VV_END_DECLS
#endif
