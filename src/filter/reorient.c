/* Reorient: the same samples at the same places in the world, in another order of axes. */
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)

typedef struct reorient_params {
    vv_object object;
    char *order, *to;
} reorient_params;

static const vv_property properties[] = {
    {VV_PROP(reorient_params, order), .kind = VV_KIND_STRING, .def_text = "\"RAS\"",
     .doc = "the new axis order: three letters, RAS, LPI, ..., one of each pair L-R, P-A, I-S, the directions in which "
            "samples follow one another along x, y, z; or the old axes, as in zyx or -xzy, where a minus reverses an "
            "axis"},
    {VV_PROP(reorient_params, to), .kind = VV_KIND_STRING, .hidden = true, .automatic = "order",
     .doc = "the former name of order"},
    {0},
};

static const vv_class reorient_class = {
    .name = "reorient",
    .doc = "parameters of reorient",
    .size = sizeof(reorient_params),
    .properties = properties,
};

/* Which old axis each new one is, and whether it runs backwards. */
typedef struct order {
    int from[3];
    bool reversed[3];
} order;

static vv_status fail_order(const char *to)
{
    return vv_fail(VV_E_ARGUMENT,
                   "reorient: '%.40s' is not an axis order; write letters as in RAS or LPI, or axes as in zyx or -xzy",
                   to);
}

/* "zyx", "-x,z,y". */
static bool parse_axes(order *out, const char *text)
{
    bool used[3] = {0};
    for (int a = 0; a < 3; a++) {
        text += *text == ',';
        out->reversed[a] = *text == '-';
        text += *text == '-' || *text == '+';
        const char *at = *text ? strchr("xyz", tolower((unsigned char)*text)) : NULL;
        if (!at || used[at - "xyz"])
            return false;
        out->from[a] = (int)(at - "xyz");
        used[out->from[a]] = true;
        text++;
    }
    return !*text;
}

/* "RAS": a letter for each new axis. */
static bool parse_letters(order *out, const char *text, const vv_grid *grid)
{
    static const char up[] = "RAS", down[] = "LPI";
    int world[3], sign[3];
    bool used[3] = {0};
    if (strlen(text) != 3)
        return false;
    vvi_grid_main_axes(world, sign, grid);
    for (int a = 0; a < 3; a++) {
        const int letter = toupper((unsigned char)text[a]);
        const char *plus = strchr(up, letter), *minus = strchr(down, letter);
        if (!plus && !minus)
            return false;
        const int axis = plus ? (int)(plus - up) : (int)(minus - down);
        if (used[axis])
            return false;
        used[axis] = true;
        for (int b = 0; b < 3; b++)
            if (world[b] == axis)
                out->from[a] = b;
        out->reversed[a] = (sign[out->from[a]] > 0) != (plus != NULL);
    }
    return true;
}

static vv_status find_order(order *out, const vv_field_info *info, const vv_object *params)
{
    const reorient_params *p = (const reorient_params *)params;
    const char *to = p->to ? p->to : p->order ? p->order : "RAS";
    if (parse_axes(out, to))
        return VV_OK;
    if (!parse_letters(out, to, &info->grid))
        return fail_order(to);
    if (info->grid.space != VV_SPACE_RAS)
        return vv_fail(VV_E_UNSUPPORTED,
                       "reorient: the volume is not anatomical, so '%.8s' means nothing; write axes as in zyx", to);
    return VV_OK;
}

static vv_field_info reordered(const vv_field_info *info, const order *o)
{
    vv_field_info out = *info;
    vv_affine *m = &out.grid.index_to_world;
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = info->grid.index_to_world.axis[o->from[a]];
        const double last = (double)(info->grid.dims[o->from[a]] - 1);
        out.grid.dims[a] = info->grid.dims[o->from[a]];
        m->axis[a] = v;
        if (!o->reversed[a])
            continue;
        m->axis[a] = (vv_vec3){-v.x, -v.y, -v.z};
        m->origin = (vv_vec3){m->origin.x + last * v.x, m->origin.y + last * v.y, m->origin.z + last * v.z};
    }
    return out;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    order o;
    const vv_status st = find_order(&o, &inputs[0], params);
    if (st == VV_OK)
        *out = reordered(&inputs[0], &o);
    return st;
}

typedef struct shared {
    vvi_making making;
    order order;
    size_t bytes; /* of a sample */
} shared;

/* The box of the input that a box of the result comes from. */
static vv_box input_box(const shared *s, const vv_box *box)
{
    const int64_t *d = vv_field_get_info(s->making.in)->grid.dims;
    vv_box in;
    for (int a = 0; a < 3; a++) {
        const int from = s->order.from[a];
        in.n[from] = box->n[a];
        in.lo[from] = s->order.reversed[a] ? d[from] - box->lo[a] - box->n[a] : box->lo[a];
    }
    return in;
}

#define GATHER(size)                                                                                                   \
    case size:                                                                                                         \
        for (int64_t i = 0; i < n; i++)                                                                                \
            memcpy(out + i * (size), in + i * step, size);                                                             \
        break

static void gather_row(char *out, const char *in, int64_t n, int64_t step, size_t bytes)
{
    if (step == (int64_t)bytes) {
        memcpy(out, in, (size_t)n * bytes);
        return;
    }
    switch (bytes) { /* known sizes become single loads and stores */
        GATHER(1);
        GATHER(2);
        GATHER(3);
        GATHER(4);
        GATHER(8);
    default:
        for (int64_t i = 0; i < n; i++)
            memcpy(out + i * (int64_t)bytes, in + i * step, bytes);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index), from = input_box(s, &box);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &from);
    int64_t step[3];
    const char *first = brick.data;
    for (int a = 0; a < 3; a++) {
        step[a] = brick.stride[s->order.from[a]];
        if (s->order.reversed[a]) {
            first += (box.n[a] - 1) * step[a];
            step[a] = -step[a];
        }
    }
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            char *out = s->making.out + (size_t)vvi_slabs_row(&s->making.slabs, &box, j, k) * s->bytes;
            gather_row(out, first + k * step[2] + j * step[1], box.n[0], step[0], s->bytes);
        }
    return VV_OK;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    (void)n_inputs;
    static const vvi_work work = {.stage = "reorient", .item = item};
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)}};
    *out = NULL;
    const vv_status st = find_order(&s.order, from, params);
    if (st != VV_OK)
        return st;
    const vv_field_info info = reordered(from, &s.order);
    const vv_box needed = input_box(&s, box);
    s.bytes = vv_type_bytes(info.type) * (size_t)info.components;
    return vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
}

const vv_operation vvi_operation_reorient = {
    .api = VV_OPERATION_API,
    .name = "reorient",
    .component = "filter",
    .group = "geometry",
    .doc = "the same samples at the same places, in another axis order: RAS, LPI, zyx",
    .example = "volvis reorient head.nrrd -o turned.nrrd --order zyx",
    .params = &reorient_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
