/* Which options what is seen has a use for, whatever the method: meshes have no samples, labels and colours no window,
 * and a transfer function whose nodes are values no range. */
#include "edits.h"
#include "input.h"
#include "refusal.h"
#include "scene/resolve.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* What there is to change, of all volumes together. */
typedef enum content {
    CONTENT_SAMPLES = 1,
    CONTENT_VERTEX_VALUES = 2, /* of meshes */
    CONTENT_WINDOW = 4,        /* slices show values over one */
    CONTENT_RANGE = 8,         /* another range gives other colours or opacities */
    CONTENT_LABELS = 16,
    CONTENT_COLORS = 32,   /* samples are colours */
    CONTENT_TRANSFER = 64, /* samples that a transfer function colours */
    CONTENT_AMOUNTS = 128  /* samples that are neither labels nor colours */
} content;

static const struct {
    const char *option;
    unsigned needs; /* one of them will do */
    const char *why;
} uses[] = {
    {"slice", CONTENT_SAMPLES, "slices do not show meshes"},
    {"method", CONTENT_SAMPLES, "slices do not show meshes"}, /* of one that shows planes */
    {"iso", CONTENT_SAMPLES,
     "a mesh has no iso-value, it is a surface already; 'volvis isosurface' makes another one of the volume"},
    {"threshold", CONTENT_SAMPLES, "a mesh has no samples, it is a surface already"},
    {"tf", CONTENT_TRANSFER | CONTENT_VERTEX_VALUES, NULL},
    {"window", CONTENT_WINDOW, NULL}, /* see why_none() */
    {"range", CONTENT_RANGE | CONTENT_VERTEX_VALUES, NULL},
    {"percentile", CONTENT_RANGE, NULL},
    {"missing", CONTENT_AMOUNTS, NULL},
};

static const char *why_none(unsigned contents, const char *option)
{
    if (strcmp(option, "missing") == 0)
        return contents & CONTENT_LABELS   ? "labels are names, and none of them stands for no value"
               : contents & CONTENT_COLORS ? "the samples are colours, and none of them stands for no value"
                                           : "it is about samples of volumes, and a mesh has none";
    if (contents & CONTENT_LABELS)
        return "labels have colours by their numbers; --tf shows them as values";
    if (contents & CONTENT_COLORS)
        return "the samples are colours, which are shown as they are";
    if (contents & CONTENT_SAMPLES && !(contents & CONTENT_TRANSFER))
        return "surfaces, meshes among them, have one colour here; --color sets it, and a volume alone is shown as a "
               "cloud";
    if (strcmp(option, "window") == 0 && contents & CONTENT_SAMPLES)
        return "these slices have the colours of a transfer function, which --range stretches";
    if (contents & CONTENT_SAMPLES)
        return "the opacities and colours of this transfer function are given by value";
    return "the mesh has no values at its vertices that could have colours; --color gives it one";
}

