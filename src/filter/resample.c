/* Resample: another spacing, the same place; or the grid of another volume. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "filter/amounts.h"
#include "filter/resample_onto.h"
#include "filter/resample_weights.h"
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 16)
/* Of one worker: where it takes more, rows are summed again for each row that they are for. */
#define RING_BYTES ((size_t)4 << 20)

typedef struct resample_params {
    vv_object object;
    char *spacing;
    vv_numbers *dims;
    int interpolation;
    double fill;
} resample_params;

enum { ROW_SPACING, ROW_DIMS, ROW_INTERPOLATION, ROW_FILL };

static const char *const interpolation_names[] = {"linear", "nearest", "cubic", "lanczos", NULL};

static const vv_property properties[] = {
    [ROW_SPACING] = {VV_PROP(resample_params, spacing), .kind = VV_KIND_STRING,
                     .automatic = "the smallest of the three, for cubic voxels; with onto, its",
                     .doc = "distance between the new samples: one length, 1mm, 2vox, or three, 1mm,1mm,2.5mm"},
    [ROW_DIMS] = {VV_PROP(resample_params, dims), .kind = VV_KIND_NUMBERS, .columns = 1, .unit = "samples",
                  .automatic = "from spacing", .option = "size",
                  .doc = "instead of spacing: number of samples along x, y, z, in the same extent"},
    [ROW_INTERPOLATION] =
        {VV_PROP(resample_params, interpolation), .kind = VV_KIND_ENUM, .names = interpolation_names,
         .automatic = "linear; nearest for labels",
         .doc = "between samples; where the number of samples is reduced, all but nearest average over the extent of "
                "each new one; lanczos (three lobes) is the sharpest, and may overshoot at edges; cubic and lanczos "
                "continue slopes up to the outermost samples, beyond which all hold the last value"},
    [ROW_FILL] = {VV_PROP(resample_params, fill), .kind = VV_KIND_F64, .unit = "value",
                  .automatic = "0; NaN for floating-point types",
                  .doc = "with onto: value of samples that lie outside the volume, by more than half a voxel"},
    {0},
};

static bool is_set(const vv_object *object, int row)
{
    return object->set >> row & 1;
}

static const vv_class resample_class = {
    .name = "resample",
    .doc = "parameters of resample",
    .size = sizeof(resample_params),
    .properties = properties,
};

/* New samples along the axes, and where they lie: old index = start + new * step. */
typedef struct grid_map {
    int64_t n[3];
    double start[3], step[3];
    const vv_grid *onto; /* NULL: the map is that of spacing or dims */
    vv_affine any;       /* with onto: old index of a new one */
    bool straight;       /* start and step say the same */
} grid_map;

static vv_status one_spacing(double *out, const char *text, size_t n, const vv_grid *grid, int axis)
{
    char word[64];
    const vv_property_context context = {.length_unit = grid->unit, .voxel = vv_grid_spacing(grid, axis)};
    if (n == 0 || n >= sizeof word)
        return vv_fail(VV_E_ARGUMENT, "resample: spacing is one length or three, as in 1mm or 1mm,1mm,2.5mm");
    memcpy(word, text, n);
    word[n] = 0;
    const vv_status st = vvi_parse_quantity(out, word, VV_Q_LENGTH, &context, "resample spacing");
    if (st == VV_OK && !(*out > 0 && isfinite(*out)))
        return vv_fail(VV_E_ARGUMENT, "resample: spacing '%s' is not above 0", word);
    return st;
}

static vv_status parse_spacing(double out[3], const char *text, const vv_grid *grid)
{
    vv_status st = VV_OK;
    if (!text || !*text) {
        for (int a = 0; a < 3; a++)
            out[a] = vv_grid_voxel(grid);
        return VV_OK;
    }
    const bool three = strchr(text, ',') != NULL;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const size_t n = strcspn(text, ",");
        if ((st = one_spacing(&out[a], text, n, grid, a)) != VV_OK || !three)
            continue;
        text += n;
        if ((*text == ',') != (a < 2))
            return vv_fail(VV_E_ARGUMENT, "resample: spacing is one length or three, as in 1mm or 1mm,1mm,2.5mm");
        text += *text == ',';
    }
    return st;
}

