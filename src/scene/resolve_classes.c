/* The classification of one volume: what was set, else the preset's, else what fits the histogram. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/label_sense.h"
#include "scene/colormaps.h"
#include "scene/gradient_scale.h"
#include "scene/presets.h"
#include "scene/resolve.h"
#include "scene/two_sided.h"
#include "scene/xray_exposure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COLORMAP_ROWS 33 /* linear in between: within 1/500 of the map */

/* A map that nobody asked for starts this share of the range below it: maps begin in the dark, and what is thin and
 * dark is not seen. */
#define DARK_PART 0.35

typedef struct choice {
    const vv_transfer *transfer;
    const vvi_preset *preset; /* NULL: none */
    vvi_proposal proposal;    /* of a preset that is worked out from the data */
    double lo, hi;            /* the range */
} choice;

static bool is_set(const vv_object *object, const char *name)
{
    return vv_object_is_set(object, name);
}

static vv_status fail(const vvi_cast *cast, vv_status status, const char *property, const char *text)
{
    char where[512];
    snprintf(where, sizeof where, "%s.segmentation.%s", cast->path, property);
    return vv_fail_at(status, NULL, where, "%s", text);
}

static vv_status fail_sides(const vvi_cast *cast, const char *property, double hi, const char *lo_name, double lo)
{
    char text[96];
    snprintf(text, sizeof text, "%g is below %s, which is %g", hi, lo_name, lo);
    return fail(cast, VV_E_ARGUMENT, property, text);
}

/* Rows of numbers that the actor owns. */
static vv_status new_rows(double **out, size_t n, vv_job *job)
{
    size_t bytes = 0;
    const vv_status st = vvi_mul_size(&bytes, n ? n : 1, sizeof(double));
    if (st != VV_OK)
        return st;
    *out = vvi_alloc(job, bytes, VVI_MEM_MODEL);
    return *out ? VV_OK : vv_fail_memory(bytes);
}

static vv_status copy_rows(const double **out, size_t *n_rows_out, const double *from, size_t n, size_t columns,
                           vv_job *job)
{
    double *rows = NULL;
    const vv_status st = new_rows(&rows, n, job);
    if (st != VV_OK)
        return st;
    memcpy(rows, from, n * sizeof *rows);
    *out = rows;
    *n_rows_out = n / columns;
    return VV_OK;
}

static vv_status copy_numbers(const double **out, size_t *n_rows_out, const vv_numbers *from, size_t columns,
                              vv_job *job)
{
    return copy_rows(out, n_rows_out, from->v, from->n, columns, job);
}

/* Both ends set, one, or none: an end that is open never crosses the one that is set. */
static vv_status resolve_range(choice *c, const vvi_cast *cast)
{
    const vv_object *t = &c->transfer->base;
    const bool lo_set = is_set(t, "range_lo"), hi_set = is_set(t, "range_hi");
    const vv_statistics *s = cast->actor->statistics;
    c->lo = lo_set ? c->transfer->range_lo : cast->two_sided ? -cast->magnitude.hi : cast->fit.lo;
    c->hi = hi_set ? c->transfer->range_hi : cast->two_sided ? cast->magnitude.hi : cast->fit.hi;
    if (lo_set && !hi_set && c->hi <= c->lo)
        c->hi = s->max > c->lo ? s->max : c->lo + 1;
    if (hi_set && !lo_set && c->lo >= c->hi)
        c->lo = s->min < c->hi ? s->min : c->hi - 1;
    if (lo_set && hi_set && !(c->hi > c->lo))
        return fail(cast, VV_E_ARGUMENT, "transfer.range_hi", "must be above range_lo");
    return VV_OK;
}

static vv_status find_preset(choice *c, const vvi_cast *cast)
{
    char where[512];
    snprintf(where, sizeof where, "%s.segmentation.transfer.preset", cast->path);
    if (c->transfer->preset && !(c->preset = vvi_preset_find(c->transfer->preset, where)))
        return vv_error_last()->status;
    return VV_OK;
}

