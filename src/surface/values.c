#include "surface/values.h"
#include "core/job.h"
#include "grid/mesh.h"
#include "grid/probe.h"

#include <math.h>
#include <string.h>

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
    const vv_vec3 world = {s->mesh->origin.x + (double)v[0], s->mesh->origin.y + (double)v[1],
                           s->mesh->origin.z + (double)v[2]};
    const vv_vec3 p = vv_affine_point(s->to_index, world);
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

static vv_status check(const vv_mesh *mesh, const vv_field *field, int component)
{
    const vv_field_info *info = vv_field_get_info(field);
    const char *unit = vv_mesh_get_info(mesh)->unit;
    if (component < 0 || component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; there are 0 to %d", component, info->components - 1);
    if (strcmp(unit, info->grid.unit) != 0)
        return vv_fail(VV_E_ARGUMENT, "the surface is in %s and the field in %s: give both the same unit", unit,
                       info->grid.unit);
    return VV_OK;
}

static void tell_outside(const sampling *s, const char *name, const vv_job *job)
{
    size_t n = 0;
    for (size_t i = 0; i < s->mesh->n_vertices; i++)
        n += !isfinite(s->values[i]);
    if (n)
        vvi_log(job, VV_LOG_WARNING, "isosurface",
                "%zu of %zu vertices lie outside the samples of %s: their value is NaN", n, s->mesh->n_vertices, name);
}

vv_status vvi_mesh_sample(vv_mesh *mesh, const vv_field *field, int component, vv_job *job)
{
    static const vvi_work work = {.stage = "values", .item = sample_chunk};
    const vv_field_info *info = vv_field_get_info(field);
    sampling s = {.mesh = vv_mesh_get_info(mesh)};
    vv_status st = check(mesh, field, component);
    if (st == VV_OK && !vv_affine_invert(&s.to_index, info->grid.index_to_world))
        st = vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: it has no values at vertices");
    if (st != VV_OK ||
        (st = vvi_probe_open(&s.probe, field, component, info->meaning == VV_MEANING_LABEL, job)) != VV_OK)
        return st;
    st = vvi_mesh_add_values(&s.values, mesh, *info->name ? info->name : "value", info->value_unit, job);
    if (st == VV_OK)
        st = vvi_parallel_for(job, &work, &s, (s.mesh->n_vertices + CHUNK - 1) / CHUNK);
    vvi_probe_close(&s.probe);
    if (st == VV_OK)
        tell_outside(&s, *info->name ? info->name : "the second volume", job);
    return st == VV_OK ? vv_field_health(field) : st;
}
