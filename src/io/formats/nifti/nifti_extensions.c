/* What follows a NIfTI header: a list of extensions, each with a code that says whose it is. Ours, and the tables of
 * labels of AFNI and of Caret (Connectome Workbench), are read; all are listed in the metadata. */
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "io/formats/nifti/nifti.h"
#include "io/formats/nifti/nifti_labels.h"
#include "io/placement.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

enum { CODE_AFNI = 4, CODE_COMMENT = 6, CODE_CARET = 30, CODE_CIFTI = 32 };
enum { LISTED_MOST = 64 }; /* of extensions, by name */

/* As registered at nifti.nimh.nih.gov. */
static const struct {
    int code;
    const char *name;
} owners[] = {
    {2, "DICOM"},          {CODE_AFNI, "AFNI"},    {CODE_COMMENT, "comment"},
    {8, "XCEDE"},          {10, "JimDimInfo"},     {12, "workflow"},
    {14, "FreeSurfer"},    {16, "pickled Python"}, {18, "MiND"},
    {20, "MiND"},          {22, "MiND"},           {24, "MiND"},
    {26, "MiND"},          {28, "MiND"},           {CODE_CARET, "Caret"},
    {CODE_CIFTI, "CIFTI"}, {34, "frame timing"},   {38, "EVAL"},
    {40, "MATLAB"},        {42, "Quantiphyse"},    {44, "spectroscopy"},
};

static const char *owner_of(int code)
{
    for (size_t i = 0; i < sizeof owners / sizeof *owners; i++)
        if (owners[i].code == code)
            return owners[i].name;
    return "unknown";
}

/* Lengths that came in a unit that NIfTI has not are written in one that it has. */
static void use_unit(vv_grid *grid, const char *unit, int xyzt_units)
{
    const double metres = vvi_length_unit_metres(unit);
    if ((xyzt_units & 7) != 0 && metres > 0)
        vvi_grid_scale(grid, vvi_length_unit_metres(grid->unit) / metres, unit);
    else
        snprintf(grid->unit, sizeof grid->unit, "%.15s", unit);
}

/* Our own: what the header has no place for. */
static vv_status use_line(vv_field_info *info, char *line, int xyzt_units, vv_notes *notes)
{
    char *equals = strchr(line, '=');
    if (!equals)
        return VV_OK;
    *equals = 0;
    const char *value = equals + 1;
    if (strcmp(line, "space") == 0 && strcmp(value, "plain") == 0)
        info->grid.space = VV_SPACE_PLAIN;
    else if (strcmp(line, "unit") == 0 && value[0])
        use_unit(&info->grid, value, xyzt_units);
    else if (strcmp(line, "value_unit") == 0)
        snprintf(info->value_unit, sizeof info->value_unit, "%.15s", value);
    else if (strcmp(line, "frame_unit") == 0)
        snprintf(info->frame_unit, sizeof info->frame_unit, "%.15s", value);
    else if (strcmp(line, "name") == 0)
        snprintf(info->name, sizeof info->name, "%.63s", value);
    return vvi_notes_add(notes, line, value);
}

static bool is_ours(const char *text)
{
    return strncmp(text, VVI_NIFTI_EXTENSION "\n", strlen(VVI_NIFTI_EXTENSION "\n")) == 0;
}

static vv_status use_comment(vv_field_info *info, char *text, int xyzt_units, vv_notes *notes)
{
    const size_t n = strlen(VVI_NIFTI_EXTENSION);
    vv_status st = VV_OK;
    if (!is_ours(text)) {
        vvi_text_clean(text);
        return text[0] ? vvi_notes_add(notes, "comment", text) : VV_OK;
    }
    char *rest = text + n + 1, *line;
    while (st == VV_OK && (line = strsep(&rest, "\n")) != NULL)
        st = use_line(info, line, xyzt_units, notes);
    return st;
}

static vv_status use_extension(vv_field_info *info, int code, char *text, int xyzt_units, vv_notes *notes)
{
    switch (code) {
    case CODE_COMMENT:
        return use_comment(info, text, xyzt_units, notes);
    case CODE_AFNI:
        return vvi_nifti_afni_labels(text, notes);
    case CODE_CARET:
    case CODE_CIFTI:
        return vvi_nifti_caret_labels(text, notes);
    default:
        return VV_OK;
    }
}

/* An extension's body, as text that ends. */
static vv_status read_body(vv_field_info *info, const vvi_nifti *h, int code, size_t n, vv_source *source,
                           vv_notes *notes)
{
    size_t got;
    char *text = vvi_alloc(NULL, n + 1, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory(n + 1);
    vv_status st = vvi_source_read_some(source, text, n, &got);
    if (st == VV_OK) {
        text[got] = 0;
        if (code != CODE_COMMENT || !is_ours(text))
            st = vvi_notes_keep(notes, code, text, got);
        if (st == VV_OK)
            st = use_extension(info, code, text, h->xyzt_units, notes);
    }
    vvi_free(text);
    return st;
}

static vv_status note_extension(vv_notes *notes, int number, int code, int64_t bytes)
{
    char key[32], value[64];
    snprintf(key, sizeof key, "extension %d", number);
    snprintf(value, sizeof value, "code %d (%s), %" PRId64 " bytes", code, owner_of(code), bytes);
    return number < LISTED_MOST ? vvi_notes_add(notes, key, value) : VV_OK;
}

/* Those up to the samples, or to the end of a header that has a file of its own. What lies about its size ends the
 * list: the samples are found without it. */
vv_status vvi_nifti_read_extensions(vv_field_info *info, const vvi_nifti *h, vv_source *source, vv_notes *notes)
{
    uint8_t flags[4], head[8];
    size_t n;
    bool exact;
    vv_status st = vvi_source_read_some(source, flags, sizeof flags, &n);
    if (st != VV_OK || n < sizeof flags || flags[0] == 0)
        return st;
    for (int number = 0; st == VV_OK; number++) {
        const uint64_t at = vvi_source_tell(source), left = vvi_source_left(source, &exact);
        const uint64_t room = h->pair ? left : h->offset > at ? h->offset - at : 0;
        int32_t size, code;
        if (room < 16)
            return VV_OK;
        if ((st = vvi_source_read_some(source, head, sizeof head, &n)) != VV_OK || n < sizeof head)
            return st;
        if (h->swapped)
            vvi_swap_bytes(head, 4, 2);
        memcpy(&size, head, 4);
        memcpy(&code, head + 4, 4);
        if (size < 16 || (uint64_t)size > room || (uint64_t)size > left)
            return vvi_notes_warn(notes,
                                  "its header extension %d says that it has %" PRId32 " bytes; %" PRIu64
                                  " are there: it and what follows are left out",
                                  number, size, room);
        if ((st = note_extension(notes, number, code, size - 8)) != VV_OK)
            return st;
        st = (uint64_t)size <= vvi_source_limits(source)->header_bytes
                 ? read_body(info, h, code, (size_t)size - 8, source, notes)
                 : vvi_source_skip(source, (uint64_t)size - 8);
    }
    return st;
}
