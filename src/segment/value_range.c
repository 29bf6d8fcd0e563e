#include "segment/value_range.h"
#include "core/units.h"
#include "filter/sample_keys.h"
#include "grid/field.h"
#include "grid/true_values.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define PART 1024 /* samples that are compared at a time */

static vv_status fail_text(const char *place, const char *text)
{
    return vv_fail(VV_E_ARGUMENT, "%s: '%s' is not a range; write LO..HI, such as 100..200, or 100.. for all from 100",
                   place, text);
}

vv_status vvi_value_range_parse(vvi_value_range *out, const char *text, const char *place)
{
    char lo[64] = "", hi[64] = "";
    const char *dots = strstr(text, ".."), *rest = dots ? dots + 2 : text;
    *out = (vvi_value_range){-INFINITY, INFINITY};
    if (!*text || strlen(text) >= sizeof lo || (dots && dots == text && !*rest))
        return fail_text(place, text);
    snprintf(lo, sizeof lo, "%.*s", (int)(dots ? (size_t)(dots - text) : strlen(text)), text);
    snprintf(hi, sizeof hi, "%s", rest);
    if ((*lo && !vvi_parse_number(&out->lo, lo)) || (*hi && !vvi_parse_number(&out->hi, hi)) || isnan(out->lo) ||
        isnan(out->hi))
        return fail_text(place, text);
    if (out->lo > out->hi)
        return vv_fail(VV_E_ARGUMENT, "%s: '%s' has its larger end first; nothing is between them", place, text);
    return VV_OK;
}

vvi_value_range vvi_value_range_as_typed(const vvi_value_range *range, const vv_field_info *info)
{
    const double step = fabs(info->value_scale);
    if (vv_type_is_float(info->type) || !vvi_has_scale(info))
        return *range;
    vvi_value_range out = *range;
    if (isfinite(out.lo))
        out.lo -= 1e-9 * fmax(step, fabs(out.lo - info->value_offset));
    if (isfinite(out.hi))
        out.hi += 1e-9 * fmax(step, fabs(out.hi - info->value_offset));
    return out;
}

static double value_of_key(int64_t key, const vv_field_info *info)
{
    char sample[8];
    double v;
    vvi_sample_of_key(sample, key, info->type);
    vvi_samples_to_f64(&v, sample, info->type, 1);
    return v * info->value_scale + info->value_offset;
}

static vvi_key_range all_keys(vv_type type)
{
    vvi_key_range all;
    const size_t bytes = vv_type_bytes(type);
    if (vvi_keys_bounds(&all.lo, &all.hi, type))
        return all;
    if (bytes == 1)
        return (vvi_key_range){0, UINT8_MAX};
    all.hi = bytes == 8 ? INT64_MAX : ((int64_t)1 << (8 * bytes - 1)) - 1;
    return (vvi_key_range){-all.hi - 1, all.hi};
}

/* The first key whose value has reached `limit`, on the way that values go with rising keys; one beyond the last: none.
 * `past`: has gone beyond it. */
static bool first_key(int64_t *out, double limit, bool past, const vv_field_info *info)
{
    const vvi_key_range all = all_keys(info->type);
    const double sign = info->value_scale < 0 ? -1 : 1;
    int64_t lo = all.lo, hi = all.hi;
#define REACHED(key)                                                                                                   \
    (past ? sign * value_of_key(key, info) > sign * limit : sign * value_of_key(key, info) >= sign * limit)
    if (!REACHED(hi))
        return false;
    while (lo < hi) {
        const int64_t middle = (int64_t)(((uint64_t)hi - (uint64_t)lo) / 2 + (uint64_t)lo);
        if (REACHED(middle))
            hi = middle;
        else
            lo = middle + 1;
    }
#undef REACHED
    *out = lo;
    return true;
}

vvi_key_range vvi_key_range_of(const vvi_value_range *range, const vv_field_info *info)
{
    const vvi_key_range none = {1, 0};
    const bool falls = info->value_scale < 0;
    vvi_key_range out = all_keys(info->type);
    int64_t beyond;
    if (!first_key(&out.lo, falls ? range->hi : range->lo, false, info))
        return none;
    if (first_key(&beyond, falls ? range->lo : range->hi, true, info)) {
        if (beyond == all_keys(info->type).lo)
            return none;
        out.hi = beyond - 1;
    }
    return out;
}

#define COMPARE(ctype)                                                                                                 \
    do {                                                                                                               \
        const ctype lo = (ctype)range->lo, hi = (ctype)range->hi, *k = (const ctype *)(const void *)keys;              \
        for (int64_t i = 0; i < n; i++)                                                                                \
            inside[i] = (uint8_t)((k[i] >= lo) & (k[i] <= hi));                                                        \
    } while (0)

static void compare(uint8_t *restrict inside, const char *restrict keys, size_t bytes, const vvi_key_range *range,
                    int64_t n)
{
    if (bytes == 1)
        COMPARE(uint8_t);
    else if (bytes == 2)
        COMPARE(int16_t);
    else if (bytes == 4)
        COMPARE(int32_t);
    else
        COMPARE(int64_t);
}

void vvi_key_range_row(uint8_t *inside, const void *samples, int64_t step, vv_type type, const vvi_key_range *range,
                       int64_t n)
{
    _Alignas(64) char keys[PART * 8];
    if (range->lo > range->hi) {
        memset(inside, 0, (size_t)n);
        return;
    }
    for (int64_t at = 0; at < n; at += PART) {
        const int64_t now = n - at < PART ? n - at : PART;
        vvi_keys_of_samples(keys, (const char *)samples + at * step, step, type, now);
        compare(inside + at, keys, vv_type_bytes(type), range, now);
    }
}
