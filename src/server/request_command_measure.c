/* A measurement of the World as the line that measures it again: of the file where that alone says the same, else of
 * the scene that is saved first. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "measuring/measuring.h"
#include "measuring/world_data.h"
#include "model/classes.h"
#include "server/command.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Options --------------------------------------------------------------------------------------------------------- */

/* "1,2,3", with all digits. */
static void put_numbers(vvi_text *out, const char *option, const double *v, size_t n, const char *between)
{
    char number[32];
    vvi_text_printf(out, " --%s=", option);
    for (size_t i = 0; i < n; i++) {
        vvi_print_number(number, v[i]);
        vvi_text_printf(out, "%s%s", i ? between : "", number);
    }
}

/* Values from lo to hi; without an upper limit it is the surface of one value. */
static void put_values(vvi_text *out, double lo, double hi)
{
    char number[2][32];
    vvi_print_number(number[0], lo);
    vvi_print_number(number[1], hi);
    if (isinf(hi) && !isinf(lo))
        vvi_text_printf(out, " --iso=%s", number[0]);
    else
        vvi_text_printf(out, " --threshold=%s..%s", isinf(lo) ? "" : number[0], isinf(hi) ? "" : number[1]);
}

static bool is_set(const vv_measurement *m, const char *name)
{
    return vv_object_is_set(&m->base, name);
}

static void put_places(vvi_text *out, const vv_measurement *m)
{
    const size_t n = m->points ? m->points->n / 3 : 0;
    const double seed[3] = {m->seed.x, m->seed.y, m->seed.z};
    if (m->space == VV_MEASURE_IN_WORLD && (n || is_set(m, "seed")))
        vvi_text_add(out, " --space=world");
    for (size_t i = 0; i < n; i++)
        put_numbers(out, "point", m->points->v + 3 * i, 3, ",");
    if (is_set(m, "seed"))
        put_numbers(out, "seed", seed, 3, ",");
}

static void put_object(vvi_text *out, const vv_measurement *m)
{
    char digits[VVI_LABEL_DIGITS];
    if (is_set(m, "iso"))
        put_numbers(out, "iso", &m->iso, 1, "");
    if (is_set(m, "threshold_lo") || is_set(m, "threshold_hi")) {
        const double lo = is_set(m, "threshold_lo") ? m->threshold_lo : -INFINITY;
        const double hi = is_set(m, "threshold_hi") ? m->threshold_hi : INFINITY;
        put_values(out, lo, hi);
    }
    if (is_set(m, "label"))
        vvi_text_printf(out, " --label=%s", vvi_label_print(digits, (vv_label_id)m->label, false));
}

/* What is left: the rows of which the line has the same. */
static vv_status put_others(vvi_text *out, const vv_measurement *m)
{
    static const char *const same[] = {"box", "method", "closed", "bins", "samples", "component"};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++) {
        char *json = NULL;
        const vv_property *row = vv_class_find(&vvi_measurement_class, same[i]);
        if (!is_set(m, same[i]))
            continue;
        const vv_status st = vv_path_get(&json, &m->base, same[i]);
        if (st != VV_OK)
            return st;
        const size_t n = strlen(json), quoted = *json == '"';
        if (strcmp(json, "true") == 0)
            vvi_text_printf(out, " --%s", same[i]);
        else if (strcmp(json, "false") != 0)
            vvi_text_printf(out, " --%s=%.*s", row->option ? row->option : row->name, (int)(n - 2 * quoted),
                            json + quoted);
        free(json);
    }
    if (m->range && m->range->n == 2)
        put_numbers(out, "range", m->range->v, 2, "..");
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        if (p->on)
            vvi_text_printf(out, " --clip='plane(n=%.17g,%.17g,%.17g d=%.17g)'", p->normal.x, p->normal.y, p->normal.z,
                            p->offset);
    }
    return VV_OK;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

