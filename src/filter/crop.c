/* Crop: the samples of a box, where they are. */
#include "filter/crop.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 19)

typedef struct crop_params {
    vv_object object;
    char *x, *y, *z;
} crop_params;

static const vv_property properties[] = {
    {VV_PROP(crop_params, x), .kind = VV_KIND_STRING, .automatic = "all",
     .doc = "samples kept along x, as in 10..59: the first and the last, counted from 0, or from the end if negative; "
            "either may be omitted; lengths from the first sample: 10mm..60mm"},
    {VV_PROP(crop_params, y), .kind = VV_KIND_STRING, .automatic = "all", .doc = "samples kept along y, as for x"},
    {VV_PROP(crop_params, z), .kind = VV_KIND_STRING, .automatic = "all", .doc = "samples kept along z, as for x"},
    {0},
};

static const vv_class crop_class = {
    .name = "crop",
    .doc = "parameters of crop",
    .size = sizeof(crop_params),
    .properties = properties,
};

/* One end of a range, as a sample number. A length names a place; `round` brings it to the first sample inside. */
static vv_status parse_end(int64_t *out, const char *text, int64_t n, const vv_grid *grid, int axis,
                           double (*round)(double))
{
    char place[16];
    snprintf(place, sizeof place, "crop %c", "xyz"[axis]);
    double at;
    if (vvi_parse_number(&at, text)) {
        if (!(at == nearbyint(at)) || fabs(at) > 0x1p53)
            return vv_fail(VV_E_ARGUMENT,
                           "%s: '%s' is not a sample number; give a whole number or a length with its unit", place,
                           text);
        *out = (int64_t)at < 0 ? (int64_t)at + n : (int64_t)at;
        return VV_OK;
    }
    const double spacing = vv_grid_spacing(grid, axis);
    const vv_property_context context = {.length_unit = grid->unit, .voxel = spacing};
    const vv_status st = vvi_parse_quantity(&at, text, VV_Q_LENGTH, &context, place);
    if (st != VV_OK)
        return st;
    /* A length written for a sample is often a hair beside it: within a millionth of a voxel it is that sample. */
    const double index = at / spacing, whole = nearbyint(index);
    const double sample = fabs(index - whole) < 1e-6 ? whole : round(index);
    if (!(fabs(sample) < 0x1p53))
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' is outside every grid", place, text);
    *out = (int64_t)sample;
    return VV_OK;
}

static bool is_length(const char *text)
{
    double number;
    return *text && !vvi_parse_number(&number, text);
}

/* "FIRST..LAST", which a comma says as well, or "FIRST:END" with a sample that is not kept any more. */
static vv_status split_range(char first[64], char last[64], bool *closed, const char *text, int axis)
{
    const char *dots = strstr(text, ".."), *comma = dots ? NULL : strchr(text, ',');
    const char *mark = dots ? dots : comma ? comma : strchr(text, ':'), *rest = mark ? mark + (dots ? 2 : 1) : NULL;
    if (!mark || strpbrk(rest, ":,") || strstr(rest, "..") || mark - text >= 64 || strlen(rest) >= 64)
        return vv_fail(VV_E_ARGUMENT, "crop %c: '%s' is not a range; write FIRST..LAST, such as 10..59 or 10mm..60mm",
                       "xyz"[axis], text);
    snprintf(first, 64, "%.*s", (int)(mark - text), text);
    snprintf(last, 64, "%s", rest);
    *closed = dots || comma;
    return VV_OK;
}

static vv_status check_range(int64_t lo, int64_t end, int64_t n, const char *text, int axis)
{
    if (lo >= end)
        return vv_fail(VV_E_ARGUMENT,
                       "crop %c: '%s' contains no sample: it begins at %lld and ends at %lld; there are 0 to %lld",
                       "xyz"[axis], text, (long long)lo, (long long)end - 1, (long long)n - 1);
    if (lo < 0 || end > n)
        return vv_fail(VV_E_ARGUMENT, "crop %c: '%s' goes beyond the data, which have samples 0 to %lld", "xyz"[axis],
                       text, (long long)n - 1);
    return VV_OK;
}

/* Lengths are closed at both ends: "10mm..60mm" keeps the samples from 10 mm to 60 mm. Numbers are so with dots, and
 * half-open with a colon. */
vv_status vvi_crop_range(int64_t *lo, int64_t *end, const char *text, const vv_grid *grid, int axis)
{
    const int64_t n = grid->dims[axis];
    char first[64], last[64];
    bool closed = false;
    vv_status st;
    *lo = 0;
    *end = n;
    if (!text || !*text)
        return VV_OK;
    if ((st = split_range(first, last, &closed, text, axis)) != VV_OK ||
        (*first && (st = parse_end(lo, first, n, grid, axis, ceil)) != VV_OK) ||
        (*last && (st = parse_end(end, last, n, grid, axis, floor)) != VV_OK))
        return st;
    if (is_length(last) || (closed && *last))
        ++*end;
    *lo = *lo < 0 && is_length(first) ? 0 : *lo;
    *end = *end > n && is_length(last) ? n : *end;
    return check_range(*lo, *end, n, text, axis);
}

static vv_status crop_box(vv_box *out, const vv_grid *grid, const vv_object *params)
{
    const crop_params *p = (const crop_params *)params;
    const char *const ranges[3] = {p->x, p->y, p->z};
    for (int a = 0; a < 3; a++) {
        int64_t lo, end;
        const vv_status st = vvi_crop_range(&lo, &end, ranges[a], grid, a);
        if (st != VV_OK)
            return st;
        out->lo[a] = lo;
        out->n[a] = end - lo;
    }
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    vv_box box;
    const vv_status st = crop_box(&box, &inputs[0].grid, params);
    if (st != VV_OK)
        return st;
    *out = inputs[0];
    out->grid = vv_grid_crop(&inputs[0].grid, &box);
    return VV_OK;
}

typedef struct shared {
    vvi_making making;
    size_t bytes; /* of a sample */
} shared;

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * s->bytes;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            memcpy(out, in, (size_t)box.n[0] * s->bytes);
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "crop", .item = item};
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    vv_field_info info;
    vv_box needed;
    shared s = {.making.in = inputs[0]};
    vv_status st;
    *out = NULL;
    if ((st = plan(&info, from, n_inputs, params)) != VV_OK || (st = crop_box(&needed, &from->grid, params)) != VV_OK)
        return st;
    for (int a = 0; a < 3; a++) {
        needed.lo[a] += box->lo[a];
        needed.n[a] = box->n[a];
    }
    s.making.slabs = vvi_slabs_of(&needed, ITEM_SAMPLES);
    s.bytes = vv_type_bytes(info.type) * (size_t)info.components;
    return vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
}

const vv_operation vvi_operation_crop = {
    .api = VV_OPERATION_API,
    .name = "crop",
    .component = "filter",
    .group = "geometry",
    .doc = "cut out a box of samples; they keep their position in the world",
    .example = "volvis crop head.nrrd -o part.nrrd --x 10..59 --z 20mm..",
    .params = &crop_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
    .in_order = true,
};
