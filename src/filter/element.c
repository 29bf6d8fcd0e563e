#include "filter/element.h"
#include "core/memory.h"
#include "core/status.h"
#include "core/vec.h"

#include <math.h>

#define BOX_MOST 1000 /* voxels to each side */
#define OTHERS_MOST 100
#define NEARLY 1e-9 /* of a squared distance: what is as far away as the radius is in it, however it was rounded */

const char *const vvi_element_shape_names[] = {"ball", "box", "cross", NULL};

enum { ROW_RADIUS, ROW_RADIUS_VOXELS };

/* How far away an offset is, as a share of the radius, squared: offset' m offset. */
typedef struct measure {
    double m[3][3];
} measure;

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

/* A ball of a length is one in the world, however the grid lies in it; of voxels an ellipsoid of the axes. */
static measure measure_of(const vv_field_info *info, const vv_object *params, const double voxels[3])
{
    const vvi_window_params *p = (const vvi_window_params *)params;
    const vv_vec3 *axis = info->grid.index_to_world.axis;
    const bool none = p->radius < 1e-6 * vv_grid_voxel(&info->grid);
    measure out = {{{0}}};
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            if (is_set(params, ROW_RADIUS))
                out.m[a][b] = none ? 4 * (a == b) : vvi_dot(axis[a], axis[b]) / (p->radius * p->radius);
            else if (a == b)
                out.m[a][b] = voxels[a] > 0 ? 1 / (voxels[a] * voxels[a]) : 4;
    return out;
}

static double away(const measure *d, int64_t i, int64_t j, int64_t k)
{
    const double o[3] = {(double)i, (double)j, (double)k};
    double sum = 0;
    for (int a = 0; a < 3; a++)
        for (int b = 0; b < 3; b++)
            sum += d->m[a][b] * o[a] * o[b];
    return sum;
}

/* How far the ellipsoid reaches along each axis: the root of the diagonal of the inverse. */
static void reach_of(double reach[3], const measure *d)
{
    const double(*m)[3] = d->m;
    const double c0 = m[1][1] * m[2][2] - m[1][2] * m[2][1], c1 = m[1][2] * m[2][0] - m[1][0] * m[2][2];
    const double c2 = m[1][0] * m[2][1] - m[1][1] * m[2][0];
    const double det = m[0][0] * c0 + m[0][1] * c1 + m[0][2] * c2;
    reach[0] = sqrt(c0 / det);
    reach[1] = sqrt((m[0][0] * m[2][2] - m[0][2] * m[2][0]) / det);
    reach[2] = sqrt((m[0][0] * m[1][1] - m[0][1] * m[1][0]) / det);
}

static vv_status radius_of(vvi_element *e, measure *d, const vv_field_info *info, const vv_object *params,
                           const char *name)
{
    const vvi_window_params *p = (const vvi_window_params *)params;
    const int shape = ((const vvi_element_params *)params)->shape;
    const double given[3] = {p->radius_voxels.x, p->radius_voxels.y, p->radius_voxels.z};
    const double most = shape == VVI_ELEMENT_BOX ? BOX_MOST : OTHERS_MOST;
    const vv_status st = vvi_window_check(params, NULL);
    double voxels[3], reach[3];
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        voxels[a] = is_set(params, ROW_RADIUS_VOXELS) ? given[a]
                    : is_set(params, ROW_RADIUS)      ? floor(p->radius / vv_grid_spacing(&info->grid, a) + 0.5)
                                                      : 1;
    *d = measure_of(info, params, voxels);
    reach_of(reach, d);
    for (int a = 0; a < 3; a++) {
        const double last = (double)(info->grid.dims[a] - 1);
        const double whole = shape == VVI_ELEMENT_BALL ? floor(reach[a] * (1 + NEARLY)) : voxels[a];
        const double r = whole < last ? whole : last;
        if (!(r <= most))
            return vv_fail(VV_E_ARGUMENT, "%s: a %s of %g voxels to each side along %c is too large; it may have %g",
                           name, vvi_element_shape_names[shape], r, "xyz"[a], most);
        e->radius[a] = (int64_t)r;
    }
    e->box = shape == VVI_ELEMENT_BOX;
    return VV_OK;
}

vv_status vvi_element_check(const vv_field_info *info, const vv_object *params, const char *name)
{
    vvi_element e = {.box = false};
    measure d;
    return radius_of(&e, &d, info, params, name);
}

static bool is_inside(const vvi_element_params *p, const measure *d, int64_t i, int64_t j, int64_t k)
{
    if (p->shape == VVI_ELEMENT_CROSS)
        return (i != 0) + (j != 0) + (k != 0) <= 1;
    return away(d, i, j, k) <= 1 + NEARLY;
}

static void add_chords(vvi_element *e, const vvi_element_params *p, const measure *d)
{
    const int64_t *r = e->radius;
    for (int64_t z = -r[2]; z <= r[2]; z++)
        for (int64_t y = -r[1]; y <= r[1]; y++) {
            vvi_chord chord = {.y = y, .z = z};
            for (int64_t x = -r[0]; x <= r[0]; x++)
                if (is_inside(p, d, x, y, z)) {
                    if (chord.length == 0)
                        chord.lo = x;
                    chord.length++;
                }
            if (chord.length > 0)
                e->chords[e->n_chords++] = chord;
        }
}

/* Lengths that occur, and those that are needed to come to them by doubling. */
static void add_lengths(vvi_element *e)
{
    e->lengths[e->n_lengths++] = 1;
    for (bool more = true; more;) {
        int64_t next = INT64_MAX;
        const int64_t last = e->lengths[e->n_lengths - 1];
        for (size_t c = 0; c < e->n_chords; c++)
            if (e->chords[c].length > last && e->chords[c].length < next)
                next = e->chords[c].length;
        more = next < INT64_MAX;
        if (more)
            e->lengths[e->n_lengths++] = next > 2 * last ? 2 * last : next;
    }
    for (size_t c = 0; c < e->n_chords; c++)
        while (e->lengths[e->chords[c].table] < e->chords[c].length)
            e->chords[c].table++;
}

vv_status vvi_element_init(vvi_element *out, const vv_field_info *info, const vv_object *params, const char *name,
                           vv_job *job)
{
    measure d;
    *out = (vvi_element){.box = false};
    const vv_status st = radius_of(out, &d, info, params, name);
    if (st != VV_OK || out->box)
        return st;
    const size_t chords = (size_t)((2 * out->radius[1] + 1) * (2 * out->radius[2] + 1)) * sizeof *out->chords;
    const size_t lengths = (size_t)(2 * out->radius[0] + 2) * sizeof *out->lengths;
    out->chords = vvi_alloc(job, chords, VVI_MEM_SCRATCH);
    out->lengths = vvi_alloc(job, lengths, VVI_MEM_SCRATCH);
    if (!out->chords || !out->lengths) {
        vvi_element_finish(out);
        return vv_fail_memory(chords + lengths);
    }
    add_chords(out, (const vvi_element_params *)params, &d);
    add_lengths(out);
    return VV_OK;
}

void vvi_element_finish(vvi_element *element)
{
    vvi_free(element->chords);
    vvi_free(element->lengths);
    *element = (vvi_element){.box = false};
}

vvi_element vvi_element_along(const vvi_element *box, int axis)
{
    vvi_element line = {.box = true};
    line.radius[axis] = box->radius[axis];
    return line;
}