static bool uses(const vv_measurement *m, const char *property)
{
    const size_t n_points = m->points ? m->points->n / 3 : 0;
    const vv_measure_form *form = vv_measure_form_of(vv_measure_kind_of(m), VV_MEASURED_VOLUME, 0, n_points);
    return vvi_measure_has_word(form ? form->uses : NULL, property);
}

/* Whether a file says of its samples what the World says of the volume: nothing moves, cuts or chooses them. */
static bool is_file(const vv_volume *volume, const vvi_measured_volume *measured)
{
    static const char *const chosen[] = {"place", "attribute", "component", "frame", "missing"};
    for (size_t i = 0; i < sizeof chosen / sizeof *chosen; i++)
        if (vv_object_is_set(&volume->base, chosen[i]))
            return false;
    return measured->data.n_planes == 0;
}

/* The volume that is named, else the first that is visible. */
static const char *id_of(const vv_world *world, const vv_measurement *m)
{
    const vv_volume *first = vvi_first_visible(world);
    for (size_t i = 0; !m->volume && i < world->volumes->n; i++)
        if (first && world->volumes->entry[i].object == &first->base)
            return world->volumes->entry[i].id;
    return m->volume ? m->volume : "";
}

/* The line of the file; *whole false: the file alone would be another answer. */
static vv_status put_file(vvi_text *out, bool *whole, const vvi_request *r, const vv_measurement *m, vv_job *job)
{
    const vv_dataset *dataset;
    const vv_volume *volume = vvi_request_volume(r->world, id_of(r->world, m), &dataset);
    vvi_measured_volume measured = {0};
    vv_field *field = NULL;
    *whole = false;
    if (!volume)
        return VV_E_NOT_FOUND;
    if (m->file || m->other || m->mask || m->values || vv_dataset_is_mesh(dataset, job))
        return VV_OK;
    vv_status st = vv_dataset_field(&field, r->world, dataset, volume->attribute, volume->frame, job);
    if (st == VV_OK)
        st = vvi_measured_volume_take(&measured, field, r->world, volume, r->view, job);
    if (st == VV_OK && is_file(volume, &measured)) {
        const char *id = volume->data ? volume->data : r->world->datasets->entry[0].id;
        const bool chosen = is_set(m, "iso") || is_set(m, "threshold_lo") || is_set(m, "threshold_hi") ||
                            is_set(m, "label") || !uses(m, "iso");
        *whole = true;
        st = vvi_command_making(out, r->world, id, job);
        vvi_text_printf(out, "volvis measure %s ", vv_measure_kind_of(m)->name);
        if (st == VV_OK)
            st = vvi_command_input(out, r->world, id, job);
        put_places(out, m);
        put_object(out, m);
        if (!chosen && measured.data.ranged)
            put_values(out, measured.data.lo, measured.data.hi);
        if (st == VV_OK)
            st = put_others(out, m);
    }
    vvi_measured_volume_finish(&measured);
    vv_field_release(field);
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_object *found = vv_collection_find(r->world->measurements, r->name);
    vvi_text text = {0};
    bool whole;
    if (!found)
        return vv_fail(VV_E_NOT_FOUND, "there is no measurement '%.64s'", r->name);
    vv_status st = put_file(&text, &whole, r, (const vv_measurement *)(const void *)found, job);
    if (st == VV_OK && !whole) {
        vvi_text_add(&text, "volvis measure stored scene.vv.json ");
        vvi_command_quote(&text, r->name);
        vvi_text_add(&text, " # after saving the World as scene.vv.json");
    }
    if (st == VV_OK)
        vvi_request_tell_text(r, &text);
    vvi_text_free(&text);
    return st;
}

vv_status vvi_request_command_measure(vvi_client *client, int64_t id, const json_t *message)
{
    const char *name = json_string_value(json_object_get(message, "measurement"));
    vvi_request *r;
    vv_status st = vvi_request_new(&r, client, id, "command", run);
    if (st != VV_OK)
        return st;
    if ((st = vvi_request_copy(&r->name, r, name ? name : "")) != VV_OK)
        return st;
    return vvi_request_add_quick(r);
}
