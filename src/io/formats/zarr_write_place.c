/* OME-Zarr has scales and translations alone: a field whose axes run along those of the world is written along them,
 * turned and mirrored as it takes; others keep their axes, and VolVis' own attributes say how they lie. */
#include "io/formats/zarr_write.h"
#include "io/place.h"
#include "io/turn.h"

/* A step that strays less than this from its axis is along it: far below what positions are known to. */
#define STRAIGHT 1e-12

void vvi_zarr_write_place(vvi_zarr_writing *w)
{
    const vv_affine *own = &w->info->grid.index_to_world;
    const vvi_turn t = vvi_turn_to_world(&w->info->grid, STRAIGHT);
    const vv_vec3 origin = t.grid.index_to_world.origin;
    const double at[3] = {origin.x, origin.y, origin.z};
    w->oblique = !t.straight;
    for (int a = 0; a < 3; a++) {
        w->source_axis[a] = w->oblique ? a : t.axis[a];
        w->flip[a] = !w->oblique && t.back[a];
        w->spacing[a] = w->oblique ? vvi_length(own->axis[a]) : vv_grid_spacing(&t.grid, a);
        w->origin[a] = w->oblique ? 0 : at[a];
    }
}
