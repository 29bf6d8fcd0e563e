/* MRC2014 keeps axes in any order but no direction against X, Y, Z: samples along such an axis are written backwards.
 */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/true_values.h"
#include "io/formats/mrc/mrc.h"
#include "io/sample_writer.h"
#include "io/world_order.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* A step that strays less than this from its axis is along it: MRC has floats. */
#define STRAIGHT 1e-6

typedef struct mrc_writing {
    vv_sink *sink;
    vv_job *job;
    const vv_field_info *info;
    int mode;
    vv_type type; /* in the file */
    bool big;
    double lowest, highest, mean, deviation; /* of stored numbers */
    size_t n_labels;
    int world[3]; /* that index axes run along */
    bool back[3];
    double step[3], origin[3]; /* along world axes; what is first in the file */
} mrc_writing;

/* MRC2014 has no unsigned bytes: signed ones hold those up to 127, 16 bits the others. */
static void choose_for_bytes(mrc_writing *w)
{
    if (w->highest <= 127) {
        w->mode = 0;
        w->type = VV_TYPE_I8;
        return;
    }
    vvi_log(w->job, VV_LOG_WARNING, "io",
            "%s: MRC has no unsigned bytes; they are written as 16-bit numbers, with the same values",
            vvi_sink_name(w->sink));
}

static void warn_of_loss(const mrc_writing *w, size_t n_frames)
{
    const vv_field_info *info = w->info;
    vvi_text t = {0};
    if (vvi_has_scale(info))
        vvi_text_add(&t, ", scale of values");
    if (info->value_unit[0])
        vvi_text_printf(&t, ", unit of values %s", info->value_unit);
    if (info->meaning == VV_MEANING_LABEL || w->n_labels > 0)
        vvi_text_add(&t, ", labels");
    if (n_frames > 1 && info->frame_step != 0)
        vvi_text_add(&t, ", time step");
    if (t.n > 2 && !t.bad)
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: MRC cannot keep: %s; write .nrrd to keep all",
                vvi_sink_name(w->sink), t.s + 2);
    vvi_text_free(&t);
}

static vv_status choose_mode(mrc_writing *w)
{
    const vv_field_info *info = w->info;
    const char *name = vvi_sink_name(w->sink);
    static const int modes[VV_TYPE_COUNT] = {6, 0, 6, 1, -1, -1, -1, -1, 2, 2};
    static const vv_type types[VV_TYPE_COUNT] = {VV_TYPE_U16, VV_TYPE_I8, VV_TYPE_U16, VV_TYPE_I16, 0,
                                                 0,           0,          0,           VV_TYPE_F32, VV_TYPE_F32};
    const bool rgb = info->components == 3 && info->type == VV_TYPE_U8 && info->meaning == VV_MEANING_RGB;
    w->mode = rgb ? 16 : modes[info->type];
    w->type = rgb ? VV_TYPE_U8 : types[info->type];
    if (info->components > 1 && !rgb)
        return vv_fail_at(
            VV_E_UNSUPPORTED, name, NULL,
            "MRC has one number per sample, and here are %d; pick one with volvis channel, or write .nrrd",
            info->components);
    if (w->mode < 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "MRC has no numbers of type %s; change them with volvis rescale, or write .nrrd",
                          vv_type_name(info->type));
    if (info->type == VV_TYPE_F64)
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: MRC has no doubles; they are written as floats", name);
    return VV_OK;
}

static void find_place(mrc_writing *w)
{
    const vv_grid *grid = &w->info->grid;
    const char *name = vvi_sink_name(w->sink);
    const double metres = vvi_length_unit_metres(grid->unit), scale = metres > 0 ? metres / 1e-10 : 1;
    const vvi_turn t = vvi_turn_to_world(grid, STRAIGHT);
    const vv_vec3 first = t.grid.index_to_world.origin;
    const double at[3] = {first.x, first.y, first.z};
    for (int i = 0; i < 3; i++) {
        w->world[t.axis[i]] = i; /* no need for another order: the header has one */
        w->back[t.axis[i]] = t.back[i];
        w->step[i] = strcmp(grid->unit, "voxels") == 0 ? 0 : vv_grid_spacing(&t.grid, i) * scale;
        w->origin[i] = at[i] * scale;
    }
    if (!t.straight)
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: MRC has no oblique axes; the volume is written as if it were %s",
                name, t.mirrored ? "upright, and is mirrored" : "upright");
    if (metres == 0 && strcmp(grid->unit, "voxels") != 0)
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: MRC measures in angstrom; lengths in '%s' are written as such", name,
                grid->unit);
}

