#include "io/sample_writer.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "grid/true_values.h"
#include "io/placement.h"
#include <string.h>

#define PIECE_BYTES ((size_t)256 << 10)

bool vvi_order_swapped(bool big_endian)
{
    const uint16_t one = 1;
    const bool machine_big = *(const uint8_t *)&one == 0;
    return big_endian != machine_big;
}

/* One row of a brick, packed: all components, or one. */
static void pack_row(uint8_t *out, const vv_brick *b, const uint8_t *row, int component)
{
    const size_t bytes = vv_type_bytes(b->type);
    const size_t sample = component < 0 ? bytes * (size_t)b->components : bytes;
    if (component > 0)
        row += (size_t)component * bytes;
    if ((size_t)b->stride[0] == sample) {
        memcpy(out, row, sample * (size_t)b->box.n[0]);
        return;
    }
    for (int64_t i = 0; i < b->box.n[0]; i++)
        memcpy(out + (size_t)i * sample, row + i * b->stride[0], sample);
}

typedef struct packer {
    vvi_samples_fn *fn;
    void *user;
    uint8_t *piece;
    size_t room, used;
    int component;
    size_t row_bytes;
} packer;

static vv_status flush(packer *p)
{
    const size_t n = p->used;
    p->used = 0;
    return n > 0 ? p->fn(p->user, p->piece, n) : VV_OK;
}

static vv_status pack_brick(packer *p, const vv_brick *b)
{
    vv_status st = VV_OK;
    for (int64_t k = 0; k < b->box.n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < b->box.n[1] && st == VV_OK; j++) {
            const uint8_t *row = (const uint8_t *)b->data + k * b->stride[2] + j * b->stride[1];
            if (p->used + p->row_bytes > p->room)
                st = flush(p);
            pack_row(p->piece + p->used, b, row, p->component);
            p->used += p->row_bytes;
        }
    return st;
}

static vv_status pack_slices(packer *p, const vv_field *field, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    vv_status st = VV_OK;
    for (int64_t k = 0; k < info->grid.dims[2] && st == VV_OK; k++) {
        const vv_box slice = {{0, 0, k}, {info->grid.dims[0], info->grid.dims[1], 1}};
        vv_brick brick;
        if ((st = vv_field_brick(&brick, field, &slice, job)) != VV_OK)
            return st;
        st = pack_brick(p, &brick);
        vv_brick_release(&brick);
        if (st == VV_OK)
            st = vvi_job_progress(job, "write", (uint64_t)k + 1, (uint64_t)info->grid.dims[2]);
    }
    return st == VV_OK ? flush(p) : st;
}

vv_status vvi_samples_each(const vv_field *field, int component, vvi_samples_fn *fn, void *user, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    const size_t n = component < 0 ? (size_t)info->components : 1;
    packer p = {.fn = fn, .user = user, .component = component};
    vv_status st = vvi_mul3_size(&p.row_bytes, (size_t)info->grid.dims[0], n, vv_type_bytes(info->type));
    if (st != VV_OK)
        return st;
    p.room = p.row_bytes > PIECE_BYTES ? p.row_bytes : PIECE_BYTES;
    p.piece = vvi_alloc(job, p.room, VVI_MEM_SCRATCH);
    if (!p.piece)
        return vv_fail_memory(p.room);
    st = pack_slices(&p, field, job);
    vvi_free(p.piece);
    return st == VV_OK ? vv_field_health(field) : st;
}

typedef struct writing {
    vv_sink *sink;
    size_t element_bytes;
    bool swap;
} writing;

static vv_status write_piece(void *user, void *data, size_t n_bytes)
{
    const writing *w = user;
    if (w->swap)
        vvi_swap_bytes(data, w->element_bytes, n_bytes / w->element_bytes);
    return vvi_sink_write(w->sink, data, n_bytes);
}

vv_status vvi_samples_write(vv_sink *sink, const vv_field *field, int component, bool big_endian, vv_job *job)
{
    const size_t bytes = vv_type_bytes(vv_field_get_info(field)->type);
    writing w = {sink, bytes, bytes > 1 && vvi_order_swapped(big_endian)};
    return vvi_samples_each(field, component, write_piece, &w, job);
}

void vvi_log_loss(const vv_sink *sink, const vv_field_info *info, size_t n_frames, const char *format, vv_job *job)
{
    vvi_text t = {0};
    const vv_grid *grid = &info->grid;
    if (grid->space != VV_SPACE_PLAIN || !vvi_is_identity(&grid->index_to_world))
        vvi_text_printf(&t, ", placement%s",
                        vv_affine_determinant(grid->index_to_world) < 0
                            ? " (its axes are left-handed: pictures of the file will be mirrored)"
                            : "");
    if (strcmp(grid->unit, "voxels") != 0)
        vvi_text_printf(&t, ", unit %s", grid->unit);
    if (vvi_has_scale(info))
        vvi_text_add(&t, ", scale of values");
    if (info->value_unit[0])
        vvi_text_printf(&t, ", unit of values %s", info->value_unit);
    const bool colour =
        info->type == VV_TYPE_U8 && (info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA);
    if (info->meaning != VV_MEANING_SCALAR && !colour)
        vvi_text_add(&t, ", meaning of channels");
    if (n_frames > 1 && info->frame_step != 0)
        vvi_text_add(&t, ", time step");
    if (t.n > 2 && !t.bad)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: the format %s cannot keep: %s; write .nrrd to keep all",
                vvi_sink_name(sink), format, t.s + 2);
    vvi_text_free(&t);
}

void vvi_log_lost_unit(const vv_sink *sink, const vv_grid *grid, const char *taken, vv_job *job)
{
    if (!(vvi_length_unit_metres(grid->unit) > 0) && strcmp(grid->unit, "voxels") != 0 &&
        strcmp(grid->unit, "units") != 0)
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: '%s' is not a known unit of length: the numbers are kept, and other programs take them for %s",
                vvi_sink_name(sink), grid->unit, taken);
}

/* What channels say: whether one has a name or a colour, and whether one has a window. */
static void look_at_channels(bool *names, bool *windows, const vv_write_options *options)
{
    *names = *windows = false;
    for (size_t c = 0; c < options->n_channels; c++) {
        *names |= options->channels[c].name[0] || options->channels[c].has_color;
        *windows |= options->channels[c].lo < options->channels[c].hi;
    }
}

void vvi_log_lost_names(const vv_sink *sink, const vv_write_options *options, unsigned keeps, const char *format,
                        vv_job *job)
{
    bool names, windows;
    vvi_text t = {0};
    look_at_channels(&names, &windows, options);
    if (names && !(keeps & VVI_KEEPS_CHANNELS))
        vvi_text_add(&t, " and names and colours of channels");
    if (windows && !(keeps & VVI_KEEPS_CHANNELS) && !((keeps & VVI_KEEPS_WINDOW) && options->n_channels == 1))
        vvi_text_add(&t, " and the range of values to be shown");
    if (options->n_labels > 0 && !(keeps & VVI_KEEPS_LABELS))
        vvi_text_add(&t, " and names and colours of labels");
    if (t.n > 0 && !t.bad)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: the format %s cannot keep %s; write .nrrd to keep them",
                vvi_sink_name(sink), format, t.s + strlen(" and "));
    vvi_text_free(&t);
}
