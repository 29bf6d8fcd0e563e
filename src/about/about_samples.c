/* What a look at samples says: ranges, statistics, values that stand for none. */
#include "about/about.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/fill_value.h"
#include "grid/info_text.h"
#include "grid/statistics.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HISTOGRAMS_MOST = 4, RANGES_MOST = 8 }; /* of components, as text */

static void tell_statistics(vv_answer *a, const vv_statistics *s, const char *unit)
{
    char lo[32], hi[32], mean[32], percentile[5][32];
    if (!s->count) {
        vvi_tell_line(a, "range", "none: no sample is a finite number");
        vvi_tell_line(a, "mean", "none");
        return;
    }
    vvi_value_print(lo, s->min, s->min, s->max);
    vvi_value_print(hi, s->max, s->min, s->max);
    vvi_value_print(mean, s->mean, s->min, s->max);
    for (int i = 0; i < 5; i++)
        vvi_value_print(percentile[i], s->percentile[i], s->percentile[0], s->percentile[4]);
    vvi_tell_line(a, "range", "%s to %s %s", lo, hi, unit);
    vvi_tell_line(a, "mean", "%s, deviation %g", mean, s->deviation);
    vvi_tell_line(a, "percentiles", "0.1%%: %s  1%%: %s  50%%: %s  99%%: %s  99.9%%: %s", percentile[0], percentile[1],
                  percentile[2], percentile[3], percentile[4]);
}

static void put_keys(vv_answer *a, const vv_statistics *s)
{
    vvi_tell_number(a, "min", s->count ? s->min : NAN); /* null */
    vvi_tell_number(a, "max", s->count ? s->max : NAN);
    vvi_tell_number(a, "mean", s->count ? s->mean : NAN);
    vvi_tell_number(a, "deviation", s->count ? s->deviation : NAN);
    vvi_tell_count(a, "count", s->count);
    vvi_tell_count(a, "nan_count", s->nan_count);
    vvi_tell_count(a, "infinite_count", s->infinite_count);
    vvi_tell_open(a, "percentiles", "{");
    static const char *const names[] = {"0.1", "1", "50", "99", "99.9"};
    for (int i = 0; i < 5; i++)
        vvi_tell_number(a, names[i], s->count ? s->percentile[i] : NAN);
    vvi_tell_close(a, "}");
    vvi_tell_open(a, "histogram", "{");
    vvi_tell_number(a, "lo", s->histogram_lo);
    vvi_tell_number(a, "hi", s->histogram_hi);
    vvi_tell_counts(a, "counts", s->histogram, (size_t)s->n_bins);
    vvi_tell_close(a, "}");
}

static void tell_bars(vv_answer *a, const vv_statistics *s)
{
    vv_statistics *bars = vvi_answer_room(a, 1, sizeof *bars);
    if (!bars)
        return;
    *bars = *s;
    vvi_tell_bars(a, bars);
}

static void put_lines(vv_answer *a, const vv_statistics *s, const char *unit, bool histogram)
{
    tell_statistics(a, s, unit);
    if (s->nan_count || s->infinite_count)
        vvi_tell_line(a, "not finite", "%" PRIu64 " NaN, %" PRIu64 " infinite", s->nan_count, s->infinite_count);
    if (s->count && histogram)
        tell_bars(a, s);
}

/* A value that pictures leave out. */
static vv_status put_fill(vv_answer *a, const vv_field *field, int component, const vv_statistics *s, vv_job *job)
{
    vvi_fills fills;
    char text[VVI_FILL_TEXT];
    if (vv_field_get_info(field)->meaning != VV_MEANING_SCALAR)
        return VV_OK;
    const vv_status st = vvi_fills_find(&fills, field, component, s, job);
    if (st != VV_OK || fills.n == 0)
        return st;
    vvi_tell_number(a, "fill", fills.fill[0].value);
    vvi_tell_number(a, "fill_share", fills.fill[0].share);
    vvi_tell_open(a, "fills", "[");
    for (int i = 0; i < fills.n; i++) {
        vvi_tell_open(a, NULL, "{");
        vvi_tell_number(a, "value", fills.fill[i].value);
        vvi_tell_number(a, "share", fills.fill[i].share);
        vvi_tell_bool(a, "declared", fills.fill[i].declared);
        vvi_tell_close(a, "}");
    }
    vvi_tell_close(a, "]");
    vvi_fills_print(text, &fills);
    vvi_tell_line(a, "fill", "%s: pictures leave %s out", text, fills.n > 1 ? "them" : "it");
    return VV_OK;
}