static vv_status preset_opacity(vvi_cast *cast, const choice *c, vvi_preset_map map, vv_job *job)
{
    double *rows = NULL;
    if (c->preset->propose)
        return copy_rows(&cast->actor->classes.opacity, &cast->actor->classes.n_opacity, c->proposal.opacity[0],
                         2 * c->proposal.n_opacity, 2, job);
    const vv_status st = new_rows(&rows, 2 * c->preset->n_opacity, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < c->preset->n_opacity; i++) {
        rows[2 * i] = c->preset->opacity[i][0] * map.scale + map.offset;
        rows[2 * i + 1] = c->preset->opacity[i][1];
    }
    cast->actor->classes.opacity = rows;
    cast->actor->classes.n_opacity = c->preset->n_opacity;
    return VV_OK;
}

static vv_status preset_color(vvi_cast *cast, const choice *c, vvi_preset_map map, vv_job *job)
{
    double *rows = NULL;
    const vv_status st = new_rows(&rows, 4 * c->preset->n_color, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < c->preset->n_color; i++) {
        memcpy(rows + 4 * i, c->preset->color[i], 4 * sizeof *rows);
        rows[4 * i] = rows[4 * i] * map.scale + map.offset;
    }
    cast->actor->classes.color = rows;
    cast->actor->classes.n_color = c->preset->n_color;
    return VV_OK;
}

/* From lo to hi; `turned`: the map's beginning is at hi. */
static vv_status colormap_rows(const double **out, size_t *n_out, double lo, double hi, const char *map, bool turned,
                               vv_job *job)
{
    const size_t n = hi > lo ? COLORMAP_ROWS : 1;
    double *rows = NULL;
    const vv_status st = new_rows(&rows, 4 * n, job);
    if (st != VV_OK)
        return st;
    for (size_t i = 0; i < n; i++) {
        const double u = n > 1 ? (double)i / (double)(n - 1) : 0.75;
        rows[4 * i] = i + 1 == n ? hi : lo + u * (hi - lo);
        vv_color color = {0};
        vv_colormap_sample(&color, map, turned ? 1 - u : u);
        memcpy(rows + 4 * i + 1, (double[]){color.r, color.g, color.b}, 3 * sizeof *rows);
    }
    *out = rows;
    *n_out = n;
    return VV_OK;
}

static vv_status colormap_color(vvi_cast *cast, double lo, double hi, const char *map, vv_job *job)
{
    return colormap_rows(&cast->actor->classes.color, &cast->actor->classes.n_color, lo, hi, map, false, job);
}

/* `property` of the volume names a colour map that there is not. */
static vv_status fail_colormap(const vvi_cast *cast, const char *property, const char *name)
{
    char where[512];
    snprintf(where, sizeof where, "%s.%s", cast->path, property);
    return vvi_colormap_fail(where, name);
}

/* Geometric mean of the box's sides, those of one sample left out. */
static double extent(const vv_actor *actor)
{
    const vv_grid *grid = &vv_field_get_info(actor->field)->grid;
    double product = 1;
    int sides = 0;
    for (int i = 0; i < 3; i++) {
        if (grid->dims[i] < 2)
            continue;
        product *= vvi_length(actor->index_to_world.axis[i]) * (double)(grid->dims[i] - 1);
        sides++;
    }
    return sides ? pow(product, 1.0 / sides) : vvi_length(actor->index_to_world.axis[0]);
}

/* Alpha says itself how opaque a sample is. */
static bool has_alpha(const vv_actor *actor)
{
    return actor->colors && vv_field_get_info(actor->colors)->meaning == VV_MEANING_RGBA;
}

/* Both tails, the same distance from zero as opaque. */
static size_t two_sided_opacity(double rows[4 * VVI_FIT_NODES], const vvi_cast *cast)
{
    const vvi_value_fit *m = &cast->magnitude;
    double half[2 * VVI_FIT_NODES];
    const size_t n = vvi_fit_opacity(half, m, m->lo, m->hi, extent(cast->actor), cast->voxel);
    for (size_t i = 0; i < n; i++) {
        const double *row = half + 2 * i;
        memcpy(rows + 2 * (n - 1 - i), (double[]){-row[0], row[1]}, 2 * sizeof *rows);
        memcpy(rows + 2 * (n + i), row, 2 * sizeof *rows);
    }
    return 2 * n;
}

/* Of one value of each ray, whose colours are known: from one end of these to the other, or away from zero. Light that
 * is added hides nothing. */
