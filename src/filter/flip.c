/* Flip: the order of samples along axes reversed, in place in the world, or the picture mirrored. */
#include "grid/field.h"
#include "grid/making.h"
#include "registry.h"

#include <ctype.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 18)

typedef struct flip_params {
    vv_object object;
    char *axes;
    bool mirror;
} flip_params;

static const vv_property properties[] = {
    {VV_PROP(flip_params, axes), .kind = VV_KIND_STRING, .def_text = "\"x\"",
     .doc = "axes to reverse: any of x, y, z together, such as xy"},
    {VV_PROP(flip_params, mirror), .kind = VV_KIND_BOOL,
     .doc =
         "keep the grid where it is, so that the volume is mirrored; otherwise only the order of the samples changes"},
    {0},
};

static const vv_class flip_class = {
    .name = "flip",
    .doc = "parameters of flip",
    .size = sizeof(flip_params),
    .properties = properties,
};

static vv_status parse_axes(bool flipped[3], const flip_params *p)
{
    memset(flipped, 0, 3 * sizeof *flipped);
    const char *axes = p->axes ? p->axes : "";
    for (const char *c = axes; *c; c++) {
        const char *at = strchr("xyz", tolower((unsigned char)*c));
        if (*c == ',' && c != axes && c[1])
            continue;
        if (!at || flipped[at - "xyz"])
            return vv_fail(VV_E_ARGUMENT,
                           "flip: '%s' is not a set of axes; write each of x, y, z at most once, as in xy", axes);
        flipped[at - "xyz"] = true;
    }
    if (!*axes)
        return vv_fail(VV_E_ARGUMENT, "flip: no axis is given; write some of x, y, z, as in xy");
    return VV_OK;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    (void)n_inputs;
    const flip_params *p = (const flip_params *)params;
    bool flipped[3];
    const vv_status st = parse_axes(flipped, p);
    if (st != VV_OK)
        return st;
    *out = inputs[0];
    for (int a = 0; a < 3 && !p->mirror; a++) {
        vv_affine *m = &out->grid.index_to_world;
        const double last = (double)(out->grid.dims[a] - 1);
        if (!flipped[a])
            continue;
        m->origin = (vv_vec3){m->origin.x + last * m->axis[a].x, m->origin.y + last * m->axis[a].y,
                              m->origin.z + last * m->axis[a].z};
        m->axis[a] = (vv_vec3){-m->axis[a].x, -m->axis[a].y, -m->axis[a].z};
    }
    return VV_OK;
}

typedef struct shared {
    vvi_making making;
    bool flipped[3];
    const vv_affine *turn; /* of vectors; NULL: samples are only moved */
} shared;

/* Bytes, eight of them at a time. */
static void reverse_bytes(char *out, const char *in, int64_t n)
{
    int64_t i = 0;
    for (; i + 8 <= n; i += 8) {
        uint64_t eight;
        memcpy(&eight, in + i, sizeof eight);
        eight = __builtin_bswap64(eight);
        memcpy(out + n - 8 - i, &eight, sizeof eight);
    }
    for (; i < n; i++)
        out[n - 1 - i] = in[i];
}

static void reverse_row(char *out, const char *in, int64_t n, int64_t stride, size_t bytes)
{
    if (bytes == 1 && stride == 1) {
        reverse_bytes(out, in, n);
        return;
    }
    switch (bytes) { /* known sizes become single loads and stores */
#define REVERSE(size)                                                                                                  \
    case size:                                                                                                         \
        for (int64_t i = 0; i < n; i++)                                                                                \
            memcpy(out + (n - 1 - i) * (size), in + i * stride, size);                                                 \
        break
        REVERSE(1);
        REVERSE(2);
        REVERSE(4);
        REVERSE(8);
#undef REVERSE
    default:
        for (int64_t i = 0; i < n; i++)
            memcpy(out + (n - 1 - i) * (int64_t)bytes, in + i * stride, bytes);
    }
}

/* A mirrored vector field shows mirrored vectors. */
static void turn_row(char *row, int64_t n, vv_type type, const vv_affine *turn)
{
    const size_t bytes = 3 * vv_type_bytes(type);
    for (int64_t i = 0; i < n; i++, row += bytes) {
        double v[3];
        vvi_samples_to_f64(v, row, type, 3);
        const vv_vec3 t = vv_affine_vector(*turn, (vv_vec3){v[0], v[1], v[2]});
        vvi_samples_from_f64(row, (double[3]){t.x, t.y, t.z}, type, 3);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    (void)scratch;
    const shared *s = user;
    const vv_field_info *info = vv_field_get_info(s->making.in);
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const size_t bytes = vv_type_bytes(info->type) * (size_t)info->components;
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const vv_box *all = &s->making.slabs.box; /* of the input, that the result comes from */
    const int64_t *n = all->n;
    int64_t to[3]; /* where the first of a run of output samples lies */
    for (int a = 0; a < 3; a++) {
        const int64_t lo = box.lo[a] - all->lo[a];
        to[a] = s->flipped[a] ? n[a] - lo - box.n[a] : lo;
    }
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t to_j = to[1] + (s->flipped[1] ? box.n[1] - 1 - j : j);
            const int64_t to_k = to[2] + (s->flipped[2] ? box.n[2] - 1 - k : k);
            char *out = s->making.out + (size_t)((to_k * n[1] + to_j) * n[0] + to[0]) * bytes;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            if (s->flipped[0])
                reverse_row(out, in, box.n[0], brick.stride[0], bytes);
            else
                memcpy(out, in, (size_t)box.n[0] * bytes);
            if (s->turn)
                turn_row(out, box.n[0], info->type, s->turn);
        }
    return VV_OK;
}

/* Mirroring index axes, seen from the world: to index space, reversed there, and back. */
static bool mirror_of(vv_affine *out, const vv_grid *grid, const bool flipped[3])
{
    vv_affine reversed = grid->index_to_world, back;
    if (!vv_affine_invert(&back, grid->index_to_world))
        return false;
    for (int a = 0; a < 3; a++)
        if (flipped[a])
            reversed.axis[a] = (vv_vec3){-reversed.axis[a].x, -reversed.axis[a].y, -reversed.axis[a].z};
    *out = vv_affine_compose(reversed, back);
    return true;
}

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "flip", .item = item};
    const flip_params *p = (const flip_params *)params;
    const vv_field_info *from = vv_field_get_info(inputs[0]);
    vv_field_info info;
    vv_affine turn;
    vv_box needed = *box;
    shared s = {.making.in = inputs[0]};
    vv_status st;
    *out = NULL;
    if ((st = plan(&info, from, n_inputs, params)) != VV_OK || (st = parse_axes(s.flipped, p)) != VV_OK)
        return st;
    if (p->mirror && info.meaning == VV_MEANING_VECTOR && info.components == 3 &&
        mirror_of(&turn, &info.grid, s.flipped))
        s.turn = &turn;
    for (int a = 0; a < 3; a++)
        if (s.flipped[a])
            needed.lo[a] = from->grid.dims[a] - box->lo[a] - box->n[a];
    s.making.slabs = vvi_slabs_of(&needed, ITEM_SAMPLES);
    return vvi_making_run(out, &s.making, &info, box, &needed, &work, &s, job);
}

const vv_operation vvi_operation_flip = {
    .api = VV_OPERATION_API,
    .name = "flip",
    .component = "filter",
    .group = "geometry",
    .doc = "reverse the order of samples along axes; with --mirror, mirror what the volume shows",
    .example = "volvis flip head.nrrd -o flipped.nrrd --axes xz",
    .params = &flip_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .carry = vv_carry_values,
};
