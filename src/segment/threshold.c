/* Threshold: values to labels, by limits that somebody gives or that the samples' histogram decides. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/making.h"
#include "registry.h"
#include "segment/connectivity.h"
#include "segment/cuts.h"
#include "segment/label_result.h"
#include "segment/runs.h"

#include <math.h>
#include <string.h>

#define ITEM_SAMPLES ((int64_t)1 << 19)

enum { BY_RANGE, BY_OTSU, BY_MULTI_OTSU, BY_MEAN, BY_LI, BY_HYSTERESIS };

typedef struct threshold_params {
    vv_object object;
    int method;
    char *range, *strong;
    int64_t classes;
    int connectivity;
    bool settled; /* no property: see settle() */
    vvi_cuts cuts;
} threshold_params;

static const char *const method_names[] = {"range", "otsu", "multi-otsu", "mean", "li", "hysteresis", NULL};

static const vv_property properties[] = {
    {VV_PROP(threshold_params, method), .kind = VV_KIND_ENUM, .names = method_names,
     .doc = "range: the values of --range; otsu: what divides values into two classes that vary least within "
            "themselves (Otsu 1979); multi-otsu: the same for more classes; mean: above the mean; li: above the "
            "value of least cross-entropy (Li & Lee 1993); hysteresis: the parts of --range that have a value of "
            "--strong in them"},
    {VV_PROP(threshold_params, range), .kind = VV_KIND_STRING, .automatic = "none: it must be given",
     .when = "method=range|hysteresis", .doc = "values inside, both ends included: 100..200, 100.. or ..200"},
    {VV_PROP(threshold_params, classes), .kind = VV_KIND_I64, .limited = true, .min = 2, .max = VVI_CUTS_MOST + 1,
     .def = 3, .when = "method=multi-otsu", .doc = "how many classes there are: labels 0, 1, ..."},
    {VV_PROP(threshold_params, strong), .kind = VV_KIND_STRING, .automatic = "none: it must be given",
     .when = "method=hysteresis", .doc = "values, of those in --range, one of which keeps a part: 300.."},
    {VV_PROP(threshold_params, connectivity), .kind = VV_KIND_ENUM, .names = vvi_connectivity_names,
     .aliases = vvi_connectivity_aliases, .when = "method=hysteresis",
     .doc = "how voxels of a part touch: at faces (6, in an image 4), at edges too (18), at corners too (26, in an "
            "image 8)"},
    {0},
};

/* A range that is needed: "threshold: range: '...' is not". */
static vv_status parse(vvi_value_range *out, const char *text, const char *name)
{
    char place[32] = "threshold: ";
    strcat(place, name);
    *out = (vvi_value_range){-INFINITY, INFINITY};
    if (text && *text)
        return vvi_value_range_parse(out, text, place);
    return vv_fail(VV_E_ARGUMENT, "threshold: %s is needed: values such as 100..200, or 100.. for all from 100%s", name,
                   strcmp(name, "range") == 0 ? "; or --method otsu, which finds them" : "");
}

/* Whether samples decide. */
static bool looks(const vv_object *params)
{
    const int method = ((const threshold_params *)params)->method;
    return method != BY_RANGE && method != BY_HYSTERESIS;
}

static vv_status check(const vv_object *object, const char *path)
{
    const threshold_params *p = (const threshold_params *)object;
    vvi_value_range range;
    vv_status st = VV_OK;
    (void)path;
    if (p->range && *p->range)
        st = parse(&range, p->range, "range");
    if (st == VV_OK && p->strong && *p->strong)
        st = parse(&range, p->strong, "strong");
    return st;
}

static const vv_class threshold_class = {
    .name = "threshold",
    .doc = "parameters of threshold",
    .size = sizeof(threshold_params),
    .properties = properties,
    .check = check,
};

/* Ranges that are typed, as values. */
static vv_status typed_ranges(vvi_value_range *range, vvi_value_range *strong, const threshold_params *p)
{
    vv_status st = parse(range, p->range, "range");
    if (st != VV_OK || p->method == BY_RANGE)
        return st;
    if ((st = parse(strong, p->strong, "strong")) == VV_OK && (strong->lo < range->lo || strong->hi > range->hi))
        st = vv_fail(VV_E_ARGUMENT, "threshold: strong values %s are not all in the range %s", p->strong, p->range);
    return st;
}

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    vvi_value_range range, strong;
    (void)n_inputs;
    *out = vvi_label_result(&inputs[0], VV_TYPE_U8);
    const vv_status st = vvi_label_need_one_component(&inputs[0], "threshold");
    if (st != VV_OK || !looks(params))
        return st != VV_OK ? st : typed_ranges(&range, &strong, (const threshold_params *)params);
    if (inputs[0].meaning == VV_MEANING_LABEL)
        return vv_fail(VV_E_UNSUPPORTED,
                       "threshold: labels are names, not amounts; give the numbers of those inside with --range");
    return VV_OK;
}