static vv_status layer_opacity(vvi_cast *cast, vv_job *job)
{
    vv_classification *k = &cast->actor->classes;
    const double lo = k->n_color ? k->color[0] : 0, hi = k->n_color ? k->color[4 * (k->n_color - 1)] : lo;
    const double even[2] = {lo, 1}, grows[4] = {lo, 0, hi, 1}, falls[4] = {lo, 1, hi, 0};
    const double away[6] = {lo, 1, 0, 0, hi, 1};
    const double *rows = cast->projects == VV_PROJECTS_SMALLEST ? falls : grows;
    size_t n = 4;
    if (cast->actor->layer.blend == VV_SLICE_ADD || !(hi > lo)) {
        rows = even;
        n = 2;
    } else if (cast->two_sided && lo < 0 && hi > 0) {
        rows = away;
        n = 6;
    }
    return copy_rows(&k->opacity, &k->n_opacity, rows, n, 2, job);
}

static vv_status automatic_opacity(vvi_cast *cast, const choice *c, vv_job *job)
{
    const vv_grid *grid = &vv_field_get_info(cast->actor->field)->grid;
    double *rows = NULL;
    if (cast->fit.empty)
        vvi_log(job, VV_LOG_WARNING, "render", "%s: no sample is a number, so nothing is seen", cast->path);
    if (cast->projects != VV_PROJECTS_NOTHING)
        return layer_opacity(cast, job);
    const vv_status st = new_rows(&rows, 4 * VVI_FIT_NODES, job);
    if (st != VV_OK)
        return st;
    cast->actor->classes.opacity = rows;
    if (has_alpha(cast->actor)) {
        memcpy(rows, (double[]){0, 0, 1, 1}, 4 * sizeof *rows);
        cast->actor->classes.n_opacity = 2;
        return VV_OK;
    }
    if (!cast->fit.empty && (grid->dims[0] < 2 || grid->dims[1] < 2 || grid->dims[2] < 2)) {
        rows[0] = c->lo; /* one slice is a picture: every value is to be seen */
        rows[1] = 0.99;
        cast->actor->classes.n_opacity = 1;
        return VV_OK;
    }
    cast->actor->classes.n_opacity =
        cast->two_sided ? two_sided_opacity(rows, cast)
                        : vvi_fit_opacity(rows, &cast->fit, c->lo, c->hi, extent(cast->actor), cast->voxel);
    return VV_OK;
}

static vv_status resolve_opacity(vvi_cast *cast, const choice *c, vvi_preset_map map, vv_job *job)
{
    if (is_set(&c->transfer->base, "opacity"))
        return copy_numbers(&cast->actor->classes.opacity, &cast->actor->classes.n_opacity, c->transfer->opacity, 2,
                            job);
    return c->preset ? preset_opacity(cast, c, map, job) : automatic_opacity(cast, c, job);
}

static vv_status projection_color(vvi_cast *cast, const choice *c, vv_job *job)
{
    const vv_object *t = &c->transfer->base;
    const vv_statistics *s = cast->actor->statistics;
    const double lo = is_set(t, "range_lo") ? c->lo : s->percentile[0];
    double hi = is_set(t, "range_hi") ? c->hi : s->percentile[4];
    if ((cast->projects == VV_PROJECTS_MEAN || cast->projects == VV_PROJECTS_SUM) && !is_set(t, "range_hi")) {
        double most;
        const vv_status st = vvi_exposure(&most, cast->actor, cast->projects == VV_PROJECTS_SUM, job);
        if (st != VV_OK)
            return st;
        hi = most > lo ? most : hi;
    }
    const bool wide = hi > lo;
    return colormap_color(cast, wide ? lo : s->min, wide ? hi : s->max, "gray", job);
}

