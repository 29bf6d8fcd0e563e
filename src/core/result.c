#include "core/result.h"
#include "core/label_text.h"
#include "core/units.h"
#include <inttypes.h>
#include <math.h>

static void new_line(vvi_result *json)
{
    if (json->compact)
        return;
    vvi_text_add(&json->text, "\n");
    for (int i = 0; i < json->depth; i++)
        vvi_text_add(&json->text, "  ");
}

static void lead(vvi_result *json, const char *key)
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

void vvi_result_open(vvi_result *json, const char *key, char bracket)
{
    lead(json, key);
    vvi_text_add_n(&json->text, &bracket, 1);
    json->depth++;
    json->filled = false;
}

void vvi_result_close(vvi_result *json, char bracket)
{
    json->depth--;
    if (json->filled)
        new_line(json);
    vvi_text_add_n(&json->text, &bracket, 1);
    json->filled = true;
}

void vvi_result_string(vvi_result *json, const char *key, const char *value)
{
    lead(json, key);
    if (value)
        vvi_text_json(&json->text, value);
    else
        vvi_text_add(&json->text, "null");
}

void vvi_result_number(vvi_result *json, const char *key, double value)
{
    lead(json, key);
    add_number(&json->text, value);
}

void vvi_result_integer(vvi_result *json, const char *key, int64_t value)
{
    lead(json, key);
    vvi_text_printf(&json->text, "%" PRId64, value);
}

void vvi_result_unsigned(vvi_result *json, const char *key, uint64_t value)
{
    lead(json, key);
    vvi_text_printf(&json->text, "%" PRIu64, value);
}

void vvi_result_label(vvi_result *json, const char *key, vv_label_id id, bool is_unsigned)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_result_raw(json, key, vvi_label_print(digits, id, is_unsigned));
}

void vvi_result_bool(vvi_result *json, const char *key, bool value)
{
    lead(json, key);
    vvi_text_add(&json->text, value ? "true" : "false");
}

void vvi_result_numbers(vvi_result *json, const char *key, const double *values, size_t n)
{
    lead(json, key);
    vvi_text_add(&json->text, "[");
    for (size_t i = 0; i < n; i++) {
        vvi_text_add(&json->text, i ? ", " : "");
        add_number(&json->text, values[i]);
    }
    vvi_text_add(&json->text, "]");
}

void vvi_result_strings(vvi_result *json, const char *key, const char *const *values)
{
    lead(json, key);
    vvi_text_add(&json->text, "[");
    for (size_t i = 0; values && values[i]; i++) {
        vvi_text_add(&json->text, i ? ", " : "");
        vvi_text_json(&json->text, values[i]);
    }
    vvi_text_add(&json->text, "]");
}

void vvi_result_raw(vvi_result *json, const char *key, const char *value)
{
    lead(json, key);
    vvi_text_add(&json->text, value);
}
