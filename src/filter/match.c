/* Match and equalise: values changed in such a way that their histogram becomes another's, or even. */
#include "core/job.h"
#include "core/memory.h"
#include "filter/amounts.h"
#include "filter/equalize_tiles.h"
#include "filter/ranks.h"
#include "grid/making.h"
#include "registry.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 15)

enum { CHANNELS_MOST = 16 };

typedef struct no_params {
    vv_object object;
} no_params;

typedef struct equalize_params {
    vv_object object;
    int method;
    char *tile;
    double clip;
} equalize_params;

enum { GLOBAL, ADAPTIVE };

static const char *const method_names[] = {"global", "adaptive", NULL};
static const char *const method_aliases[] = {"clahe", "adaptive", NULL};

static const vv_property no_properties[] = {{0}};
static const vv_property equalize_properties[] = {
    {VV_PROP(equalize_params, method), .kind = VV_KIND_ENUM, .names = method_names, .aliases = method_aliases,
     .doc = "global: by the histogram of all samples; adaptive: by those of tiles, between whose middles it is mixed "
            "(CLAHE)"},
    {VV_PROP(equalize_params, tile), .kind = VV_KIND_STRING, .automatic = "an eighth of each axis",
     .when = "method=adaptive", .doc = "side of a tile, in samples or as a length: 32, 20mm; tiles are about as large"},
    {VV_PROP(equalize_params, clip), .kind = VV_KIND_F64, .limited = true, .min = 1, .max = 1e6, .def = 3,
     .when = "method=adaptive",
     .doc = "how much contrast may grow: how many times the mean a bin of a tile's histogram may hold"},
    {0},
};

static const vv_class match_class = {
    .name = "match", .doc = "parameters of match", .size = sizeof(no_params), .properties = no_properties};
static const vv_class equalize_class = {
    .name = "equalize",
    .doc = "parameters of equalize",
    .size = sizeof(equalize_params),
    .properties = equalize_properties,
};

/* The way of a channel's numbers to others. */
typedef struct way {
    vvi_ranks own, to; /* to: of the other volume; none: the numbers become even */
    void *held, *to_held;
} way;

typedef struct shared {
    vvi_making making;
    const vv_field_info *in, *info;
    way ways[CHANNELS_MOST];
    bool matches;
    vv_job *job;
} shared;

/* As many samples as are no larger than v in one have to be no larger than the result in the other. */
static double matched(double v, const way *w)
{
    const size_t n = w->own.n, m = w->to.n;
    const double part = vvi_line_at(v, w->own.at, w->own.up_to, n) / w->own.up_to[n - 1];
    return vvi_line_at(part * w->to.up_to[m - 1], w->to.up_to, w->to.at, m);
}

/* Ranks spread over the numbers that there are: least and largest stay. */
static double evened(double v, const way *w)
{
    const vvi_ranks *r = &w->own;
    const double first = r->up_to[0], last = r->up_to[r->n - 1], lo = r->at[0], hi = r->at[r->n - 1];
    return last > first ? lo + (hi - lo) * ((vvi_line_at(v, r->at, r->up_to, r->n) - first) / (last - first)) : v;
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t bytes = (size_t)(s->making.slabs.step[0] * s->in->components) * sizeof(double);
    *scratch_out = vvi_alloc(s->job, bytes, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(bytes);
}

static void finish(void *scratch, void *user)
{
    vvi_free(scratch);
}

static void map_row(double *row, const shared *s, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const way *w = &s->ways[i % (size_t)s->in->components];
        if (isfinite(row[i]))
            row[i] = s->matches ? matched(row[i], w) : evened(row[i], w);
    }
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick brick = vvi_brick_part(&s->making.brick, &box);
    const size_t n = (size_t)(box.n[0] * s->in->components), each = vv_type_bytes(s->info->type);
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const int64_t row = vvi_slabs_row(&s->making.slabs, &box, j, k) * s->in->components;
            const char *in = (const char *)brick.data + j * brick.stride[1] + k * brick.stride[2];
            vvi_samples_to_f64(scratch, in, s->in->type, n);
            map_row(scratch, s, n);
            vvi_samples_from_f64(s->making.out + (size_t)row * each, scratch, s->info->type, n);
        }
    return vvi_job_poll(s->job);
}

static vv_status check(const vv_field_info *info, const char *name)
{
    if (info->meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED, "%s: labels are names, not amounts, and have no histogram to change", name);
    if (info->components > CHANNELS_MOST)
        return vv_fail(VV_E_ARGUMENT, "%s: takes at most %d channels, found %d; pick some with 'volvis channel'", name,
                       CHANNELS_MOST, info->components);
    return VV_OK;
}

static vv_status plan_match(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    vv_status st;
    *out = inputs[0];
    if ((st = check(&inputs[0], "match")) != VV_OK || (st = check(&inputs[1], "match")) != VV_OK)
        return st;
    if (inputs[1].components != 1 && inputs[1].components != inputs[0].components)
        return vv_fail(VV_E_ARGUMENT,
                       "match: expected a reference of one channel or of %d, found %d; pick one with 'volvis channel'",
                       inputs[0].components, inputs[1].components);
    out->type = inputs[1].type;
    out->value_scale = inputs[1].value_scale;
    out->value_offset = inputs[1].value_offset;
    memcpy(out->value_unit, inputs[1].value_unit, sizeof out->value_unit);
    return VV_OK;
}

