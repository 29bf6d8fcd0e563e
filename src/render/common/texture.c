/* Opening a texture. */
#include "render/common/texture.h"
#include "core/status.h"
#include <math.h>

/* The most lengths of the texture in one of the World. */
static double most_per_length(const vv_affine *m)
{
    const vv_vec3 *a = m->axis;
    const double x = a[0].x * a[0].x + a[1].x * a[1].x + a[2].x * a[2].x;
    const double y = a[0].y * a[0].y + a[1].y * a[1].y + a[2].y * a[2].y;
    const double z = a[0].z * a[0].z + a[1].z * a[1].z + a[2].z * a[2].z;
    return sqrt(fmax(x, fmax(y, z)));
}

vv_status vvi_texture_open(vvi_texture *out, const vv_actor *actor, const vv_scene *scene, vv_job *job)
{
    const vv_texture *from = &actor->texture;
    const vv_affine m = vv_affine_compose(from->from_world, actor->index_to_world);
    const double rows[3][4] = {{m.axis[0].x, m.axis[1].x, m.axis[2].x, m.origin.x},
                               {m.axis[0].y, m.axis[1].y, m.axis[2].y, m.origin.y},
                               {m.axis[0].z, m.axis[1].z, m.axis[2].z, m.origin.z}};
    *out = (vvi_texture){.kind = from->kind,
                         .mapping = from->mapping,
                         .wrap = from->wrap,
                         .replace = from->apply == VV_APPLY_REPLACE,
                         .parallel = scene->lens.parallel,
                         .strength = (float)from->strength,
                         .seed = from->seed};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 4; b++)
            out->from_index[a][b] = (float)rows[a][b];
    for (int c = 0; c < 6; c++)
        out->color[c / 3][c % 3] = (float)from->color[c / 3][c % 3];
    out->pixel = (float)(2 * scene->lens.half_height / scene->height * most_per_length(&from->from_world));
    if (!from->image)
        return VV_OK;
    out->aspect = (float)from->image->width / (float)from->image->height;
    const vv_status st = vvi_image_levels_build(&out->levels, from->image, job);
    return st == VV_OK ? VV_OK : vv_fail_in(st, "volumes.%s.texture", actor->id);
}

void vvi_texture_close(vvi_texture *t)
{
    vvi_image_levels_free(&t->levels);
}
