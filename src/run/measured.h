/** @file
 * What is measured, open: of files, and of a World.
 */
#ifndef VVI_RUN_MEASURED_H
#define VVI_RUN_MEASURED_H
#include "measuring/world_data.h"
#include "run/stream.h"
#include <volvis/file.h>

/** A volume or a mesh. Zeroed is valid to close; it stays where it is while it is used. */
typedef struct vvi_measured {
    vvi_measured_volume volume; /**< and its data; of a mesh those alone */
    vv_mesh *mesh;
    vv_file *file; /**< NULL: it is somebody else's, or there is none */
    vvi_stream stream;
} vvi_measured;

/** All that a question is of. Zeroed is valid to close. */
typedef struct vvi_measured_all {
    vvi_measured input, other, mask, values;
    vvi_measured_meshes shown;
    vv_measured_inputs inputs;
} vvi_measured_all;

/** The samples of a file, which lives as long: in memory, or slab by slab. A World: as its volume has them
 * (vvi_measured_volume_take()); NULL: as they are. name: for people. */
vv_status vvi_measured_file(vvi_measured *out, vv_file *file, int64_t frame, const char *name, const vv_world *world,
                            const vv_volume *volume, const char *view, vv_job *job);
/** A mesh, which is taken. */
void vvi_measured_mesh(vvi_measured *out, vv_mesh *mesh, const char *name);
/** What a volume of a World shows, as the World has it: samples, or a mesh in its own space. VV_E_NOT_FOUND: no such
 * volume, or no data. */
vv_status vvi_measured_shown(vvi_measured *out, const vv_world *world, const char *id, const char *view, vv_job *job);
/** The samples of a dataset, as they are. what: for errors. VV_E_NOT_FOUND, VV_E_ARGUMENT (a mesh). */
vv_status vvi_measured_dataset(vvi_measured *out, const vv_world *world, const char *id, const char *what, vv_job *job);
void vvi_measured_close(vvi_measured_all *all);
#endif
