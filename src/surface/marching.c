#include "surface/marching.h"
#include "core/cpu.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/mesh_normals.h"
#include "surface/marching_blocks.h"
#include "surface/marching_plan.h"

#include <math.h>
#include <string.h>

void vvi_march_turn_over(uint32_t *from, const uint32_t *to)
{
    for (; from < to; from += 3) {
        const uint32_t v = from[1];
        from[1] = from[2];
        from[2] = v;
    }
}

static bool read_as_it_lies(const vvi_march *m, const vvi_marching_options *o)
{
    static const vv_type types[VVI_MARCH_TYPES] = {VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_I16, VV_TYPE_F32};
    for (int t = 0; t < VVI_MARCH_TYPES; t++)
        if (types[t] == m->brick.type && m->brick.stride[0] == (int64_t)vv_type_bytes(types[t]) && !o->cap)
            return true;
    return false;
}

/* The least sample of the type that is not below `stored`, or, inverted, that is above. False: there is none, or all
 * are. */
static bool find_threshold(vvi_march *m)
{
    const double s = m->inverted ? nextafter(m->stored, INFINITY) : m->stored;
    const double least = ceil(s);
    switch (m->brick.type) {
#define INTEGER(vv_name, march_type, ctype)                                                                            \
    case vv_name: {                                                                                                    \
        const ctype t = (ctype)fmin(fmax(least, vvi_type_min(vv_name)), vvi_type_max(vv_name));                        \
        memcpy(m->threshold, &t, sizeof t);                                                                            \
        m->type = march_type;                                                                                          \
        return least > vvi_type_min(vv_name) && least <= vvi_type_max(vv_name);                                        \
    }
        INTEGER(VV_TYPE_U8, VVI_MARCH_U8, uint8_t)
        INTEGER(VV_TYPE_U16, VVI_MARCH_U16, uint16_t)
        INTEGER(VV_TYPE_I16, VVI_MARCH_I16, int16_t)
#undef INTEGER
    default: {
        float t = (float)s;
        if ((double)t < s)
            t = nextafterf(t, INFINITY);
        memcpy(m->threshold, &t, sizeof t);
        m->type = VVI_MARCH_F32;
        return isfinite(t);
    }
    }
}

/* Places count from the world place of the first sample, and with the cap from one before it. */
static vv_status make_frame(vvi_march *m, const vv_grid *grid)
{
    const vv_affine *to_world = &grid->index_to_world;
    const double voxel = vv_grid_voxel(grid), sign = m->inverted ? 1 : -1;
    vv_affine inverse;
    if (!vv_affine_invert(&inverse, *to_world))
        return vv_fail(VV_E_ARGUMENT, "the grid's axes lie in one plane: there is no surface");
    for (int i = 0; i < 3; i++) {
        float *row = m->frame.to_world[i];
        row[3] = 0;
        for (int a = 0; a < 3; a++) {
            row[a] = (float)(&to_world->axis[a].x)[i];
            row[3] -= (float)m->pad * row[a];
            m->frame.to_normal[i][a] = (float)(sign * voxel * (&inverse.axis[i].x)[a]);
        }
    }
    m->mirrored = vv_affine_determinant(*to_world) < 0;
    return VV_OK;
}

static vv_status prepare(vvi_march *m, const vv_field *field, const vvi_marching_options *o)
{
    const vv_field_info *info = vv_field_get_info(field);
    m->kernels = vvi_march_kernels_for(vvi_job_cpu(m->job));
    m->component = o->component;
    m->decided = o->topology == VVI_MARCHING_DECIDED;
    m->pad = o->cap;
    m->made = !read_as_it_lies(m, o);
    m->falls = info->value_scale < 0;
    m->inverted = m->falls && !m->made; /* made floats rise with the value */
    if (m->made) {
        const float zero = 0;
        memcpy(m->threshold, &zero, sizeof zero);
        m->type = VVI_MARCH_F32;
    }
    for (int a = 0; a < 3; a++)
        m->n[a] = m->grid.dims[a] + 2 * m->pad;
    m->words = (size_t)(m->n[0] + 63) / 64 + 1;
    return make_frame(m, &m->grid);
}

/* What the stored samples lie between: of floats the finite ones, of integers all that there are. */
static vv_status find_ends(vvi_march *m, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    vv_statistics s;
    m->ends[0] = m->ends[1] = 0;
    if (!m->made)
        return VV_OK;
    if (!vv_type_is_float(info->type)) {
        m->ends[0] = vvi_type_min(info->type);
        m->ends[1] = vvi_type_max(info->type);
        return VV_OK;
    }
    const vv_status st = vv_field_statistics(&s, field, m->component, m->job);
    if (st == VV_OK) {
        m->ends[0] = (s.min - info->value_offset) / info->value_scale;
        m->ends[1] = (s.max - info->value_offset) / info->value_scale;
    }
    return st;
}

