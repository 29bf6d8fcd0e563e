#include "render/decorate/round_numbers.h"
#include "core/units.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MINUS "\xe2\x88\x92" /* U+2212 */
#define SLACK 1e-9           /* of a step: what rounding does to places that are ticks */

double vvi_nice_below(double x)
{
    static const double factors[] = {5, 2, 1};
    if (!(x > 0) || !isfinite(x))
        return 0;
    const double power = pow(10, floor(log10(x)));
    for (size_t i = 0; i < sizeof factors / sizeof *factors; i++)
        if (factors[i] * power <= x * (1 + SLACK))
            return factors[i] * power;
    return power / 2; /* log10 was rounded up */
}

double vvi_nice_above(double x)
{
    const double below = vvi_nice_below(x);
    if (!(below > 0) || below >= x * (1 - SLACK))
        return below;
    const double leading = below / pow(10, floor(log10(below * (1 + SLACK))));
    return leading > 4 ? below * 2 : leading > 1.5 ? below * 2.5 : below * 2; /* 5 to 10, 2 to 5, 1 to 2 */
}

vvi_ticks vvi_nice_ticks(double lo, double hi, int most)
{
    vvi_ticks t = {0};
    if (!(hi > lo) || most < 1 || !isfinite(hi - lo))
        return t;
    t.step = vvi_nice_above((hi - lo) / most);
    if (!(t.step > 0) || t.step < 1e-12 * fmax(fabs(lo), fabs(hi))) /* doubles do not tell them apart */
        return (vvi_ticks){0};
    const double from = ceil(lo / t.step - SLACK), to = floor(hi / t.step + SLACK);
    t.first = from * t.step;
    t.n = to >= from ? (int)(to - from) + 1 : 0;
    return t;
}

double vvi_tick_at(const vvi_ticks *t, int i)
{
    return (rint(t->first / t->step) + i) * t->step;
}

/* The C library's minus becomes a true one. */
static void print_signs(char *out, size_t room, const char *number)
{
    size_t n = 0;
    out[0] = 0;
    for (; *number && n + 4 < room; number++) {
        const char *piece = *number == '-' ? MINUS : (char[]){*number, 0};
        n += (size_t)snprintf(out + n, room - n, "%s", piece);
    }
}

/* A multiple of the step without the last bits of the multiplication: 6e37 and not 5.9999999999999995e37. */
static double rounded(double value, double step)
{
    const double digits = step > 0 ? floor(log10(fabs(value))) - floor(log10(step)) + 1 : 0;
    char text[48];
    snprintf(text, sizeof text, "%.*e", (int)fmin(fmax(digits, 15), 17) - 1, value);
    return strtod(text, NULL);
}

void vvi_print_tick(char out[40], double value, double step)
{
    char number[48];
    if (!isfinite(value)) {
        snprintf(out, 40, "%s", isnan(value) ? "none" : value < 0 ? MINUS "\xe2\x88\x9e" : "\xe2\x88\x9e");
        return;
    }
    const int decimals = step > 0 && isfinite(step) ? (int)-floor(log10(step * (1 + SLACK))) : 0,
              d = decimals > 0 ? decimals : 0;
    const double units = rint(value * pow(10, d));
    if (d > 5 || fabs(value) >= 1e7) {
        vvi_print_unsigned_zero(number, units == 0 ? 0 : rounded(units / pow(10, d), step));
    } else if (d) { /* without the locale's comma */
        const long long whole = (long long)fabs(units), power = (long long)pow(10, d);
        snprintf(number, sizeof number, "%s%lld.%0*lld", units < 0 ? "-" : "", whole / power, d, whole % power);
    } else {
        snprintf(number, sizeof number, "%lld", (long long)units);
    }
    print_signs(out, 40, number);
}

/* As many digits as `step` asks for, without zeros behind the last that counts. */
static void print_trimmed(char out[40], double value, double step)
{
    vvi_print_tick(out, value, step);
    const char *point = strchr(out, '.'), *power = strchr(out, 'e');
    for (size_t n = strlen(out); point && !power && out[n - 1] != 0; n--) {
        const char last = out[n - 1];
        if (last != '0' && last != '.')
            break;
        out[n - 1] = 0;
        if (last == '.')
            break;
    }
}

void vvi_print_value(char out[40], double value)
{
    print_trimmed(out, value, fmax(vvi_nice_below(fabs(value)) * 1e-3, 1e-5 * fabs(value)));
}

const char *vvi_unit_sign(const char *unit)
{
    return strcmp(unit, "um") == 0 ? "\xc2\xb5m" : strcmp(unit, "angstrom") == 0 ? "\xc3\x85" : unit;
}

/* The unit in which a length is at least 1 and less than 1000; false where the unit is none of the real world. */
static bool choose_unit(double *length, const char **unit)
{
    static const struct {
        const char *name;
        double metres;
    } units[] = {{"km", 1e3}, {"m", 1}, {"mm", 1e-3}, {"um", 1e-6}, {"nm", 1e-9}};
    const double metres = vvi_length_unit_metres(*unit) * *length;
    if (!(metres > 0))
        return false;
    size_t i = 0;
    while (i + 1 < sizeof units / sizeof *units && metres < units[i].metres * (1 - SLACK))
        i++;
    *unit = units[i].name;
    *length = metres / units[i].metres;
    return true;
}

void vvi_print_length(char out[64], double length, const char *unit)
{
    char number[40];
    const double metres = vvi_length_unit_metres(unit);
    if (metres > 0 && (length < 1 * (1 - SLACK) || length >= 1000 * (1 - SLACK)))
        choose_unit(&length, &unit);
    print_trimmed(number, length, vvi_nice_below(length) * 1e-2);
    const char *sign = vvi_unit_sign(unit);
    const size_t n = strlen(sign), plural = strcmp(number, "1") == 0 && n > 3 && sign[n - 1] == 's';
    snprintf(out, 64, "%s %.*s", number, (int)(n - plural), sign); /* 1 voxel, 2 voxels */
}
