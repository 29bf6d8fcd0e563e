/* Two pictures, or two volumes: how they differ, and by how much they may. */
#include "core/memory.h"
#include "core/status.h"
#include "grid/info_text.h"
#include "grid/turned_grid.h"
#include "measure/field_difference.h"
#include "measuring/comparing.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

void vv_compare_limits_init(vv_compare_limits *limits, size_t size)
{
    const vv_compare_limits none = {.size = size, .psnr = NAN, .ssim = NAN, .flip = NAN, .max_difference = NAN};
    memset(limits, 0, size);
    memcpy(limits, &none, size < sizeof none ? size : sizeof none);
}

vv_status vvi_comparing_begin(vvi_comparing *c, vv_answer **out, const vv_compare_limits *limits, vv_job *job)
{
    *c = (vvi_comparing){.answer = *out = vvi_calloc(1, sizeof *c->answer), .job = job};
    vv_compare_limits_init(&c->limits, sizeof c->limits);
    if (limits)
        memcpy(&c->limits, limits, limits->size < sizeof c->limits ? limits->size : sizeof c->limits);
    return c->answer ? VV_OK : vv_fail_memory(sizeof *c->answer);
}

vv_status vvi_comparing_end(const vvi_comparing *c, bool *exceeded_out, vv_status st)
{
    *exceeded_out = c->exceeded;
    return st == VV_OK && c->answer->bad ? vv_fail_memory(c->answer->n * sizeof *c->answer->item) : st;
}

void vvi_comparing_judge(vvi_comparing *c, const char *what, double found, double limit, bool least)
{
    const char *at = least ? "at least" : "at most";
    if (isnan(limit) || (least ? found >= limit : found <= limit))
        return;
    c->exceeded = true;
    if (isnan(found))
        vvi_tell_line(c->answer, "differs", "%s is not defined, the limit is %s %g", what, at, limit);
    else
        vvi_tell_line(c->answer, "differs", "%s is %g, the limit is %s %g", what, found, at, limit);
}

void vvi_comparing_verdict(const vvi_comparing *c, bool identical)
{
    const vv_compare_limits *l = &c->limits;
    const bool limited = !isnan(l->psnr) || !isnan(l->ssim) || !isnan(l->flip) || !isnan(l->max_difference);
    vvi_tell_bool(c->answer, "identical", identical);
    vvi_tell_bool(c->answer, "differs", limited ? c->exceeded : !identical);
}

static void tell_decibels(vv_answer *a, double psnr, double max_difference)
{
    vvi_tell_number(a, "psnr", psnr);
    if (isfinite(psnr))
        vvi_tell_line(a, "PSNR", "%.2f dB", psnr);
    else if (isnan(psnr))
        vvi_tell_line(a, "PSNR", "not defined: %s",
                      isfinite(max_difference) ? "all values of A are the same, or differences have no finite square"
                                               : "somewhere only one of A and B is a finite number");
    else
        vvi_tell_line(a, "PSNR", "infinite: nothing differs");
}

/* Images ---------------------------------------------------------------------------------------------------------- */

static void tell_images(vvi_comparing *c, const vv_image_difference *d)
{
    vv_answer *a = c->answer;
    tell_decibels(a, d->psnr, d->max_difference);
    vvi_tell_number(a, "ssim", d->ssim);
    vvi_tell_number(a, "flip_mean", d->flip_mean);
    vvi_tell_number(a, "max_difference", d->max_difference);
    vvi_tell_count(a, "different_pixels", d->n_different);
    vvi_tell_line(a, "SSIM", "%.6f", d->ssim);
    vvi_tell_line(a, "FLIP", "%.6f mean", d->flip_mean);
    vvi_tell_line(a, "largest", "%.4g of 1", d->max_difference);
    vvi_tell_line(a, "pixels", "%" PRIu64 " differ", d->n_different);
    vvi_comparing_judge(c, "PSNR", d->psnr, c->limits.psnr, true);
    vvi_comparing_judge(c, "SSIM", d->ssim, c->limits.ssim, true);
    vvi_comparing_judge(c, "FLIP", d->flip_mean, c->limits.flip, false);
    vvi_comparing_judge(c, "the largest difference", d->max_difference, c->limits.max_difference, false);
    vvi_comparing_verdict(c, d->n_different == 0);
}

