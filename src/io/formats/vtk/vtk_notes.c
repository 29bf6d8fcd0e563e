/* What the field data of VTK's XML files say: times and other few numbers, and what our own writer notes as text. */
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/formats/vtk/vtk_xml.h"
#include "io/number_text.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>
#include <strings.h>

#define NUMBERS_MOST 16
#define LETTERS_MOST 256

static bool is_time(const char *name)
{
    return strcasecmp(name, "TimeValue") == 0 || strcasecmp(name, "TIME") == 0;
}

static vv_status note_numbers(const vvi_vtk_file *file, const vvi_vtk_array *a, uint64_t n, vv_source *source,
                              vv_notes *notes, vv_job *job)
{
    double *v;
    vvi_text t = {0};
    vv_status st = vvi_vtk_numbers(&v, file, a, n, source, job);
    if (st != VV_OK)
        return st == VV_E_FORMAT || st == VV_E_UNSUPPORTED
                   ? vvi_notes_warn(notes, "its field data '%.60s' cannot be read and are left out", a->name)
                   : st;
    for (uint64_t i = 0; i < n; i++) {
        char number[32];
        vvi_print_number(number, v[i]);
        vvi_text_printf(&t, "%s%s", i ? " " : "", isfinite(v[i]) ? number : "nan");
    }
    vvi_free(v);
    st = t.bad ? vv_fail_memory(t.n) : vvi_notes_add(notes, is_time(a->name) ? "time" : a->name, t.s);
    vvi_text_free(&t);
    return st;
}

/* Text is an array of letters that ends with 0. Only as plain text: it is short, and ours. */
static vv_status read_letters(char out[LETTERS_MOST], const vvi_vtk_array *a, vv_source *source, vv_job *job)
{
    vvi_number_text *numbers;
    size_t got = 0;
    out[0] = 0;
    if (a->form != VVI_VTK_TEXT || a->end - a->begin > (uint64_t)LETTERS_MOST * 5)
        return VV_OK;
    vv_status st = vvi_number_text_open(&numbers, source, a->begin, a->end, VV_TYPE_U8, job);
    if (st != VV_OK)
        return st;
    st = vvi_number_text_read(numbers, out, 0, LETTERS_MOST - 1, &got);
    out[st == VV_OK ? got : 0] = 0;
    vvi_number_text_close(numbers);
    vvi_text_clean(out);
    return st == VV_E_FORMAT ? VV_OK : st;
}

static void set_number(double *out, const char *text)
{
    double v;
    if (vvi_parse_number(&v, text) && isfinite(v))
        *out = v;
}

/* True when it is one of the things that our writer notes. */
static bool set_own(vv_field_info *info, const char *name, const char *text)
{
    if (strcmp(name, "volvis unit") == 0)
        vvi_unit_name(info->grid.unit, text, strlen(text));
    else if (strcmp(name, "volvis value unit") == 0)
        vvi_unit_name(info->value_unit, text, strlen(text));
    else if (strcmp(name, "volvis space") == 0)
        info->grid.space = strcmp(text, "RAS") == 0 ? VV_SPACE_RAS : VV_SPACE_PLAIN;
    else if (strcmp(name, "volvis value scale") == 0)
        set_number(&info->value_scale, text);
    else if (strcmp(name, "volvis value offset") == 0)
        set_number(&info->value_offset, text);
    else if (strcmp(name, "volvis meaning") != 0)
        return false;
    else if (strcmp(text, "label") == 0 && !vv_type_is_float(info->type))
        info->meaning = VV_MEANING_LABEL;
    else if (strcmp(text, "vector") == 0)
        info->meaning = VV_MEANING_VECTOR;
    else if (strcmp(text, "rgb") == 0 && info->components == 3)
        info->meaning = VV_MEANING_RGB;
    else if (strcmp(text, "rgba") == 0 && info->components == 4)
        info->meaning = VV_MEANING_RGBA;
    else if (strcmp(text, "scalar") == 0)
        info->meaning = VV_MEANING_SCALAR;
    return true;
}

static vv_status note_text(vv_field_info *info, const vvi_vtk_array *a, vv_source *source, vv_notes *notes, vv_job *job)
{
    char text[LETTERS_MOST];
    vv_status st = read_letters(text, a, source, job);
    if (st == VV_OK && text[0] && !set_own(info, a->name, text))
        st = vvi_notes_add(notes, a->name, text);
    return st;
}

vv_status vvi_vtk_read_notes(vv_field_info *info, const vvi_vtk_file *file, vv_source *source, vv_notes *notes,
                             vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < file->n_arrays && st == VV_OK; i++) {
        const vvi_vtk_array *a = &file->array[i];
        if (a->section != VVI_VTK_FIELD || !a->name[0] || (!a->appended && a->begin == a->end))
            continue;
        const int64_t tuples = a->tuples ? a->tuples : 1;
        if (strcmp(a->type_name, "String") == 0)
            st = note_text(info, a, source, notes, job);
        else if (a->has_type && tuples * a->components <= NUMBERS_MOST && tuples <= NUMBERS_MOST)
            st = note_numbers(file, a, (uint64_t)(tuples * a->components), source, notes, job);
    }
    return st;
}
