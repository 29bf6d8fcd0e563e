/* Parts, channels and labels of a file. */
#include "about/about.h"
#include "grid/info_text.h"
#include "grid/label_id.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <volvis/image.h>
#include <volvis/measure.h>

enum { LINES_MOST = 64 }; /* of labels and parts, for people */

static unsigned code(double v)
{
    return (unsigned)lrint(255 * (v > 0 ? v < 1 ? v : 1 : 0));
}

static void print_color(char out[16], vv_color c)
{
    const int n = snprintf(out, 16, "#%02x%02x%02x", code(vv_srgb_encode(c.r)), code(vv_srgb_encode(c.g)),
                           code(vv_srgb_encode(c.b)));
    if (code(c.a) != 255)
        snprintf(out + n, 16 - (size_t)n, "%02x", code(c.a));
}

size_t vvi_about_lines(const vvi_about *about)
{
    return about->options.all ? SIZE_MAX : LINES_MOST;
}

void vvi_about_more(const vvi_about *about, size_t n)
{
    if (n > vvi_about_lines(about))
        vvi_tell_line(about->answer, "", "and %zu more%s", n - vvi_about_lines(about),
                      about->options.more ? about->options.more : "");
}

void vvi_about_parts(const vvi_about *about)
{
    vv_answer *a = about->answer;
    vv_part part;
    size_t n = 0;
    vvi_tell_open(a, "parts", "[");
    for (; vv_file_part(about->file, n, &part); n++) {
        vvi_tell_open(a, NULL, "{");
        vvi_tell_text(a, "name", part.name);
        vvi_tell_text(a, "about", part.about);
        vvi_tell_bool(a, "chosen", part.chosen);
        vvi_tell_close(a, "}");
        if (n < vvi_about_lines(about))
            vvi_tell_line(a, n ? "" : "parts", "%s%s%s%s", part.name, *part.about ? ": " : "", part.about,
                          part.chosen ? " (this one)" : "");
    }
    vvi_about_more(about, n);
    vvi_tell_close(a, "]");
}

void vvi_about_channel_keys(vv_answer *a, const vv_channel *channel)
{
    char color[16];
    const bool named = channel && channel->name[0], colored = channel && channel->has_color;
    if (colored)
        print_color(color, channel->color);
    vvi_tell_text(a, "name", named ? channel->name : NULL);
    vvi_tell_text(a, "color", colored ? color : NULL);
    if (channel && channel->lo < channel->hi)
        vvi_tell_numbers(a, "window", (const double[]){channel->lo, channel->hi}, 2);
    else
        vvi_tell_text(a, "window", NULL);
}

void vvi_about_channel_line(vv_answer *a, int component, const vv_channel *channel)
{
    char color[16] = "", window[80] = "", lo[32], hi[32];
    if (channel && channel->has_color)
        print_color(color, channel->color);
    if (channel && channel->lo < channel->hi) {
        vvi_value_print(lo, channel->lo, channel->lo, channel->hi);
        vvi_value_print(hi, channel->hi, channel->lo, channel->hi);
        snprintf(window, sizeof window, ", window %s to %s", lo, hi);
    }
    vvi_tell_line(a, "channel", "%d%s%s%s%s%s", component, channel && channel->name[0] ? " " : "",
                  channel ? channel->name : "", *color ? ", " : "", color, window);
}

void vvi_about_channels(const vvi_about *about)
{
    vv_answer *a = about->answer;
    size_t n;
    const vv_channel *channels = vv_file_channels(about->file, &n);
    vvi_tell_open(a, "channels", "[");
    for (size_t c = 0; c < n; c++) {
        vvi_tell_open(a, NULL, "{");
        vvi_about_channel_keys(a, &channels[c]);
        vvi_tell_close(a, "}");
        vvi_about_channel_line(a, (int)c, &channels[c]);
    }
    vvi_tell_close(a, "]");
}

/* Labels ---------------------------------------------------------------------------------------------------------- */

/* One line and one JSON object; count NULL: not counted. */
typedef struct row {
    vv_label_id value;
    bool is_unsigned;
    const vv_label *label; /* NULL: the file does not name it */
    const uint64_t *count;
    double volume;
    const char *unit; /* of the volume; "" when lengths have none */
} row;

