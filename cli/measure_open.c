/* The samples that are measured, and what their scene says of them: place, cut planes, threshold, channel. */
#include "core/vec.h"
#include "grid/field.h"
#include "measure.h"
#include "mesh_scene.h"
#include "model/classes.h"
#include "model/frame.h"
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define NO_LIMIT 1e308 /* the largest value that scenes write */

/* n . M q >= d, made unit again. */
vv_plane cli_plane_mapped(const vv_plane *p, const vv_affine *map)
{
    const vv_vec3 n = p->normal;
    const vv_vec3 turned = {vvi_dot(n, map->axis[0]), vvi_dot(n, map->axis[1]), vvi_dot(n, map->axis[2])};
    const double length = vvi_length(turned);
    return (vv_plane){vvi_scaled(turned, 1 / length), (p->offset - vvi_dot(n, map->origin)) / length};
}

/* Planes of the model's World and of its first visible volume, whose own are in its data's space. */
static void take_planes(cli_measuring *m, const vv_collection *planes, const vv_affine *place)
{
    for (size_t i = 0; planes && i < planes->n; i++) {
        const vv_cut_plane *p = (const vv_cut_plane *)(const void *)planes->entry[i].object;
        if (!p->on || m->n_planes == sizeof m->planes / sizeof *m->planes)
            continue;
        vv_vec3 n = p->normal;
        vvi_unit(&n);
        vv_plane *out = &m->planes[m->n_planes++];
        vv_affine inverse;
        *out = (vv_plane){n, p->offset};
        if (place && vv_affine_invert(&inverse, *place))
            *out = cli_plane_mapped(out, &inverse);
    }
}

static const vv_volume *first_visible(const vv_world *world)
{
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *v = (const vv_volume *)(const void *)world->volumes->entry[i].object;
        if (v->visible)
            return v;
    }
    return NULL;
}

vv_status cli_measuring_put_at(vv_field **field, const vv_affine *place)
{
    vv_field_info info = *vv_field_get_info(*field);
    vv_field *placed;
    info.grid.index_to_world = vv_affine_compose(*place, info.grid.index_to_world);
    const vv_status st = vvi_field_relabel(&placed, *field, &info);
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = placed;
    return VV_OK;
}

/* What the scene does to its data: place, threshold, component, its own cut planes. */
static vv_status take_volume(cli_measuring *m, const vv_volume *v)
{
    const vv_affine place = vvi_frame_matrix((const vv_frame *)(const void *)v->place);
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)v->segmentation;
    const vv_threshold *threshold = (const vv_threshold *)(const void *)segmentation->threshold;
    const vv_status st = cli_measuring_put_at(&m->field, &place);
    if (st != VV_OK)
        return st;
    m->place = place;
    take_planes(m, v->cut_planes, &place);
    m->chosen |= m->of_scene;
    if (!m->o->component)
        m->choice.component = (int)v->component;
    if (segmentation->kind == VV_SEGMENT_THRESHOLD && vv_object_is_set(&threshold->base, "lo") && !m->chosen) {
        m->chosen = m->of_scene = true;
        m->choice.lo = threshold->lo;
        const bool limited = vv_object_is_set(&threshold->base, "hi") && threshold->hi < NO_LIMIT;
        m->choice.hi = limited ? threshold->hi : INFINITY;
    }
    return VV_OK;
}

/* --clip adds planes to those of the World; which, is kept. */
static vv_status edit_clip(cli_measuring *m, cli_edits *edits)
{
    vvi_text *out = &m->result->planes;
    vv_world *world = vv_model_snapshot(edits->model);
    const size_t n_before = world->cut_planes->n;
    vv_object_release(&world->base);
    const vv_status st = cli_edit_clip(edits);
    world = vv_model_snapshot(edits->model);
    for (size_t i = n_before; i < world->cut_planes->n; i++) {
        char *json = NULL;
        if (vv_object_to_json(&json, world->cut_planes->entry[i].object, 0) == VV_OK)
            vvi_text_printf(out, "%s%s", out->n ? ", " : "", json);
        free(json);
    }
    vv_object_release(&world->base);
    return st;
}

/* A label between two others is none of the values between them. */
static bool shows_labels(const cli_measuring *m, const vv_volume *volume)
{
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    return vv_object_is_set(&segmentation->base, "kind") ? segmentation->kind == VV_SEGMENT_LABELS
                                                         : vv_field_get_info(m->field)->meaning == VV_MEANING_LABEL;
}