static bool is_given(const cli_edits *edits, const char *option)
{
    if (strcmp(option, "missing") == 0)
        return ((const cli_reading *)cli_command_options(edits->command, &cli_reading_class))->missing != NULL;
    const char *text = cli_look_text(edits->look, option);
    const vv_renderer *planes = vv_registry_plane_renderer(edits->command->registry);
    return text && (strcmp(option, "method") != 0 || (planes && strcmp(text, planes->name) == 0));
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

static vv_status resolve(vv_actor *out, cli_edits *edits, const vv_world *world, const char *id)
{
    char method[64], path[256];
    double load_s = 0;
    cli_edit_method_of(method, edits);
    snprintf(path, sizeof path, "views.%s.render.%s", edits->view, method);
    const vv_renderer *renderer = vv_registry_renderer(edits->command->registry, method);
    const vv_object *params = vv_path_object(&world->base, path);
    *out = (vv_actor){0};
    return vvi_resolve_actor(out, &load_s, world, id, vvi_volume_named(world, id), renderer, params,
                             edits->command->job);
}

/* The same World with another range of one volume. */
static vv_status set_other_range(vv_world **out, const vv_world *world, const char *id)
{
    static const char *const ends[] = {"range_lo", "range_hi"};
    const vv_volume *volume = vvi_volume_named(world, id);
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    const vv_transfer *transfer = (const vv_transfer *)(const void *)segmentation->transfer;
    const double lo = transfer->range_lo, hi = transfer->range_hi;
    const double others[] = {lo - (hi - lo) / 3, hi + (hi - lo) / 2};
    vv_object *root = vv_object_retain((vv_object *)&world->base);
    vv_status st = VV_OK;
    for (size_t i = 0; i < 2 && st == VV_OK; i++) {
        char path[192], number[40];
        snprintf(path, sizeof path, "volumes.%s.segmentation.transfer.%s", id, ends[i]);
        snprintf(number, sizeof number, "%.17g", others[i]);
        st = vv_path_set(&root, path, number, NULL);
    }
    *out = (vv_world *)(void *)root;
    return st;
}

static bool same_rows(const double *a, size_t n_a, const double *b, size_t n_b, size_t columns)
{
    return n_a == n_b && (n_a == 0 || memcmp(a, b, n_a * columns * sizeof *a) == 0);
}

static bool same_classes(const vv_classification *a, const vv_classification *b)
{
    return same_rows(a->opacity, a->n_opacity, b->opacity, b->n_opacity, 2) &&
           same_rows(a->color, a->n_color, b->color, b->n_color, 4);
}

/* Whether it follows: with another range it looks otherwise. */
static vv_status follows_range(bool *out, cli_edits *edits, const vv_world *world, const char *id,
                               const vv_actor *actor)
{
    vv_world *other = NULL;
    vv_actor changed = {0};
    vv_status st = set_other_range(&other, world, id);
    if (st == VV_OK)
        st = resolve(&changed, edits, other, id);
    *out = st != VV_OK || !same_classes(&actor->classes, &changed.classes);
    vvi_actor_finish(&changed);
    vv_object_release(other ? &other->base : NULL);
    return st;
}

static vv_status look_at_samples(unsigned *contents, cli_edits *edits, const vv_world *world, const char *id,
                                 const vv_volume *volume)
{
    const cli_look *o = edits->look;
    vv_actor actor;
    bool follows = false;
    const bool transfer = cli_edit_heeds(edits, world, VV_ASPECT_TRANSFER);
    *contents |= CONTENT_SAMPLES | (transfer ? CONTENT_TRANSFER : 0);
    if (!o->window && !o->range && !o->percentile && !is_given(edits, "missing"))
        return VV_OK;
    vv_status st = resolve(&actor, edits, world, id);
    const bool labels = actor.classes.kind == VV_SEGMENT_LABELS;
    const int colors = ((const vv_volume_slices *)(const void *)volume->slices)->colors;
    const bool slices = cli_edit_is_slice(edits),
               window = slices && !labels && !actor.colors && colors == VV_SLICE_WINDOW;
    const bool classes =
        transfer && actor.classes.kind == VV_SEGMENT_TRANSFER && (!slices || colors == VV_SLICE_TRANSFER);
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    if (st == VV_OK && classes && vv_object_is_set(segmentation->transfer, "range_lo")) /* else it is for another */
        st = follows_range(&follows, edits, world, id, &actor);
    *contents |= (window ? CONTENT_WINDOW : 0) | (window || follows ? CONTENT_RANGE : 0) |
                 (labels ? CONTENT_LABELS : 0) | (!labels && !actor.colors ? CONTENT_AMOUNTS : 0) |
                 (actor.colors ? CONTENT_COLORS : 0);
    vvi_actor_finish(&actor);
    return st;
}

static vv_status look_at_mesh(unsigned *contents, cli_edits *edits, const vv_world *world, const vv_dataset *dataset)
{
    vv_mesh *mesh = NULL;
    if (!edits->look->tf && !edits->look->range)
        return VV_OK;
    const vv_status st = vv_dataset_mesh(&mesh, world, dataset, edits->command->job);
    *contents |= st == VV_OK && vv_mesh_get_info(mesh)->values ? CONTENT_VERTEX_VALUES : 0;
    vv_mesh_release(mesh);
    return st;
}

/* any_out: something is seen at all. */
static vv_status look_at(unsigned *contents, bool *any_out, cli_edits *edits, const vv_world *world)
{
    vv_status st = VV_OK;
    *contents = 0;
    *any_out = false;
    for (size_t i = 0; i < world->volumes->n && st == VV_OK; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        const vv_dataset *dataset = vvi_volume_dataset(world, volume);
        if (!volume->visible || !dataset)
            continue;
        *any_out = true;
        st = vv_dataset_is_mesh(dataset, edits->command->job)
                 ? look_at_mesh(contents, edits, world, dataset)
                 : look_at_samples(contents, edits, world, world->volumes->entry[i].id, volume);
    }
    return st;
}

/* Options --------------------------------------------------------------------------------------------------------- */

static bool any_is_given(const cli_edits *edits)
{
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (is_given(edits, uses[i].option))
            return true;
    return false;
}

vv_status cli_edit_check_contents(cli_edits *edits, const vv_world *world)
{
    unsigned contents;
    bool any;
    if (!any_is_given(edits))
        return VV_OK;
    if (look_at(&contents, &any, edits, world) != VV_OK || !any)
        return VV_OK; /* what cannot be read is told by who shows it */
    for (size_t i = 0; i < sizeof uses / sizeof *uses; i++)
        if (is_given(edits, uses[i].option) && !(contents & uses[i].needs))
            return cli_refused(edits->command, uses[i].option,
                               vv_fail(VV_E_ARGUMENT, "--%s does nothing here: %s", uses[i].option,
                                       uses[i].why ? uses[i].why : why_none(contents, uses[i].option)));
    return VV_OK;
}
