/* The part of a made dataset that a view shows, and a picture of it in the place of what it is made of. */
#include "server/preview.h"
#include "core/job.h"
#include "core/os.h"
#include "core/vec.h"
#include "model/contents.h"
#include "model/dataset.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/render.h>

/* What is made first, to learn how long more of it takes. */
enum { TRIAL_SAMPLES = 1 << 15, PATH_ROOM = 192 };
/* A cubic spline of a box is that of the whole so far from its border, within a millionth. */
enum { MARGIN = 1, MARGIN_CUBIC = 12 };

typedef struct work {
    const vvi_preview_wish *wish;
    vvi_preview *out;
    const char *id;        /* of the dataset that would be made */
    vv_world *world;       /* with it */
    vv_scene *scene;       /* as it is seen now */
    const vv_actor *actor; /* NULL: the data are a mesh */
    vvi_made made;
    vv_object *params;
    int64_t frame;   /* that the volume shows */
    vv_affine place; /* from the data's own space to the World */
    vv_field *field; /* of the box */
    vv_job *job;
} work;

static void finish(work *w)
{
    vv_field_release(w->field);
    vv_object_release(w->params);
    vvi_made_close(&w->made);
    vv_scene_release(w->scene);
}

void vvi_preview_finish(vvi_preview *preview)
{
    vv_image_release(preview->image);
    vv_image_release(preview->input);
    *preview = (vvi_preview){0};
}

/* The World as it is ----------------------------------------------------------------------------------------------- */

static vv_status fail_unseen(const work *w)
{
    return vv_fail(VV_E_NOT_FOUND, "volumes.%s is not seen in this view: show it to see a preview", w->wish->volume);
}

/* What is shown now, and where its data's own space is. */
static vv_status find_actor(work *w)
{
    const vv_volume *volume = vvi_volume_named(w->world, w->wish->volume);
    bool mesh = false;
    w->frame = volume ? volume->frame : 0;
    for (size_t i = 0; i < w->scene->n_mesh_actors; i++)
        mesh |= strcmp(w->scene->mesh_actors[i].look.id, w->wish->volume) == 0;
    for (size_t i = 0; i < w->scene->n_actors; i++)
        if (strcmp(w->scene->actors[i].id, w->wish->volume) == 0)
            w->actor = &w->scene->actors[i];
    if (!w->actor)
        return mesh ? VV_OK : fail_unseen(w);
    vv_affine to_index;
    if (!vv_affine_invert(&to_index, vv_field_get_info(w->actor->field)->grid.index_to_world))
        return fail_unseen(w);
    w->place = vv_affine_compose(w->actor->index_to_world, to_index);
    return VV_OK;
}

static vv_status open_recipe(work *w)
{
    const vv_dataset *dataset = vvi_dataset_named(w->world, w->id);
    vv_status st = vvi_made_open(&w->made, w->world, dataset, w->job);
    if (st == VV_OK)
        st = vvi_made_params(&w->params, &w->made, w->job);
    return st == VV_OK ? vvi_made_plan(&w->out->info, &w->made, w->params, w->job) : st;
}

static bool makes_mesh(const work *w)
{
    return vv_operation_makes(w->made.operation) == VV_IS_MESH;
}

enum { TRIANGLE_BYTES = 24 }; /* three corners, and its share of vertices */

/* Voxels, or triangles, of an input, and their bytes. */
static vv_status weigh_input(uint64_t *parts, uint64_t *bytes, const work *w, const vv_dataset *input)
{
    vv_field_info info;
    vv_mesh *mesh = NULL;
    vv_status st;
    if (vv_dataset_is_mesh(input, w->job)) {
        if ((st = vv_dataset_mesh(&mesh, w->world, input, w->job)) == VV_OK) {
            *parts += vv_mesh_get_info(mesh)->n_triangles;
            *bytes += vv_mesh_get_info(mesh)->n_triangles * TRIANGLE_BYTES;
        }
        vv_mesh_release(mesh);
        return st;
    }
    uint64_t more = 0;
    if ((st = vv_dataset_info(&info, w->world, input, w->job)) == VV_OK)
        st = vv_field_info_bytes(&more, &info);
    if (st == VV_OK) {
        *parts += (uint64_t)info.grid.dims[0] * (uint64_t)info.grid.dims[1] * (uint64_t)info.grid.dims[2];
        *bytes += more;
    }
    return st;
}