static vv_status resolve_color(vvi_cast *cast, const choice *c, vvi_preset_map map, vv_job *job)
{
    const bool anatomical = vv_field_get_info(cast->actor->field)->grid.space == VV_SPACE_RAS;
    const char *name = cast->two_sided ? VVI_TWO_SIDED_MAP : anatomical ? "tissue" : "viridis";
    if (is_set(&c->transfer->base, "color"))
        return copy_numbers(&cast->actor->classes.color, &cast->actor->classes.n_color, c->transfer->color, 4, job);
    if (c->transfer->colormap)
        name = c->transfer->colormap;
    else if (c->preset && c->preset->color)
        return preset_color(cast, c, map, job);
    else if (c->proposal.n_color)
        return copy_rows(&cast->actor->classes.color, &cast->actor->classes.n_color, c->proposal.color[0],
                         4 * c->proposal.n_color, 4, job);
    else if (c->preset && c->preset->colormap)
        name = c->preset->colormap;
    else if (cast->projects != VV_PROJECTS_NOTHING) /* nobody chose: greys over all but a thousandth at each end */
        return projection_color(cast, c, job);
    vv_color first;
    if (!vv_colormap_sample(&first, name, 0))
        return fail_colormap(cast, "segmentation.transfer.colormap", name);
    const bool chosen = c->transfer->colormap && (name[0] != '#' || cast->projects != VV_PROJECTS_NOTHING);
    const double dark = chosen || cast->two_sided ? 0 : DARK_PART * (c->hi - c->lo);
    if (cast->fit.falls && !c->transfer->colormap && !cast->two_sided) /* dark is what is next to the background */
        return colormap_rows(&cast->actor->classes.color, &cast->actor->classes.n_color, c->lo, c->hi + dark, name,
                             true, job);
    return colormap_color(cast, c->lo - dark, c->hi, name, job);
}

/* How steep a boundary must be to be whole. */
static vv_status resolve_gradient(vvi_cast *cast, const vv_transfer *transfer, vv_job *job)
{
    vv_classification *c = &cast->actor->classes;
    c->gradient_power = transfer->gradient_power;
    c->gradient_reference = transfer->gradient_reference;
    if (!(c->gradient_power > 0) || is_set(&transfer->base, "gradient_reference"))
        return VV_OK;
    return vvi_gradient_scale(&c->gradient_reference, cast->actor, job);
}

/* Sides that stand the wrong way round would leave a region in which nothing lies. */
static vv_status check_region(const vvi_cast *cast, const vv_region *r, size_t i)
{
    const struct {
        double lo, hi;
        const char *lo_name, *hi_name;
    } sides[] = {{r->value_lo, r->value_hi, "value_lo", "value_hi"},
                 {r->top_lo, r->top_hi, "top_lo", "top_hi"},
                 {r->gradient_lo, r->gradient_hi, "gradient_lo", "gradient_hi"}};
    for (size_t side = 0; side < sizeof sides / sizeof *sides; side++) {
        char property[64];
        if (sides[side].lo <= sides[side].hi)
            continue;
        snprintf(property, sizeof property, "transfer.regions.%zu.%s", i, sides[side].hi_name);
        return fail_sides(cast, property, sides[side].hi, sides[side].lo_name, sides[side].lo);
    }
    return VV_OK;
}

/* A preset that is worked out from the data; where they have nothing for it, what is taken when nothing is chosen. */
static vv_status resolve_proposal(choice *c, vvi_cast *cast, vv_job *job)
{
    const vv_object *t = &c->transfer->base;
    const vv_actor *actor = cast->actor;
    const vv_grid *grid = &vv_field_get_info(actor->field)->grid;
    const vvi_preset *preset = c->preset;
    if (!preset || strcmp(preset->head.kind, "proposal") != 0)
        return VV_OK;
    c->preset = NULL;
    if (!preset->propose || is_set(t, "opacity"))
        return VV_OK;
    vvi_value_profile *profile = vvi_alloc(job, sizeof *profile, VVI_MEM_SCRATCH);
    if (!profile)
        return vv_fail_memory(sizeof *profile);
    const vv_status st = vvi_profile_get(profile, actor, job);
    const vvi_proposal_data data = {.profile = profile,
                                    .fit = &cast->fit,
                                    .from = is_set(t, "range_lo") ? c->lo : -INFINITY,
                                    .to = is_set(t, "range_hi") ? c->hi : INFINITY,
                                    .extent = extent(actor),
                                    .length = cast->voxel};
    const bool solid = grid->dims[0] > 1 && grid->dims[1] > 1 && grid->dims[2] > 1; /* a slice is shown whole */
    if (st == VV_OK && solid && preset->propose(&c->proposal, &data))
        c->preset = preset;
    else if (st == VV_OK)
        vvi_log(job, VV_LOG_WARNING, "render",
                "%s: preset '%s' finds nothing in these values to work with; opacity is fitted to the histogram",
                cast->path, preset->head.name);
    vvi_free(profile);
    return st;
}

