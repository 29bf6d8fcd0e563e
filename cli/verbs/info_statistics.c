#include "info_statistics.h"
#include "core/units.h"
#include "grid/fill_value.h"
#include "grid/info_text.h"
#include "grid/statistics.h"
#include "histogram.h"
#include "info_names.h"
#include "value.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HISTOGRAMS_MOST = 4, RANGES_MOST = 8 }; /* of components, as text */

static void text_statistics(cli_command *command, const vv_statistics *s, const char *unit)
{
    char lo[32], hi[32], mean[32], percentile[5][32];
    if (!s->count) {
        cli_command_line(command, "range", "none: no sample is a finite number");
        cli_command_line(command, "mean", "none");
        return;
    }
    vvi_value_print(lo, s->min, s->min, s->max);
    vvi_value_print(hi, s->max, s->min, s->max);
    vvi_value_print(mean, s->mean, s->min, s->max);
    for (int i = 0; i < 5; i++)
        vvi_value_print(percentile[i], s->percentile[i], s->percentile[0], s->percentile[4]);
    cli_command_line(command, "range", "%s to %s %s", lo, hi, unit);
    cli_command_line(command, "mean", "%s, deviation %g", mean, s->deviation);
    cli_command_line(command, "percentiles", "0.1%%: %s  1%%: %s  50%%: %s  99%%: %s  99.9%%: %s", percentile[0],
                     percentile[1], percentile[2], percentile[3], percentile[4]);
}

static void put_json(vvi_result *json, const vv_statistics *s)
{
    vvi_result_number(json, "min", s->count ? s->min : NAN); /* null */
    vvi_result_number(json, "max", s->count ? s->max : NAN);
    vvi_result_number(json, "mean", s->count ? s->mean : NAN);
    vvi_result_number(json, "deviation", s->count ? s->deviation : NAN);
    vvi_result_unsigned(json, "count", s->count);
    vvi_result_unsigned(json, "nan_count", s->nan_count);
    vvi_result_unsigned(json, "infinite_count", s->infinite_count);
    vvi_result_open(json, "percentiles", '{');
    static const char *const names[] = {"0.1", "1", "50", "99", "99.9"};
    for (int i = 0; i < 5; i++)
        vvi_result_number(json, names[i], s->count ? s->percentile[i] : NAN);
    vvi_result_close(json, '}');
    cli_histogram_json(json, s);
}

static void put_text(cli_command *command, const vv_statistics *s, const char *unit, bool histogram)
{
    text_statistics(command, s, unit);
    if (s->nan_count || s->infinite_count)
        cli_command_line(command, "not finite", "%" PRIu64 " NaN, %" PRIu64 " infinite", s->nan_count,
                         s->infinite_count);
    if (s->count && histogram)
        cli_histogram_text(&command->text, s, true);
}

/* A value that pictures leave out. */
static vv_status put_fill(cli_command *command, const vv_field *field, int component, const vv_statistics *s)
{
    vvi_fills fills;
    char text[VVI_FILL_TEXT];
    if (vv_field_get_info(field)->meaning != VV_MEANING_SCALAR)
        return VV_OK;
    const vv_status st = vvi_fills_find(&fills, field, component, s, command->job);
    if (st != VV_OK || fills.n == 0)
        return st;
    vvi_result_number(&command->json, "fill", fills.fill[0].value);
    vvi_result_number(&command->json, "fill_share", fills.fill[0].share);
    vvi_result_open(&command->json, "fills", '[');
    for (int i = 0; i < fills.n; i++) {
        vvi_result_open(&command->json, NULL, '{');
        vvi_result_number(&command->json, "value", fills.fill[i].value);
        vvi_result_number(&command->json, "share", fills.fill[i].share);
        vvi_result_bool(&command->json, "declared", fills.fill[i].declared);
        vvi_result_close(&command->json, '}');
    }
    vvi_result_close(&command->json, ']');
    vvi_fills_print(text, &fills);
    cli_command_line(command, "fill", "%s: pictures leave %s out", text, fills.n > 1 ? "them" : "it");
    return VV_OK;
}

