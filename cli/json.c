#include "json.h"
#include "core/units.h"
#include <inttypes.h>
#include <math.h>

static void new_line(cli_json *json)
{
    vvi_text_add(&json->text, "\n");
    for (int i = 0; i < json->depth; i++)
        vvi_text_add(&json->text, "  ");
}

static void lead(cli_json *json, const char *key)
{
    if (json->filled)
        vvi_text_add(&json->text, ",");
    if (json->depth > 0)
        new_line(json);
    if (key) {
        vvi_text_json(&json->text, key);
        vvi_text_add(&json->text, ": ");
    }
    json->filled = true;
}

static void add_number(vvi_text *text, double value)
{
    char digits[32];
    if (!isfinite(value)) {
        vvi_text_add(text, "null");
        return;
    }
    vvi_print_unsigned_zero(digits, value);
    vvi_text_add(text, digits);
}

void cli_json_open(cli_json *json, const char *key, char bracket)
{
    lead(json, key);
    vvi_text_add_n(&json->text, &bracket, 1);
    json->depth++;
    json->filled = false;
}

void cli_json_close(cli_json *json, char bracket)
{
    json->depth--;
    if (json->filled)
        new_line(json);
    vvi_text_add_n(&json->text, &bracket, 1);
    json->filled = true;
}

void cli_json_string(cli_json *json, const char *key, const char *value)
{
    lead(json, key);
    if (value)
        vvi_text_json(&json->text, value);
    else
        vvi_text_add(&json->text, "null");
}

void cli_json_number(cli_json *json, const char *key, double value)
{
    lead(json, key);
    add_number(&json->text, value);
}

void cli_json_integer(cli_json *json, const char *key, int64_t value)
{
    lead(json, key);
    vvi_text_printf(&json->text, "%" PRId64, value);
}

void cli_json_unsigned(cli_json *json, const char *key, uint64_t value)
{
    lead(json, key);
    vvi_text_printf(&json->text, "%" PRIu64, value);
}

void cli_json_bool(cli_json *json, const char *key, bool value)
{
    lead(json, key);
    vvi_text_add(&json->text, value ? "true" : "false");
}

void cli_json_numbers(cli_json *json, const char *key, const double *values, size_t n)
{
    lead(json, key);
    vvi_text_add(&json->text, "[");
    for (size_t i = 0; i < n; i++) {
        vvi_text_add(&json->text, i ? ", " : "");
        add_number(&json->text, values[i]);
    }
    vvi_text_add(&json->text, "]");
}

void cli_json_strings(cli_json *json, const char *key, const char *const *values)
{
    lead(json, key);
    vvi_text_add(&json->text, "[");
    for (size_t i = 0; values && values[i]; i++) {
        vvi_text_add(&json->text, i ? ", " : "");
        vvi_text_json(&json->text, values[i]);
    }
    vvi_text_add(&json->text, "]");
}

void cli_json_raw(cli_json *json, const char *key, const char *value)
{
    lead(json, key);
    vvi_text_add(&json->text, value);
}
