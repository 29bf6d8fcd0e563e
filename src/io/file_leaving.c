#include "io/file_leaving.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/fill_value.h"
#include <stdio.h>
#include <string.h>

/* "-9999, 1e+20" */
static void print_values(char out[256], const double *values, size_t n)
{
    size_t at = 0;
    out[0] = 0;
    for (size_t i = 0; i < n && at < 256; i++)
        at += (size_t)snprintf(out + at, 256 - at, "%s%.9g", i ? ", " : "", values[i]);
}

vv_status vvi_leaving_new(vvi_leaving **out, const vv_field_info *info, const double *values, size_t n,
                          const char *name, vv_notes *notes)
{
    const bool labels = info->meaning == VV_MEANING_LABEL;
    char text[256], note[384];
    *out = NULL;
    if (labels || info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA)
        return vv_fail_at(VV_E_ARGUMENT, name, NULL, "its samples are %s: none of them stands for no value",
                          labels ? "labels, each of which is a name" : "colours");
    vvi_leaving *l = *out = vvi_calloc(1, sizeof *l + n * sizeof *values);
    if (!l)
        return vv_fail_memory(n * sizeof *values);
    l->rest = *info;
    l->rest.type = vvi_type_without(info->type);
    l->n = n;
    memcpy(l->value, values, n * sizeof *values);
    print_values(text, values, n);
    snprintf(note, sizeof note, "%s, as was said, read as NaN", text);
    return vvi_notes_add(notes, "missing values", note);
}

static bool find_number(double *out, const vv_notes *notes, const char *name)
{
    const char *key, *value;
    for (size_t i = 0; vvi_notes_get(notes, i, &key, &value); i++)
        if (strcmp(key, name) == 0)
            return vvi_parse_number(out, value);
    return false;
}

bool vvi_notes_padding(double out[2], const vv_notes *notes)
{
    if (!find_number(&out[0], notes, "PixelPaddingValue"))
        return false;
    if (!find_number(&out[1], notes, "PixelPaddingRangeLimit"))
        out[1] = out[0];
    return true;
}
