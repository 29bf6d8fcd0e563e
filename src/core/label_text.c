#include "core/label_text.h"
#include "core/units.h"
#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int vvi_label_compare(vv_label_id a, vv_label_id b, bool is_unsigned)
{
    const uint64_t x = (uint64_t)a, y = (uint64_t)b;
    return is_unsigned ? (x > y) - (x < y) : (a > b) - (a < b);
}

double vvi_label_value(vv_label_id id, bool is_unsigned)
{
    return is_unsigned ? (double)(uint64_t)id : (double)id;
}

const char *vvi_label_print(char out[VVI_LABEL_DIGITS], vv_label_id id, bool is_unsigned)
{
    if (is_unsigned)
        snprintf(out, VVI_LABEL_DIGITS, "%" PRIu64, (uint64_t)id);
    else
        snprintf(out, VVI_LABEL_DIGITS, "%" PRId64, id);
    return out;
}

bool vvi_label_parse(vv_label_id *out, const char *typed, bool is_unsigned)
{
    const char *digits = typed + (*typed == '-' || *typed == '+');
    double v;
    if (*digits && digits[strspn(digits, "0123456789")] == 0) {
        const bool minus = *typed == '-';
        errno = 0;
        const uint64_t size = strtoull(digits, NULL, 10), most = (uint64_t)INT64_MAX + minus;
        *out = (vv_label_id)(minus ? 0 - size : size);
        return errno == 0 && (size <= most || (is_unsigned && !minus));
    }
    if (!vvi_parse_number(&v, typed) || v != floor(v) || !(fabs(v) < 0x1p53))
        return false;
    *out = (vv_label_id)v;
    return true;
}