/* Regions of a two-dimensional transfer function, and up to which gradient. */
static vv_status resolve_regions(vvi_cast *cast, const vv_transfer *transfer, vv_job *job)
{
    vv_classification *c = &cast->actor->classes;
    const size_t n = transfer->regions->n;
    if (!n)
        return VV_OK;
    vv_region *to = vvi_alloc(job, n * sizeof *to, VVI_MEM_MODEL);
    if (!to)
        return vv_fail_memory(n * sizeof *to);
    c->regions = to;
    c->n_regions = n;
    vv_status st = vvi_gradient_scale(&c->gradient_top, cast->actor, job);
    for (size_t i = 0; st == VV_OK && i < n; i++) {
        const vv_transfer_region *r = (const vv_transfer_region *)transfer->regions->entry[i].object;
        const bool closed = is_set(&r->base, "gradient_hi");
        to[i] = (vv_region){.value_lo = r->value_lo,
                            .value_hi = r->value_hi,
                            .top_lo = is_set(&r->base, "top_lo") ? r->top_lo : r->value_lo,
                            .top_hi = is_set(&r->base, "top_hi") ? r->top_hi : r->value_hi,
                            .gradient_lo = r->gradient_lo,
                            .gradient_hi = closed ? r->gradient_hi : INFINITY,
                            .color = {r->color.r, r->color.g, r->color.b},
                            .opacity = r->opacity,
                            .edge = r->edge};
        c->gradient_top = fmax(c->gradient_top, closed ? r->gradient_hi : r->gradient_lo);
        st = check_region(cast, &to[i], i);
    }
    return st;
}

static vv_status resolve_transfer(vvi_cast *cast, const vv_transfer *transfer, vv_job *job)
{
    choice c = {.transfer = transfer};
    vvi_preset_map map = {1, 0, false};
    vv_status st = VV_OK;
    vv_actor *actor = cast->actor;
    if ((st = find_preset(&c, cast)) != VV_OK || (st = resolve_range(&c, cast)) != VV_OK ||
        (st = resolve_proposal(&c, cast, job)) != VV_OK)
        return st;
    if (c.preset && !c.preset->propose)
        map = vvi_preset_place(c.preset, vv_field_get_info(actor->field), actor->statistics, c.lo, c.hi);
    if (map.guessed)
        vvi_log(job, VV_LOG_WARNING, "render",
                "%s: preset '%s' is for values in %s, which these are not: stretched over %g to %g "
                "(segmentation.transfer.range_lo, range_hi)",
                cast->path, c.preset->head.name, c.preset->head.value_unit, c.lo, c.hi);
    if ((st = resolve_color(cast, &c, map, job)) != VV_OK || (st = resolve_opacity(cast, &c, map, job)) != VV_OK)
        return st;
    const bool typed = is_set(&transfer->base, "opacity");
    if (is_set(&transfer->base, "opacity_length"))
        actor->classes.opacity_length = transfer->opacity_length;
    else
        actor->classes.opacity_length = typed || transfer->regions->n ? 1 : cast->voxel;
    return (st = resolve_gradient(cast, transfer, job)) == VV_OK ? resolve_regions(cast, transfer, job) : st;
}

static vv_status resolve_threshold(vvi_cast *cast, const vv_threshold *threshold, vv_job *job)
{
    vv_classification *c = &cast->actor->classes;
    double *row = NULL;
    c->lo = is_set(&threshold->base, "lo") ? threshold->lo : cast->fit.split;
    c->hi = is_set(&threshold->base, "hi") ? threshold->hi : fmax(cast->actor->statistics->max, c->lo);
    if (!(c->lo <= c->hi))
        return fail(cast, VV_E_ARGUMENT, "threshold.hi", "must not be below lo");
    const vv_status st = new_rows(&row, 4, job);
    if (st != VV_OK)
        return st;
    const vv_color color = cast->volume->color;
    memcpy(row, (double[]){c->lo, color.r, color.g, color.b}, 4 * sizeof *row);
    c->color = row;
    c->n_color = 1;
    return VV_OK;
}

