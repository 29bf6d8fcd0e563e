/* Values of C as the JSON that vv_path_set() reads: one way in, with all of its checks. */
#include "core/property_impl.h"
#include "core/text.h"
#include "core/units.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

vv_status vv_path_set_number(vv_object **root, const char *path, double value, const vv_property_context *context)
{
    char text[32];
    if (!isfinite(value)) /* JSON has no such numbers, and null would unset */
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "expected a finite number, found %g", value);
    vvi_print_number(text, value);
    return vv_path_set(root, path, text, context);
}

vv_status vv_path_set_integer(vv_object **root, const char *path, int64_t value, const vv_property_context *context)
{
    char text[32];
    snprintf(text, sizeof text, "%" PRId64, value);
    return vv_path_set(root, path, text, context);
}

vv_status vv_path_set_bool(vv_object **root, const char *path, bool value, const vv_property_context *context)
{
    return vv_path_set(root, path, value ? "true" : "false", context);
}

static vv_status set_text(vv_object **root, const char *path, vvi_text *text, const vv_property_context *context)
{
    const vv_status st = text->bad ? vv_fail_memory(text->n) : vv_path_set(root, path, text->s, context);
    vvi_text_free(text);
    return st;
}

vv_status vv_path_set_text(vv_object **root, const char *path, const char *value, const vv_property_context *context)
{
    vvi_text text = {0};
    vvi_text_json(&text, value);
    return set_text(root, path, &text, context);
}

/* How many numbers a row of a table has; 0: it is no table. */
static size_t columns_at(const vv_object *root, const char *path)
{
    vvi_trail trail;
    if (vvi_trail_find(&trail, root, path) != VV_OK || trail.n == 0)
        return 0;
    const vv_property *row = trail.hop[trail.n - 1].property;
    return row && row->kind == VV_KIND_NUMBERS && row->columns > 1 ? (size_t)row->columns : 0;
}

vv_status vv_path_set_numbers(vv_object **root, const char *path, const double *values, size_t n,
                              const vv_property_context *context)
{
    const size_t columns = columns_at(*root, path);
    char number[32];
    vvi_text text = {0};
    if (columns && n % columns)
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "expected rows of %zu numbers, found %zu", columns, n);
    vvi_text_add(&text, "[");
    for (size_t i = 0; i < n; i++) {
        if (!isfinite(values[i])) {
            vvi_text_free(&text);
            return vv_fail_at(VV_E_ARGUMENT, NULL, path, "expected finite numbers, found %g", values[i]);
        }
        vvi_print_number(number, values[i]);
        vvi_text_printf(&text, "%s%s%s", i ? ", " : "", columns && i % columns == 0 ? "[" : "", number);
        if (columns && i % columns == columns - 1)
            vvi_text_add(&text, "]");
    }
    vvi_text_add(&text, "]");
    return set_text(root, path, &text, context);
}