/* Brings what is beyond the range of floats into it, and what is small enough not to be lost beside it; samples keep
 * what they have in most fields. */
static double find_unit(const vvi_march *m)
{
    enum { MOST = 30 };
    int exponent = 0;
    const double most = fmax(fabs(m->ends[0] - m->stored), fabs(m->ends[1] - m->stored));
    if (most > 0 && isfinite(most))
        (void)frexp(most, &exponent);
    return exponent > MOST || exponent < -MOST ? ldexp(1, exponent < -1000 ? 1000 : -exponent) : 1;
}

static bool has_cells(const vvi_march *m)
{
    return m->n[0] > 1 && m->n[1] > 1 && m->n[2] > 1;
}

/* Of an opened march: the value that is searched for. */
static void aim(vvi_march *m, const vv_field_info *info, double value)
{
    m->stored = (value - info->value_offset) / info->value_scale;
    m->unit = find_unit(m);
    m->frame.iso = m->made ? 0 : (float)m->stored;
    m->some = has_cells(m) && (m->made || find_threshold(m));
}

static vv_status check_value(double value)
{
    return isfinite(value) ? VV_OK : vv_fail(VV_E_ARGUMENT, "a surface needs a finite value; this is %g", value);
}

static vv_status check(const vv_field *field, const vvi_marching_options *o)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_status st = check_value(o->value);
    if (st != VV_OK)
        return st;
    if (o->component < 0 || o->component >= info->components)
        return vv_fail(VV_E_ARGUMENT, "channel %d does not exist; there are 0 to %d", o->component,
                       info->components - 1);
    if (info->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "labels are names, with no values in between: choose one of them");
    return VV_OK;
}

/* Counts become those of all items before, of values before too. */
static vvi_march_count sum_counts(vvi_marches *all)
{
    vvi_march_count before = {0, 0, 0};
    for (size_t v = 0; v < all->n; v++) {
        vvi_march *m = &all->march[v];
        for (size_t i = 0; i <= m->n_items; i++) {
            const vvi_march_count here = m->count[i];
            m->count[i] = before;
            before.vertices += here.vertices;
            before.triangles += here.triangles;
            before.unknown += here.unknown;
        }
    }
    return before;
}

/* The same for each value that was looked for. */
static size_t unknown_samples(const vvi_marches *all)
{
    size_t most = 0;
    for (size_t v = 0; v < all->n; v++) {
        const vvi_march *m = &all->march[v];
        const size_t here = m->count[m->n_items].unknown - m->count->unknown;
        most = here > most ? here : most;
    }
    return most;
}

vv_status vvi_march_new_mesh(vv_mesh **out, vvi_march *m, vvi_march_count count, size_t n_parts, bool normals)
{
    vv_mesh_info mesh = {.n_vertices = count.vertices,
                         .n_triangles = count.triangles,
                         .n_parts = n_parts,
                         .origin = m->grid.index_to_world.origin,
                         .space = m->grid.space};
    memcpy(mesh.unit, m->grid.unit, sizeof mesh.unit);
    const vv_status st = vvi_mesh_new(out, &m->arrays, &mesh, normals ? VVI_MESH_NORMALS : 0, m->job);
    m->frame.position = m->arrays.positions;
    m->frame.normal = m->arrays.normals;
    return st;
}

/* What the min-max blocks of a field say of its rows, where they are wanted and can say it. */
static vv_status ask_blocks(vvi_march *m, const vv_field *field, const vvi_marching_options *o)
{
    enum { SHIFT = 3 };
    vvi_cached *minmax = NULL;
    if (!o->blocks || m->made || o->box.n[0] || !m->some)
        return VV_OK;
    const vvi_cache_key key = vvi_minmax_key("minmax", field, o->component, SHIFT);
    vv_status st = vvi_minmax_get(&minmax, &key, &m->brick, o->component, SHIFT, m->job);
    if (st == VV_OK)
        st = vvi_march_blocks(m, vvi_cached_value(minmax));
    vvi_cache_release(minmax);
    return st;
}

vv_status vvi_march_open(vvi_march *m, const vv_field *field, const vvi_marching_options *o, vv_job *job)
{
    const vv_box box = o->box.n[0] ? o->box : vv_field_box(field);
    *m = (vvi_march){.job = job};
    vv_status st = check(field, o);
    if (st == VV_OK)
        st = vv_field_brick(&m->brick, field, &box, job);
    if (st != VV_OK)
        return st;
    m->grid = vv_grid_crop(&vv_field_get_info(field)->grid, &box);
    if ((st = prepare(m, field, o)) == VV_OK && (st = find_ends(m, field)) == VV_OK)
        aim(m, vv_field_get_info(field), o->value);
    return st;
}

/* One value ------------------------------------------------------------------------------------------------------- */

