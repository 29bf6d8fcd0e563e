/* A measurement of the World as the line that measures it again: of the file where that alone says the same, else of
 * the scene that is saved first. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "core/vec.h"
#include "measuring/measuring.h"
#include "model/classes.h"
#include "run/measured.h"
#include "server/command.h"

#include <math.h>
#include <string.h>

/* Planes of the question, which the verb takes as clips. */
static void put_clips(vvi_text *out, const vv_measurement *m)
{
    for (size_t i = 0; i < m->cut_planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)m->cut_planes->entry[i].object;
        if (p->on)
            vvi_text_printf(out, " --clip='plane(n=%.17g,%.17g,%.17g d=%.17g)'", p->normal.x, p->normal.y, p->normal.z,
                            p->offset);
    }
}

/* Whether the values that the World shows are the object, since no other is asked for. */
static bool is_shown(const vv_measurement *m, const vv_measured_data *data)
{
    static const char *const objects[] = {"iso", "threshold_lo", "threshold_hi", "label"};
    const size_t n_points = m->points ? m->points->n / 3 : 0;
    const vv_measure_form *form = vv_measure_form_of(vv_measure_kind_of(m), VV_MEASURED_VOLUME, 0, n_points);
    bool shown = data->ranged && form && vvi_measure_has_word(form->uses, "iso") && !vvi_measurement_has_region(m);
    for (size_t i = 0; i < sizeof objects / sizeof *objects; i++)
        shown &= !vv_object_is_set(&m->base, objects[i]);
    return shown;
}

/* What the World shows without an upper limit is the surface of one value. */
static void put_shown(vvi_text *out, const vv_measured_data *data)
{
    char number[2][32];
    vvi_print_number(number[0], data->lo);
    vvi_print_number(number[1], data->hi);
    vvi_text_printf(out, isinf(data->hi) ? " --iso=%s" : " --threshold=%s..%s", number[0], number[1]);
}

/* The line of a file whose samples are those of the World. */
static vv_status put_line(vvi_text *out, const vvi_request *r, const char *id, const vv_measurement *m,
                          const vv_measured_data *data, vv_job *job)
{
    vv_status st = vvi_command_making(out, r->world, id, job);
    vvi_text_printf(out, "volvis measure %s ", vv_measure_kind_of(m)->name);
    if (st == VV_OK)
        st = vvi_command_input(out, r->world, id, job);
    if (st == VV_OK)
        st = vvi_command_options(out, &m->base, vvi_command_quote);
    if (st == VV_OK && vvi_measurement_has_region(m))
        st = vvi_command_options(out, m->region, vvi_command_quote);
    put_clips(out, m);
    if (is_shown(m, data))
        put_shown(out, data);
    return st;
}

/* Whether a file says of its samples what the World says of the volume: nothing moves, cuts or chooses them, or tells
 * their lengths in another unit. unit: of the file. */
static bool is_file(const vv_volume *volume, const vvi_measured_volume *measured, const char *unit)
{
    static const char *const chosen[] = {"place", "attribute", "component", "frame", "missing"};
    for (size_t i = 0; i < sizeof chosen / sizeof *chosen; i++)
        if (vv_object_is_set(&volume->base, chosen[i]))
            return false;
    return measured->data.n_planes == 0 && strcmp(vv_field_get_info(measured->field)->grid.unit, unit) == 0;
}

/* Whether a mesh of the World is what its file has: nothing moves or cuts it, or tells its lengths in another unit. */
static bool is_mesh_file(const vvi_measured_meshes *shown)
{
    const vv_affine here = vv_affine_identity();
    const vv_measured_data *data = shown->data;
    bool moved = shown->n != 1 || vvi_length(vvi_sub(data->place.origin, here.origin)) > 0;
    for (int a = 0; a < 3 && !moved; a++)
        moved = vvi_length(vvi_sub(data->place.axis[a], here.axis[a])) > 0;
    return !moved && data->n_planes == 0 && strcmp(data->unit, vv_mesh_get_info(data->mesh)->unit) == 0;
}

/* As put_file(), of meshes: made ones are measured before a file rounds their places. */
static vv_status put_mesh_file(vvi_text *out, bool *whole, const vvi_request *r, const vv_measurement *m,
                               const vv_volume *volume, const vv_dataset *dataset, vv_job *job)
{
    vvi_measured_meshes shown;
    vv_status st = vvi_measured_meshes_take(&shown, r->world, m->volume, "the World", job);
    *whole = st == VV_OK && dataset->path && !vv_dataset_is_made(dataset) && is_mesh_file(&shown);
    if (*whole)
        st = put_line(out, r, vvi_volume_dataset_id(r->world, volume), m, shown.data, job);
    vvi_measured_meshes_finish(&shown);
    return st;
}

/* The line of the file; *whole false: the file alone would be another answer. */
static vv_status put_file(vvi_text *out, bool *whole, const vvi_request *r, const vv_measurement *m, vv_job *job)
{
    const char *id = vvi_measured_volume_id(r->world, m->volume);
    const vv_dataset *dataset = NULL;
    const vv_volume *volume = id ? vvi_request_volume(r->world, id, &dataset) : NULL;
    vvi_measured_all measured = {0};
    *whole = false;
    if (!id)
        return vv_fail(VV_E_NOT_FOUND, "there is no volume '%.64s' that could be measured", m->volume ? m->volume : "");
    if (!volume)
        return VV_E_NOT_FOUND;
    if (m->file || m->other || m->mask || m->values)
        return VV_OK;
    if (vv_dataset_is_mesh(dataset, job))
        return put_mesh_file(out, whole, r, m, volume, dataset, job);
    vv_field_info info;
    vv_status st = vv_dataset_info(&info, r->world, dataset, job);
    if (st == VV_OK)
        st = vvi_measured_shown(&measured.input, r->world, id, r->view, job);
    if (st == VV_OK && is_file(volume, &measured.input.volume, info.grid.unit)) {
        *whole = true;
        st = put_line(out, r, vvi_volume_dataset_id(r->world, volume), m, &measured.input.volume.data, job);
    }
    vvi_measured_close(&measured);
    return st;
}

static vv_status run(vvi_task *task, vv_job *job)
{
    vvi_request *r = (vvi_request *)(void *)task;
    const vv_measurement *found = r->name ? vvi_measurement_named(r->world, r->name) : NULL;
    vvi_text text = {0};
    bool whole;
    if (!found)
        return vv_fail(VV_E_NOT_FOUND, "there is no measurement '%.64s'", r->name ? r->name : "");
    vv_status st = put_file(&text, &whole, r, found, job);
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
    vvi_request *r;
    const vv_status st = vvi_request_new(&r, client, id, "command", run);
    return st == VV_OK ? vvi_request_add_quick(r, vvi_request_take_text(&r->name, message, "measurement")) : st;
}
