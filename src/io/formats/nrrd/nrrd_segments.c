/* Segments, as 3D Slicer writes them. What a segment had in the file that it comes from goes on, if that was a NRRD:
 * its ID, its tags and keys that nobody knows. */
#include "core/memory.h"
#include "grid/label_color.h"
#include "grid/label_id.h"
#include "io/formats/nrrd/nrrd.h"
#include "io/placement.h"
#include "io/scan.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define NONE SIZE_MAX

/* A key of a segment: "Segment3_Tags:=...". */
typedef struct old_key {
    const char *line, *rest; /* rest: from "_" on */
    size_t next;             /* of the same segment; NONE: the last */
} old_key;

/* The segments of the file that the samples come from. */
typedef struct origin {
    const vv_notes *notes; /* NULL: none is known */
    vvi_nrrd table;        /* its names alone */
    old_key *key;
    size_t n_keys;
    size_t first[VVI_NRRD_NAMES_MOST]; /* key of each segment */
} origin;

typedef struct writing {
    vvi_text *t;
    const vv_field_info *info;
    const vv_write_options *options;
    const vvi_nrrd_segmentation *seg; /* NULL: a plain NRRD of labels */
    const origin *from;
} writing;

/* Origin ---------------------------------------------------------------------------------------------------------- */