/* Component by component; `s` is room for one. */
static vv_status each_component(cli_command *command, const cli_input *input, const vv_field *field, vv_statistics *s)
{
    const vv_field_info *info = vv_field_get_info(field);
    size_t n;
    const vv_channel *channels = vv_file_channels(input->file, &n);
    vv_status st = vvi_field_statistics_exact(s, field, 0, command->job);
    if (st != VV_OK)
        return st;
    put_json(&command->json, s);
    vvi_result_open(&command->json, "channels", '[');
    for (int c = 0; c < info->components && st == VV_OK; c++) {
        const vv_channel *channel = (size_t)c < n ? &channels[c] : NULL;
        if ((st = vvi_field_statistics_exact(s, field, c, command->job)) != VV_OK)
            break;
        vvi_result_open(&command->json, NULL, '{');
        cli_info_channel_json(&command->json, channel);
        put_json(&command->json, s);
        if (channel || info->components > 1)
            cli_info_channel_text(command, c, channel);
        st = put_fill(command, field, c, s);
        vvi_result_close(&command->json, '}');
        put_text(command, s, info->value_unit, info->components <= HISTOGRAMS_MOST);
    }
    vvi_result_close(&command->json, ']');
    return st;
}

static const char *find_metadata(const cli_input *input, const char *name)
{
    const char *key, *value;
    for (size_t i = 0; vv_file_metadata(input->file, i, &key, &value); i++)
        if (strcmp(key, name) == 0)
            return value;
    return NULL;
}

/* Padding of images is kept as it is stored, and explains a strange range; see put_fill(). */
static void text_padding(cli_command *command, const cli_input *input, const char *padding)
{
    const vv_field_info *info = vv_file_info(input->file);
    const char *limit = find_metadata(input, "PixelPaddingRangeLimit");
    char value[96] = "";
    double v;
    if (!limit && vvi_parse_number(&v, padding) && (info->value_scale != 1 || info->value_offset != 0))
        snprintf(value, sizeof value, " (%g%s%s)", v * info->value_scale + info->value_offset,
                 info->value_unit[0] ? " " : "", info->value_unit);
    cli_command_line(command, "padding", "%s%s%s as stored%s: no measurement; left out of pictures where it lies apart",
                     padding, limit ? " to " : "", limit ? limit : "", value);
}

void cli_info_missing(cli_command *command, const cli_input *input)
{
    const char *missing = find_metadata(input, "missing values");
    const char *padding = find_metadata(input, "PixelPaddingValue");
    if (missing)
        cli_command_line(command, "missing", "%s", missing);
    if (padding)
        text_padding(command, input, padding);
}

vv_status cli_info_range(cli_command *command, const cli_input *input, const vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    const bool labels = info->meaning == VV_MEANING_LABEL;
    vv_statistics *s = malloc(sizeof *s);
    vv_status st = s ? VV_OK : vv_fail_memory(sizeof *s);
    for (int c = 0; c < info->components && c < RANGES_MOST && st == VV_OK; c++) {
        char lo[32], hi[32], mean[48] = "", missing[64] = "";
        if ((st = vv_field_statistics(s, field, c, command->job)) != VV_OK)
            break;
        const uint64_t strange = s->nan_count + s->infinite_count;
        if (strange)
            snprintf(missing, sizeof missing, "; %" PRIu64 " samples are not finite", strange);
        vvi_value_print(lo, s->min, s->min, s->max);
        vvi_value_print(hi, s->max, s->min, s->max);
        if (!labels)
            snprintf(mean, sizeof mean, ", mean %.6g", s->mean);
        if (s->count)
            cli_command_line(command, c ? "" : "range", "%s to %s%s%s%s%s", lo, hi, info->value_unit[0] ? " " : "",
                             info->value_unit, mean, missing);
        else
            cli_command_line(command, c ? "" : "range", "none: no sample is a finite number");
    }
    free(s);
    return st;
}

vv_status cli_info_statistics(cli_command *command, const cli_input *input, const vv_field *field)
{
    uint32_t checksum = 0;
    char text[32];
    vv_status st = vv_field_checksum(&checksum, field, command->job);
    vv_statistics *s = st == VV_OK ? malloc(sizeof *s) : NULL;
    if (!s)
        return st == VV_OK ? vv_fail_memory(sizeof *s) : st;
    snprintf(text, sizeof text, "crc32:%08" PRIx32, checksum);
    vvi_result_string(&command->json, "checksum", text);
    st = each_component(command, input, field, s);
    free(s);
    if (st == VV_OK && vv_field_get_info(field)->meaning == VV_MEANING_LABEL)
        st = cli_info_label_counts(command, input, field);
    else if (st == VV_OK)
        cli_info_labels(command, input);
    return st;
}
