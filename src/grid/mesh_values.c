/* What a field has at the vertices of a mesh. */
#include "core/job.h"
#include "grid/mesh.h"
#include "grid/probe.h"

#include <math.h>

enum { CHUNK = 4096 };

typedef struct sampling {
    const vv_mesh_info *mesh;
    vvi_probe probe;
    vv_affine to_index;
    float *values;
} sampling;

static double value_at(const sampling *s, size_t vertex)
{
    const float *v = s->mesh->positions + 3 * vertex;
    const vv_vec3 place = {s->mesh->origin.x + (double)v[0], s->mesh->origin.y + (double)v[1],
                           s->mesh->origin.z + (double)v[2]};
    const vv_vec3 p = vv_affine_point(s->to_index, place);
    const double at[3] = {p.x, p.y, p.z};
    for (int a = 0; a < 3; a++)
        if (!(at[a] >= -0.5 && at[a] <= (double)s->probe.dims[a] - 0.5))
            return NAN;
    return vvi_probe_value(&s->probe, at);
}

/* Item: some vertices. */
static vv_status sample_chunk(void *scratch, void *user, size_t item)
{
    const sampling *s = user;
    const size_t begin = item * CHUNK, n = s->mesh->n_vertices, end = begin + CHUNK < n ? begin + CHUNK : n;
    (void)scratch;
    for (size_t v = begin; v < end; v++)
        s->values[v] = (float)value_at(s, v);
    return VV_OK;
}

vv_status vvi_mesh_values_of(float *out, const vv_mesh_info *mesh, const vv_affine *to_index, const vv_field *field,
                             int component, bool nearest, vv_job *job)
{
    static const vvi_work work = {.stage = "values", .item = sample_chunk};
    sampling s = {.mesh = mesh, .to_index = *to_index};
    s.values = out;
    vv_status st = vvi_probe_open(&s.probe, field, component, nearest, job);
    if (st != VV_OK)
        return st;
    st = vvi_parallel_for(job, &work, &s, (mesh->n_vertices + CHUNK - 1) / CHUNK);
    vvi_probe_close(&s.probe);
    return st;
}