static const char *const code_names[VV_LABEL_CODES] = {"category", "type", "type_modifier", "region",
                                                       "region_modifier"};

static void put_codes(vv_answer *a, const vv_code *codes)
{
    vvi_tell_open(a, "codes", "{");
    for (int c = 0; c < VV_LABEL_CODES; c++) {
        if (!codes[c].value[0] && !codes[c].meaning[0])
            continue;
        vvi_tell_open(a, code_names[c], "{");
        vvi_tell_text(a, "scheme", codes[c].scheme);
        vvi_tell_text(a, "value", codes[c].value);
        vvi_tell_text(a, "meaning", codes[c].meaning);
        vvi_tell_close(a, "}");
    }
    vvi_tell_close(a, "}");
}

static void put_keys(vv_answer *a, const row *r)
{
    char color[16], digits[VVI_LABEL_DIGITS];
    const bool colored = r->label && r->label->has_color;
    if (colored)
        print_color(color, r->label->color);
    vvi_tell_open(a, NULL, "{");
    vvi_tell_json(a, "value", vvi_label_print(digits, r->value, r->is_unsigned));
    vvi_tell_text(a, "name", r->label && r->label->name[0] ? r->label->name : NULL);
    vvi_tell_text(a, "color", colored ? color : NULL);
    if (r->label && r->label->codes)
        put_codes(a, r->label->codes);
    if (r->count) {
        vvi_tell_count(a, "count", *r->count);
        vvi_tell_number(a, "volume", r->volume);
    }
    vvi_tell_close(a, "}");
}

/* What the codes mean, where the name does not say that: "  [Tissue, Lung, Left]" */
static void add_meanings(vvi_text *text, const vv_label *label)
{
    bool any = false;
    for (int c = 0; label->codes && c < VV_LABEL_CODES; c++) {
        const char *meaning = label->codes[c].meaning;
        if (!meaning[0] || strcasecmp(meaning, label->name) == 0)
            continue;
        vvi_text_add(text, any ? ", " : "  [");
        vvi_text_add_clean(text, meaning);
        any = true;
    }
    vvi_text_add(text, any ? "]" : "");
}

/* In columns, which a line would close up. */
static void put_line(vvi_text *lines, bool first, const row *r)
{
    char color[16] = "", counted[96] = "", digits[VVI_LABEL_DIGITS];
    if (r->label && r->label->has_color)
        print_color(color, r->label->color);
    if (r->count)
        snprintf(counted, sizeof counted, "%10" PRIu64 " samples %12.6g %s  ", *r->count, r->volume, r->unit);
    vvi_text_printf(lines, "%-14s%5s  %s%-9s  ", first ? "labels" : "",
                    vvi_label_print(digits, r->value, r->is_unsigned), counted, color);
    vvi_text_add_clean(lines, r->label ? r->label->name : "");
    if (r->label)
        add_meanings(lines, r->label);
    vvi_text_add(lines, "\n");
}

static int by_value(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label *)a)->value, ((const vv_label *)b)->value, false);
}

static int by_unsigned_value(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label *)a)->value, ((const vv_label *)b)->value, true);
}

static bool is_unsigned(const vvi_about *about)
{
    return vvi_label_is_unsigned(vv_file_info(about->file)->type);
}

/* The file's labels by ascending value, yours to free(); NULL without any, or without memory. */
static vv_label *sorted_labels(const vvi_about *about, size_t *n_out)
{
    const vv_label *labels = vv_file_labels(about->file, n_out);
    vv_label *sorted = *n_out ? malloc(*n_out * sizeof *sorted) : NULL;
    if (!sorted) {
        *n_out = 0;
        return NULL;
    }
    memcpy(sorted, labels, *n_out * sizeof *sorted);
    qsort(sorted, *n_out, sizeof *sorted, is_unsigned(about) ? by_unsigned_value : by_value);
    return sorted;
}

