/* Pad: samples around those that there are, which stay where they are in the world. */
#include "core/job.h"
#include "core/memory.h"
#include "filter/amounts.h"
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)

typedef struct pad_params {
    vv_object object;
    char *x, *y, *z, *all;
    vv_numbers *size;
    int border;
    double value;
} pad_params;

enum { ROW_X, ROW_Y, ROW_Z, ROW_ALL, ROW_SIZE, ROW_BORDER, ROW_VALUE };
enum { BORDER_VALUE, BORDER_NEAREST, BORDER_MIRROR, BORDER_WRAP };

static const char *const border_names[] = {"value", "nearest", "mirror", "wrap", NULL};

static const vv_property properties[] = {
    [ROW_X] = {VV_PROP(pad_params, x), .kind = VV_KIND_STRING, .automatic = "as all",
               .doc = "samples added before and behind along x: 10,20, or 10 for both; or lengths, 5mm"},
    [ROW_Y] = {VV_PROP(pad_params, y), .kind = VV_KIND_STRING, .automatic = "as all", .doc = "along y, as for x"},
    [ROW_Z] = {VV_PROP(pad_params, z), .kind = VV_KIND_STRING, .automatic = "as all", .doc = "along z, as for x"},
    [ROW_ALL] = {VV_PROP(pad_params, all), .kind = VV_KIND_STRING, .automatic = "none",
                 .doc = "the same along x, y and z; axes of one sample are left alone"},
    [ROW_SIZE] = {VV_PROP(pad_params, size), .kind = VV_KIND_NUMBERS, .columns = 1, .unit = "samples",
                  .automatic = "from the others",
                  .doc =
                      "instead: number of samples along x, y, z, the old ones in the middle of them; of an odd number "
                      "one more is behind"},
    [ROW_BORDER] = {VV_PROP(pad_params, border), .kind = VV_KIND_ENUM, .names = border_names,
                    .doc =
                        "what is added: value; nearest: the border's sample; mirror: the samples before it, from the "
                        "border inwards, which itself is not repeated; wrap: those of the other end"},
    [ROW_VALUE] = {VV_PROP(pad_params, value), .kind = VV_KIND_F64, .unit = "value", .when = "border=value",
                   .doc = "value of the samples that are added"},
    {0},
};

static const vv_class pad_class = {
    .name = "pad",
    .doc = "parameters of pad",
    .size = sizeof(pad_params),
    .properties = properties,
};

/* How many are added before the first sample, and how many there are then. */
typedef struct margins {
    int64_t before[3], n[3];
} margins;

/* "10,20": before and behind; "10": both. */
static vv_status parse_sides(int64_t sides[2], const char *text, const vv_grid *grid, int axis)
{
    char one[64], place[16];
    const char *comma = strchr(text, ',');
    snprintf(place, sizeof place, "pad %c", "xyz"[axis]);
    if (strlen(text) >= sizeof one || (comma && strchr(comma + 1, ',')))
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' is neither one number nor two; write 10, 10,20 or 5mm", place, text);
    snprintf(one, sizeof one, "%.*s", (int)(comma ? comma - text : (int)strlen(text)), text);
    vv_status st = vvi_parse_samples(&sides[0], one, grid, axis, place);
    sides[1] = sides[0];
    return st == VV_OK && comma ? vvi_parse_samples(&sides[1], comma + 1, grid, axis, place) : st;
}

static vv_status check_size(const pad_params *p, const vv_grid *grid)
{
    if (p->object.set >> ROW_X & 0xf)
        return vv_fail(VV_E_ARGUMENT, "pad: `size` and `x`, `y`, `z`, `all` set the same thing; give one or the other");
    if (p->size->n != 3)
        return vv_fail(VV_E_ARGUMENT, "pad: `size` has %zu numbers; three are needed", p->size->n);
    for (int a = 0; a < 3; a++)
        if (!(p->size->v[a] >= (double)grid->dims[a] && p->size->v[a] == floor(p->size->v[a]) &&
              p->size->v[a] <= 1 << 30))
            return vv_fail(VV_E_ARGUMENT,
                           "pad: size %g along %c: expected a whole number of at least %lld, as many samples as there "
                           "are; 'volvis crop' makes them fewer",
                           p->size->v[a], "xyz"[a], (long long)grid -> dims[a]);
    return VV_OK;
}