/* Unit, planes, place and threshold of the World; --clip adds to its planes. */
static vv_status take_world(cli_measuring *m, vv_model *model, const char *view)
{
    const cli_look look = {.clip = m->o->clip};
    cli_edits edits = {.command = m->command, .model = model, .look = &look};
    const vv_status st = edit_clip(m, &edits);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(model);
    take_planes(m, world->cut_planes, NULL);
    const vv_volume *volume = first_visible(world);
    if (volume && !shows_labels(m, volume) && cli_mesh_scene_iso(&m->choice.lo, world, view, m->command->job)) {
        m->of_scene = true;
        m->choice.hi = INFINITY;
    }
    const vv_status taken = volume ? take_volume(m, volume) : VV_OK;
    vv_object_release(&world->base);
    return taken;
}

/* Data alone: nothing but the unit. */
static vv_status open_data(cli_measuring *m, vv_model *model, const char *word)
{
    vvi_text unit = {0};
    vv_status st = cli_measuring_read(&m->field, &m->input, &m->stream, m->command, word);
    if (st != VV_OK)
        return st;
    vvi_text_json(&unit, vv_field_get_info(m->field)->grid.unit);
    st = unit.bad ? vv_fail_memory(unit.n) : vv_model_set(model, NULL, "unit", unit.s);
    vvi_text_free(&unit);
    return st;
}

vv_status cli_measuring_world(vv_model *model, vvi_recipe *recipe, cli_command *command, const char *word, bool edited)
{
    cli_edits edits = {.command = command, .model = model};
    vv_world *world = NULL;
    vv_status st = cli_input_world(&world, recipe, command, word);
    if (st == VV_OK && (st = vv_model_replace(model, NULL, world)) == VV_OK && edited)
        st = cli_edit_paths(&edits);
    vv_object_release(world ? &world->base : NULL);
    return st;
}

/* Figures of other samples than those that the scene was made of are told as such: a picture of them is refused. The
 * checksum is that of the first time step. */
static vv_status note_changed(const cli_measuring *m, const vv_world *world, const char *word)
{
    const vv_volume *volume = first_visible(world);
    const vv_dataset *dataset = volume ? cli_input_dataset(world, volume) : NULL;
    uint32_t expected = 0, found = 0;
    if (!dataset || !dataset->checksum || m->input.frame > 0 || !vvi_checksum_parse(&expected, dataset->checksum))
        return VV_OK;
    const vv_status st = vv_field_checksum(&found, m->field, m->command->job);
    if (st == VV_OK && found != expected)
        cli_command_note(m->command,
                         "%s: was made from samples of %s, and those of '%s' are others now, crc32:%08" PRIx32
                         ": these are measured",
                         word, dataset->checksum, dataset->path, found);
    return st;
}

/* The samples are of the data that the World has then. */
static vv_status open_scene(cli_measuring *m, vv_model *model, vvi_recipe *recipe, const char *word, bool edited)
{
    vv_status st = cli_measuring_world(model, recipe, m->command, word, edited);
    if (st != VV_OK)
        return st;
    vv_world *world = vv_model_snapshot(model);
    if ((st = cli_input_open_in(&m->input, m->command, world, word)) == VV_OK)
        st = vvi_stream_samples(&m->field, &m->stream, m->input.file, m->input.frame < 0 ? 0 : m->input.frame,
                                m->command->job);
    if (st == VV_OK)
        st = note_changed(m, world, word);
    vv_object_release(&world->base);
    return st;
}

vv_status cli_measuring_open_samples(cli_measuring *m, const char *word)
{
    const vv_collection *set = m->command->common->set;
    const bool edited = set && set->n && m->result->edited && strcmp(word, m->result->edited) == 0;
    vv_model *model = NULL;
    vvi_recipe recipe = {0};
    vv_status st = vv_model_new(&model, m->command->runtime);
    if (st == VV_OK)
        st = edited || cli_input_contents(m->command, word) != CLI_INPUT_DATA
                 ? open_scene(m, model, &recipe, word, edited)
                 : open_data(m, model, word);
    if (st == VV_OK)
        st = take_world(m, model, recipe.view);
    const int64_t n_frames = st == VV_OK ? vv_file_info(m->input.file)->n_frames : 0;
    if (n_frames > 1 && m->input.frame < 0)
        cli_command_note(m->command, "%s: the first of %lld time steps is measured; choose another with FILE@N",
                         m->input.path, (long long)n_frames);
    vv_model_release(model);
    return st;
}

vv_status cli_measuring_read(vv_field **out, cli_input *input, vvi_stream *stream, cli_command *command,
                             const char *word)
{
    const vv_status st = cli_input_open(input, command, word);
    return st != VV_OK
               ? st
               : vvi_stream_samples(out, stream, input->file, input->frame < 0 ? 0 : input->frame, command->job);
}