static vv_status weigh(uint64_t *parts, work *w)
{
    vv_status st = makes_mesh(w) ? VV_OK : vv_field_info_bytes(&w->out->bytes, &w->out->info);
    *parts = 0;
    for (size_t i = 0; i < w->made.n && st == VV_OK; i++)
        if (w->made.input[i])
            st = weigh_input(parts, &w->out->bytes, w, w->made.input[i]);
    return st;
}

/* The samples ------------------------------------------------------------------------------------------------------ */

static vv_vec3 cross_hair_index(const work *w, vv_affine index_to_world)
{
    vv_affine to_index;
    return vv_affine_invert(&to_index, index_to_world) ? vv_affine_point(to_index, w->scene->cross_hair)
                                                       : (vv_vec3){0, 0, 0};
}

static vv_affine result_place(const work *w)
{
    return vv_affine_compose(w->place, w->out->info.grid.index_to_world);
}

static double samples_of(const vv_box *box)
{
    return (double)box->n[0] * (double)box->n[1] * (double)box->n[2];
}

static vv_status make_part(work *w, const vvi_made_run *run, const vv_box *box)
{
    vv_field_release(w->field);
    w->out->box = *box;
    return vvi_made_box(&w->field, &w->made, run, box, w->job);
}

/* All that is seen, where that is quickly made; else what is around the cross-hair. */
static vv_status make_in_time(work *w, const vvi_made_run *run, const vv_box *seen, const double middle[3])
{
    const vv_box trial = vvi_preview_smaller(seen, middle, TRIAL_SAMPLES);
    const double begin = vvi_os_seconds();
    const vv_status st = make_part(w, run, &trial);
    const double spent = vvi_os_seconds() - begin;
    const double most = spent > 0 ? samples_of(&trial) * w->wish->part_s / spent : INFINITY;
    if (st != VV_OK || samples_of(&trial) >= fmin(samples_of(seen), most))
        return st;
    const vv_box larger = vvi_preview_smaller(seen, middle, most);
    return make_part(w, run, &larger);
}

