/* What meshes take of the light: their triangles in the cells that they pass through. */
#include "core/job.h"
#include "core/vec.h"
#include "render/raycast/prepare_light.h"
#include <math.h>

/* Optical depth of what is opaque; and how often it is asked whether to stop. */
#define OPAQUE_DEPTH 6
enum { TRIANGLES_A_POLL = 1 << 14, MOST_PARTS = 1 << 10 };

/* One mesh on its way into the cells. */
typedef struct strewing {
    float *cells;
    const vvi_light_grid *grid;
    const vvi_ray_meshes *meshes;
    const vvi_ray_mesh *mesh;
    vv_affine to_world, to_cell; /* from the mesh's positions; from the world */
    double side;                 /* of a cell, world length */
} strewing;

static bool is_cut(const vv_actor *look, vv_vec3 at)
{
    for (size_t i = 0; i < look->n_planes; i++)
        if (vvi_dot(look->planes[i].normal, at) < look->planes[i].offset)
            return true;
    return false;
}

/* Per world length, of a cell that the triangle passes through there. */
static float taken_at(const strewing *s, uint32_t triangle, const double share[3])
{
    double rgba[4];
    vvi_gfx_color_at(rgba, &s->mesh->surface, &s->meshes->decode, triangle, share, NULL);
    return (float)(fmin(-log1p(-fmin(fmax(rgba[3], 0), 0.999999)), OPAQUE_DEPTH) / s->side);
}

static void strew(const strewing *s, uint32_t triangle, const vv_vec3 corner[3], const double share[3])
{
    const int32_t *n = s->grid->n;
    vv_vec3 at = vvi_scaled(corner[0], share[0]);
    at = vvi_add(at, vvi_add(vvi_scaled(corner[1], share[1]), vvi_scaled(corner[2], share[2])));
    const vv_vec3 p = vv_affine_point(s->to_cell, at);
    const double x = floor(p.x + 0.5), y = floor(p.y + 0.5), z = floor(p.z + 0.5);
    if (!(x >= 0 && x < n[0] && y >= 0 && y < n[1] && z >= 0 && z < n[2]) || is_cut(&s->mesh->actor->look, at))
        return;
    float *cell = &s->cells[((size_t)z * (size_t)n[1] + (size_t)y) * (size_t)n[0] + (size_t)x];
    *cell = fmaxf(*cell, taken_at(s, triangle, share)); /* however many of its triangles there are */
}

/* Places half a cell apart, so that none is left out but by its corner. */
static void strew_triangle(const strewing *s, uint32_t triangle)
{
    const vv_mesh_info *m = &s->mesh->shown;
    vv_vec3 corner[3];
    double longest = 0;
    for (int k = 0; k < 3; k++) {
        const float *v = m->positions + 3 * (size_t)m->triangles[3 * (size_t)triangle + (size_t)k];
        corner[k] = vv_affine_point(s->to_world, vvi_vec((double)v[0], (double)v[1], (double)v[2]));
    }
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, vvi_length(vv_affine_vector(s->to_cell, vvi_sub(corner[(k + 1) % 3], corner[k]))));
    const int parts = (int)fmin(ceil(2 * longest), MOST_PARTS) + 1;
    for (int i = 0; i <= parts; i++)
        for (int j = 0; i + j <= parts; j++) {
            const double u = (double)i / parts, v = (double)j / parts;
            strew(s, triangle, corner, (double[3]){1 - u - v, u, v});
        }
}

vv_status vvi_raycast_add_meshes(float *cells, const vvi_light_grid *grid, const vvi_ray_meshes *meshes, vv_job *job)
{
    strewing s = {.grid = grid, .meshes = meshes};
    vv_status st = VV_OK;
    s.cells = cells;
    if (!vv_affine_invert(&s.to_cell, grid->cell_to_world))
        return vv_fail(VV_E_ARGUMENT, "light: the cells of its grid have no volume");
    s.side = cbrt(fabs(vv_affine_determinant(grid->cell_to_world)));
    for (size_t i = 0; i < meshes->n; i++) {
        s.mesh = &meshes->mesh[i];
        if (!vv_affine_invert(&s.to_world, s.mesh->to_mesh))
            continue;
        for (size_t t = 0; t < s.mesh->shown.n_triangles && st == VV_OK; t++) {
            strew_triangle(&s, (uint32_t)t);
            st = t % TRIANGLES_A_POLL ? VV_OK : vvi_job_poll(job);
        }
    }
    return st;
}
