/* The public name of what renderers of other programs need: volvis/sys/scene.h. */
#include "scene/lens.h"

void vv_lens_ray(vv_vec3 *origin_out, vv_vec3 *direction_out, const vv_lens *lens, int32_t width, int32_t height,
                 double x, double y)
{
    vvi_lens_ray(origin_out, direction_out, lens, width, height, x, y);
}