/* Cuts ------------------------------------------------------------------------------------------------------------ */

static vvi_cut_method cut_method(const threshold_params *p)
{
    return p->method == BY_MEAN ? VVI_CUT_MEAN : p->method == BY_LI ? VVI_CUT_LI : VVI_CUT_OTSU;
}

static int n_classes(const threshold_params *p)
{
    return p->method == BY_MULTI_OTSU ? (int)p->classes : 2;
}

static void tell(const vvi_cuts *cuts, vv_job *job)
{
    vvi_find_numbers(job, "thresholds", cuts->told, (size_t)cuts->n);
    for (int c = 0; c < cuts->n; c++)
        vvi_find_phrase(job, "%d above %.9g", c + 1, cuts->told[c]);
}

/* One set of them for all time steps. */
static vv_status settle(vv_object *params, const vv_field_series *fields, vv_job *job)
{
    threshold_params *p = (threshold_params *)params;
    const vv_status st = vvi_cuts_find(&p->cuts, cut_method(p), n_classes(p), fields, job);
    p->settled = st == VV_OK;
    if (p->settled)
        tell(&p->cuts, job);
    return st;
}

static vv_status find_cuts(vvi_cuts *out, const threshold_params *p, const vv_field *field, bool first, vv_job *job)
{
    *out = p->cuts;
    if (p->settled)
        return VV_OK;
    const vv_status st = vvi_cuts_of_field(out, cut_method(p), n_classes(p), field, job);
    if (st == VV_OK && first)
        tell(out, job);
    return st;
}

/* Labels by the keys of samples ----------------------------------------------------------------------------------- */

