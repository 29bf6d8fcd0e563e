/* Figures with their units and errors: lines, JSON keys, rows of a table. */
#include "core/units.h"
#include "measure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define ROUNDING 1e-12

void cli_power_unit(char out[32], const char *unit, int power)
{
    snprintf(out, 32, power == 1 ? "%s" : "%s^%d", unit, power);
}

static double round_to(double v, double unit)
{
    return unit > 1 ? round(v / unit) * unit : v;
}

void cli_figure_digits(char out[48], char error_out[48], double value, double error)
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

void cli_figure_print(char out[CLI_FIGURE_TEXT], const cli_figure *f)
{
    char unit[40] = "";
    if (*f->unit)
        snprintf(unit, sizeof unit, " %s", f->unit);
    if (isnan(f->value)) {
        snprintf(out, CLI_FIGURE_TEXT, "none");
    } else if (isnan(f->error) && f->chance > 0) {
        char value[48], chance[48];
        cli_figure_digits(value, chance, f->value, f->chance);
        snprintf(out, CLI_FIGURE_TEXT, "%s%s", value, unit);
    } else if (!(f->error > 0) || !isfinite(f->error)) {
        const bool whole = f->value == floor(f->value) && fabs(f->value) < 1e15;
        snprintf(out, CLI_FIGURE_TEXT, whole ? "%.0f%s%s" : "%.6g%s%s", f->value, f->error == 0 ? " \xc2\xb1 0" : "",
                 unit);
    } else {
        char value[48], error[48];
        cli_figure_digits(value, error, f->value, f->error);
        snprintf(out, CLI_FIGURE_TEXT, "%s \xc2\xb1 %s%s", value, error, unit);
    }
}

void cli_place_print(char out[CLI_FIGURE_TEXT], const double v[3], const double error[3])
{
    char text[3][48], digits[48];
    for (int a = 0; a < 3; a++)
        cli_figure_digits(text[a], digits, v[a], error ? error[a] : NAN);
    snprintf(out, CLI_FIGURE_TEXT, "%s, %s, %s", text[0], text[1], text[2]);
}

void cli_figure_row(vvi_text *out, const cli_figure *f)
{
    char number[32] = "";
    vvi_text_printf(out, "%s,", f->key);
    if (isfinite(f->value))
        vvi_print_number(number, f->value);
    vvi_text_printf(out, "%s,", number);
    *number = 0;
    if (isfinite(f->error))
        vvi_print_number(number, f->error);
    vvi_text_printf(out, "%s,%s\n", number, f->unit);
}

void cli_figure_add_number(vvi_text *out, const char *name, double value)
{
    char number[32];
    if (!isfinite(value))
        return;
    vvi_print_number(number, value);
    vvi_text_printf(out, ", \"%s\": %s", name, number);
}

void cli_figure_keep(cli_result *result, const cli_figure *f)
{
    vvi_text *out = &result->figures;
    vvi_text_printf(out, "%s{\"name\": ", out->n ? ", " : "");
    vvi_text_json(out, f->key);
    cli_figure_add_number(out, "value", f->value);
    cli_figure_add_number(out, "error", f->error);
    if (*f->unit) {
        vvi_text_add(out, ", \"unit\": ");
        vvi_text_json(out, f->unit);
    }
    vvi_text_add(out, "}");
}

/* "box_area" of the part "box". */
static void name_figure(char out[192], const cli_result *result, const char *key, const char *end)
{
    snprintf(out, 192, "%s%s%s%s", result->part ? result->part : "", result->part ? "_" : "", key, end);
}

void cli_vector_put(cli_result *result, const char *key, const double v[3], const double error[3], const char *unit)
{
    vvi_result_numbers(&result->command->json, key, v, 3);
    for (int a = 0; a < 3; a++) {
        char name[192];
        cli_figure f = {.key = name, .value = v[a], .error = error ? error[a] : NAN};
        name_figure(name, result, key, (const char *const[]){"_x", "_y", "_z"}[a]);
        snprintf(f.unit, sizeof f.unit, "%s", unit);
        cli_figure_keep(result, &f);
        if (result->csv)
            cli_figure_row(&result->command->text, &f);
    }
}

void cli_result_free(cli_result *result)
{
    vvi_text_free(&result->figures);
    vvi_text_free(&result->planes);
}

void cli_figure_put(cli_result *result, const cli_figure *f)
{
    cli_command *command = result->command;
    char text[CLI_FIGURE_TEXT], key[64], name[192];
    cli_figure named = *f;
    named.key = name;
    name_figure(name, result, f->key, "");
    cli_figure_keep(result, &named);
    vvi_result_number(&command->json, f->key, f->value);
    if (!isnan(f->error)) {
        snprintf(key, sizeof key, "%s_error", f->key);
        vvi_result_number(&command->json, key, f->error);
    }
    if (*f->unit) {
        snprintf(key, sizeof key, "%s_unit", f->key);
        vvi_result_string(&command->json, key, f->unit);
    }
    if (result->csv) {
        cli_figure_row(&command->text, &named);
        return;
    }
    cli_figure_print(text, f);
    cli_command_line(command, f->label, "%s", text);
}
