#include "value.h"
#include "core/status.h"
#include "core/units.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

bool cli_value_split_range(char lo[64], char hi[64], const char *typed)
{
    const char *dots = strstr(typed, ".."), *comma = strchr(typed, ','), *colon = strchr(typed, ':');
    const char *mark = dots ? dots : comma ? comma : colon;
    const char *rest = !mark ? "" : mark + (mark == dots ? 2 : 1);
    const size_t n = mark ? (size_t)(mark - typed) : strlen(typed);
    if (n >= 64 || strlen(rest) >= 64 || (n == 0 && !*rest) || strpbrk(rest, ",:") || strstr(rest, ".."))
        return false;
    snprintf(lo, 64, "%.*s", (int)n, typed);
    snprintf(hi, 64, "%s", rest);
    return true;
}

/* Two numbers as a range, "10..60". */
static bool scan_range(double out[2], const char *typed)
{
    char lo[64], hi[64];
    return strstr(typed, "..") && cli_value_split_range(lo, hi, typed) && vvi_parse_number(&out[0], lo) &&
           vvi_parse_number(&out[1], hi) && isfinite(out[0]) && isfinite(out[1]);
}

vv_status cli_value_numbers(double *out, size_t n, const char *typed, bool by_x)
{
    const char *at = typed;
    if (n == 2 && !by_x && scan_range(out, typed))
        return VV_OK;
    for (size_t i = 0; i < n; i++) {
        if (!vvi_scan_number(&out[i], at, &at) || !isfinite(out[i]))
            return vv_fail(VV_E_ARGUMENT, "expected %zu numbers with %s between them, found '%s'", n,
                           by_x ? "an x or a comma" : "a comma", typed);
        const bool parted = *at == ',' || (by_x && (*at == 'x' || *at == 'X'));
        if (i + 1 < n ? !parted : *at != 0)
            return vv_fail(VV_E_ARGUMENT, "expected %zu numbers with %s between them, found '%s'", n,
                           by_x ? "an x or a comma" : "a comma", typed);
        at += parted;
    }
    return VV_OK;
}

void cli_value_vector(vvi_text *out, const char *typed)
{
    vvi_text_add(out, "[");
    for (bool first = true; first || *typed == ','; first = false) {
        char part[64];
        double number;
        typed += *typed == ',' && !first;
        const size_t n = strcspn(typed, ",");
        snprintf(part, sizeof part, "%.*s", (int)n, typed);
        vvi_text_add(out, first ? "" : ", ");
        if (vvi_parse_number(&number, part))
            vvi_text_add(out, part);
        else
            vvi_text_json(out, part);
        typed += n;
    }
    vvi_text_add(out, "]");
}

vv_status cli_value_point(vvi_text *out, const char *option, const char *typed)
{
    size_t n = 1;
    for (const char *at = typed; *at; at++)
        n += *at == ',';
    if (n != 3)
        return vv_fail(VV_E_ARGUMENT, "--%s: expected three numbers X,Y,Z, found '%s'", option, typed);
    cli_value_vector(out, typed);
    return out->bad ? vv_fail_memory(out->n) : VV_OK;
}

static int by_number(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

double cli_value_median(double *v, size_t n)
{
    qsort(v, n, sizeof *v, by_number);
    return n % 2 ? v[n / 2] : (v[n / 2 - 1] + v[n / 2]) / 2;
}

void cli_value_duration(char out[32], double seconds)
{
    if (seconds < 0.995)
        snprintf(out, 32, "%.2f s", seconds);
    else if (seconds < 9.95)
        snprintf(out, 32, "%.1f s", seconds);
    else if (seconds < 119.5)
        snprintf(out, 32, "%.0f s", seconds);
    else if (seconds < 119.5 * 60)
        snprintf(out, 32, "%.0f min", seconds / 60);
    else if (seconds < 47.5 * 3600)
        snprintf(out, 32, "%.1f h", seconds / 3600);
    else
        snprintf(out, 32, "%.0f days", fmin(seconds / 86400, 1e9));
}