static vv_status copy_labels(vv_classification *c, const vv_numbers *table, vv_job *job)
{
    const vv_status st = copy_numbers(&c->labels, &c->n_labels, table, 5, job);
    const size_t bytes = c->n_labels * sizeof(vv_label_id);
    if (st != VV_OK || !table->labels || !bytes)
        return st;
    vv_label_id *ids = vvi_alloc(job, bytes, VVI_MEM_MODEL);
    if (!ids)
        return vv_fail_memory(bytes);
    memcpy(ids, table->labels, bytes);
    c->label_ids = ids;
    return VV_OK;
}

static vv_status resolve_labels(vvi_cast *cast, const vv_labels *labels, const vv_transfer *transfer, vv_job *job)
{
    vv_classification *c = &cast->actor->classes;
    const bool typed = is_set(&labels->base, "table") || is_set(&labels->base, "opacity");
    c->label_opacity = labels->opacity;
    c->opacity_length = typed ? 1 : cast->voxel;
    if (is_set(&transfer->base, "opacity_length"))
        c->opacity_length = transfer->opacity_length;
    return labels->table ? copy_labels(c, labels->table, job) : VV_OK;
}

/* Somebody has said how these values are to be seen as amounts. */
static bool any_is_set(const vv_object *object, const char *but)
{
    for (const vv_property *p = object->cls->properties; p->name; p++)
        if (strcmp(p->name, but) != 0 && vv_object_is_set(object, p->name))
            return true;
    return false;
}

/* What nobody says: that these integers are labels. */
static vv_status sense_labels(vv_classification *c, const vvi_cast *cast, const vv_segmentation *s, vv_job *job)
{
    size_t n = 0;
    const vv_volume *volume = cast->volume;
    if (cast->amounts || cast->actor->colors || any_is_set(s->transfer, "opacity_scale") ||
        any_is_set(s->threshold, "") || any_is_set(volume->slices, "opacity") ||
        volume->interpolation == VV_INTERPOLATE_CUBIC)
        return VV_OK;
    const vv_status st = vvi_label_sense(&n, cast->actor->field, cast->actor->component, job);
    if (st == VV_OK && n) {
        c->kind = VV_SEGMENT_LABELS;
        vvi_log(job, VV_LOG_INFO, "render",
                "%s is shown as labels, of which %zu were found; %s.segmentation.kind=transfer shows it as amounts",
                cast->path, n, cast->path);
    }
    return st;
}

/* Whether opacity grows away from zero: where nobody has said otherwise, and where a map that has a middle is laid
 * about it. */
static bool is_two_sided(vvi_cast *cast, const vv_transfer *transfer)
{
    const vv_statistics *s = cast->actor->statistics;
    const bool lo = is_set(&transfer->base, "range_lo"), hi = is_set(&transfer->base, "range_hi");
    if (transfer->preset || lo != hi)
        return false;
    if (!lo && vvi_two_sided(&cast->magnitude, vv_field_get_info(cast->actor->field), s))
        return true;
    const bool about_zero = lo ? vvi_about_zero(transfer->range_lo, transfer->range_hi) : s->min < 0 && s->max > 0;
    return about_zero && vvi_two_sided_map(transfer->colormap) &&
           vvi_fit_magnitudes(&cast->magnitude, s, lo ? transfer->range_hi : 0);
}