static vv_status map_axis(grid_map *out, int axis, double n_new, double step, int64_t n_old)
{
    if (!(n_new <= 1 << 20))
        return vv_fail(VV_E_LIMIT,
                       "resample: %g samples along %c are more than the %d that a result may have; give a larger "
                       "spacing or fewer samples",
                       n_new, "xyz"[axis], 1 << 20);
    out->n[axis] = n_new < 1 ? 1 : (int64_t)n_new;
    out->step[axis] = step;
    out->start[axis] = 0.5 * (double)(n_old - 1) - 0.5 * (double)(out->n[axis] - 1) * step; /* the middle stays */
    return VV_OK;
}

static vv_status find_map_onto(grid_map *out, const vv_grid *grid, const vv_grid *onto, const vv_object *params)
{
    if (is_set(params, ROW_SPACING) || is_set(params, ROW_DIMS))
        return vv_fail(VV_E_ARGUMENT, "resample: onto says where the samples lie; omit `spacing` and `size`");
    const vv_status st = vvi_onto_map(&out->any, grid, onto);
    if (st != VV_OK)
        return st;
    out->straight = vvi_onto_is_straight(&out->any, onto->dims);
    out->onto = onto;
    for (int a = 0; a < 3; a++) {
        out->n[a] = onto->dims[a];
        out->start[a] = (&out->any.origin.x)[a];
        out->step[a] = (&out->any.axis[a].x)[a];
    }
    return VV_OK;
}

static vv_status find_map(grid_map *out, const vv_field_info *info, const vv_object *params)
{
    const resample_params *p = (const resample_params *)params;
    const bool by_dims = p->dims && p->dims->n;
    double spacing[3];
    vv_status st;
    *out = (grid_map){.straight = true};
    if (is_set(params, ROW_FILL))
        return vv_fail(VV_E_ARGUMENT, "resample: `fill` does nothing without onto=FILE, as no sample lies outside");
    if (by_dims && is_set(params, ROW_SPACING))
        return vv_fail(VV_E_ARGUMENT, "resample: `spacing` and `size` set the same thing; give one of them");
    if (by_dims && p->dims->n != 3)
        return vv_fail(VV_E_ARGUMENT, "resample: `size` has %zu numbers; three are needed", (size_t)p->dims->n);
    if ((st = parse_spacing(spacing, p->spacing, &info->grid)) != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        const int64_t n = info->grid.dims[a];
        const double old = vv_grid_spacing(&info->grid, a);
        if (by_dims && !(p->dims->v[a] >= 1 && p->dims->v[a] == floor(p->dims->v[a])))
            return vv_fail(VV_E_ARGUMENT, "resample: size %g along %c is not a whole number of at least 1",
                           p->dims->v[a], "xyz"[a]);
        if (by_dims)
            st = map_axis(out, a, p->dims->v[a], (double)n / p->dims->v[a], n);
        else if (n == 1) /* a slice stays one */
            st = map_axis(out, a, 1, 1, 1);
        else
            st = map_axis(out, a, floor((double)n * old / spacing[a] + 0.5), spacing[a] / old, n);
        if (st != VV_OK)
            return st;
    }
    return VV_OK;
}

static vv_field_info resampled(const vv_field_info *info, const grid_map *map)
{
    vv_field_info out = *info;
    vv_affine *m = &out.grid.index_to_world;
    if (map->onto) {
        out.grid = *map->onto;
        return out;
    }
    m->origin = vv_affine_point(info->grid.index_to_world, (vv_vec3){map->start[0], map->start[1], map->start[2]});
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = m->axis[a];
        out.grid.dims[a] = map->n[a];
        m->axis[a] = (vv_vec3){v.x * map->step[a], v.y * map->step[a], v.z * map->step[a]};
    }
    return out;
}