typedef struct shared {
    vvi_making making;
    int n; /* ranges; a label is how many of them a sample is in */
    vvi_key_range range[VVI_CUTS_MOST];
    vv_job *job;
} shared;

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const size_t n = (size_t)s->making.slabs.step[0];
    (void)worker;
    *scratch_out = vvi_alloc(s->job, n, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(n);
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static vv_status item(void *scratch, void *user, size_t index)
{
    const shared *s = user;
    const vv_box box = vvi_slabs_item(&s->making.slabs, index);
    const vv_brick in = vvi_brick_part(&s->making.brick, &box);
    uint8_t *more = scratch;
    for (int64_t k = 0; k < box.n[2]; k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            uint8_t *out = (uint8_t *)s->making.out + vvi_slabs_row(&s->making.slabs, &box, j, k);
            const char *row = (const char *)in.data + j * in.stride[1] + k * in.stride[2];
            vvi_key_range_row(out, row, in.stride[0], in.type, &s->range[0], box.n[0]);
            for (int c = 1; c < s->n; c++) {
                vvi_key_range_row(more, row, in.stride[0], in.type, &s->range[c], box.n[0]);
                for (int64_t i = 0; i < box.n[0]; i++)
                    out[i] = (uint8_t)(out[i] + more[i]);
            }
        }
    return VV_OK;
}

static vv_status set_ranges(shared *s, const threshold_params *p, const vv_field *field, const vv_box *box, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const bool first = box->lo[0] == 0 && box->lo[1] == 0 && box->lo[2] == 0;
    vvi_value_range range, unused;
    vvi_cuts cuts;
    vv_status st;
    if (p->method == BY_RANGE) {
        if ((st = typed_ranges(&range, &unused, p)) != VV_OK)
            return st;
        range = vvi_value_range_as_typed(&range, info);
        s->range[0] = vvi_key_range_of(&range, info);
        s->n = 1;
        return VV_OK;
    }
    if ((st = find_cuts(&cuts, p, field, first, job)) != VV_OK)
        return st;
    for (; s->n < cuts.n; s->n++) {
        range = (vvi_value_range){cuts.above[s->n], INFINITY};
        s->range[s->n] = vvi_key_range_of(&range, info);
    }
    return VV_OK;
}

/* Hysteresis ------------------------------------------------------------------------------------------------------ */

/* Marks the parts that have a strong sample: where a run's samples are cut into runs of strong ones. */
static void keep_strong(uint32_t *label, const vvi_runs *weak, const vvi_runs *strong)
{
    for (size_t row = 0; row < weak->n_rows; row++) {
        uint32_t w = weak->first[row];
        for (uint32_t i = strong->first[row]; i < strong->first[row + 1]; i++) {
            while (weak->end[w] <= strong->lo[i]) /* a strong run lies in a weak one */
                w++;
            label[weak->part[w]] = 1;
        }
    }
}

static vv_status find_runs(vvi_runs *weak, vvi_runs *strong, const vv_field *field, const threshold_params *p,
                           vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const vv_box all = vv_field_box(field);
    const vvi_touch touch = {.axes = p->connectivity + 1};
    vvi_value_range range, core;
    vv_brick brick;
    vv_status st = typed_ranges(&range, &core, p);
    if (st != VV_OK || (st = vv_field_brick(&brick, field, &all, job)) != VV_OK)
        return st;
    range = vvi_value_range_as_typed(&range, info);
    core = vvi_value_range_as_typed(&core, info);
    const vvi_run_source of_range = {.brick = &brick, .range = vvi_key_range_of(&range, info)};
    const vvi_run_source of_core = {.brick = &brick, .range = vvi_key_range_of(&core, info)};
    if ((st = vvi_runs_find(weak, &of_range, &touch, "threshold", job)) == VV_OK)
        st = vvi_runs_find(strong, &of_core, &touch, "threshold", job);
    vv_brick_release(&brick);
    return st;
}

static vv_status run_hysteresis(vv_field **out, const vv_field *field, const threshold_params *p, vv_job *job)
{
    const vv_field_info result = vvi_label_result(vv_field_get_info(field), VV_TYPE_U8);
    vvi_runs weak = {0}, strong = {0};
    uint32_t *label = NULL;
    void *data;
    vv_status st = find_runs(&weak, &strong, field, p, job);
    const size_t bytes = ((size_t)weak.n_parts + 1) * sizeof *label;
    if (st == VV_OK && !(label = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(bytes);
    if (st == VV_OK && (st = vv_field_new_empty(out, &data, &result, job)) == VV_OK) {
        keep_strong(label, &weak, &strong);
        st = vvi_runs_paint(data, VV_TYPE_U8, &weak, label, job);
    }
    vvi_free(label);
    vvi_runs_finish(&weak);
    vvi_runs_finish(&strong);
    if (st == VV_OK || !*out)
        return st;
    vv_field_release(*out);
    *out = NULL;
    return st;
}

/* All of it ------------------------------------------------------------------------------------------------------- */

static vv_status run_box(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                         const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.stage = "threshold", .start = start, .item = item, .finish = finish};
    const threshold_params *p = (const threshold_params *)params;
    const vv_box all = vv_field_box(inputs[0]);
    vv_field_info info;
    shared s = {.making = {.in = inputs[0], .slabs = vvi_slabs_of(box, ITEM_SAMPLES)}, .job = job};
    *out = NULL;
    vv_status st = plan(&info, vv_field_get_info(inputs[0]), n_inputs, params);
    if (st != VV_OK)
        return st;
    if (p->method == BY_HYSTERESIS && memcmp(&all, box, sizeof all) != 0)
        return vv_fail(VV_E_LIMIT, "threshold: hysteresis needs all samples in memory at once: raise the limit with "
                                   "--memory, or crop the volume");
    if (p->method == BY_HYSTERESIS)
        return run_hysteresis(out, inputs[0], p, job);
    if ((st = set_ranges(&s, p, inputs[0], box, job)) != VV_OK)
        return st;
    return vvi_making_run(out, &s.making, &info, box, box, &work, &s, job);
}

const vv_operation vvi_operation_threshold = {
    .api = VV_OPERATION_API,
    .name = "threshold",
    .component = "segment",
    .group = "segmentation",
    .doc = "values to labels: 1 for those inside a range, or a label for each class; NaN is in none and becomes 0",
    .example = "volvis threshold head.nrrd -o bone.nrrd --range 150..",
    .params = &threshold_class,
    .inputs = VV_ONE_VOLUME,
    .run_box = run_box,
    .plan = plan,
    .looks = looks,
    .settle = settle,
    .in_order = true,
};
