/* Amounts together with labels: the segments lie in what they were found in, and its skin would hide them. */
#include "core/job.h"
#include "model/contents.h"
#include "scene/resolve.h"
#include <math.h>

/* Of the optical depth that it has alone: what is seen by its skin is then a veil whose outline is still there. */
#define VEIL 0.03

static const vv_volume *volume_of(const vv_scene *scene, const vv_actor *actor)
{
    return vvi_volume_named(scene->world, actor->id);
}

/* Nobody says how opaque it is. */
static bool is_fitted(const vv_scene *scene, const vv_actor *actor)
{
    double lo, hi;
    const vv_renderer *renderer = scene->renderer;
    if (vvi_actor_projects(scene, actor) || (renderer->solid && renderer->solid(&lo, &hi, scene, actor)))
        return false;
    const vv_segmentation *s = (const vv_segmentation *)volume_of(scene, actor)->segmentation;
    const vv_object *t = s->transfer;
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    if (n[0] < 2 || n[1] < 2 || n[2] < 2) /* a slice hides nothing that lies in it */
        return false;
    return actor->classes.kind == VV_SEGMENT_TRANSFER && !actor->colors && !actor->classes.n_regions &&
           !vv_object_is_set(t, "opacity") && !vv_object_is_set(t, "preset") && !vv_object_is_set(t, "opacity_scale");
}

static void thin(vv_actor *actor)
{
    double *rows = (double *)(uintptr_t)actor->classes.opacity; /* the actor's own */
    for (size_t i = 0; i < actor->classes.n_opacity; i++)
        rows[2 * i + 1] = -expm1(VEIL * log1p(-fmin(rows[2 * i + 1], 1 - 0x1p-53)));
}

void vvi_veil_amounts(vv_scene *scene, vv_job *job)
{
    const char *labels = NULL;
    for (size_t i = 0; i < scene->n_actors && !labels; i++)
        if (scene->actors[i].classes.kind == VV_SEGMENT_LABELS)
            labels = scene->actors[i].id;
    for (size_t i = 0; i < scene->n_actors && labels; i++) {
        vv_actor *actor = &scene->actors[i];
        if (!is_fitted(scene, actor))
            continue;
        thin(actor);
        vvi_log(job, VV_LOG_INFO, "render",
                "volumes.%s is a thin veil, so that the labels of volumes.%s are seen in it; "
                "volumes.%s.segmentation.transfer.opacity_scale=1 shows it whole",
                actor->id, labels, actor->id);
    }
}
