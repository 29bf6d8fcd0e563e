/* OME-Zarr has scales and translations alone: a field is written along the axes of the world that its own are nearest
 * to, turned and mirrored as it takes. One that lies oblique stands upright about its middle then, where other programs
 * have least of it in the wrong place; VolVis' own attributes say how it lies. */
#include "core/job.h"
#include "io/formats/zarr/zarr_write.h"
#include "io/placement.h"
#include "io/world_order.h"

/* A step that strays less than this from its axis is along it: far below what positions are known to. */
#define STRAIGHT 1e-12

static void warn_of_oblique(const vvi_zarr_writing *w, bool mirrored)
{
    vvi_log(w->job, VV_LOG_WARNING, "io",
            "%s: OME-Zarr has no oblique axes: VolVis reads them back, but other programs will show it as if it were "
            "upright about its middle%s",
            vvi_sink_name(w->sink), mirrored ? ", and mirrored" : "");
}

void vvi_zarr_write_place(vvi_zarr_writing *w)
{
    const vvi_turn t = vvi_turn_to_world(&w->info->grid, STRAIGHT);
    const vv_vec3 origin = t.grid.index_to_world.origin;
    const double first[3] = {origin.x, origin.y, origin.z};
    double half[3];
    for (int a = 0; a < 3; a++)
        half[a] = 0.5 * (double)(t.grid.dims[a] - 1);
    const vv_vec3 middle = vv_affine_point(t.grid.index_to_world, (vv_vec3){half[0], half[1], half[2]});
    const double centre[3] = {middle.x, middle.y, middle.z};
    w->oblique = !t.straight;
    w->placement = t.grid.index_to_world;
    for (int a = 0; a < 3; a++) {
        w->source_axis[a] = t.axis[a];
        w->flip[a] = t.back[a];
        w->spacing[a] = vv_grid_spacing(&t.grid, a);
        w->origin[a] = w->oblique ? centre[a] - w->spacing[a] * half[a] : first[a];
    }
    if (w->oblique)
        warn_of_oblique(w, t.mirrored);
}
