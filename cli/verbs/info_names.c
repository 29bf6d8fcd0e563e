#include "info_names.h"
#include "grid/info_text.h"
#include "grid/label_id.h"
#include "label_counts.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

enum { LINES_MOST = 64 }; /* of labels and parts, as text; all with --verbose and in JSON */

static unsigned code(double v)
{
    return (unsigned)lrint(255 * (v > 0 ? v < 1 ? v : 1 : 0));
}

void cli_print_color(char out[16], vv_color c)
{
    const int n = snprintf(out, 16, "#%02x%02x%02x", code(vv_srgb_encode(c.r)), code(vv_srgb_encode(c.g)),
                           code(vv_srgb_encode(c.b)));
    if (code(c.a) != 255)
        snprintf(out + n, 16 - (size_t)n, "%02x", code(c.a));
}

size_t cli_info_lines(const cli_command *command)
{
    return command->common->verbose ? SIZE_MAX : LINES_MOST;
}

void cli_info_more(cli_command *command, size_t n)
{
    if (n > cli_info_lines(command))
        cli_command_line(command, "", "and %zu more, which --verbose and --json list", n - cli_info_lines(command));
}

void cli_info_parts(cli_command *command, const cli_input *input)
{
    vv_part part;
    size_t n = 0;
    vvi_result_open(&command->json, "parts", '[');
    for (; vv_file_part(input->file, n, &part); n++) {
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_string(&command->json, "name", part.name);
        vvi_result_string(&command->json, "about", part.about);
        vvi_result_bool(&command->json, "chosen", part.chosen);
        vvi_result_close(&command->json, '}');
        if (n < cli_info_lines(command))
            cli_command_line(command, n ? "" : "parts", "%s%s%s%s", part.name, *part.about ? ": " : "", part.about,
                             part.chosen ? " (this one)" : "");
    }
    cli_info_more(command, n);
    vvi_result_close(&command->json, ']');
}

void cli_info_channel_json(vvi_result *json, const vv_channel *channel)
{
    char color[16];
    const bool named = channel && channel->name[0], colored = channel && channel->has_color;
    if (colored)
        cli_print_color(color, channel->color);
    vvi_result_string(json, "name", named ? channel->name : NULL);
    vvi_result_string(json, "color", colored ? color : NULL);
    if (channel && channel->lo < channel->hi)
        vvi_result_numbers(json, "window", (const double[]){channel->lo, channel->hi}, 2);
    else
        vvi_result_string(json, "window", NULL);
}

void cli_info_channel_text(cli_command *command, int component, const vv_channel *channel)
{
    char color[16] = "", window[80] = "", lo[32], hi[32];
    if (channel && channel->has_color)
        cli_print_color(color, channel->color);
    if (channel && channel->lo < channel->hi) {
        vvi_value_print(lo, channel->lo, channel->lo, channel->hi);
        vvi_value_print(hi, channel->hi, channel->lo, channel->hi);
        snprintf(window, sizeof window, ", window %s to %s", lo, hi);
    }
    cli_command_line(command, "channel", "%d%s%s%s%s%s", component, channel && channel->name[0] ? " " : "",
                     channel ? channel->name : "", *color ? ", " : "", color, window);
}

void cli_info_channels(cli_command *command, const cli_input *input)
{
    size_t n;
    const vv_channel *channels = vv_file_channels(input->file, &n);
    vvi_result_open(&command->json, "channels", '[');
    for (size_t c = 0; c < n; c++) {
        vvi_result_open(&command->json, NULL, '{');
        cli_info_channel_json(&command->json, &channels[c]);
        vvi_result_close(&command->json, '}');
        cli_info_channel_text(command, (int)c, &channels[c]);
    }
    vvi_result_close(&command->json, ']');
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

static void put_codes(vvi_result *json, const vv_code *codes)
{
    vvi_result_open(json, "codes", '{');
    for (int c = 0; c < VV_LABEL_CODES; c++) {
        if (!codes[c].value[0] && !codes[c].meaning[0])
            continue;
        vvi_result_open(json, code_names[c], '{');
        vvi_result_string(json, "scheme", codes[c].scheme);
        vvi_result_string(json, "value", codes[c].value);
        vvi_result_string(json, "meaning", codes[c].meaning);
        vvi_result_close(json, '}');
    }
    vvi_result_close(json, '}');
}

static void put_json(vvi_result *json, const row *r)
{
    char color[16];
    const bool colored = r->label && r->label->has_color;
    if (colored)
        cli_print_color(color, r->label->color);
    vvi_result_open(json, NULL, '{');
    vvi_result_label(json, "value", r->value, r->is_unsigned);
    vvi_result_string(json, "name", r->label && r->label->name[0] ? r->label->name : NULL);
    vvi_result_string(json, "color", colored ? color : NULL);
    if (r->label && r->label->codes)
        put_codes(json, r->label->codes);
    if (r->count) {
        vvi_result_unsigned(json, "count", *r->count);
        vvi_result_number(json, "volume", r->volume);
    }
    vvi_result_close(json, '}');
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

/* In columns, which cli_command_line() would close up. */
static void put_text(cli_command *command, bool first, const row *r)
{
    char color[16] = "", counted[96] = "", digits[VVI_LABEL_DIGITS];
    if (r->label && r->label->has_color)
        cli_print_color(color, r->label->color);
    if (r->count)
        snprintf(counted, sizeof counted, "%10" PRIu64 " samples %12.6g %s  ", *r->count, r->volume, r->unit);
    vvi_text_printf(&command->text, "%-14s%5s  %s%-9s  ", first ? "labels" : "",
                    vvi_label_print(digits, r->value, r->is_unsigned), counted, color);
    vvi_text_add_clean(&command->text, r->label ? r->label->name : "");
    if (r->label)
        add_meanings(&command->text, r->label);
    vvi_text_add(&command->text, "\n");
}

static int by_value(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label *)a)->value, ((const vv_label *)b)->value, false);
}