static vv_status kernel_of(vvi_resample_kernel *out, const vv_field_info *info, const vv_object *params)
{
    const resample_params *p = (const resample_params *)params;
    const bool labels = info->meaning == VV_MEANING_LABEL, chosen = is_set(params, ROW_INTERPOLATION);
    *out = labels && !chosen ? VVI_RESAMPLE_NEAREST : (vvi_resample_kernel)p->interpolation;
    if (labels && *out != VVI_RESAMPLE_NEAREST)
        return vv_fail(VV_E_UNSUPPORTED, "resample: labels are names, not amounts: --interpolation nearest keeps them");
    return VV_OK;
}

/* infos[1] is of onto, where there is one. */
static vv_status choose(grid_map *map, vvi_resample_kernel *kernel, const vv_field_info *infos, bool onto,
                        const vv_object *params)
{
    const vv_status st = kernel_of(kernel, &infos[0], params);
    if (st != VV_OK)
        return st;
    *map = (grid_map){.straight = true};
    return onto ? find_map_onto(map, &infos[0].grid, &infos[1].grid, params) : find_map(map, &infos[0], params);
}

/* The stored number outside. */
static vv_status find_fill(char fill[8], const vv_field_info *info, const vv_object *params)
{
    const double missing = NAN;
    if (is_set(params, ROW_FILL))
        return vvi_stored_bytes(fill, info, ((const resample_params *)params)->fill, "resample: fill");
    const double stored = vv_type_is_float(info->type) ? missing : -info->value_offset / info->value_scale;
    vvi_samples_from_f64(fill, &stored, info->type, 1);
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    grid_map map;
    vvi_resample_kernel kernel;
    const bool onto = n_inputs > 1 && inputs[1].grid.dims[0] > 0;
    char fill[8];
    vv_status st = choose(&map, &kernel, inputs, onto, params);
    if (st == VV_OK && (st = find_fill(fill, &inputs[0], params)) == VV_OK)
        *out = resampled(&inputs[0], &map);
    return st;
}

typedef struct shared {
    vvi_making making;
    bool nearest; /* samples are taken as they are, with all of their bits */
    vvi_resample_axis axis[3];
    char fill[8]; /* the bytes of a number outside */
    vv_job *job;
} shared;

static void fill_samples(char *out, const shared *s, int64_t n)
{
    const vv_field_info *info = vv_field_get_info(s->making.in);
    vvi_fill_numbers(out, s->fill, vv_type_bytes(info->type), n * info->components);
}

static size_t numbers_of_row(const shared *s)
{
    const vv_field_info *info = vv_field_get_info(s->making.in);
    return (size_t)info->grid.dims[0] * (size_t)info->components;
}

/* Of one worker. Rows of the input are summed along z once for each slice of the result, and then, as many of them as
 * have a part in a row of it, along y. */
typedef struct rows {
    size_t slots;
    int64_t *place; /* by slot of the ring: slice of the result and row of the input that it holds; -1: none */
    double *ring, *row, *sum, *made;
} rows;