static vv_status keep_key(origin *o, const char *line)
{
    size_t number, at = o->n_keys;
    const char *rest;
    if (!vvi_nrrd_numbered(&number, &rest, line, "Segment") || rest[0] != '_' || !strstr(rest, ":="))
        return VV_OK;
    if ((at & (at - 1)) == 0) {
        void *grown = vvi_realloc(NULL, o->key, (at ? at * 2 : 1) * sizeof *o->key, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(at * 2 * sizeof *o->key);
        o->key = grown;
    }
    o->key[o->n_keys++] = (old_key){line, rest, o->first[number]};
    o->first[number] = at;
    char *key = vvi_strdup(line);
    if (!key)
        return vv_fail_memory(strlen(line));
    char *value = strstr(key, ":=");
    *value = 0;
    value += 2;
    vvi_nrrd_unescape(value);
    const vv_status st = vvi_nrrd_name_key(&o->table, key, value);
    free(key);
    return st;
}

static vv_status open_origin(origin *o, const vv_write_options *options)
{
    int32_t code;
    size_t n;
    const char *line;
    vv_status st = VV_OK;
    for (size_t i = 0; i < VVI_NRRD_NAMES_MOST; i++)
        o->first[i] = NONE;
    if (!vvi_nrrd_has_origin(options))
        return VV_OK;
    o->notes = vvi_file_notes(options->origin);
    for (size_t i = 0; st == VV_OK && (line = vvi_notes_kept(o->notes, i, &code, &n)) != NULL; i++)
        if (code == VVI_NRRD_KEPT_KEY && !memchr(line, '\n', n))
            st = keep_key(o, line);
    return st;
}

static void close_origin(origin *o)
{
    vvi_nrrd_names_free(o->table.names);
    vvi_free(o->key);
}

/* Which of its segments a label was. */
static size_t find_old(const origin *o, const vv_label *label)
{
    const vvi_nrrd_segment *s;
    for (size_t i = 0; (s = vvi_nrrd_get_segment(o->table.names, i)) != NULL; i++)
        if (s->there && s->layer == label->layer && s->label.value == label->value)
            return i;
    return NONE;
}

static const char *old_value(const origin *o, size_t old, const char *rest)
{
    const size_t n = strlen(rest);
    for (size_t k = old == NONE ? NONE : o->first[old]; k != NONE; k = o->key[k].next)
        if (strncmp(o->key[k].rest, rest, n) == 0 && strncmp(o->key[k].rest + n, ":=", 2) == 0)
            return o->key[k].rest + n + 2;
    return NULL;
}

/* A key of the segmentation as a whole. */
static const char *old_whole(const origin *o, const char *key)
{
    const size_t n_key = strlen(key);
    int32_t code;
    size_t n;
    const char *line;
    for (size_t i = 0; o->notes && (line = vvi_notes_kept(o->notes, i, &code, &n)) != NULL; i++)
        if (code == VVI_NRRD_KEPT_KEY && strncmp(line, key, n_key) == 0 && strncmp(line + n_key, ":=", 2) == 0 &&
            !memchr(line, '\n', n))
            return line + n_key + 2;
    return NULL;
}

/* A segment -------------------------------------------------------------------------------------------------------- */

static bool is_taken(const origin *o, const char *id)
{
    for (size_t i = 0; i < VVI_NRRD_NAMES_MOST && o->n_keys > 0; i++) {
        const char *there = old_value(o, o->first[i] == NONE ? NONE : i, "_ID");
        if (there && strcmp(there, id) == 0)
            return true;
    }
    return false;
}

static const char *print_value(char out[VVI_LABEL_DIGITS], const writing *w, const vv_label *label)
{
    return vvi_label_print(out, label->value, vvi_label_is_unsigned(w->info->type));
}

static void add_id(const writing *w, size_t i, size_t old, const vv_label *label)
{
    char id[64], digits[VVI_LABEL_DIGITS];
    const char *there = old_value(w->from, old, "_ID");
    int n = snprintf(id, sizeof id, "Segment_%s", print_value(digits, w, label));
    if (label->layer > 0)
        n += snprintf(id + n, sizeof id - (size_t)n, "_layer%d", label->layer);
    if (!there && is_taken(w->from, id))
        snprintf(id + n, sizeof id - (size_t)n, "_%zu", i);
    vvi_text_printf(w->t, "Segment%zu_ID:=%s\n", i, there ? there : id);
}

/* A name that was longer than names are here stays what it was. */
static void add_name(const writing *w, size_t i, size_t old, const vv_label *label)
{
    char digits[VVI_LABEL_DIGITS];
    const char *there = old_value(w->from, old, "_Name");
    const vvi_nrrd_segment *s = old == NONE ? NULL : vvi_nrrd_get_segment(w->from->table.names, old);
    const char *made = old_value(w->from, old, "_NameAutoGenerated");
    const bool same = there && s && strcmp(s->label.name, label->name) == 0;
    if (!label->name[0] && !w->seg)
        return;
    vvi_text_printf(w->t, "Segment%zu_Name:=", i);
    if (same)
        vvi_text_printf(w->t, "%s\n", there);
    else if (label->name[0])
        vvi_nrrd_add_name(w->t, label->name);
    else
        vvi_text_printf(w->t, "Segment_%s\n", print_value(digits, w, label));
    vvi_text_printf(w->t, "Segment%zu_NameAutoGenerated:=%s\n", i, same && made ? made : label->name[0] ? "0" : "1");
}

static void add_color(const writing *w, size_t i, size_t old, const vv_label *label)
{
    char key[64];
    vv_color color = label->color;
    const char *there = old_value(w->from, old, "_Color"), *made = old_value(w->from, old, "_ColorAutoGenerated");
    const vvi_nrrd_segment *s = old == NONE ? NULL : vvi_nrrd_get_segment(w->from->table.names, old);
    const bool same = there && s && s->label.has_color && label->has_color &&
                      memcmp(&s->label.color, &color, 3 * sizeof color.r) == 0;
    if (!label->has_color && !w->seg)
        return;
    if (!label->has_color) { /* the one that it is shown in */
        double rgb[3];
        vvi_label_color(rgb, label->value);
        color = (vv_color){rgb[0], rgb[1], rgb[2], 1};
    }
    snprintf(key, sizeof key, "Segment%zu_Color", i);
    if (same)
        vvi_text_printf(w->t, "%s:=%s\n", key, there);
    else
        vvi_nrrd_add_color(w->t, key, color);
    vvi_text_printf(w->t, "Segment%zu_ColorAutoGenerated:=%s\n", i, same && made ? made : label->has_color ? "0" : "1");
    if (label->has_color && color.a != 1)
        vvi_text_printf(w->t, "Segment%zu_VolVisOpacity:=%.6g\n", i, color.a);
}

/* Slicer takes the extent of the first segment of a layer for the layer: it cuts off what lies outside. So all segments
 * of a layer have the one of the layer, which is what Slicer writes. */
static void add_extent(const writing *w, size_t i, int layer)
{
    vvi_text_printf(w->t, "Segment%zu_Extent:=", i);
    for (int a = 0; a < 3; a++) {
        const int64_t lo = w->seg ? w->seg->box[layer][2 * a] : 0;
        const int64_t hi = w->seg ? w->seg->box[layer][2 * a + 1] : w->info->grid.dims[a] - 1;
        vvi_text_printf(w->t, "%s%" PRId64 " %" PRId64, a ? " " : "", lo, hi);
    }
    vvi_text_add(w->t, "\n");
}

/* Tags, and whatever else it had. */
static void add_rest(const writing *w, size_t i, size_t old, const vv_label *label)
{
    static const char *const ours[] = {
        "_ID",    "_Name",   "_NameAutoGenerated", "_Color", "_ColorAutoGenerated", "_LabelValue",
        "_Layer", "_Extent", "_VolVisOpacity"};
    bool tags = false;
    for (size_t k = old == NONE ? NONE : w->from->first[old]; k != NONE; k = w->from->key[k].next) {
        const char *rest = w->from->key[k].rest;
        const size_t n = (size_t)(strstr(rest, ":=") - rest);
        bool known = false;
        for (size_t o = 0; o < sizeof ours / sizeof *ours; o++)
            known |= strlen(ours[o]) == n && strncmp(ours[o], rest, n) == 0;
        if (!known)
            vvi_text_printf(w->t, "Segment%zu%s\n", i, rest);
        tags |= n == 5 && strncmp(rest, "_Tags", 5) == 0;
    }
    if (tags || !label->codes)
        return;
    vvi_text_printf(w->t, "Segment%zu_Tags:=", i);
    vvi_nrrd_add_tags(w->t, label->codes);
    vvi_text_add(w->t, "\n");
}

static void add_segment(const writing *w, size_t i, const vv_label *label)
{
    char digits[VVI_LABEL_DIGITS];
    const int layer = w->options->layers ? label->layer : 0;
    const size_t old = find_old(w->from, label);
    add_id(w, i, old, label);
    add_name(w, i, old, label);
    add_color(w, i, old, label);
    vvi_text_printf(w->t, "Segment%zu_LabelValue:=%s\nSegment%zu_Layer:=%d\n", i, print_value(digits, w, label), i,
                    layer);
    add_extent(w, i, layer);
    add_rest(w, i, old, label);
}

/* The whole -------------------------------------------------------------------------------------------------------- */

/* Where the first sample is in the volume that was segmented: what a crop cuts off moves it; other changes make another
 * volume, false. */
static bool move_offset(int64_t offset[3], const char *there, const writing *w)
{
    const vv_grid *now = &w->info->grid, *then = &vv_file_info(w->options->origin)->grid;
    vv_affine back;
    for (int a = 0; a < 3; a++)
        if (!there || !vvi_scan_int(&offset[a], there, &there) || llabs(offset[a]) > INT32_MAX)
            return false;
    if (strcmp(now->unit, then->unit) != 0 || !vv_affine_invert(&back, then->index_to_world))
        return false;
    const vv_affine m = vv_affine_compose(back, now->index_to_world);
    const double turned = fabs(m.axis[0].x - 1) + fabs(m.axis[0].y) + fabs(m.axis[0].z) + fabs(m.axis[1].x) +
                          fabs(m.axis[1].y - 1) + fabs(m.axis[1].z) + fabs(m.axis[2].x) + fabs(m.axis[2].y) +
                          fabs(m.axis[2].z - 1);
    const double shift[3] = {m.origin.x, m.origin.y, m.origin.z};
    for (int a = 0; a < 3; a++) {
        if (!(turned < 1e-6) || !(fabs(shift[a] - rint(shift[a])) < 1e-3) || !(fabs(shift[a]) < INT32_MAX))
            return false;
        offset[a] += (int64_t)rint(shift[a]);
    }
    return true;
}

/* NAME|VALUE|ABOUT&...: one of them is the grid of the volume that was segmented. */
static void add_parameters(vvi_text *t, const char *there, bool same_volume)
{
    static const char *const grid = "Reference image geometry|";
    vvi_text_add(t, "Segmentation_ConversionParameters:=");
    for (const char *at = there ? there : ""; *at;) {
        const size_t n = strcspn(at, "&"), whole = n + (at[n] == '&');
        if (same_volume || strncmp(at, grid, strlen(grid)) != 0)
            vvi_text_add_n(t, at, whole);
        at += whole;
    }
    vvi_text_add(t, "\n");
}

static void add_whole(const writing *w)
{
    static const char *const name = "Binary labelmap";
    int64_t offset[3] = {0};
    const char *shown = old_whole(w->from, "Segmentation_ContainedRepresentationNames");
    const char *parameters = old_whole(w->from, "Segmentation_ConversionParameters");
    const char *there = old_whole(w->from, "Segmentation_ReferenceImageExtentOffset");
    const bool same_volume = there && move_offset(offset, there, w);
    if (!same_volume)
        memset(offset, 0, sizeof offset);
    if (!w->seg && !shown && !parameters && !there)
        return;
    vvi_text_printf(w->t, "Segmentation_ContainedRepresentationNames:=%s\n", shown ? shown : "Binary labelmap|");
    add_parameters(w->t, parameters, same_volume);
    /* of Slicer before and since version 5.3 */
    vvi_text_printf(w->t, "Segmentation_MasterRepresentation:=%s\nSegmentation_SourceRepresentation:=%s\n", name, name);
    vvi_text_printf(w->t, "Segmentation_ReferenceImageExtentOffset:=%" PRId64 " %" PRId64 " %" PRId64 "\n", offset[0],
                    offset[1], offset[2]);
}

vv_status vvi_nrrd_add_segments(vvi_text *t, const vv_field_info *info, const vv_write_options *options,
                                const vvi_nrrd_segmentation *seg)
{
    origin *from = vvi_alloc_zeroed(NULL, sizeof *from, VVI_MEM_SCRATCH);
    if (!from)
        return vv_fail_memory(sizeof *from);
    const writing w = {t, info, options, seg, from};
    const vv_status st = open_origin(from, options);
    for (size_t i = 0; st == VV_OK && i < options->n_labels && i < VVI_NRRD_NAMES_MOST; i++)
        add_segment(&w, i, &options->labels[i]);
    if (st == VV_OK && (seg || options->n_labels > 0))
        add_whole(&w);
    close_origin(from);
    vvi_free(from);
    return st;
}
