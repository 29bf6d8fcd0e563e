/* Figures with their units and errors: lines, JSON keys, rows of a table. */
#include "core/units.h"
#include "measure.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

void cli_power_unit(char out[32], const char *unit, int power)
{
    snprintf(out, 32, power == 1 ? "%s" : "%s^%d", unit, power);
}

void cli_figure_print(char out[96], const cli_figure *f)
{
    char unit[40] = "";
    if (*f->unit)
        snprintf(unit, sizeof unit, " %s", f->unit);
    if (isnan(f->value)) {
        snprintf(out, 96, "none");
    } else if (!(f->error > 0) || !isfinite(f->error)) {
        const bool whole = f->value == floor(f->value) && fabs(f->value) < 1e15;
        snprintf(out, 96, whole ? "%.0f%s" : "%.7g%s", f->value, unit);
    } else {
        const int decimals = (int)fmin(fmax(1 - floor(log10(f->error)), 0), 12);
        if (fabs(f->value) < 1e12)
            snprintf(out, 96, "%.*f \xc2\xb1 %.*f%s", decimals, f->value, decimals, f->error, unit);
        else
            snprintf(out, 96, "%.9g \xc2\xb1 %.2g%s", f->value, f->error, unit);
    }
}

static void put_csv(vvi_text *out, const cli_figure *f)
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

void cli_figure_put(cli_command *command, const cli_figure *f, bool csv)
{
    char text[96], key[64];
    cli_json_number(&command->json, f->key, f->value);
    if (!isnan(f->error)) {
        snprintf(key, sizeof key, "%s_error", f->key);
        cli_json_number(&command->json, key, f->error);
    }
    if (*f->unit) {
        snprintf(key, sizeof key, "%s_unit", f->key);
        cli_json_string(&command->json, key, f->unit);
    }
    if (csv) {
        put_csv(&command->text, f);
        return;
    }
    cli_figure_print(text, f);
    cli_command_line(command, f->label, "%s", text);
}