void vvi_about_labels(const vvi_about *about)
{
    vv_answer *a = about->answer;
    vvi_text lines = {0};
    size_t n;
    vv_label *labels = sorted_labels(about, &n);
    vvi_tell_open(a, "labels", "[");
    for (size_t i = 0; i < n; i++) {
        const row r = {.value = labels[i].value, .is_unsigned = is_unsigned(about), .label = &labels[i]};
        put_keys(a, &r);
        if (i < vvi_about_lines(about))
            put_line(&lines, i == 0, &r);
    }
    vvi_tell_block(a, &lines);
    vvi_about_more(about, n);
    vvi_tell_close(a, "]");
    free(labels);
}

/* "mm^3", and what one sample takes of it. */
static double cell_volume(char unit[24], const vv_grid *grid)
{
    const bool measured = strcmp(grid->unit, "voxels") != 0;
    snprintf(unit, 24, "%s%s", measured ? grid->unit : "", measured ? "^3" : "");
    return fabs(vv_affine_determinant(grid->index_to_world));
}

/* What occurs, by ascending value: measures say nothing of 0, which is the rest of n samples. */
typedef struct counted {
    const vv_label_measures *measures;
    size_t n;
    uint64_t n_zero;
    bool is_unsigned;
} counted;

/* By number; false past the end. */
static bool counted_nth(vv_label_id *value, uint64_t *count, const counted *c, size_t index)
{
    size_t before = 0; /* 0 stands after those that are less */
    while (before < c->n && vvi_label_compare(c->measures[before].label, 0, c->is_unsigned) < 0)
        before++;
    const bool zero = c->n_zero > 0 && index == before;
    const size_t at = index - (c->n_zero > 0 && index > before);
    if (!zero && at >= c->n)
        return false;
    *value = zero ? 0 : c->measures[at].label;
    *count = zero ? c->n_zero : c->measures[at].count;
    return true;
}

/* Both lists ascend: labels of the file that do not occur stand among those that do. */
static void put_counts(const vvi_about *about, const vv_label *labels, size_t n_labels, const counted *c)
{
    vv_answer *a = about->answer;
    vvi_text lines = {0};
    char unit[24];
    const double cell = cell_volume(unit, &vv_field_get_info(about->options.field)->grid);
    size_t n = 0;
    vvi_tell_open(a, "labels", "[");
    for (size_t l = 0, i = 0;; n++) {
        vv_label_id value = 0;
        uint64_t count = 0;
        const bool left = counted_nth(&value, &count, c, i);
        if (l == n_labels && !left)
            break;
        const int order = l == n_labels ? 1 : !left ? -1 : vvi_label_compare(labels[l].value, value, c->is_unsigned);
        const bool named = order <= 0, there = order >= 0;
        count = there ? count : 0;
        const row r = {.value = named ? labels[l].value : value,
                       .is_unsigned = c->is_unsigned,
                       .label = named ? &labels[l] : NULL,
                       .count = &count,
                       .volume = (double)count * cell,
                       .unit = unit};
        put_keys(a, &r);
        if (n < vvi_about_lines(about))
            put_line(&lines, n == 0, &r);
        l += named;
        i += there;
    }
    vvi_tell_block(a, &lines);
    vvi_about_more(about, n);
    vvi_tell_close(a, "]");
    vvi_tell_text(a, "volume_unit", *unit ? unit : NULL);
}

vv_status vvi_about_label_counts(const vvi_about *about)
{
    const int64_t *dims = vv_field_get_info(about->options.field)->grid.dims;
    counted c = {.n_zero = (uint64_t)(dims[0] * dims[1] * dims[2]), .is_unsigned = is_unsigned(about)};
    vv_label_measures *measures = NULL;
    vv_label_options options;
    size_t n_labels;
    vv_label_options_init(&options, sizeof options);
    options.no_areas = true;
    const vv_status st = vv_measure_labels(&measures, &c.n, about->options.field, &options, about->job);
    if (st != VV_OK)
        return st;
    c.measures = measures;
    for (size_t i = 0; i < c.n; i++)
        c.n_zero -= measures[i].count;
    vv_label *labels = sorted_labels(about, &n_labels);
    put_counts(about, labels, n_labels, &c);
    free(labels);
    vv_label_measures_free(measures);
    return VV_OK;
}