/* Tiles along each axis. */
static vv_status find_tiles(int64_t n[3], const vv_field_info *info, const equalize_params *p)
{
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        const int64_t dims = info->grid.dims[a];
        int64_t side = (dims + 7) / 8;
        if (p->tile && *p->tile)
            st = vvi_parse_samples(&side, p->tile, &info->grid, a, "equalize: tile");
        if (st == VV_OK && side < 1)
            return vv_fail(VV_E_ARGUMENT, "equalize: tile '%s' is less than one sample along %c", p->tile, "xyz"[a]);
        n[a] = side < dims && side > 0 ? (dims + side / 2) / side : 1;
    }
    return st;
}

static vv_status plan_equalize(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs,
                               const vv_object *params)
{
    int64_t tiles[3];
    *out = inputs[0];
    out->value_unit[0] = 0; /* the numbers no longer measure it */
    const vv_status st = check(&inputs[0], "equalize");
    return st == VV_OK ? find_tiles(tiles, &inputs[0], (const equalize_params *)params) : st;
}

static vv_status find_way(way *w, const vv_field *field, const vv_field *reference, int component, vv_job *job)
{
    const int other = reference && vv_field_get_info(reference)->components > 1 ? component : 0;
    vv_status st = vvi_ranks_of(&w->own, &w->held, field, component, job);
    if (st == VV_OK && reference)
        st = vvi_ranks_of(&w->to, &w->to_held, reference, other, job);
    if (st == VV_OK && reference && w->own.n > 0 && w->to.n == 0)
        st = vv_fail(VV_E_ARGUMENT, "match: the reference has no finite sample, and so no histogram");
    return st;
}

static vv_status run_any(vv_field **out, const vv_field *in, const vv_field *reference, const vv_field_info *info,
                         const vv_box *box, vv_job *job)
{
    const vvi_work work = {.stage = reference ? "match" : "equalize", .start = start, .item = item, .finish = finish};
    shared s = {.making = {.in = in, .slabs = vvi_slabs_of(box, ITEM_SAMPLES)},
                .in = vv_field_get_info(in),
                .info = info,
                .matches = reference != NULL,
                .job = job};
    vv_status st = VV_OK;
    for (int c = 0; c < s.in->components && st == VV_OK; c++)
        st = find_way(&s.ways[c], in, reference, c, job);
    if (st == VV_OK)
        st = vvi_making_run(out, &s.making, info, box, box, &work, &s, job);
    for (int c = 0; c < s.in->components; c++) {
        vvi_ranks_release(s.ways[c].held);
        vvi_ranks_release(s.ways[c].to_held);
    }
    return st;
}

static vv_status run_match(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                           const vv_box *box, vv_job *job)
{
    const vv_field_info infos[2] = {*vv_field_get_info(inputs[0]), *vv_field_get_info(inputs[1])};
    vv_field_info info;
    const vv_status st = plan_match(&info, infos, 2, params);
    *out = NULL;
    if (st == VV_OK && (infos[0].value_scale < 0) != (infos[1].value_scale < 0))
        return vv_fail(VV_E_UNSUPPORTED,
                       "match: stored numbers of one volume fall where values rise; 'volvis calc' writes values");
    return st == VV_OK ? run_any(out, inputs[0], inputs[1], &info, box, job) : st;
}

static vv_status run_equalize(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                              const vv_box *box, vv_job *job)
{
    vv_field_info info;
    const vv_status st = plan_equalize(&info, vv_field_get_info(inputs[0]), 1, params);
    *out = NULL;
    const equalize_params *p = (const equalize_params *)params;
    int64_t tiles[3];
    if (st != VV_OK)
        return st;
    if (p->method == GLOBAL)
        return run_any(out, inputs[0], NULL, &info, box, job);
    const vv_status found = find_tiles(tiles, vv_field_get_info(inputs[0]), p);
    return found == VV_OK ? vvi_equalize_tiles(out, inputs[0], tiles, p->clip, box, job) : found;
}

static const vv_operand inputs_taken[] = {
    {"volume", VV_IS_FIELD, 1, 1, "the volume that it works on"},
    {"reference", VV_IS_FIELD, 1, 1, "the volume whose histogram the result has, on any grid"},
    {0},
};

const vv_operation vvi_operation_match = {
    .api = VV_OPERATION_API,
    .name = "match",
    .component = "filter",
    .group = "values",
    .doc = "change values so that their histogram becomes that of another volume; the order of values stays",
    .example = "volvis match post.nrrd reference=pre.nrrd -o alike.nrrd",
    .params = &match_class,
    .inputs = inputs_taken,
    .run_box = run_match,
    .plan = plan_match,
};

const vv_operation vvi_operation_equalize = {
    .api = VV_OPERATION_API,
    .name = "equalize",
    .component = "filter",
    .group = "values",
    .doc = "spread values so that their histogram is even, over all or tile by tile (CLAHE), within their range",
    .example = "volvis equalize head.nrrd -o even.nrrd --method adaptive --tile 20mm",
    .params = &equalize_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_equalize,
    .plan = plan_equalize,
};