/* Header ------------------------------------------------------------------------------------------------------------
 */

/* Without the zero at their end. */
static void put_letters(uint8_t *to, const char *letters)
{
    while (*letters)
        *to++ = (uint8_t)*letters++;
}

static void put_word(uint8_t *head, int at, int32_t v, bool big)
{
    uint32_t u;
    memcpy(&u, &v, 4);
    for (int i = 0; i < 4; i++)
        head[at + i] = (uint8_t)(u >> 8 * (big ? 3 - i : i));
}

static void put_real(uint8_t *head, int at, double value, bool big)
{
    const float f = (float)value;
    int32_t v;
    memcpy(&v, &f, 4);
    put_word(head, at, v, big);
}

static void put_labels(const mrc_writing *w, uint8_t *head)
{
    const vv_grid *grid = &w->info->grid;
    const bool own = grid->space == VV_SPACE_RAS || (strcmp(grid->unit, "A") != 0 && strcmp(grid->unit, "voxels") != 0);
    char text[3][81] = {"written by VolVis", "", ""};
    int n = 1;
    if (w->info->name[0])
        snprintf(text[n++], sizeof *text, "%s", w->info->name);
    if (own)
        snprintf(text[n++], sizeof *text, VVI_MRC_OWN "%s%s", grid->space == VV_SPACE_RAS ? "RAS, " : "", grid->unit);
    put_word(head, 220, n, w->big);
    memset(head + 224, ' ', 80 * (size_t)n);
    for (int i = 0; i < n; i++)
        memcpy(head + 224 + 80 * i, text[i], strlen(text[i]));
}

static vv_status find_statistics(mrc_writing *w, const vv_field *const *frames, size_t n)
{
    double lowest = INFINITY, highest = -INFINITY, sum = 0, squares = 0;
    for (size_t f = 0; f < n; f++) {
        vv_statistics s;
        vv_status st = vv_field_statistics(&s, frames[f], 0, w->job);
        if (st != VV_OK)
            return st;
        const double scale = w->info->value_scale, offset = w->info->value_offset;
        const double a = (s.min - offset) / scale, b = (s.max - offset) / scale, mean = (s.mean - offset) / scale;
        lowest = fmin(lowest, fmin(a, b));
        highest = fmax(highest, fmax(a, b));
        sum += mean / (double)n;
        squares += (s.deviation / scale * (s.deviation / scale) + mean * mean) / (double)n;
    }
    w->lowest = lowest;
    w->highest = highest;
    w->mean = sum;
    w->deviation = sqrt(fmax(0, squares - sum * sum));
    return VV_OK;
}

static vv_status write_header(const mrc_writing *w, size_t n_frames)
{
    uint8_t head[VVI_MRC_BYTES] = {0};
    const int64_t *n = w->info->grid.dims;
    if ((uint64_t)n[2] > INT32_MAX / n_frames || n[0] > INT32_MAX || n[1] > INT32_MAX)
        return vv_fail_at(VV_E_LIMIT, vvi_sink_name(w->sink), NULL, "has more sections than an MRC header can count");
    for (int i = 0; i < 3; i++) {
        put_word(head, 4 * i, (int32_t)(i == 2 ? n[2] * (int64_t)n_frames : n[i]), w->big);
        put_word(head, 28 + 4 * w->world[i], (int32_t)n[i], w->big);
        put_real(head, 40 + 4 * w->world[i], w->step[w->world[i]] * (double)n[i], w->big);
        put_real(head, 52 + 4 * i, 90, w->big);
        put_word(head, 64 + 4 * i, w->world[i] + 1, w->big);
        put_real(head, 196 + 4 * i, w->origin[i], w->big);
    }
    put_word(head, 12, w->mode, w->big);
    put_word(head, 88, n_frames > 1 ? 401 : n[2] > 1 ? 1 : 0, w->big);
    put_word(head, 108, 20140, w->big);
    put_letters(head + 208, "MAP ");
    memset(head + 212, w->big ? 0x11 : 0x44, 2);
    put_labels(w, head);
    put_real(head, 76, w->lowest, w->big);
    put_real(head, 80, w->highest, w->big);
    put_real(head, 84, w->mean, w->big);
    put_real(head, 216, w->deviation, w->big);
    return vvi_sink_write(w->sink, head, sizeof head);
}

