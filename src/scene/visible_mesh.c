/* Vertices that follow one another mostly lie together: of a block whose box lies farther out nowhere none is looked
 * at.
 */
#include "scene/visible_mesh.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include <math.h>
#include <string.h>

enum { BLOCK = 64, OFTEN = 1 << 10 };

typedef struct extremes {
    vv_vec3 slope[VVI_SHAPE_POINTS]; /* of the way along each direction, in the mesh's space */
    double along[VVI_SHAPE_POINTS];
    vv_vec3 point[VVI_SHAPE_POINTS]; /* there, from its origin */
} extremes;

static void begin(extremes *e, const vv_affine *place)
{
    int n = 0;
    for (int d = 0; d < 729; d++) {
        const int x = d % 9 - 4, y = d / 9 % 9 - 4, z = d / 81 - 4;
        const bool inside = x > -4 && x < 4 && y > -4 && y < 4 && z > -4 && z < 4;
        const vv_vec3 direction = vvi_vec(x, y, z), *axis = place->axis;
        if (inside)
            continue;
        e->slope[n] = vvi_vec(vvi_dot(axis[0], direction), vvi_dot(axis[1], direction), vvi_dot(axis[2], direction));
        e->point[n] = vvi_vec(0, 0, 0);
        e->along[n++] = -INFINITY;
    }
}

static vv_vec3 vertex_at(const vv_mesh_info *m, size_t v)
{
    const float *p = m->positions + 3 * v;
    return vvi_vec((double)p[0], (double)p[1], (double)p[2]);
}

static void add_vertex(extremes *e, int direction, vv_vec3 p)
{
    const double along = vvi_dot(e->slope[direction], p);
    if (!(along > e->along[direction]) || !isfinite(along))
        return;
    e->along[direction] = along;
    e->point[direction] = p;
}

static void add_block(extremes *e, const vv_mesh_info *m, const uint8_t *used, size_t first, size_t end)
{
    vv_vec3 lo = {INFINITY, INFINITY, INFINITY}, hi = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t v = first; v < end; v++) {
        const vv_vec3 p = vertex_at(m, v);
        if (!used[v])
            continue;
        lo = vvi_vec(fmin(lo.x, p.x), fmin(lo.y, p.y), fmin(lo.z, p.z));
        hi = vvi_vec(fmax(hi.x, p.x), fmax(hi.y, p.y), fmax(hi.z, p.z));
    }
    for (int d = 0; d < VVI_SHAPE_POINTS && lo.x <= hi.x; d++) {
        const vv_vec3 s = e->slope[d];
        const vv_vec3 far = vvi_vec(s.x > 0 ? hi.x : lo.x, s.y > 0 ? hi.y : lo.y, s.z > 0 ? hi.z : lo.z);
        for (size_t v = first; v < end && vvi_dot(s, far) > e->along[d]; v++)
            if (used[v])
                add_vertex(e, d, vertex_at(m, v));
    }
}

static vv_status look(extremes *e, const vv_mesh_info *m, vv_job *job)
{
    uint8_t *used = vvi_alloc_zeroed(job, m->n_vertices + 1, VVI_MEM_SCRATCH);
    vv_status st = used ? VV_OK : vv_fail_memory(m->n_vertices + 1);
    for (size_t k = 0; used && k < 3 * m->n_triangles; k++)
        used[m->triangles[k]] = 1;
    for (size_t v = 0; v < m->n_vertices && st == VV_OK; v += BLOCK) {
        add_block(e, m, used, v, v + BLOCK < m->n_vertices ? v + BLOCK : m->n_vertices);
        if (v % (BLOCK * OFTEN) == 0)
            st = vvi_job_poll(job);
    }
    vvi_free(used);
    return st;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vv_mesh_actor *shape = user;
    const vv_mesh_info *m = vv_mesh_get_info(shape->mesh);
    extremes *e = vvi_alloc(job, sizeof *e, VVI_MEM_DERIVED);
    if (!e)
        return vv_fail_memory(sizeof *e);
    begin(e, &shape->place);
    const vv_status st = look(e, m, job);
    for (int d = 0; d < VVI_SHAPE_POINTS && st == VV_OK; d++)
        e->point[d] = vv_affine_point(shape->place, vvi_add(m->origin, e->point[d]));
    *value_out = e;
    *bytes_out = sizeof *e;
    if (st == VV_OK)
        return VV_OK;
    vvi_free(e);
    return st;
}

vv_status vvi_visible_mesh_points(vv_vec3 out[VVI_SHAPE_POINTS], const vv_mesh_actor *shape, vv_job *job)
{
    vvi_cached *cached;
    const uint64_t where = vvi_hash(&shape->place, sizeof shape->place, vv_mesh_checksum(shape->mesh));
    const vvi_cache_key key = {"visible mesh", 0, where};
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, (void *)shape, job);
    if (st != VV_OK)
        return st;
    memcpy(out, ((const extremes *)vvi_cached_value(cached))->point, VVI_SHAPE_POINTS * sizeof *out);
    vvi_cache_release(cached);
    return VV_OK;
}