vv_status vv_compare_images(vv_answer **out, bool *exceeded_out, const vv_image *a, const vv_image *b,
                            const vv_compare_limits *limits, vv_job *job)
{
    vvi_comparing c;
    vv_image_difference d;
    vv_status st = vvi_comparing_begin(&c, out, limits, job);
    if (st != VV_OK)
        return st;
    vvi_tell_text(c.answer, "kind", "images");
    if (a->width != b->width || a->height != b->height) {
        c.exceeded = true;
        vvi_tell_line(c.answer, "differs", "sizes are %d x %d and %d x %d", a->width, a->height, b->width, b->height);
        vvi_comparing_verdict(&c, false);
    } else if ((st = vv_image_compare(&d, a, b, job)) == VV_OK) {
        tell_images(&c, &d);
    }
    return vvi_comparing_end(&c, exceeded_out, st);
}

/* Volumes --------------------------------------------------------------------------------------------------------- */

/* One of the two: samples, or where they are read from. */
typedef struct volume {
    const vv_field_info *info;
    const vv_field *field;
    vv_file *file;
    int64_t frame;
} volume;

static void tell_axes(const vvi_comparing *c, vvi_axes axes, const char *order, const vv_grid *a, const vv_grid *b)
{
    char letters_a[16], letters_b[16];
    vv_grid_orientation(letters_a, a);
    vv_grid_orientation(letters_b, b);
    vvi_tell_bool(c->answer, "same_axes", axes == VVI_AXES_SAME);
    vvi_tell_text(c->answer, "reoriented", axes == VVI_AXES_TURNED ? order : "");
    if (axes == VVI_AXES_TURNED)
        vvi_tell_line(c->answer, "axes",
                      "%s and %s; compared at the same places, the second as by 'reorient --order %s'", letters_a,
                      letters_b, order);
    else if (axes == VVI_AXES_OTHER)
        vvi_tell_line(c->answer, "axes",
                      "%s and %s, which run differently; compared sample by sample as they are stored: "
                      "resample one first: 'volvis resample B onto=A -o C'",
                      letters_a, letters_b);
}

static void tell_placement(vv_answer *answer, const vv_field_info *a, const vv_field_info *b)
{
    const double moved = vvi_placement_difference(&a->grid, &b->grid);
    const bool same_world = strcmp(a->grid.unit, b->grid.unit) == 0 && a->grid.space == b->grid.space;
    vvi_tell_number(answer, "placement_difference", moved);
    vvi_tell_bool(answer, "same_world", same_world);
    vvi_tell_bool(answer, "same_type", a->type == b->type);
    if (!same_world)
        vvi_tell_line(answer, "world", "%s, %s", a->grid.unit, b->grid.unit);
    vvi_tell_line(answer, "placement", moved > 0 ? "corners are up to %g %s apart" : "the same", moved, a->grid.unit);
    vvi_tell_line(answer, "types", "%s, %s", vv_type_name(a->type), vv_type_name(b->type));
}

static void tell_volumes(vvi_comparing *c, const vvi_field_difference *d)
{
    vv_answer *a = c->answer;
    tell_decibels(a, d->psnr, d->max_difference);
    vvi_tell_number(a, "max_difference", d->max_difference);
    vvi_tell_number(a, "rms", d->rms);
    vvi_tell_count(a, "different_samples", d->n_different);
    vvi_tell_line(a, "largest", "%g", d->max_difference);
    vvi_tell_line(a, "RMS", "%g", d->rms);
    vvi_tell_line(a, "samples", "%" PRIu64 " of %" PRIu64 " differ", d->n_different, d->n_samples);
    vvi_comparing_judge(c, "PSNR", d->psnr, c->limits.psnr, true);
    vvi_comparing_judge(c, "the largest difference", d->max_difference, c->limits.max_difference, false);
    vvi_comparing_verdict(c, d->n_different == 0);
}

