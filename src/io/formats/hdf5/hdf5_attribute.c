/* Attributes of HDF5 objects as text and as numbers, whatever way they are kept: texts of fixed or of any length,
 * single letters in an array, integers and floats of any size. */
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/formats/hdf5/hdf5.h"
#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TABLE_MOST ((hsize_t)1 << 20)
#define VALUES_MOST 8192
#define BYTES_MOST (64u << 10)

typedef struct attribute {
    hid_t id, type;
    H5T_class_t class;
    size_t n, bytes; /* values, bytes of one */
} attribute;

static void close_attribute(attribute *a)
{
    if (a->type >= 0)
        H5Tclose(a->type);
    if (a->id >= 0)
        H5Aclose(a->id);
}

/* Sizes are looked at before anything is read. */
static bool open_attribute(attribute *a, hid_t object, const char *name)
{
    *a = (attribute){.id = -1, .type = -1};
    if (H5Aexists(object, name) <= 0 || (a->id = H5Aopen(object, name, H5P_DEFAULT)) < 0)
        return false;
    a->type = H5Aget_type(a->id);
    const hid_t space = H5Aget_space(a->id);
    const hssize_t n = space >= 0 ? H5Sget_simple_extent_npoints(space) : -1;
    if (space >= 0)
        H5Sclose(space);
    a->class = a->type >= 0 ? H5Tget_class(a->type) : H5T_NO_CLASS;
    a->bytes = a->type >= 0 ? H5Tget_size(a->type) : 0;
    a->n = n > 0 ? (size_t)n : 0;
    if (n >= 1 && n <= VALUES_MOST && a->bytes >= 1 && a->bytes <= BYTES_MOST && a->n * a->bytes <= BYTES_MOST)
        return true;
    close_attribute(a);
    return false;
}

/* One text after another; letters by themselves make a word. */
static void join(vvi_text *t, const char *s, size_t n, size_t number, bool letters)
{
    if (number > 0 && !letters)
        vvi_text_add(t, ",");
    vvi_text_add_n(t, s, n);
}

static bool text_of_any_length(vvi_text *t, const attribute *a)
{
    char **texts = vvi_calloc(a->n, sizeof *texts);
    const hid_t memory = H5Tcopy(a->type);
    const bool read = texts && H5Aread(a->id, memory, texts) >= 0;
    bool letters = a->n > 1;
    for (size_t i = 0; read && i < a->n; i++)
        letters = letters && texts[i] && strlen(texts[i]) == 1;
    for (size_t i = 0; read && i < a->n; i++)
        join(t, texts[i] ? texts[i] : "", texts[i] ? strnlen(texts[i], BYTES_MOST) : 0, i, letters);
    if (read) {
        const hid_t space = H5Aget_space(a->id);
        H5Dvlen_reclaim(memory, space, H5P_DEFAULT, texts);
        H5Sclose(space);
    }
    H5Tclose(memory);
    free(texts);
    return read;
}

static bool text_of_fixed_length(vvi_text *t, const attribute *a)
{
    char *bytes = vvi_calloc(a->n, a->bytes);
    const bool read = bytes && H5Aread(a->id, a->type, bytes) >= 0;
    for (size_t i = 0; read && i < a->n; i++)
        join(t, bytes + i * a->bytes, strnlen(bytes + i * a->bytes, a->bytes), i, a->bytes == 1);
    free(bytes);
    return read;
}

/* All of the text, yours to free(); NULL when the attribute is no text. */
static char *take_text(const attribute *a)
{
    vvi_text t = {0};
    if (a->class != H5T_STRING)
        return NULL;
    vvi_text_add(&t, "");
    const bool read = H5Tis_variable_str(a->type) > 0 ? text_of_any_length(&t, a) : text_of_fixed_length(&t, a);
    while (t.n > 0 && t.s && isspace((unsigned char)t.s[t.n - 1]))
        t.s[--t.n] = 0;
    if (!read || !t.s) {
        vvi_text_free(&t);
        return NULL;
    }
    return vvi_text_take(&t);
}

bool vvi_h5_text(char *out, size_t room, hid_t object, const char *name)
{
    attribute a;
    out[0] = 0;
    if (!open_attribute(&a, object, name))
        return false;
    char *text = take_text(&a);
    if (text)
        snprintf(out, room, "%s", text);
    free(text);
    close_attribute(&a);
    return out[0] != 0;
}

static int numbers_in_text(double *out, int most, const char *text)
{
    int n = 0;
    while (n < most && *text) {
        const char *end;
        text += strspn(text, " \t,;[]()");
        if (!vvi_scan_number(&out[n], text, &end) || end == text)
            break;
        text = end;
        n++;
    }
    return n;
}

bool vvi_h5_number_is_whole(hid_t type)
{
    size_t sign = 0, exponent = 0, n_exponent = 0, mantissa = 0, n_mantissa = 0;
    const size_t bits = 8 * H5Tget_size(type), precision = H5Tget_precision(type);
    const int offset = H5Tget_offset(type);
    if (precision < 1 || precision > bits || offset < 0 || (size_t)offset > bits - precision)
        return false;
    if (H5Tget_class(type) != H5T_FLOAT)
        return true;
    return H5Tget_fields(type, &sign, &exponent, &n_exponent, &mantissa, &n_mantissa) >= 0 && sign < precision &&
           n_exponent <= precision && exponent <= precision - n_exponent && n_mantissa <= precision &&
           mantissa <= precision - n_mantissa;
}

