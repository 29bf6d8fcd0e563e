/* What a NIfTI header says beyond the samples' info, as names and values: for formats that have a place for such, so
 * that the way to them and back loses nothing. Only what differs from the header that the info alone makes is said. */
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "io/formats/nifti/nifti.h"
#include "io/scan.h"
#include <math.h>
#include <stddef.h>
#include <string.h>

typedef enum kind { WHOLE, REAL, TEXT } kind;

typedef struct word {
    const char *name; /* as the format's own header has it */
    kind kind;
    size_t offset, room; /* room: of a text */
} word;

#define INT(field)                                                                                                     \
    {                                                                                                                  \
#field, WHOLE, offsetof(vvi_nifti, field), 0                                                                   \
    }
#define NUMBER(name, field)                                                                                            \
    {                                                                                                                  \
        name, REAL, offsetof(vvi_nifti, field), 0                                                                      \
    }
#define STRING(name, field)                                                                                            \
    {                                                                                                                  \
        name, TEXT, offsetof(vvi_nifti, field), sizeof(((vvi_nifti *)0)->field)                                        \
    }

static const word words[] = {
    INT(version),
    INT(sform_code),
    INT(qform_code),
    INT(intent_code),
    NUMBER("intent_p1", intent_p[0]),
    NUMBER("intent_p2", intent_p[1]),
    NUMBER("intent_p3", intent_p[2]),
    STRING("descrip", description),
    STRING("aux_file", aux_file),
    NUMBER("cal_min", cal_min),
    NUMBER("cal_max", cal_max),
    INT(xyzt_units),
    INT(dim_info),
    INT(slice_code),
    NUMBER("slice_start", slice_start),
    NUMBER("slice_end", slice_end),
    NUMBER("slice_duration", slice_duration),
    NUMBER("toffset", toffset),
    NUMBER("qfac", pixdim[0]),
    NUMBER("pixdim1", pixdim[1]),
    NUMBER("pixdim2", pixdim[2]),
    NUMBER("pixdim3", pixdim[3]),
    NUMBER("pixdim4", pixdim[4]),
    NUMBER("quatern_b", quatern[0]),
    NUMBER("quatern_c", quatern[1]),
    NUMBER("quatern_d", quatern[2]),
    NUMBER("qoffset_x", qoffset[0]),
    NUMBER("qoffset_y", qoffset[1]),
    NUMBER("qoffset_z", qoffset[2]),
};

enum { N_WORDS = sizeof words / sizeof *words };

static const void *value_of(const vvi_nifti *h, const word *w)
{
    return (const char *)h + w->offset;
}

static bool differs(const vvi_nifti *a, const vvi_nifti *b, const word *w)
{
    const void *p = value_of(a, w), *q = value_of(b, w);
    if (w->kind == TEXT)
        return strcmp(p, q) != 0;
    return memcmp(p, q, w->kind == WHOLE ? sizeof(int) : sizeof(double)) != 0;
}

static void add_value(vvi_text *out, const vvi_nifti *h, const word *w)
{
    char number[32];
    const void *at = value_of(h, w);
    double real;
    int whole;
    if (w->kind == TEXT) {
        vvi_text_add_clean(out, at);
    } else if (w->kind == WHOLE) {
        memcpy(&whole, at, sizeof whole);
        vvi_text_printf(out, "%d", whole);
    } else {
        memcpy(&real, at, sizeof real);
        vvi_print_number(number, real);
        vvi_text_add(out, number);
    }
}

static bool is_said(const vvi_nifti *h, const word *w)
{
    double real;
    if (w->kind != REAL)
        return true;
    memcpy(&real, value_of(h, w), sizeof real);
    return isfinite(real);
}

void vvi_nifti_add_words(vvi_text *out, const char *before, const char *between, const vv_field_info *info,
                         size_t n_frames, const vv_write_options *options)
{
    vvi_nifti full = {0}, plain = {0};
    vv_write_options alone = *options;
    alone.origin = NULL;
    alone.n_channels = 0; /* who reads the words has no channels yet */
    if (!options->origin)
        return;
    vvi_nifti_fill(&full, info, n_frames, options);
    vvi_nifti_fill(&plain, info, n_frames, &alone);
    for (const word *w = words; w < words + N_WORDS; w++)
        if (differs(&full, &plain, w) && is_said(&full, w)) {
            vvi_text_printf(out, "%s%s%s", before, w->name, between);
            add_value(out, &full, w);
            vvi_text_add(out, "\n");
        }
}

static bool take_word(vvi_nifti *h, const char *name, size_t n_name, const char *value)
{
    double real;
    int64_t whole;
    const char *end;
    for (const word *w = words; w < words + N_WORDS; w++) {
        char *at = (char *)h + w->offset;
        if (strlen(w->name) != n_name || memcmp(w->name, name, n_name) != 0)
            continue;
        if (w->kind == TEXT) {
            memset(at, 0, w->room);
            memcpy(at, value, strnlen(value, w->room - 1));
        } else if (w->kind == WHOLE && vvi_scan_int(&whole, value, &end) && whole >= 0 && whole <= INT16_MAX) {
            memcpy(at, &(int){(int)whole}, sizeof(int));
        } else if (w->kind == REAL && vvi_parse_number(&real, value) && isfinite(real)) {
            memcpy(at, &real, sizeof real);
        }
        return true;
    }
    return false;
}

vv_status vvi_nifti_keep_lines(vv_notes *notes, const char *lines, const vv_field_info *info)
{
    vv_write_options options;
    vvi_nifti h = {0};
    bool any = false;
    vv_write_options_init(&options, sizeof options);
    vvi_nifti_fill(&h, info, (size_t)info->n_frames, &options);
    while (*lines) {
        char value[256];
        const size_t n = strcspn(lines, "\n"), n_name = strcspn(lines, "=\n");
        if (n_name < n && n - n_name < sizeof value) {
            memcpy(value, lines + n_name + 1, n - n_name - 1);
            value[n - n_name - 1] = 0;
            any |= take_word(&h, lines, n_name, value);
        }
        lines += n + (lines[n] != 0);
    }
    if (!any)
        return VV_OK;
    uint8_t bytes[VVI_NIFTI2_BYTES];
    h.version = h.version == 2 ? 2 : 1;
    vvi_nifti_pack(bytes, &h);
    return vvi_notes_keep(notes, VVI_NIFTI_KEPT_WORDS, bytes, h.version == 1 ? VVI_NIFTI1_BYTES : VVI_NIFTI2_BYTES);
}

bool vvi_nifti_is_kept_by(const char *format)
{
    static const char *const formats[] = {"nifti", "nrrd", "seg.nrrd", "hdf5"};
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (strcmp(format, formats[i]) == 0)
            return true;
    return false;
}