static vv_status find_pads(margins *out, const vv_grid *grid, const vv_object *params)
{
    const pad_params *p = (const pad_params *)params;
    const char *const texts[3] = {p->x, p->y, p->z};
    const bool by_size = p->size && p->size->n;
    vv_status st = by_size ? check_size(p, grid) : VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const char *all = p->all && grid->dims[a] > 1 ? p->all : "0";
        int64_t sides[2] = {0, 0};
        if (by_size)
            sides[0] = ((int64_t)p->size->v[a] - grid->dims[a]) / 2,
            sides[1] = (int64_t)p->size->v[a] - grid->dims[a] - sides[0];
        else
            st = parse_sides(sides, texts[a] && *texts[a] ? texts[a] : all, grid, a);
        out->before[a] = sides[0];
        out->n[a] = grid->dims[a] + sides[0] + sides[1];
    }
    return st;
}

static vv_status find_fill(char fill[8], const vv_field_info *info, const vv_object *params)
{
    const pad_params *p = (const pad_params *)params;
    memset(fill, 0, 8);
    return p->border == BORDER_VALUE ? vvi_stored_bytes(fill, info, p->value, "pad: value") : VV_OK;
}

static vv_field_info padded(const vv_field_info *info, const margins *pads)
{
    vv_field_info out = *info;
    const vv_vec3 first = {(double)-pads->before[0], (double)-pads->before[1], (double)-pads->before[2]};
    out.grid.index_to_world.origin = vv_affine_point(info->grid.index_to_world, first);
    memcpy(out.grid.dims, pads->n, sizeof out.grid.dims);
    return out;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    char fill[8];
    margins pads;
    vv_status st = find_pads(&pads, &inputs[0].grid, params);
    if (st == VV_OK && (st = find_fill(fill, &inputs[0], params)) == VV_OK)
        *out = padded(&inputs[0], &pads);
    return st;
}

typedef struct shared {
    vvi_making making;
    margins pads;
    int border;
    char fill[8];
    size_t each; /* bytes of a number */
    int64_t components;
    int64_t *old_x; /* along x, of each sample of the box: no division for each of a row */
} shared;

/* The old sample that a new one is; -1: it is the value. */
static int64_t old_of(const shared *s, int axis, int64_t i)
{
    const int64_t n = vv_field_get_info(s->making.in)->grid.dims[axis], at = i - s->pads.before[axis];
    if (at >= 0 && at < n)
        return at;
    switch (s->border) {
    case BORDER_VALUE:
        return -1;
    case BORDER_NEAREST:
        return at < 0 ? 0 : n - 1;
    case BORDER_WRAP:
        return (at % n + n) % n;
    default: {
        const int64_t period = n > 1 ? 2 * (n - 1) : 1, in = (at % period + period) % period;
        return in < n ? in : period - in;
    }
    }
}

#define MARGIN(ctype)                                                                                                  \
    for (int64_t i = 0; i < n; i++)                                                                                    \
        memcpy(out + i * (int64_t)sizeof(ctype), row + (old[i] - first) * step, sizeof(ctype));                        \
    break

/* n samples in a row's margin. */
static void write_margin(char *out, const shared *s, const char *row, const int64_t *old, int64_t n)
{
    const int64_t step = s->making.brick.stride[0], first = s->making.brick.box.lo[0];
    const int64_t bytes = (int64_t)s->each * s->components;
    if (s->border == BORDER_VALUE) {
        vvi_fill_numbers(out, s->fill, s->each, n * s->components);
        return;
    }
    switch (bytes) {
    case 1:
        MARGIN(uint8_t);
    case 2:
        MARGIN(uint16_t);
    case 4:
        MARGIN(uint32_t);
    default:
        for (int64_t i = 0; i < n; i++)
            memcpy(out + i * bytes, row + (old[i] - first) * step, (size_t)bytes);
    }
}

