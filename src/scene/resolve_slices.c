/* How slices show a volume: nothing of it can fail, so that other methods need not know of it. */
#include "model/contents.h"
#include "scene/resolve.h"
#include "scene/two_sided.h"
#include <math.h>

#define OVER_OTHERS 0.5 /* opacity of what covers all that is below it */

bool vvi_is_channel(const vv_transfer *transfer)
{
    return transfer->colormap && transfer->colormap[0] == '#';
}

/* Nobody says how they are to be seen, and zero is their middle. */
static bool about_zero(vvi_value_fit *out, const vv_actor *actor, const vv_volume_slices *slices)
{
    return !actor->colors && actor->classes.kind != VV_SEGMENT_LABELS && !slices->colormap &&
           !vv_object_is_set(&slices->base, "window_lo") && !vv_object_is_set(&slices->base, "window_hi") &&
           vvi_two_sided(out, vv_field_get_info(actor->field), actor->statistics);
}

/* A map whose middle stands for zero has it there, where there are values on both sides. */
static void centre_window(vv_slice_look *look, const vv_statistics *s)
{
    const double below = -s->percentile[0], above = s->percentile[4];
    if (vvi_two_sided_map(look->colormap) && below > 0 && above > 0) {
        look->hi = fmax(below, above);
        look->lo = -look->hi;
    }
}

/* Percentiles that any look at the samples gives; ends that somebody set stay where they are. */
static void resolve_window(vv_slice_look *look, const vv_volume_slices *slices, const vv_transfer *transfer,
                           const vv_statistics *s)
{
    const bool wide = s->percentile[4] > s->percentile[1], channel = vvi_is_channel(transfer);
    look->lo = wide ? s->percentile[1] : s->min;
    look->hi = wide ? s->percentile[4] : s->max > s->min ? s->max : s->min + 1;
    centre_window(look, s);
    if (channel && vv_object_is_set(&transfer->base, "range_lo") && vv_object_is_set(&transfer->base, "range_hi")) {
        look->lo = transfer->range_lo;
        look->hi = transfer->range_hi;
    }
    if (vv_object_is_set(&slices->base, "window_lo")) {
        look->hi = fmax(look->hi, slices->window_lo);
        look->lo = slices->window_lo;
    }
    if (vv_object_is_set(&slices->base, "window_hi")) {
        look->hi = slices->window_hi;
        if (!vv_object_is_set(&slices->base, "window_lo"))
            look->lo = fmin(look->lo, look->hi);
    }
}

void vvi_resolve_slices(vv_scene *scene, size_t i)
{
    vv_actor *actor = &scene->actors[i];
    vv_slice_look *look = &actor->slices;
    const vv_volume *volume = vvi_volume_named(scene->world, actor->id);
    const vv_volume_slices *slices = (const vv_volume_slices *)(const void *)volume->slices;
    const vv_segmentation *segmentation = (const vv_segmentation *)(const void *)volume->segmentation;
    const vv_transfer *transfer = (const vv_transfer *)(const void *)segmentation->transfer;
    const bool channel = vvi_is_channel(transfer);
    *look = (vv_slice_look){.colors = slices->colors, .blend = channel ? VV_SLICE_ADD : VV_SLICE_OVER};
    if (vv_object_is_set(&slices->base, "blend"))
        look->blend = slices->blend;
    vvi_value_fit fit;
    const bool middle = !channel && about_zero(&fit, actor, slices);
    look->colormap = slices->colormap ? slices->colormap
                     : channel        ? transfer->colormap
                     : middle         ? VVI_TWO_SIDED_MAP
                                      : "#ffffff";
    resolve_window(look, slices, transfer, actor->statistics);
    if (middle) {
        look->hi = vvi_two_sided_end(&fit, actor->statistics);
        look->lo = -look->hi;
    }
    const bool over = i > 0 && look->blend == VV_SLICE_OVER;
    look->clear_middle = over && vvi_two_sided_map(look->colormap) && vvi_about_zero(look->lo, look->hi);
    look->clear_below = vv_object_is_set(&slices->base, "clear_below")
                            ? slices->clear_below
                            : over && !look->clear_middle && vv_object_is_set(&slices->base, "window_lo");
    /* a map whose weak values are clear shows what is below it there: its colours are seen whole */
    const bool mapped = !actor->colors && actor->classes.kind != VV_SEGMENT_LABELS && slices->colors == VV_SLICE_WINDOW;
    const bool covers = over && !(mapped && (look->clear_middle || look->clear_below));
    look->opacity = vv_object_is_set(&slices->base, "opacity") ? slices->opacity : covers ? OVER_OTHERS : 1;
}