static vv_status start(void **scratch_out, void *user, int worker)
{
    (void)worker;
    const shared *s = user;
    const size_t n = numbers_of_row(s), most = (size_t)s->axis[1].most;
    const size_t slots = s->nearest ? 0 : most <= RING_BYTES / sizeof(double) / n ? most : 1;
    const size_t made = (size_t)s->making.slabs.box.n[0] * (size_t)vv_field_get_info(s->making.in)->components;
    const size_t bytes = sizeof(rows) + slots * sizeof(int64_t) + ((slots + 2) * n + made) * sizeof(double);
    rows *r = *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(bytes);
    r->slots = slots;
    r->place = (int64_t *)(r + 1);
    r->ring = (double *)(r->place + slots);
    r->row = r->ring + slots * n;
    r->sum = r->row + n;
    r->made = r->sum + n;
    for (size_t i = 0; i < slots; i++)
        r->place[i] = -1;
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static void add_row(double *sum, const double *row, size_t n, double w)
{
    for (size_t i = 0; i < n; i++)
        sum[i] += w * row[i];
}

/* Row y of the input, along z as slice k of the result has it. */
static const double *sum_along_z(rows *r, const shared *s, const vv_brick *brick, int64_t y, int64_t k)
{
    const vvi_resample_axis *az = &s->axis[2];
    const size_t n = numbers_of_row(s);
    const int64_t slot = y % (int64_t)r->slots, place = k * vv_field_get_info(s->making.in)->grid.dims[1] + y;
    double *sum = r->ring + (size_t)slot * n;
    if (r->place[slot] == place)
        return sum;
    const char *in = (const char *)brick->data + (y - brick->box.lo[1]) * brick->stride[1] +
                     (az->first[k] - brick->box.lo[2]) * brick->stride[2];
    memset(sum, 0, n * sizeof *sum);
    for (int c = 0; c < az->count[k]; c++) {
        vvi_samples_to_f64(r->row, in + c * brick->stride[2], brick->type, n);
        add_row(sum, r->row, n, az->w[k * az->most + c]);
    }
    r->place[slot] = place;
    return sum;
}

static void make_row(char *out, const shared *s, rows *r, const vv_brick *brick, int64_t j, int64_t k)
{
    const vvi_resample_axis *ax = &s->axis[0], *ay = &s->axis[1];
    const size_t n = numbers_of_row(s), components = (size_t)brick->components;
    double *sum = r->sum, *made = r->made;
    memset(sum, 0, n * sizeof *sum);
    for (int b = 0; b < ay->count[j]; b++)
        add_row(sum, sum_along_z(r, s, brick, ay->first[j] + b, k), n, ay->w[j * ay->most + b]);
    for (int64_t i = 0; i < s->making.slabs.box.n[0]; i++) {
        const int64_t x = s->making.slabs.box.lo[0] + i;
        for (size_t c = 0; c < components; c++) {
            double v = 0;
            for (int a = 0; a < ax->count[x]; a++)
                v += ax->w[x * ax->most + a] * sum[(size_t)(ax->first[x] + a) * components + c];
            made[(size_t)i * components + c] = v;
        }
    }
    vvi_samples_from_f64(out, made, brick->type, (size_t)s->making.slabs.box.n[0] * components);
}

/* Those before and behind the old ones. */
static void fill_ends(char *row, const shared *s)
{
    const vvi_resample_axis *ax = &s->axis[0];
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const size_t bytes = vv_type_bytes(info->type) * (size_t)info->components;
    for (int64_t i = 0; i < s->making.slabs.box.n[0]; i++)
        if (ax->count[s->making.slabs.box.lo[0] + i] == 0)
            fill_samples(row + (size_t)i * bytes, s, 1);
}

static void take_row(char *out, const shared *s, const vv_brick *brick, int64_t j, int64_t k)
{
    const vvi_resample_axis *ax = &s->axis[0];
    const size_t bytes = vv_type_bytes(brick->type) * (size_t)brick->components;
    const int64_t y = s->axis[1].first[j] - brick->box.lo[1], z = s->axis[2].first[k] - brick->box.lo[2];
    const char *in = (const char *)brick->data + y * brick->stride[1] + z * brick->stride[2];
    for (int64_t i = 0; i < s->making.slabs.box.n[0]; i++)
        memcpy(out + (size_t)i * bytes, in + (size_t)ax->first[s->making.slabs.box.lo[0] + i] * bytes, bytes);
}

static void write_row(char *out, const shared *s, rows *scratch, const vv_brick *brick, int64_t j, int64_t k)
{
    if (s->axis[1].count[j] == 0 || s->axis[2].count[k] == 0) {
        fill_samples(out, s, s->making.slabs.box.n[0]);
        return;
    }
    if (s->nearest)
        take_row(out, s, brick, j, k);
    else
        make_row(out, s, scratch, brick, j, k);
    fill_ends(out, s);
}

/* The old samples that new ones [lo, lo + n) are made of. */
static void run_of(int64_t *lo_out, int64_t *n_out, const vvi_resample_axis *axis, int64_t lo, int64_t n)
{
    int64_t first = INT64_MAX, end = 0;
    for (int64_t i = lo; i < lo + n; i++) {
        if (axis->count[i] == 0)
            continue;
        first = axis->first[i] < first ? axis->first[i] : first;
        end = axis->first[i] + axis->count[i] > end ? axis->first[i] + axis->count[i] : end;
    }
    *lo_out = end ? first : 0;
    *n_out = end ? end - first : 1; /* none: any sample will do */
}

/* Whole rows of the input that a box of the result is made of. */
static vv_box box_needed(const shared *s, const vv_box *box)
{
    vv_box from = {{0, 0, 0}, {vv_field_get_info(s->making.in)->grid.dims[0], 0, 0}};
    run_of(&from.lo[1], &from.n[1], &s->axis[1], box->lo[1], box->n[1]);
    run_of(&from.lo[2], &from.n[2], &s->axis[2], box->lo[2], box->n[2]);
    return from;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_box from = box_needed(s, &box);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &from);
    vv_status st = VV_OK;
    const size_t bytes = vv_type_bytes(info->type) * (size_t)info->components;
    for (int64_t k = 0; k < box.n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < box.n[1] && st == VV_OK; j++) {
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * bytes;
            write_row(out, s, scratch, &brick, box.lo[1] + j, box.lo[2] + k);
            st = vvi_job_poll(s->job);
        }
    return st;
}

