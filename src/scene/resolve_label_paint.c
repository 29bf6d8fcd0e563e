/* Colours from labels of another dataset: those that its labels have anyhow. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/label_id.h"
#include "grid/label_sense.h"
#include "model/contents.h"
#include "scene/label_ids.h"
#include "scene/load.h"
#include "scene/resolve.h"
#include "scene/transfer.h"
#include <string.h>
#include <volvis/file.h>

/* Who says which colours labels have: a volume of the World that shows them, else their file. */
typedef struct naming {
    vv_classification classes;
    vv_file *file;
    const vv_label *label;
    size_t n;
} naming;

static bool is_set(const vv_volume_paint *paint, const char *name)
{
    return vv_object_is_set(&paint->base, name);
}

static const vv_numbers *table_of(const vv_world *world, const char *data)
{
    for (size_t i = 0; i < world->volumes->n; i++) {
        const vv_volume *volume = vvi_volume_nth(world, i);
        const vv_segmentation *s = (const vv_segmentation *)(const void *)volume->segmentation;
        const vv_labels *labels = (const vv_labels *)(const void *)s->labels;
        if (volume->data && strcmp(volume->data, data) == 0 && vv_object_is_set(&labels->base, "table"))
            return labels->table;
    }
    return NULL;
}

static vv_status open_naming(naming *out, const vvi_cast *cast, const vv_dataset *dataset, const char *data,
                             vv_job *job)
{
    const vv_numbers *table = table_of(cast->world, data);
    *out = (naming){.classes = {.kind = VV_SEGMENT_LABELS, .opacity_length = 1}};
    if (table) {
        out->classes.labels = table->v;
        out->classes.n_labels = table->n / 5;
        out->classes.label_ids = table->labels;
    }
    if (table || !dataset->path)
        return VV_OK;
    const vv_status st = vvi_dataset_open(&out->file, cast->world, dataset, job);
    if (st == VV_OK)
        out->label = vv_file_labels(out->file, &out->n);
    return st;
}

static void color_label(double rgb[3], const naming *from, vv_label_id id, bool is_unsigned)
{
    double rgbk[4];
    vvi_transfer_label(rgbk, &from->classes, id, is_unsigned);
    for (size_t i = 0; i < from->n; i++)
        if (from->label[i].value == id && from->label[i].has_color)
            memcpy(rgbk, (double[]){from->label[i].color.r, from->label[i].color.g, from->label[i].color.b},
                   3 * sizeof *rgbk);
    memcpy(rgb, rgbk, 3 * sizeof *rgb);
}

/* A row for each label but 0, which is what no label is of. */
static vv_status make_rows(vv_paint *out, const vvi_label_ids *ids, const naming *from, vv_job *job)
{
    const size_t bytes = 4 * (ids->n + 1) * sizeof(double);
    double *rows = vvi_alloc(job, bytes, VVI_MEM_MODEL);
    if (!rows)
        return vv_fail_memory(bytes);
    out->color = rows;
    for (size_t i = 0; i < ids->n; i++) {
        double *row = rows + 4 * out->n_color;
        if (ids->id[i] == 0)
            continue;
        row[0] = vvi_label_value(ids->id[i], ids->is_unsigned);
        color_label(row + 1, from, ids->id[i], ids->is_unsigned);
        out->n_color++;
    }
    if (out->n_color == 0) { /* nothing is painted */
        memset(rows, 0, 4 * sizeof *rows);
        rows[0] = out->n_color = 1;
    }
    return VV_OK;
}

vv_status vvi_sense_label_paint(const vvi_cast *cast, vv_job *job)
{
    size_t n = 0;
    const vv_volume_paint *paint = (const vv_volume_paint *)(const void *)cast->volume->paint;
    vv_paint *out = &cast->actor->paint;
    if (vv_field_get_info(out->field)->meaning != VV_MEANING_SCALAR || paint->colormap || is_set(paint, "range_lo") ||
        is_set(paint, "range_hi"))
        return VV_OK;
    const vv_status st = vvi_label_sense(&n, out->field, out->component, job);
    out->nearest = st == VV_OK && n > 0;
    if (out->nearest)
        vvi_log(job, VV_LOG_INFO, "render",
                "%s.paint is by labels, of which %zu were found; with %s.paint.colormap it is by amounts", cast->path,
                n, cast->path);
    return st;
}

vv_status vvi_resolve_label_paint(bool *out, const vvi_cast *cast, const vv_dataset *dataset, vv_job *job)
{
    const vv_volume_paint *paint = (const vv_volume_paint *)(const void *)cast->volume->paint;
    vv_paint *to = &cast->actor->paint;
    vvi_cached *ids = NULL;
    naming from = {0};
    *out = false;
    if (!to->nearest || is_set(paint, "color") || paint->colormap || is_set(paint, "range_lo") ||
        is_set(paint, "range_hi"))
        return VV_OK;
    vv_statistics *s = vvi_alloc(job, sizeof *s, VVI_MEM_SCRATCH);
    if (!s)
        return vv_fail_memory(sizeof *s);
    vv_status st = vv_field_statistics(s, to->field, to->component, job);
    const bool rows = st == VV_OK && !vvi_label_ids_needed(vv_field_get_info(to->field), s);
    vvi_free(s);
    if (!rows)
        return st;
    if ((st = vvi_label_ids_get(&ids, to->field, to->component, job)) == VV_OK &&
        (st = open_naming(&from, cast, dataset, paint->data, job)) == VV_OK)
        st = make_rows(to, vvi_cached_value(ids), &from, job);
    vv_file_close(from.file);
    vvi_cache_release(ids);
    *out = st == VV_OK;
    return st == VV_OK ? st : vv_fail_in(st, "%s.paint", cast->path);
}