static vv_status make_box(work *w)
{
    const vv_affine to_world = result_place(w);
    const vv_vec3 at = cross_hair_index(w, to_world);
    const double middle[3] = {at.x, at.y, at.z};
    const int64_t *dims = w->out->info.grid.dims;
    vv_box seen = {{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    const bool plane = w->scene->renderer->plane != NULL;
    if (plane && !vvi_preview_seen(&seen, w->scene, to_world, dims, w->actor->cubic ? MARGIN_CUBIC : MARGIN))
        return vv_fail(VV_E_ARGUMENT, "nothing of the result is seen in this view");
    const vv_box wanted = plane ? seen : vvi_preview_smaller(&seen, middle, (double)w->wish->samples_most);
    vvi_made_run run;
    vv_status st = vvi_made_fail(&w->made, NULL, vvi_made_run_open(&run, w->world, w->made.dataset, w->frame, w->job));
    if (st == VV_OK)
        st = make_in_time(w, &run, &wanted, middle);
    vvi_made_run_close(&run);
    w->out->full = st == VV_OK && samples_of(&w->out->box) >= samples_of(&seen);
    return st;
}

/* The whole comes from the cache, and stays there for whoever wants it next. */
static vv_status make_whole(work *w)
{
    const int64_t *dims = w->out->info.grid.dims;
    w->out->full = true;
    if (makes_mesh(w)) {
        vv_mesh *mesh = NULL;
        const vv_status st = vv_dataset_mesh(&mesh, w->world, w->made.dataset, w->job);
        vv_mesh_release(mesh);
        return st;
    }
    w->out->box = (vv_box){{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    return vv_dataset_field(&w->field, w->world, w->made.dataset, NULL, w->frame, w->job);
}

/* The picture ------------------------------------------------------------------------------------------------------ */

static bool row_keeps_values(const vvi_made *made, const vv_object *params)
{
    vv_carry carry = {0};
    return made->operation->carry && made->operation->carry(&carry, params) == VV_OK && !carry.new_values;
}

/* What is made on the way changes what values mean as well as what is looked at. */
static bool inserted_keeps_values(const work *w)
{
    vvi_made made;
    vv_object *params = NULL;
    const vv_dataset *dataset =
        (const vv_dataset *)(const void *)vv_collection_find(w->world->datasets, w->wish->inserted);
    vv_status st = vvi_made_open(&made, w->world, dataset, w->job);
    if (st == VV_OK)
        st = vvi_made_params(&params, &made, w->job);
    const bool keeps = st == VV_OK && row_keeps_values(&made, params);
    vv_object_release(params);
    vvi_made_close(&made);
    return keeps;
}

/* Whether values mean what they did: they are seen as they were then. */
static bool keeps_values(const work *w)
{
    if (makes_mesh(w) || !w->actor ||
        !(w->wish->inserted ? inserted_keeps_values(w) : row_keeps_values(&w->made, w->params)))
        return false;
    const vv_field_info *now = vv_field_get_info(w->actor->field);
    return w->out->info.components == now->components && w->out->info.meaning == now->meaning;
}

static vv_status put_data(work *w, vv_object **root)
{
    char path[PATH_ROOM], name[PATH_ROOM];
    vv_object *data = NULL;
    vv_status st = VV_OK;
    if (!w->out->whole) {
        st = vv_object_new(&data, &vv_dataset_class, NULL);
        if (st == VV_OK)
            st = vvi_dataset_attach((vv_dataset *)(void *)data, w->field);
        snprintf(path, sizeof path, "datasets.%.128s", w->id);
        if (st == VV_OK)
            st = vv_path_put(root, path, data, NULL);
        vv_object_release(data);
    }
    snprintf(path, sizeof path, "volumes.%.128s.data", w->wish->volume);
    snprintf(name, sizeof name, "\"%.128s\"", w->id);
    return st == VV_OK ? vv_path_set(root, path, name, NULL) : st;
}

const char *const vvi_label_properties[] = {"table", "names", NULL};

/* New labels are seen as they will be: without the colours of those that they are made of. */
static vv_status forget_labels(const work *w, vv_object **root)
{
    char path[PATH_ROOM + 64];
    vv_status st = VV_OK;
    for (const char *const *name = vvi_label_properties; *name && st == VV_OK; name++) {
        snprintf(path, sizeof path, "volumes.%.128s." VVI_LABELS_PATH "%s", w->wish->volume, *name);
        st = vv_path_unset(root, path, NULL);
    }
    return st;
}

/* From where it is seen now, with the result in the place of the data. What it is made of is drawn on the way. */
static vv_status picture_world(vv_world **out, work *w)
{
    vv_world *fixed = NULL;
    vv_object *root;
    char path[PATH_ROOM];
    *out = NULL;
    vv_status st = vv_scene_fix(&fixed, w->scene);
    if (st == VV_OK && w->wish->tells_before)
        st = vv_render(&w->out->input, NULL, fixed, w->wish->view, NULL, w->job);
    if (st != VV_OK) {
        if (fixed)
            vv_object_release(&fixed->base);
        return st;
    }
    if (keeps_values(w)) {
        root = vv_object_retain(&fixed->base);
    } else {
        root = vv_object_retain(&w->world->base);
        snprintf(path, sizeof path, "views.%.128s.camera", w->wish->view);
        st = vv_path_copy(&root, &fixed->base, path, NULL);
        if (st == VV_OK)
            st = vv_path_copy(&root, &fixed->base, "cross_hair", NULL);
        if (st == VV_OK && !w->made.operation->carry && !w->wish->inserted)
            st = forget_labels(w, &root);
    }
    vv_object_release(&fixed->base);
    if (st == VV_OK)
        st = put_data(w, &root);
    if (st == VV_OK)
        *out = (vv_world *)(void *)root;
    else
        vv_object_release(root);
    return st;
}

static vv_status tell_window(work *w, vv_world *shown)
{
    vv_scene *scene = NULL;
    if (!w->scene->renderer->plane)
        return VV_OK;
    const vv_status st = vv_scene_resolve(&scene, shown, w->wish->view, w->job);
    for (size_t i = 0; st == VV_OK && i < scene->n_actors; i++)
        if (strcmp(scene->actors[i].id, w->wish->volume) == 0) {
            w->out->has_window = !scene->actors[i].colors && scene->actors[i].classes.kind != VV_SEGMENT_LABELS;
            w->out->window[0] = scene->actors[i].slices.lo;
            w->out->window[1] = scene->actors[i].slices.hi;
        }
    vv_scene_release(scene);
    return st;
}

static bool nearest_inside(int64_t out[3], vv_vec3 at, const vv_box *box)
{
    const double place[3] = {at.x, at.y, at.z};
    for (int a = 0; a < 3; a++) {
        const double nearest = floor(place[a] + 0.5);
        if (!(nearest >= (double)box->lo[a] && nearest < (double)(box->lo[a] + box->n[a])))
            return false;
        out[a] = (int64_t)nearest - box->lo[a];
    }
    return true;
}

static void tell_value(work *w)
{
    int64_t was[3], is[3];
    if (!w->field || !w->actor)
        return;
    const vv_box before = vv_field_box(w->actor->field);
    const int component = w->actor->component, components = vv_field_get_info(w->field)->components;
    w->out->has_value = nearest_inside(was, cross_hair_index(w, w->actor->index_to_world), &before) &&
                        nearest_inside(is, cross_hair_index(w, result_place(w)), &w->out->box);
    if (!w->out->has_value)
        return;
    w->out->before = vv_field_value(w->actor->field, was[0], was[1], was[2], component);
    w->out->after = vv_field_value(w->field, is[0], is[1], is[2], component < components ? component : 0);
}

static vv_status draw(work *w)
{
    vv_world *shown = NULL;
    vv_status st = picture_world(&shown, w);
    if (st == VV_OK)
        st = vv_render(&w->out->image, NULL, shown, w->wish->view, NULL, w->job);
    if (st == VV_OK)
        st = tell_window(w, shown);
    if (st == VV_OK)
        tell_value(w);
    if (shown)
        vv_object_release(&shown->base);
    return st;
}

/* From a part of what is seen, which is in memory. */
vv_status vvi_preview_seconds(double *out, const vv_world *world, const char *made, int64_t frame, vv_job *job)
{
    vvi_made_run run;
    const vv_dataset *dataset = (const vv_dataset *)(const void *)vv_collection_find(world->datasets, made);
    *out = NAN;
    if (vv_dataset_is_mesh(dataset, job))
        return VV_OK;
    vv_status st = vvi_made_run_open(&run, world, dataset, frame, job);
    if (st == VV_OK) {
        const vvi_run_plan plan = vvi_made_run_plan(&run, NULL);
        *out = vvi_run_seconds(&plan, job);
        st = vvi_job_poll(job);
    }
    vvi_made_run_close(&run);
    return st;
}

static vv_status tell_time(const work *w)
{
    if (!w->actor)
        return VV_OK;
    return vvi_made_fail(&w->made, NULL, vvi_preview_seconds(&w->out->seconds, w->world, w->id, w->frame, w->job));
}

static vv_status make(work *w)
{
    uint64_t parts;
    vv_status st = weigh(&parts, w);
    if (st == VV_OK && makes_mesh(w) && w->scene->renderer->plane)
        st = vv_fail(VV_E_UNSUPPORTED, "%s makes a mesh, which slices do not show", w->made.operation->name);
    if (st != VV_OK)
        return st;
    w->out->whole = !w->actor || !vvi_made_is_local(&w->made, w->params, w->out->info.n_frames);
    if (w->out->whole && parts > w->wish->whole_most && !w->wish->whole) {
        st = tell_time(w);
        if (st != VV_OK || !(w->out->seconds <= w->wish->part_s))
            return st;
    }
    st = w->out->whole ? make_whole(w) : make_box(w);
    return st == VV_OK ? draw(w) : st;
}

vv_status vvi_preview_make(vvi_preview *out, const vvi_preview_wish *wish, vv_job *job)
{
    work w = {
        .wish = wish, .out = out, .id = wish->made, .world = wish->world, .place = vv_affine_identity(), .job = job};
    *out = (vvi_preview){.seconds = NAN};
    vv_status st = vv_scene_resolve(&w.scene, w.world, wish->view, job);
    if (st == VV_OK)
        st = find_actor(&w);
    if (st == VV_OK)
        st = open_recipe(&w);
    if (st == VV_OK)
        st = make(&w);
    finish(&w);
    if (st != VV_OK)
        vvi_preview_finish(out);
    return st;
}