static vv_status samples_of(vv_field **out, const volume *v, vv_job *job)
{
    if (!v->field)
        return vv_file_read(out, v->file, v->frame, NULL, job);
    *out = vv_field_retain(v->field);
    return VV_OK;
}

/* The second as b_grid has it. */
static vv_status compare_samples(vvi_comparing *c, const volume *a, const volume *b, const vv_grid *b_grid,
                                 const vvi_grid_fit *turn, bool turned)
{
    vv_field *first = NULL, *second = NULL, *fitted = NULL;
    vvi_field_difference d;
    vv_status st = samples_of(&first, a, c->job);
    if (st == VV_OK && (st = samples_of(&second, b, c->job)) == VV_OK && turned)
        st = vvi_field_fitted(&fitted, second, b_grid, turn, c->job);
    const vv_field *other = turned ? fitted : second;
    if (st == VV_OK) {
        tell_placement(c->answer, vv_field_get_info(first), vv_field_get_info(other));
        st = vvi_field_compare(&d, first, other, c->job);
    }
    if (st == VV_OK)
        tell_volumes(c, &d);
    vv_field_release(fitted);
    vv_field_release(second);
    vv_field_release(first);
    return st;
}

static vv_status compare_volumes(vvi_comparing *c, const volume *a, const volume *b)
{
    char about_a[VVI_SAMPLES_TEXT], about_b[VVI_SAMPLES_TEXT], order[8];
    vvi_grid_fit turn;
    const vvi_axes axes = vvi_axes_compare(&turn, &a->info->grid, &b->info->grid);
    const vv_grid b_grid = vvi_grid_turned(&b->info->grid, &turn);
    const bool same_dims =
        a->info->components == b->info->components && memcmp(a->info->grid.dims, b_grid.dims, sizeof b_grid.dims) == 0;
    vvi_samples_print(about_a, a->info, 1);
    vvi_samples_print(about_b, b->info, 1);
    vvi_turn_print(order, &turn);
    vvi_tell_text(c->answer, "kind", "volumes");
    vvi_tell_bool(c->answer, "same_dims", same_dims);
    if (!same_dims) {
        c->exceeded = true;
        vvi_tell_line(c->answer, "differs", "%s and %s", about_a, about_b);
        vvi_comparing_verdict(c, false);
        return VV_OK;
    }
    vvi_tell_line(c->answer, "samples", "%s", about_a);
    tell_axes(c, axes, order, &a->info->grid, &b->info->grid);
    return compare_samples(c, a, b, &b_grid, &turn, axes == VVI_AXES_TURNED);
}

static vv_status compare(vv_answer **out, bool *exceeded_out, const volume *a, const volume *b,
                         const vv_compare_limits *limits, vv_job *job)
{
    vvi_comparing c;
    const vv_status st = vvi_comparing_begin(&c, out, limits, job);
    return st == VV_OK ? vvi_comparing_end(&c, exceeded_out, compare_volumes(&c, a, b)) : st;
}

vv_status vv_compare_files(vv_answer **out, bool *exceeded_out, vv_file *a, int64_t frame_a, vv_file *b,
                           int64_t frame_b, const vv_compare_limits *limits, vv_job *job)
{
    const volume first = {.info = vv_file_info(a), .file = a, .frame = frame_a};
    const volume second = {.info = vv_file_info(b), .file = b, .frame = frame_b};
    return compare(out, exceeded_out, &first, &second, limits, job);
}

vv_status vv_compare_fields(vv_answer **out, bool *exceeded_out, const vv_field *a, const vv_field *b,
                            const vv_compare_limits *limits, vv_job *job)
{
    const volume first = {.info = vv_field_get_info(a), .field = a};
    const volume second = {.info = vv_field_get_info(b), .field = b};
    return compare(out, exceeded_out, &first, &second, limits, job);
}
