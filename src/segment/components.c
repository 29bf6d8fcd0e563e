/* Components: each connected part of labels, of a mask or of a range of values gets a label of its own. */
#include "segment/components.h"
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include "registry.h"
#include "segment/connectivity.h"
#include "segment/label_result.h"
#include "segment/voxels.h"

#include <stdio.h>
#include <string.h>

static const vv_property properties[] = {
    {VV_PROP(vvi_components_params, range), .kind = VV_KIND_STRING, .automatic = "all that is not 0",
     .doc = "values whose parts are found, both ends included: 100..200, 100.. or ..200"},
    {VV_PROP(vvi_components_params, merge), .kind = VV_KIND_BOOL,
     .doc = "parts of different labels that touch are one part; so it always is with --range"},
    VVI_CONNECTIVITY_PROPERTY(vvi_components_params, connectivity, "parts"),
    {VV_PROP(vvi_components_params, min_size), .kind = VV_KIND_STRING, .automatic = "one voxel",
     .doc = "smaller parts are left out: 100 (voxels), or a volume, 2.5mm3"},
    {VV_PROP(vvi_components_params, keep), .kind = VV_KIND_I64, .limited = true, .min = 1, .max = 4294967295.0,
     .automatic = "all", .doc = "only so many parts, the largest"},
    {0},
};

static bool given(const char *text)
{
    return text && *text;
}

static vv_status check(const vv_object *object, const char *path)
{
    const vvi_components_params *p = (const vvi_components_params *)object;
    vvi_value_range range;
    (void)path;
    return given(p->range) ? vvi_value_range_parse(&range, p->range, "components: range") : VV_OK;
}

static const vv_class components_class = {
    .name = "components",
    .doc = "parameters of components",
    .size = sizeof(vvi_components_params),
    .properties = properties,
    .check = check,
};

static vv_status plan(vv_field_info *out, const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const vvi_components_params *p = (const vvi_components_params *)params;
    double size;
    (void)n_inputs;
    vv_status st = vvi_label_need_one_component(&inputs[0], "components");
    if (st == VV_OK)
        st = check(params, NULL);
    if (st == VV_OK)
        st = vvi_voxels_parse(&size, p->min_size, &inputs[0].grid, "components: min_size");
    if (st == VV_OK && !given(p->range) && !p->merge && vv_type_is_float(inputs[0].type))
        return vv_fail(VV_E_ARGUMENT, "components: the values are real numbers, of which no two are one part; give "
                                      "those inside with --range LO..HI, or --merge for all that are not 0");
    *out = vvi_label_result(&inputs[0], VV_TYPE_U32);
    return st;
}

vv_status vvi_components_runs(vvi_runs *out, const vv_brick *brick, const vv_field_info *info,
                              const vvi_components_params *p, vv_job *job)
{
    vvi_value_range range = {0, 0};
    const vvi_touch touch = {.axes = p->connectivity + 1};
    vvi_run_source source = {.brick = brick, .other = !given(p->range), .each = !given(p->range) && !p->merge};
    if (given(p->range)) {
        const vv_status st = vvi_value_range_parse(&range, p->range, "components: range");
        if (st != VV_OK)
            return st;
        range = vvi_value_range_as_typed(&range, info);
    }
    source.range = vvi_key_range_of(&range, info);
    return vvi_runs_find(out, &source, &touch, "components", job);
}

void vvi_components_tell(const vvi_part_sizes *s, vv_job *job)
{
    const uint32_t told = s->n_kept < VVI_PARTS_TOLD ? s->n_kept : VVI_PARTS_TOLD;
    double largest[VVI_PARTS_TOLD];
    char sizes[VVI_PARTS_TOLD * 24] = "", kept[24] = "";
    for (uint32_t i = 0; i < told; i++) {
        const size_t at = strlen(sizes);
        largest[i] = (double)s->largest[i];
        snprintf(sizes + at, sizeof sizes - at, "%s%llu",
                 i == 0          ? ""
                 : i + 1 == told ? " and "
                                 : ", ",
                 (unsigned long long)s->largest[i]);
    }
    vvi_find_count(job, "parts_found", s->n_parts);
    vvi_find_count(job, "parts", s->n_kept);
    vvi_find_numbers(job, "largest_voxels", largest, told);
    if (s->n_kept != s->n_parts)
        snprintf(kept, sizeof kept, "%u of ", s->n_kept);
    if (told == 0)
        vvi_find_phrase(job, "%s%u parts", kept, s->n_parts);
    else if (told == 1)
        vvi_find_phrase(job, "%s%u part%s, %sof %s voxels", kept, s->n_parts, s->n_parts == 1 ? "" : "s",
                        s->n_parts == 1 ? "" : "the largest ", sizes);
    else
        vvi_find_phrase(job, "%s%u parts, the largest of %s voxels", kept, s->n_parts, sizes);
}

vv_status vvi_components_kept(double *least, uint32_t *most, const vv_field_info *info, const vvi_components_params *p)
{
    *most = p->keep > 0 ? (uint32_t)p->keep : UINT32_MAX;
    return vvi_voxels_parse(least, p->min_size, &info->grid, "components: min_size");
}

static vv_status paint(vv_field **out, const vvi_runs *runs, const vv_field_info *info, const vvi_components_params *p,
                       vv_job *job)
{
    const vv_field_info result = vvi_label_result(info, VV_TYPE_U32);
    vvi_part_sizes sizes = {0};
    double least;
    uint32_t most;
    void *data;
    vv_status st = vvi_components_kept(&least, &most, info, p);
    if (st == VV_OK)
        st = vvi_part_sizes_find(&sizes, runs, least, most, job);
    if (st == VV_OK && (st = vv_field_new_empty(out, &data, &result, job)) == VV_OK)
        st = vvi_runs_paint(data, VV_TYPE_U32, runs, sizes.rank, job);
    if (st == VV_OK)
        vvi_components_tell(&sizes, job);
    vvi_part_sizes_finish(&sizes);
    return st;
}

static vv_status run(vv_field **out, const vv_field *const *inputs, size_t n_inputs, const vv_object *params,
                     vv_job *job)
{
    const vvi_components_params *p = (const vvi_components_params *)params;
    const vv_field_info *info = vv_field_get_info(inputs[0]);
    const vv_box all = vv_field_box(inputs[0]);
    vv_field_info planned;
    vvi_runs runs = {0};
    vv_brick brick;
    *out = NULL;
    vv_status st = plan(&planned, info, n_inputs, params);
    if (st != VV_OK || (st = vv_field_brick(&brick, inputs[0], &all, job)) != VV_OK)
        return st;
    st = vvi_components_runs(&runs, &brick, info, p, job);
    vv_brick_release(&brick);
    if (st == VV_OK)
        st = paint(out, &runs, info, p, job);
    vvi_runs_finish(&runs);
    if (st != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static uint64_t memory(const vv_field_info *inputs, size_t n_inputs, const vv_object *params)
{
    const bool values =
        ((const vvi_components_params *)params)->range || ((const vvi_components_params *)params)->merge;
    return vvi_runs_memory(&inputs[0], !values);
}

const vv_operation vvi_operation_components = {
    .api = VV_OPERATION_API,
    .name = "components",
    .component = "segment",
    .group = "segmentation",
    .doc = "connected parts, each with a label of its own: 1 is the largest, and the first in the volume of equal ones",
    .example = "volvis components head.nrrd -o parts.nrrd --range 150.. --min-size 50",
    .params = &components_class,
    .inputs = VV_ONE_VOLUME,
    .run = run,
    .plan = plan,
    .memory = memory,
    .passes = &vvi_components_passes,
};