vv_status vvi_resolve_classes(vvi_cast *cast, vv_job *job)
{
    const vv_segmentation *s = (const vv_segmentation *)cast->volume->segmentation;
    const vv_transfer *transfer = (const vv_transfer *)s->transfer;
    const vv_field_info *info = vv_field_get_info(cast->actor->field);
    vv_classification *c = &cast->actor->classes;
    c->kind = is_set(&s->base, "kind")            ? s->kind
              : info->meaning == VV_MEANING_LABEL ? VV_SEGMENT_LABELS
                                                  : VV_SEGMENT_TRANSFER;
    if (!is_set(&s->base, "kind") && info->meaning == VV_MEANING_SCALAR) {
        const vv_status st = sense_labels(c, cast, s, job);
        if (st != VV_OK)
            return st;
    }
    if (c->kind == VV_SEGMENT_COLORS) /* the field is alpha or luminance: a transfer function of that */
        c->kind = VV_SEGMENT_TRANSFER;
    if (c->kind == VV_SEGMENT_THRESHOLD && cast->projects != VV_PROJECTS_NOTHING) /* values are shown, not a solid */
        c->kind = VV_SEGMENT_TRANSFER;
    c->opacity_scale = transfer->opacity_scale;
    c->opacity_length = cast->voxel;
    const vv_status fitted =
        vvi_fit_field(&cast->fit, cast->actor->field, cast->actor->component, cast->actor->statistics, job);
    if (fitted != VV_OK)
        return fitted;
    cast->actor->iso = cast->fit.split;
    cast->two_sided = is_two_sided(cast, transfer);
    if (c->kind == VV_SEGMENT_LABELS)
        return resolve_labels(cast, (const vv_labels *)s->labels, transfer, job);
    if (c->kind == VV_SEGMENT_TRANSFER)
        return resolve_transfer(cast, transfer, job);
    const vv_status st = resolve_threshold(cast, (const vv_threshold *)s->threshold, job);
    cast->actor->iso = c->lo;
    return st;
}

vv_status vvi_resolve_value_colors(vvi_cast *cast, double lo, double hi, const char *unit, vv_job *job)
{
    const vv_segmentation *s = (const vv_segmentation *)cast->volume->segmentation;
    choice c = {.transfer = (const vv_transfer *)s->transfer};
    vv_statistics *numbers = vvi_alloc_zeroed(job, sizeof *numbers, VVI_MEM_DERIVED);
    vv_field_info info = vv_field_info_default();
    vv_color first;
    vv_status st;
    if (!numbers)
        return vv_fail_memory(sizeof *numbers);
    cast->actor->statistics = numbers;
    cast->fit.lo = numbers->min = lo;
    cast->fit.hi = numbers->max = hi;
    snprintf(info.value_unit, sizeof info.value_unit, "%s", unit);
    if (is_set(&c.transfer->base, "color"))
        return copy_numbers(&cast->actor->classes.color, &cast->actor->classes.n_color, c.transfer->color, 4, job);
    if ((st = find_preset(&c, cast)) != VV_OK || (st = resolve_range(&c, cast)) != VV_OK)
        return st;
    if (!c.transfer->colormap && c.preset && c.preset->color)
        return preset_color(cast, &c, vvi_preset_place(c.preset, &info, numbers, c.lo, c.hi), job);
    const char *map = c.transfer->colormap             ? c.transfer->colormap
                      : c.preset && c.preset->colormap ? c.preset->colormap
                                                       : "viridis";
    if (!vv_colormap_sample(&first, map, 0))
        return fail_colormap(cast, "segmentation.transfer.colormap", map);
    return colormap_color(cast, c.lo, c.hi, map, job);
}

vv_status vvi_resolve_paint(vvi_cast *cast, vv_job *job)
{
    const vv_volume_paint *paint = (const vv_volume_paint *)cast->volume->paint;
    vv_paint *out = &cast->actor->paint;
    if (is_set(&paint->base, "color"))
        return copy_numbers(&out->color, &out->n_color, paint->color, 4, job);
    const char *map = paint->colormap ? paint->colormap : "viridis";
    vv_color first;
    if (!vv_colormap_sample(&first, map, 0))
        return fail_colormap(cast, "paint.colormap", paint->colormap);
    vv_statistics *s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_field_statistics(s, out->field, out->component, job);
    const double lo = is_set(&paint->base, "range_lo") ? paint->range_lo : s->min;
    const double hi = is_set(&paint->base, "range_hi") ? paint->range_hi : s->max;
    vvi_free(s);
    if (st == VV_OK && lo > hi) {
        char where[512];
        snprintf(where, sizeof where, "%s.paint.range_hi", cast->path);
        return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%g is below range_lo, which is %g", hi, lo);
    }
    return st == VV_OK ? colormap_rows(&out->color, &out->n_color, lo, hi, map, false, job) : st;
}
