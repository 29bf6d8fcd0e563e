/* What the light of a picture depends on: the part of the World that its view shows, the data, the renderer. */
#include "render/picture_depends.h"
#include "grid/crc.h"
#include "model/contents.h"
#include "model/object_hash.h"
#include "scene/resolve.h"
#include <string.h>
#include <volvis/version.h>

/* Rows that change nothing in its light, or that are looked at here in another way. */
typedef struct left_out {
    const char *cls, *row;
} left_out;

static const left_out always[] = {
    {"world", "schema"},   {"world", "title"},   {"world", "datasets"},     {"world", "volumes"},
    {"world", "lights"},   {"world", "views"},   {"world", "measurements"}, /* those that are shown follow */
    {"volume", "title"},   {"volume", "data"},   {"paint", "data"},         {"texture", "image"},
    {"labels", "names"},   {"light", "title"},   {"view", "title"},         {"render", "method"},
    {"render", "methods"}, {"render", "budget"}, /* which only ends it */
};

/* Boxes and axes take part in framing; letters and lines are drawn when it is looked at. */
static bool frames(const vv_property *row)
{
    return !strcmp(row->name, "box") || !strcmp(row->name, "axes") || !strcmp(row->name, "cut_planes");
}

static bool leaves_out(const void *user, const vv_object *owner, const vv_property *row)
{
    const vv_scene *scene = user;
    const char *cls = owner->cls->name;
    for (size_t i = 0; i < sizeof always / sizeof *always; i++)
        if (!strcmp(cls, always[i].cls) && !strcmp(row->name, always[i].row))
            return true;
    if (owner == scene->view->decorations)
        return !frames(row);
    if (owner != &scene->world->base)
        return false;
    if (!strcmp(row->name, "background")) /* noise is judged over it */
        return !(scene->noise > 0);
    return !strcmp(row->name, "cross_hair") && scene->renderer->heeds &&
           !scene->renderer->heeds(scene->params, VV_ASPECT_CROSS_HAIR);
}

static uint64_t hash_world(const vv_scene *scene, uint64_t hash)
{
    const vvi_hash_rules rules = {.leaves_out = leaves_out, .user = scene};
    const vv_collection *volumes = scene->world->volumes, *lights = scene->world->lights;
    hash = vvi_object_hash(&scene->world->base, &rules, hash);
    hash = vvi_object_hash(&scene->view->base, &rules, hash);
    for (size_t i = 0; i < volumes->n; i++)
        if (vvi_volume_nth(scene->world, i)->visible)
            hash = vvi_object_hash(volumes->entry[i].object, &rules, hash);
    hash = vvi_hash_u64(lights->n > 0, hash); /* without any there are others */
    for (size_t i = 0; i < lights->n; i++)
        if (((const vv_light *)(const void *)lights->entry[i].object)->on)
            hash = vvi_object_hash(lights->entry[i].object, &rules, hash);
    hash = vvi_hash_text(scene->renderer->name, hash);
    return scene->params ? vvi_object_hash(scene->params, &rules, hash) : hash;
}

static uint64_t hash_place(const vv_affine *place, uint64_t hash)
{
    const double *v = (const double *)(const void *)place;
    for (size_t i = 0; i < sizeof *place / sizeof *v; i++)
        hash = vvi_hash_f64(v[i], hash);
    return hash;
}

static uint64_t hash_image(const vv_image *image, uint64_t hash)
{
    const size_t n = (size_t)image->width * (size_t)image->height;
    hash = vvi_hash_u64((uint64_t)image->width, hash);
    return vvi_hash_u64(vvi_crc32(0, image->rgba, 4 * n * sizeof *image->rgba, vvi_crc_has_fold()), hash);
}

/* Samples: by what they are, or by who has them. */
static vv_status add_field(uint64_t *hash, const vv_field *field, bool lasting, vv_job *job)
{
    uint32_t sum = 0;
    if (!field || !lasting) {
        *hash = vvi_hash_u64(field ? vv_field_identity(field) : 0, *hash);
        return VV_OK;
    }
    const vv_field_info *info = vv_field_get_info(field);
    const vv_status st = vv_field_checksum(&sum, field, job);
    for (int axis = 0; axis < 3; axis++)
        *hash = vvi_hash_u64((uint64_t)info->grid.dims[axis], *hash);
    *hash = vvi_hash_text(vv_type_name(info->type), *hash);
    *hash = vvi_hash_u64(sum, *hash);
    return st;
}

/* Colours of labels may be those of a volume that is not seen. */
static uint64_t hash_paint(const vv_paint *paint, uint64_t hash)
{
    for (size_t i = 0; paint->field && i < 4 * paint->n_color; i++)
        hash = vvi_hash_f64(paint->color[i], hash);
    return hash;
}

static vv_status add_actor(uint64_t *hash, const vv_actor *actor, bool lasting, vv_job *job)
{
    vv_status st = add_field(hash, actor->field, lasting, job);
    if (st == VV_OK)
        st = add_field(hash, actor->colors, lasting, job);
    if (st == VV_OK)
        st = add_field(hash, actor->paint.field, lasting, job);
    *hash = hash_paint(&actor->paint, *hash);
    *hash = hash_place(&actor->index_to_world, *hash);
    *hash = hash_place(&actor->paint.index_to_world, *hash);
    if (actor->texture.image)
        *hash = hash_image(actor->texture.image, *hash);
    return st;
}

vv_status vvi_picture_depends(uint64_t *out, const vv_picture *picture, bool lasting, vv_job *job)
{
    const vv_scene *scene = picture->scene;
    uint64_t hash = hash_world(scene, vvi_hash_text(vv_version(), VVI_PICTURE_VERSION));
    vv_status st = VV_OK;
    hash = vvi_hash_text(picture->isa, hash);
    for (size_t i = 0; i < scene->n_actors && st == VV_OK; i++)
        st = add_actor(&hash, &scene->actors[i], lasting, job);
    for (size_t i = 0; i < scene->n_mesh_actors; i++) {
        hash = hash_paint(&scene->mesh_actors[i].look.paint, hash);
        hash = hash_place(&scene->mesh_actors[i].place, hash);
        hash = vvi_hash_u64(vv_mesh_checksum(scene->mesh_actors[i].mesh), hash);
    }
    *out = hash;
    return st;
}
