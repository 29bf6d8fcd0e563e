/* Questions about data and about what is seen. */
#include "core/memory.h"
#include "grid/label_id.h"
#include "measuring/answer.h"
#include "scene/resolve.h"
#include "server/request.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/about.h>
#include <volvis/pick.h>

static void put_vector(vvi_result *out, const char *key, vv_vec3 v)
{
    vvi_result_numbers(out, key, (double[3]){v.x, v.y, v.z}, 3);
}

static vv_status run_pick(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const char *unit = r->world->unit ? r->world->unit : "voxels";
    char text[256] = "nothing there", digits[VVI_LABEL_DIGITS];
    vv_picked p;
    const vv_status st = vv_pick(&p, &r->pixel, 1, r->world, r->view, job);
    if (st != VV_OK)
        return st;
    vvi_result *out = &r->value;
    vvi_result_open(out, NULL, '{');
    vvi_result_bool(out, "hit", p.hit);
    if (p.hit) {
        vvi_result_string(out, "volume", p.volume);
        put_vector(out, "position", p.world);
        put_vector(out, "index", p.index);
        vvi_result_number(out, "value", p.volume ? p.value : (double)NAN);
        if (p.labelled) /* as text: pages read numbers as doubles */
            vvi_result_string(out, "label", vvi_label_print(digits, p.label, p.label_unsigned));
        vvi_result_string(out, "unit", unit);
        vvi_result_number(out, "depth", p.depth);
        snprintf(text, sizeof text, "%s%.64s at %.5g, %.5g, %.5g %s", p.volume ? "" : "a thing ",
                 p.volume ? p.volume : "", p.world.x, p.world.y, p.world.z, unit);
        const size_t n = strlen(text);
        if (p.labelled)
            snprintf(text + n, sizeof text - n, ": label %s", digits);
        else if (p.volume && isfinite(p.value))
            snprintf(text + n, sizeof text - n, ": %.6g", p.value);
    }
    vvi_result_string(out, "text", text);
    vvi_result_close(out, '}');
    return VV_OK;
}

vv_status vvi_request_pick(vvi_client *client, int64_t id, const json_t *message)
{
    const double x = json_number_value(json_object_get(message, "x")),
                 y = json_number_value(json_object_get(message, "y"));
    vvi_request *r;
    if (!(x >= 0 && x <= 1 && y >= 0 && y <= 1))
        return vv_fail(VV_E_ARGUMENT, "a pick is at x and y from 0 to 1");
    const vv_status st = vvi_request_new(&r, client, id, "pick", run_pick);
    if (st != VV_OK)
        return st;
    r->pixel = (vv_pixel){(int32_t)fmin(x * client->width, client->width - 1),
                          (int32_t)fmin(y * client->height, client->height - 1)};
    return vvi_request_add_quick(r, vvi_request_size(r, client->width, client->height));
}

/* The volume that a message names, else the first; NULL, and an error. */
const vv_volume *vvi_request_volume(const vv_world *world, const char *id, const vv_dataset **dataset_out)
{
    const vv_volume *volume = id ? vvi_volume_named(world, id) : world->volumes->n ? vvi_volume_nth(world, 0) : NULL;
    *dataset_out = volume ? vvi_volume_dataset(world, volume) : NULL;
    if (!*dataset_out)
        vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s' with data", id ? id : "");
    return *dataset_out ? volume : NULL;
}

static void put_statistics(vvi_result *out, const vv_statistics *s, const char *unit)
{
    vvi_result_open(out, NULL, '{');
    vvi_result_number(out, "lo", s->histogram_lo);
    vvi_result_number(out, "hi", s->histogram_hi);
    vvi_result_open(out, "counts", '[');
    for (int i = 0; i < s->n_bins; i++)
        vvi_result_unsigned(out, NULL, s->histogram[i]);
    vvi_result_close(out, ']');
    vvi_result_string(out, "unit", unit);
    vvi_result_number(out, "min", s->min);
    vvi_result_number(out, "max", s->max);
    vvi_result_number(out, "mean", s->mean);
    vvi_result_number(out, "deviation", s->deviation);
    vvi_result_unsigned(out, "n", s->count);
    vvi_result_open(out, "percentiles", '{');
    vvi_result_number(out, "1", s->percentile[1]);
    vvi_result_number(out, "50", s->percentile[2]);
    vvi_result_number(out, "99", s->percentile[3]);
    vvi_result_close(out, '}');
    vvi_result_close(out, '}');
}

/* Of what pictures show: without what stands for no value. */
static vv_status seen_statistics(vv_statistics *out, vv_field **field, const vv_volume *volume, vv_job *job)
{
    vv_actor actor = {.field = *field, .component = (int)volume->component, .statistics = out};
    vv_status st = vv_field_statistics(out, *field, actor.component, job);
    if (st == VV_OK)
        st = vvi_resolve_missing(&actor, volume, NULL, job);
    *field = (vv_field *)(uintptr_t)actor.field;
    return st;
}

static vv_status run_histogram(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_dataset *dataset;
    const vv_volume *volume = vvi_request_volume(r->world, r->name, &dataset);
    vv_field *field = NULL;
    vv_statistics *s = volume ? vvi_calloc(1, sizeof *s) : NULL;
    if (!volume)
        return VV_E_NOT_FOUND;
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_dataset_field(&field, r->world, dataset, volume->attribute, volume->frame, job);
    if (st == VV_OK)
        st = seen_statistics(s, &field, volume, job);
    if (st == VV_OK)
        put_statistics(&r->value, s, vv_field_get_info(field)->value_unit);
    vv_field_release(field);
    free(s);
    return st;
}

vv_status vvi_request_of_volume(vvi_client *client, int64_t id, const json_t *message, const char *name,
                                vv_status (*run)(vvi_task *task, vv_job *job))
{
    vvi_request *r;
    const vv_status st = vvi_request_new(&r, client, id, name, run);
    return st == VV_OK ? vvi_request_add_quick(r, vvi_request_take_text(&r->name, message, "volume")) : st;
}

vv_status vvi_request_histogram(vvi_client *client, int64_t id, const json_t *message)
{
    return vvi_request_of_volume(client, id, message, "histogram", run_histogram);
}

static vv_status run_info(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_dataset *dataset = vvi_dataset_named(r->world, r->name);
    vv_field_info info;
    vv_answer *answer = NULL;
    if (!dataset)
        return vv_fail(VV_E_NOT_FOUND, "there is no dataset '%.64s'", r->name);
    vv_status st = vv_dataset_info(&info, r->world, dataset, job);
    if (st == VV_OK && (st = vv_about_samples(&answer, &info)) == VV_OK) {
        vvi_result_open(&r->value, NULL, '{');
        vvi_result_string(&r->value, "path", dataset->path);
        vvi_answer_add_json(&r->value, answer);
        vvi_result_close(&r->value, '}');
    }
    vv_answer_release(answer);
    return st;
}

vv_status vvi_request_info(vvi_client *client, int64_t id, const json_t *message)
{
    vvi_request *r;
    if (!json_is_string(json_object_get(message, "dataset")))
        return vv_fail(VV_E_ARGUMENT, "'info' needs a dataset");
    const vv_status st = vvi_request_new(&r, client, id, "info", run_info);
    return st == VV_OK ? vvi_request_add_quick(r, vvi_request_take_text(&r->name, message, "dataset")) : st;
}