static int by_unsigned_value(const void *a, const void *b)
{
    return vvi_label_compare(((const vv_label *)a)->value, ((const vv_label *)b)->value, true);
}

static bool is_unsigned(const cli_input *input)
{
    return vvi_label_is_unsigned(vv_file_info(input->file)->type);
}

/* The file's labels by ascending value, yours to free(); NULL without any, or without memory. */
static vv_label *sorted_labels(const cli_input *input, size_t *n_out)
{
    const vv_label *labels = vv_file_labels(input->file, n_out);
    vv_label *sorted = *n_out ? malloc(*n_out * sizeof *sorted) : NULL;
    if (!sorted) {
        *n_out = 0;
        return NULL;
    }
    memcpy(sorted, labels, *n_out * sizeof *sorted);
    qsort(sorted, *n_out, sizeof *sorted, is_unsigned(input) ? by_unsigned_value : by_value);
    return sorted;
}

void cli_info_labels(cli_command *command, const cli_input *input)
{
    size_t n;
    vv_label *labels = sorted_labels(input, &n);
    vvi_result_open(&command->json, "labels", '[');
    for (size_t i = 0; i < n; i++) {
        const row r = {.value = labels[i].value, .is_unsigned = is_unsigned(input), .label = &labels[i]};
        put_json(&command->json, &r);
        if (i < cli_info_lines(command))
            put_text(command, i == 0, &r);
    }
    cli_info_more(command, n);
    vvi_result_close(&command->json, ']');
    free(labels);
}

/* "mm^3", and what one sample takes of it. */
static double cell_volume(char unit[24], const vv_grid *grid)
{
    const bool measured = strcmp(grid->unit, "voxels") != 0;
    snprintf(unit, 24, "%s%s", measured ? grid->unit : "", measured ? "^3" : "");
    return fabs(vv_affine_determinant(grid->index_to_world));
}

/* Both lists ascend: labels of the file that do not occur stand among those that do. */
static void put_counts(cli_command *command, const vv_label *labels, size_t n_labels, const cli_label_count *counts,
                       size_t n_counts, const vv_field_info *info)
{
    static const uint64_t none = 0;
    char unit[24];
    const double cell = cell_volume(unit, &info->grid);
    const bool is_unsigned = vvi_label_is_unsigned(info->type);
    size_t n = 0;
    vvi_result_open(&command->json, "labels", '[');
    for (size_t l = 0, c = 0; l < n_labels || c < n_counts; n++) {
        const int order = l == n_labels   ? 1
                          : c == n_counts ? -1
                                          : vvi_label_compare(labels[l].value, counts[c].value, is_unsigned);
        const bool named = order <= 0, there = order >= 0;
        const row r = {.value = named ? labels[l].value : counts[c].value,
                       .is_unsigned = is_unsigned,
                       .label = named ? &labels[l] : NULL,
                       .count = there ? &counts[c].count : &none,
                       .volume = there ? (double)counts[c].count * cell : 0,
                       .unit = unit};
        put_json(&command->json, &r);
        if (n < cli_info_lines(command))
            put_text(command, n == 0, &r);
        l += named;
        c += there;
    }
    cli_info_more(command, n);
    vvi_result_close(&command->json, ']');
    vvi_result_string(&command->json, "volume_unit", *unit ? unit : NULL);
}

vv_status cli_info_label_counts(cli_command *command, const cli_input *input, const vv_field *field)
{
    size_t n_labels, n_counts;
    cli_label_count *counts;
    const vv_status st = cli_count_labels(&counts, &n_counts, field, command->job);
    if (st != VV_OK)
        return st;
    vv_label *labels = sorted_labels(input, &n_labels);
    put_counts(command, labels, n_labels, counts, n_counts, vv_field_get_info(field));
    free(labels);
    free(counts);
    return VV_OK;
}