/* Component by component; `s` is room for one. */
static vv_status each_component(const vvi_about *about, vv_statistics *s)
{
    vv_answer *a = about->answer;
    const vv_field *field = about->options.field;
    const vv_field_info *info = vv_field_get_info(field);
    size_t n;
    const vv_channel *channels = vv_file_channels(about->file, &n);
    vv_status st = vvi_field_statistics_exact(s, field, 0, about->job);
    if (st != VV_OK)
        return st;
    put_keys(a, s);
    vvi_tell_open(a, "channels", "[");
    for (int c = 0; c < info->components && st == VV_OK; c++) {
        const vv_channel *channel = (size_t)c < n ? &channels[c] : NULL;
        if ((st = vvi_field_statistics_exact(s, field, c, about->job)) != VV_OK)
            break;
        vvi_tell_open(a, NULL, "{");
        vvi_about_channel_keys(a, channel);
        put_keys(a, s);
        if (channel || info->components > 1)
            vvi_about_channel_line(a, c, channel);
        st = put_fill(a, field, c, s, about->job);
        vvi_tell_close(a, "}");
        put_lines(a, s, info->value_unit, info->components <= HISTOGRAMS_MOST);
    }
    vvi_tell_close(a, "]");
    return st;
}

static const char *find_metadata(const vv_file *file, const char *name)
{
    const char *key, *value;
    for (size_t i = 0; vv_file_metadata(file, i, &key, &value); i++)
        if (strcmp(key, name) == 0)
            return value;
    return NULL;
}

/* Padding of images is kept as it is stored, and explains a strange range; see put_fill(). */
static void tell_padding(const vvi_about *about, const char *padding)
{
    const vv_field_info *info = vv_file_info(about->file);
    const char *limit = find_metadata(about->file, "PixelPaddingRangeLimit");
    char value[96] = "";
    double v;
    if (!limit && vvi_parse_number(&v, padding) && (info->value_scale != 1 || info->value_offset != 0))
        snprintf(value, sizeof value, " (%g%s%s)", v * info->value_scale + info->value_offset,
                 info->value_unit[0] ? " " : "", info->value_unit);
    vvi_tell_line(about->answer, "padding",
                  "%s%s%s as stored%s: no measurement; left out of pictures where it lies apart", padding,
                  limit ? " to " : "", limit ? limit : "", value);
}

void vvi_about_missing(const vvi_about *about)
{
    const char *missing = find_metadata(about->file, "missing values");
    const char *padding = find_metadata(about->file, "PixelPaddingValue");
    if (missing)
        vvi_tell_line(about->answer, "missing", "%s", missing);
    if (padding)
        tell_padding(about, padding);
}

vv_status vvi_about_range(const vvi_about *about)
{
    vv_answer *a = about->answer;
    const vv_field *field = about->options.field;
    const vv_field_info *info = vv_field_get_info(field);
    const bool labels = info->meaning == VV_MEANING_LABEL;
    vv_statistics *s = malloc(sizeof *s);
    vv_status st = s ? VV_OK : vv_fail_memory(sizeof *s);
    for (int c = 0; c < info->components && c < RANGES_MOST && st == VV_OK; c++) {
        char lo[32], hi[32], mean[48] = "", missing[64] = "";
        if ((st = vv_field_statistics(s, field, c, about->job)) != VV_OK)
            break;
        const uint64_t strange = s->nan_count + s->infinite_count;
        if (strange)
            snprintf(missing, sizeof missing, "; %" PRIu64 " samples are not finite", strange);
        vvi_value_print(lo, s->min, s->min, s->max);
        vvi_value_print(hi, s->max, s->min, s->max);
        if (!labels)
            snprintf(mean, sizeof mean, ", mean %.6g", s->mean);
        if (s->count)
            vvi_tell_line(a, c ? "" : "range", "%s to %s%s%s%s%s", lo, hi, info->value_unit[0] ? " " : "",
                          info->value_unit, mean, missing);
        else
            vvi_tell_line(a, c ? "" : "range", "none: no sample is a finite number");
    }
    free(s);
    return st;
}

vv_status vvi_about_statistics(const vvi_about *about)
{
    const vv_field *field = about->options.field;
    uint32_t checksum = 0;
    char text[32];
    vv_status st = vv_field_checksum(&checksum, field, about->job);
    vv_statistics *s = st == VV_OK ? malloc(sizeof *s) : NULL;
    if (!s)
        return st == VV_OK ? vv_fail_memory(sizeof *s) : st;
    snprintf(text, sizeof text, "crc32:%08" PRIx32, checksum);
    vvi_tell_text(about->answer, "checksum", text);
    st = each_component(about, s);
    free(s);
    if (st == VV_OK && vv_field_get_info(field)->meaning == VV_MEANING_LABEL)
        st = vvi_about_label_counts(about);
    else if (st == VV_OK)
        vvi_about_labels(about);
    return st;
}
