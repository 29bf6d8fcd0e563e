/** @file
 * What a World says of data that are measured: where they lie, what is cut away, which values are seen.
 */
#ifndef VVI_MEASURING_WORLD_DATA_H
#define VVI_MEASURING_WORLD_DATA_H
#include "model/contents.h"
#include <volvis/measuring.h>

enum { VVI_MEASURED_PLANES = 32 };

/** A volume. Zeroed is valid to finish. */
typedef struct vvi_measured_volume {
    vv_measured_data data;
    vv_field *field;
    vv_plane planes[VVI_MEASURED_PLANES];
} vvi_measured_volume;

/** The meshes that a World shows. Zeroed is valid to finish. */
typedef struct vvi_measured_meshes {
    vv_measured_data *data; /**< n of them */
    struct vvi_measured_mesh *mesh;
    size_t n;
} vvi_measured_meshes;

/** The id of the volume that a question names, else of the first visible one. NULL: there is none. */
const char *vvi_measured_volume_id(const vv_world *world, const char *named);
/** Whether the first visible volume is a mesh. */
bool vvi_world_shows_meshes(const vv_world *world, vv_job *job);
/** The value of the surface that a view's method shows of values (view "": the first); false: it shows none, or one
 * whose value nobody has set. Nothing is loaded. */
bool vvi_world_surface_value(double *out, const vv_world *world, const char *view, vv_job *job);

/** Lengths of a grid in another unit, where both are real ones. */
void vvi_grid_take_unit(vv_grid *grid, const char *unit);
/** The samples of a volume, which are `field`, as the World has them, lengths in its unit; volume NULL: the samples
 * alone, cut by its planes. frame: the time step that they are. file: what says how their labels are called; NULL:
 * nothing does. name: for people. view: whose surface is the object, "": the first. *out stays where it is while it is
 * used. */
vv_status vvi_measured_volume_take(vvi_measured_volume *out, const vv_field *field, const vv_file *file, int64_t frame,
                                   const char *name, const vv_world *world, const vv_volume *volume, const char *view,
                                   vv_job *job);
void vvi_measured_volume_finish(vvi_measured_volume *volume);

/** All visible meshes of a World, which lives as long, or that of one volume alone (its id; NULL: all). file: its name,
 * for errors. */
vv_status vvi_measured_meshes_take(vvi_measured_meshes *out, const vv_world *world, const char *only, const char *file,
                                   vv_job *job);
void vvi_measured_meshes_finish(vvi_measured_meshes *meshes);
#endif
