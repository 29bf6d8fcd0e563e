/* Digits of figures: as many as their errors allow. */
#include "measuring/answer.h"
#include <math.h>
#include <stdio.h>

#define ROUNDING 1e-12

void vvi_power_unit(char out[32], const char *unit, int power)
{
    snprintf(out, 32, power == 1 ? "%s" : "%s^%d", unit, power);
}

static double round_to(double v, double unit)
{
    return unit > 1 ? round(v / unit) * unit : v;
}

void vvi_figure_digits(char out[48], char error_out[48], double value, double error)
{
    if (error > 0 && error < ROUNDING * fabs(value)) { /* that of doubles is no more than noise */
        snprintf(out, 48, "%.9g", value);
        snprintf(error_out, 48, "%.2g", error);
        return;
    }
    if (!(error > 0) || !isfinite(error) || !isfinite(value)) {
        snprintf(out, 48, "%.6g", value);
        snprintf(error_out, 48, "%.2g", error);
        return;
    }
    const int last = 1 - (int)floor(log10(error)), size = value != 0 ? (int)floor(log10(fabs(value))) : -last;
    const bool small = fmax(fabs(value), error) < 1e-4 || last > 12;
    const double unit_of_last = last < 0 ? pow(10, -last) : 1; /* 1518662 with 52385: 1519000 with 52000 */
    value = round_to(value, unit_of_last);
    error = round_to(error, unit_of_last);
    if (!small && fabs(value) < 1e12) {
        snprintf(out, 48, "%.*f", last > 0 ? last : 0, value);
        snprintf(error_out, 48, "%.*f", last > 0 ? last : 0, error);
    } else {
        snprintf(out, 48, "%.*g", (int)fmin(fmax(size + last + 1, 2), 17), value);
        snprintf(error_out, 48, "%.2g", error);
    }
}

void vvi_figure_print(char out[VVI_FIGURE_TEXT], double value, double error, double chance, const char *unit_name)
{
    char unit[40] = "";
    if (*unit_name)
        snprintf(unit, sizeof unit, " %s", unit_name);
    if (isnan(value)) {
        snprintf(out, VVI_FIGURE_TEXT, "none");
    } else if (isnan(error) && chance > 0) {
        char digits[48], rest[48];
        vvi_figure_digits(digits, rest, value, chance);
        snprintf(out, VVI_FIGURE_TEXT, "%s%s", digits, unit);
    } else if (!(error > 0) || !isfinite(error)) {
        const bool whole = value == floor(value) && fabs(value) < 1e15;
        snprintf(out, VVI_FIGURE_TEXT, whole ? "%.0f%s%s" : "%.6g%s%s", value, error == 0 ? " \xc2\xb1 0" : "", unit);
    } else {
        char digits[48], off[48];
        vvi_figure_digits(digits, off, value, error);
        snprintf(out, VVI_FIGURE_TEXT, "%s \xc2\xb1 %s%s", digits, off, unit);
    }
}

void vvi_place_print(char out[VVI_FIGURE_TEXT], const double v[3], const double error[3])
{
    char text[3][48], digits[48];
    for (int a = 0; a < 3; a++)
        vvi_figure_digits(text[a], digits, v[a], error ? error[a] : NAN);
    snprintf(out, VVI_FIGURE_TEXT, "%s, %s, %s", text[0], text[1], text[2]);
}