static vv_status make_room(vvi_march *m)
{
    const size_t rows = (size_t)(m->n[1] * m->n[2]);
    m->n_items = m->n[2] > 1 ? (size_t)(m->n[2] - 2) / VVI_MARCH_LAYERS + 1 : 0;
    m->count = vvi_alloc_zeroed(m->job, (m->n_items + 1) * sizeof *m->count, VVI_MEM_SCRATCH);
    m->interior = vvi_alloc_zeroed(m->job, (size_t)m->n[2] * sizeof *m->interior, VVI_MEM_SCRATCH);
    m->span = vvi_alloc(m->job, rows * sizeof *m->span, VVI_MEM_SCRATCH);
    m->rows = vvi_alloc(m->job, rows * sizeof *m->rows, VVI_MEM_SCRATCH);
    m->passes = vvi_alloc(m->job, rows * sizeof *m->passes, VVI_MEM_SCRATCH);
    return m->count && m->interior && m->span && m->rows && m->passes ? VV_OK : vv_fail_memory(rows * sizeof *m->rows);
}

static void free_room(vvi_march *m)
{
    vvi_free(m->count);
    vvi_free(m->interior);
    vvi_free(m->span);
    vvi_free(m->rows);
    vvi_free(m->passes);
    vvi_free(m->blocks);
}

/* All of them --------------------------------------------------------------------------------------------------- */

static void name_part(vv_mesh_part *part, const vvi_march *m, double value)
{
    const vvi_march_count *last = &m->count[m->n_items];
    vvi_print_number(part->name, value);
    part->first_triangle = m->count->triangles;
    part->n_triangles = last->triangles - part->first_triangle;
}

static vv_status fill(vv_mesh **out, vvi_marches *all, vvi_march_count count, const double *names, bool normals)
{
    vvi_march *first = all->march;
    vv_status st = vvi_march_new_mesh(out, first, count, names ? all->n : 0, normals);
    for (size_t v = 0; v < all->n && st == VV_OK; v++) {
        vvi_march *m = &all->march[v];
        m->arrays = first->arrays;
        m->frame.position = first->frame.position;
        m->frame.normal = first->frame.normal;
        if (names)
            name_part(&first->arrays.parts[v], m, names[v]);
    }
    if (st == VV_OK)
        st = vvi_march_fill_all(all);
    for (size_t v = 0; v < all->n && st == VV_OK; v++)
        if (normals && atomic_load_explicit(&all->march[v].missing, memory_order_relaxed))
            st = vvi_normals_fill(first->arrays.normals, *out, first->job);
    return st;
}

static vv_status march(vv_mesh **out, vvi_marches *all, const double *names, bool normals)
{
    vv_job *job = all->march->job;
    vv_status st = vvi_march_count_all(all);
    if (st != VV_OK)
        return st;
    const vvi_march_count count = sum_counts(all);
    const size_t unknown = unknown_samples(all);
    if (unknown)
        vvi_log(job, VV_LOG_WARNING, "surface", "%zu samples are not numbers: the cells around them are left out",
                unknown);
    return fill(out, all, count, names, normals);
}

/* names: the values, where each gives a part; NULL: one surface without parts. */
static vv_status march_values(vv_mesh **out, const vv_field *field, const double *values, const double *names, size_t n,
                              const vvi_marching_options *options, vv_job *job)
{
    vvi_marching_options o = *options;
    vvi_marches all = {.n = n};
    o.value = values[0];
    vvi_march *m = all.march = vvi_alloc_zeroed(job, n * sizeof *m, VVI_MEM_SCRATCH);
    if (!m)
        return vv_fail_memory(n * sizeof *m);
    vv_status st = vvi_march_open(m, field, &o, job);
    for (size_t v = 1; v < n && st == VV_OK; v++) {
        m[v] = m[0];
        aim(&m[v], vv_field_get_info(field), values[v]);
        st = check_value(values[v]);
    }
    for (size_t v = 0; v < n && st == VV_OK; v++)
        if ((st = make_room(&m[v])) == VV_OK)
            st = ask_blocks(&m[v], field, &o);
    if (st == VV_OK)
        st = march(out, &all, names, !o.no_normals);
    for (size_t v = 0; v < n; v++)
        free_room(&m[v]);
    vv_brick_release(&m->brick);
    vvi_free(m);
    return st == VV_OK ? vv_field_health(field) : st;
}

static vv_status release_failed(vv_mesh **out, vv_status st)
{
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vvi_marching_cubes(vv_mesh **out, const vv_field *field, const vvi_marching_options *options, vv_job *job)
{
    *out = NULL;
    return release_failed(out, march_values(out, field, &options->value, NULL, 1, options, job));
}

vv_status vvi_marching_values(vv_mesh **out, const vv_field *field, const double *values, size_t n,
                              const vvi_marching_options *options, vv_job *job)
{
    *out = NULL;
    if (n == 0)
        return vv_fail(VV_E_ARGUMENT, "a surface needs a value; none was given");
    return release_failed(out, march_values(out, field, values, values, n, options, job));
}