/* Samples -----------------------------------------------------------------------------------------------------------
 */

static void convert(uint8_t *out, const uint8_t *in, vv_type type)
{
    if (type == VV_TYPE_U8) {
        const uint16_t v = *in;
        memcpy(out, &v, 2);
    } else {
        double v;
        memcpy(&v, in, 8);
        const float f = (float)v;
        memcpy(out, &f, 4);
    }
}

static vv_status write_row(const mrc_writing *w, uint8_t *out, const uint8_t *row, int64_t stride)
{
    const size_t in = vv_type_bytes(w->info->type), to = vv_type_bytes(w->type), c = (size_t)w->info->components;
    const int64_t n = w->info->grid.dims[0];
    for (int64_t i = 0; i < n; i++) {
        const uint8_t *from = row + (w->back[0] ? n - 1 - i : i) * stride;
        if (in == to)
            memcpy(out + (size_t)i * c * to, from, c * to);
        else
            convert(out + (size_t)i * to, from, w->info->type);
    }
    if (to > 1 && vvi_order_swapped(w->big))
        vvi_swap_bytes(out, to, (size_t)n * c);
    return vvi_sink_write(w->sink, out, (size_t)n * c * to);
}

static vv_status write_volume(const mrc_writing *w, const vv_field *field, uint8_t *out)
{
    const int64_t *n = w->info->grid.dims;
    vv_status st = VV_OK;
    for (int64_t k = 0; k < n[2] && st == VV_OK; k++) {
        vv_brick b;
        const vv_box slice = {{0, 0, w->back[2] ? n[2] - 1 - k : k}, {n[0], n[1], 1}};
        if ((st = vv_field_brick(&b, field, &slice, w->job)) != VV_OK)
            return st;
        for (int64_t j = 0; j < n[1] && st == VV_OK; j++)
            st =
                write_row(w, out, (const uint8_t *)b.data + (w->back[1] ? n[1] - 1 - j : j) * b.stride[1], b.stride[0]);
        vv_brick_release(&b);
        if (st == VV_OK)
            st = vvi_job_progress(w->job, "write", (uint64_t)k + 1, (uint64_t)n[2]);
    }
    return st == VV_OK ? vv_field_health(field) : st;
}

vv_status vvi_mrc_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job)
{
    mrc_writing w = {.sink = sink, .job = job, .info = vv_field_get_info(frames[0]), .big = options->big_endian};
    w.n_labels = options->n_labels;
    vv_status st = choose_mode(&w);
    if (st != VV_OK || (st = find_statistics(&w, frames, n_frames)) != VV_OK)
        return st;
    if (w.info->type == VV_TYPE_U8 && w.type == VV_TYPE_U16)
        choose_for_bytes(&w);
    if (options->written)
        options->written->type = w.type;
    find_place(&w);
    warn_of_loss(&w, n_frames);
    vvi_log_lost_names(sink, options, VVI_KEEPS_LABELS, "mrc", job); /* labels were told */
    const size_t bytes = (size_t)w.info->grid.dims[0] * (size_t)w.info->components * vv_type_bytes(w.type);
    uint8_t *row = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!row)
        return vv_fail_memory(bytes);
    st = write_header(&w, n_frames);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = write_volume(&w, frames[f], row);
    vvi_free(row);
    return st;
}