static int read_numbers(double *out, int most, const attribute *a)
{
    double *all = vvi_calloc(a->n, sizeof *all);
    int n = 0;
    if (all && H5Aread(a->id, H5T_NATIVE_DOUBLE, all) >= 0)
        for (; n < most && (size_t)n < a->n; n++)
            out[n] = all[n];
    free(all);
    return n;
}

int vvi_h5_numbers(double *out, int most, hid_t object, const char *name)
{
    attribute a;
    int n = 0;
    if (!open_attribute(&a, object, name))
        return 0;
    if ((a.class == H5T_INTEGER || a.class == H5T_FLOAT) && vvi_h5_number_is_whole(a.type))
        n = read_numbers(out, most, &a);
    char *text = take_text(&a);
    if (text)
        n = numbers_in_text(out, most, text);
    free(text);
    close_attribute(&a);
    return n;
}

int vvi_h5_label_ids(vv_label_id *out, int most, hid_t object, const char *name)
{
    attribute a;
    int n = 0;
    if (!open_attribute(&a, object, name))
        return 0;
    if (a.class == H5T_INTEGER && a.bytes == 8 && a.n <= (size_t)most &&
        H5Aread(a.id, H5Tget_sign(a.type) == H5T_SGN_2 ? H5T_NATIVE_INT64 : H5T_NATIVE_UINT64, out) >= 0)
        n = (int)a.n;
    close_attribute(&a);
    return n;
}

/* A data set of chunks is unpacked by the library, a chunk at a time. */
static bool is_unpacked_small(hid_t creation)
{
    hsize_t chunk[VVI_H5_RANK], n = 1;
    const int rank = H5Pget_chunk(creation, VVI_H5_RANK, chunk);
    for (int a = 0; a < rank && a < VVI_H5_RANK; a++) {
        if (chunk[a] < 1 || chunk[a] > TABLE_MOST / n)
            return false;
        n *= chunk[a];
    }
    return rank >= 0 && rank <= VVI_H5_RANK;
}

bool vvi_h5_table(double *out, size_t n, hid_t data)
{
    if (H5Iget_type(data) != H5I_DATASET)
        return false;
    const hid_t creation = H5Dget_create_plist(data), type = H5Dget_type(data), space = H5Dget_space(data);
    const H5D_layout_t layout = H5Pget_layout(creation);
    const H5T_class_t class = H5Tget_class(type);
    bool good = vvi_h5_is_inside(creation) && n <= TABLE_MOST && H5Sget_simple_extent_npoints(space) == (hssize_t)n &&
                (class == H5T_INTEGER || class == H5T_FLOAT) && vvi_h5_number_is_whole(type) &&
                (layout != H5D_CHUNKED || is_unpacked_small(creation));
    good = good && H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, out) >= 0;
    if (space >= 0)
        H5Sclose(space);
    if (type >= 0)
        H5Tclose(type);
    if (creation >= 0)
        H5Pclose(creation);
    return good;
}

/* Metadata -------------------------------------------------------------------------------------------------------- */

#define NUMBERS_SHOWN 16

static void print_numbers(vvi_text *t, const double *value, int n)
{
    for (int i = 0; i < n; i++) {
        char number[32];
        vvi_print_number(number, value[i]);
        vvi_text_printf(t, "%s%s", i ? " " : "", number);
    }
}

typedef struct noting {
    vv_notes *notes;
    vv_status st;
} noting;

/* What the library or a convention keeps for itself says nothing to people. */
static bool is_internal(const char *name)
{
    static const char *const names[] = {
        "CLASS",         "NAME",        "DIMENSION_LIST", "REFERENCE_LIST", "_Netcdf4Dimid",    "_Netcdf4Coordinates",
        "_NCProperties", "_nc3_strict", "IMAGE_VERSION",  "directions",     "DIMENSION_LABELS", "channels",
        "channel_names", "labels",      "label_names",    "axes",           "meaning",          "name",
        "origin",        "space",       "unit",           "element_size",   "value_unit",       "scale_factor",
        "add_offset",    "frame_step",  "frame_unit",     VVI_H5_NIFTI};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (strcmp(name, names[i]) == 0)
            return true;
    return false;
}

static herr_t note_attribute(hid_t object, const char *name, const H5A_info_t *info, void *user)
{
    noting *noted = user;
    attribute a;
    vvi_text t = {0};
    (void)info;
    if (is_internal(name) || !open_attribute(&a, object, name))
        return 0;
    char *text = take_text(&a);
    double value[NUMBERS_SHOWN];
    if (text)
        vvi_text_add(&t, text);
    else if ((a.class == H5T_INTEGER || a.class == H5T_FLOAT) && a.n <= NUMBERS_SHOWN && vvi_h5_number_is_whole(a.type))
        print_numbers(&t, value, read_numbers(value, NUMBERS_SHOWN, &a));
    close_attribute(&a);
    if (t.n > 0 && !t.bad)
        noted->st = vvi_notes_add(noted->notes, name, t.s);
    vvi_text_free(&t);
    free(text);
    return noted->st == VV_OK ? 0 : 1;
}

vv_status vvi_h5_note_attributes(vv_notes *notes, hid_t object)
{
    noting noted = {notes, VV_OK};
    hsize_t at = 0;
    /* Looking for one that is not there decodes all: the library's list of them must not fail half way, where 1.10
     * frees what it has not made. */
    if (H5Aexists(object, "volvis: none") != 0)
        return vvi_notes_warn(notes, "has attributes that cannot be read; they are left out");
    H5Aiterate2(object, H5_INDEX_NAME, H5_ITER_NATIVE, &at, note_attribute, &noted);
    return noted.st;
}