static vv_status make_axes(shared *s, const grid_map *map, vvi_resample_kernel kernel)
{
    const int64_t *d = vv_field_get_info(s->making.in)->grid.dims;
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++)
        st = vvi_resample_axis_make(&s->axis[a], kernel, d[a], map->n[a], map->start[a], map->step[a], s->job);
    for (int a = 0; a < 3 && st == VV_OK && map->onto; a++)
        vvi_resample_axis_cut(&s->axis[a], d[a], map->start[a], map->step[a]);
    return st;
}

/* Items are whole rows: the sum over y and z is made once for each. */
static vvi_slabs slabs_of_rows(const vv_box *box)
{
    return vvi_slabs_of(box, box->n[0] > ITEM_SAMPLES ? box->n[0] : ITEM_SAMPLES);
}

static vv_status run_axes(vv_field **out, const vv_field *in, const vv_field_info *info, const grid_map *map,
                          vvi_resample_kernel kernel, const char fill[8], const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "resample", .start = start, .item = item, .finish = finish};
    shared s = {
        .making = {.in = in, .slabs = slabs_of_rows(box)}, .nearest = kernel == VVI_RESAMPLE_NEAREST, .job = job};
    memcpy(s.fill, fill, sizeof s.fill);
    vv_status st = make_axes(&s, map, kernel);
    if (st == VV_OK) {
        const vv_box needed = box_needed(&s, box);
        st = vvi_making_run(out, &s.making, info, box, &needed, &work, &s, job);
    }
    for (int a = 0; a < 3; a++)
        vvi_resample_axis_free(&s.axis[a]);
    return st;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    vv_field_info infos[2] = {*vv_field_get_info(inputs[0])};
    const bool onto = n_inputs > 1 && inputs[1];
    char fill[8] = {0};
    grid_map map;
    vvi_resample_kernel kernel;
    *out = NULL;
    if (onto)
        infos[1] = *vv_field_get_info(inputs[1]);
    vv_status st = choose(&map, &kernel, infos, onto, params);
    if (st != VV_OK || (st = find_fill(fill, &infos[0], params)) != VV_OK)
        return st;
    const vv_field_info info = resampled(&infos[0], &map);
    return map.straight ? run_axes(out, inputs[0], &info, &map, kernel, fill, box, job)
                        : vvi_onto_run_box(out, inputs[0], &info, &map.any, kernel, fill, box, job);
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the volume that it works on"},
    {"onto", VV_IS_FIELD, 0, 1, "a volume whose grid the result has; of its samples none is read", .grid_only = true},
    {0},
};

const vv_operation vvi_operation_resample = {
    .api = VV_OPERATION_API,
    .name = "resample",
    .component = "filter",
    .group = "geometry",
    .doc = "the same volume with another spacing, or on the grid of another volume (onto=FILE), wherever that lies; "
           "without "
           "parameters its voxels become cubes",
    .example = "volvis resample head.nrrd -o even.nrrd --spacing 2mm",
    .params = &resample_class,
    .inputs = inputs_taken,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
