/* The data kind of regular grids: trilinear inside cells between samples; labels fill boxes around their samples.
 *
 * segments() is the definition that faster traversals are tested against: double precision, cell by cell
 * (Amanatides & Woo 1987), nothing clever. */
#include "grid/field.h"
#include "registry.h"

#include <math.h>

typedef struct walk {
    const vv_field *field;
    int component;
    bool nearest;
    int64_t n_cells[3];
    double shift;      /* of cell faces against whole indices: 0, or -0.5 for boxes around samples */
    double o[3], d[3]; /* the ray in index space; d is not of length 1, so that t stays a world length */
    double t0, t1;
    int64_t cell[3];
} walk;

static bool accepts(const vv_field_info *info)
{
    for (int a = 0; a < 3; a++)
        if (info->grid.dims[a] < 1)
            return false;
    return info->components >= 1;
}

static void domain(double lo[3], double hi[3], const vv_field_info *info)
{
    const double margin = info->meaning == VV_MEANING_LABEL ? 0.5 : 0;
    for (int a = 0; a < 3; a++) {
        lo[a] = -margin;
        hi[a] = (double)(info->grid.dims[a] - 1) + margin;
    }
}

static vv_bounds bounds(const vv_field_info *info)
{
    double lo[3], hi[3];
    domain(lo, hi, info);
    return vvi_grid_box_bounds(&info->grid, lo, hi);
}

/* The part of the ray inside the domain; a ray along a face has d == 0 there and is judged by its origin, since
 * 0 * infinity would be NaN. */
static bool clip(walk *w, const double lo[3], const double hi[3])
{
    for (int a = 0; a < 3; a++) {
        if (w->d[a] == 0) {
            if (w->o[a] < lo[a] || w->o[a] > hi[a])
                return false;
            continue;
        }
        const double u = (lo[a] - w->o[a]) / w->d[a], v = (hi[a] - w->o[a]) / w->d[a];
        w->t0 = fmax(w->t0, fmin(u, v));
        w->t1 = fmin(w->t1, fmax(u, v));
    }
    return w->t0 < w->t1;
}

/* Where the ray leaves the present cell through a face of axis a; INFINITY when it does not. */
static double leave(const walk *w, int a)
{
    if (w->d[a] == 0)
        return INFINITY;
    const double face = (double)(w->cell[a] + (w->d[a] > 0)) + w->shift;
    return (face - w->o[a]) / w->d[a];
}

static bool at_last_cell(const walk *w, int a)
{
    return w->d[a] > 0 ? w->cell[a] >= w->n_cells[a] - 1 : w->cell[a] <= 0;
}

/* The cell at t0. On a face it is the one that the ray goes into. */
static void enter(walk *w)
{
    for (int a = 0; a < 3; a++) {
        const double p = w->o[a] + w->t0 * w->d[a] - w->shift;
        const double most = (double)(w->n_cells[a] - 1);
        w->cell[a] = (int64_t)fmin(fmax(floor(p), 0), most);
        while (!at_last_cell(w, a) && leave(w, a) <= w->t0)
            w->cell[a] += w->d[a] > 0 ? 1 : -1;
    }
}

/* Ends weigh exactly 1 and the other side nothing: a NaN beyond a sample that is hit does not reach it. */
static double mix(double a, double b, double f)
{
    return f == 0 ? a : f == 1 ? b : a * (1 - f) + b * f;
}

static double value_at(const walk *w, double t)
{
    const int64_t *c = w->cell;
    if (w->nearest)
        return vv_field_value(w->field, c[0], c[1], c[2], w->component);
    double f[3];
    for (int a = 0; a < 3; a++)
        f[a] = fmin(fmax(w->o[a] + t * w->d[a] - (double)c[a], 0), 1);
    double row[4];
    for (int r = 0; r < 4; r++) {
        const int64_t j = c[1] + (r & 1), k = c[2] + (r >> 1);
        row[r] = mix(vv_field_value(w->field, c[0], j, k, w->component),
                     vv_field_value(w->field, c[0] + 1, j, k, w->component), f[0]);
    }
    return mix(mix(row[0], row[1], f[1]), mix(row[2], row[3], f[1]), f[2]);
}

static bool begin(walk *w, vv_vec3 origin, vv_vec3 direction)
{
    const vv_field_info *info = vv_field_get_info(w->field);
    vv_affine world_to_index;
    if (!vv_affine_invert(&world_to_index, info->grid.index_to_world))
        return false;
    const vv_vec3 o = vv_affine_point(world_to_index, origin), d = vv_affine_vector(world_to_index, direction);
    const double o3[3] = {o.x, o.y, o.z}, d3[3] = {d.x, d.y, d.z};
    double lo[3], hi[3];
    domain(lo, hi, info);
    w->nearest = info->meaning == VV_MEANING_LABEL;
    w->shift = w->nearest ? -0.5 : 0;
    for (int a = 0; a < 3; a++) {
        const int64_t n = info->grid.dims[a];
        w->o[a] = o3[a];
        w->d[a] = d3[a];
        w->n_cells[a] = w->nearest || n == 1 ? n : n - 1;
    }
    return clip(w, lo, hi);
}

static size_t segments(vv_segment *out, size_t max, const vv_field *field, int component, vv_vec3 origin,
                       vv_vec3 direction, double t_min, double t_max)
{
    walk w = {.field = field, .component = component, .t0 = t_min, .t1 = t_max};
    size_t n = 0;
    if (!begin(&w, origin, direction))
        return 0;
    enter(&w);
    for (double t = w.t0; t < w.t1;) {
        int axis = -1;
        double t_next = w.t1;
        for (int a = 0; a < 3; a++)
            if (!at_last_cell(&w, a) && leave(&w, a) < t_next) {
                t_next = leave(&w, a);
                axis = a;
            }
        /* Through an edge or a corner: a cell of length 0 is passed without a segment. */
        if (t_next > t) {
            if (n < max)
                out[n] = (vv_segment){t, t_next, (float)value_at(&w, t), (float)value_at(&w, t_next)};
            n++;
            t = t_next;
        }
        if (axis < 0)
            break;
        w.cell[axis] += w.d[axis] > 0 ? 1 : -1;
    }
    return n;
}

const vv_data_kind vvi_data_kind_regular = {
    .api = VV_DATA_KIND_API,
    .name = "regular",
    .doc = "samples on a regular grid: trilinear between them, boxes around labels",
    .accepts = accepts,
    .bounds = bounds,
    .segments = segments,
};