/* A row, of which the old samples are a piece. */
static void write_row(char *out, const shared *s, const vv_box *item, const char *row)
{
    const size_t bytes = s->each * (size_t)s->components;
    const int64_t step = s->making.brick.stride[0], first = s->making.brick.box.lo[0], from = s->pads.before[0];
    const int64_t begin = item->lo[0], end = begin + item->n[0];
    const int64_t to = from + vv_field_get_info(s->making.in)->grid.dims[0];
    const int64_t lo = from < begin ? begin : from > end ? end : from, hi = to < lo ? lo : to > end ? end : to;
    const int64_t *old = s->old_x + (begin - s->making.slabs.box.lo[0]);
    write_margin(out, s, row, old, lo - begin);
    if (hi > lo)
        memcpy(out + (size_t)(lo - begin) * bytes, row + (lo - from - first) * step, (size_t)(hi - lo) * bytes);
    write_margin(out + (size_t)(hi - begin) * bytes, s, row, old + (hi - begin), end - hi);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_brick *b = &s->making.brick;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t bytes = s->each * (size_t)s->components;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * bytes;
            const int64_t y = old_of(s, 1, box.lo[1] + j), z = old_of(s, 2, box.lo[2] + k);
            if (y < 0 || z < 0)
                vvi_fill_numbers(out, s->fill, s->each, box.n[0] * s->components);
            else
                write_row(out, s, &box,
                          (const char *)b->data + (y - b->box.lo[1]) * b->stride[1] +
                              (z - b->box.lo[2]) * b->stride[2]);
        }
    return VV_OK;
}

/* The old samples that a box has in it; any where it has none. */
static vv_box box_needed(const shared *s, const vv_box *box)
{
    vv_box needed = {{0, 0, 0}, {1, 1, 1}};
    for (int a = 0; a < 3; a++) {
        int64_t lo = INT64_MAX, hi = -1;
        for (int64_t i = box->lo[a]; i < box->lo[a] + box->n[a]; i++) {
            const int64_t old = old_of(s, a, i);
            lo = old >= 0 && old < lo ? old : lo;
            hi = old > hi ? old : hi;
        }
        if (hi >= 0)
            needed.lo[a] = lo, needed.n[a] = hi - lo + 1;
    }
    return needed;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "pad", .item = item};
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    shared s = {
        .making = {.in = inputs[0], .slabs = vvi_slabs_of(box, box->n[0] > ITEM_SAMPLES ? box->n[0] : ITEM_SAMPLES)},
        .border = ((const pad_params *)params)->border,
        .each = vv_type_bytes(from->type),
        .components = from->components};
    vv_status st;
    *out = NULL;
    if ((st = find_pads(&s.pads, &from->grid, params)) != VV_OK || (st = find_fill(s.fill, from, params)) != VV_OK)
        return st;
    const vv_field_info info = padded(from, &s.pads);
    const vv_box needed = box_needed(&s, box);
    const size_t bytes = (size_t)box->n[0] * sizeof *s.old_x;
    s.old_x = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!s.old_x)
        return vv_fail_memory(bytes);
    for (int64_t i = 0; i < box->n[0]; i++)
        s.old_x[i] = old_of(&s, 0, box->lo[0] + i);
    st = vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
    vvi_free(s.old_x);
    return st;
}

const vv_operation vvi_operation_pad = {
    .api = VV_OPERATION_API,
    .name = "pad",
    .component = "filter",
    .group = "geometry",
    .doc = "add samples around a volume; those that there are stay at their place in the world",
    .example = "volvis pad head.nrrd -o room.nrrd --x 10 --z 5mm,0 --value 0",
    .params = &pad_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
