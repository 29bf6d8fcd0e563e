/* What stands before the samples of a .vti file. What VTK has no word for is noted in the field data. */
#include "core/units.h"
#include "io/formats/vtk/vti_write.h"
#include "io/placement.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* Samples begin at a multiple of this, so that they can be mapped whatever their type. */
#define ALIGNMENT 64

static void add_escaped(vvi_text *t, const char *s)
{
    for (; *s; s++) {
        const unsigned char c = (unsigned char)*s;
        if (c == '&')
            vvi_text_add(t, "&amp;");
        else if (c == '<')
            vvi_text_add(t, "&lt;");
        else if (c == '"')
            vvi_text_add(t, "&quot;");
        else if (c < 32)
            vvi_text_add(t, " ");
        else
            vvi_text_add_n(t, s, 1);
    }
}

static void add_reals(vvi_text *t, const char *name, const double *v, int n)
{
    vvi_text_printf(t, " %s=\"", name);
    for (int i = 0; i < n; i++) {
        char number[32];
        vvi_print_unsigned_zero(number, v[i]);
        vvi_text_printf(t, "%s%s", i ? " " : "", number);
    }
    vvi_text_add(t, "\"");
}

static void add_grid(vvi_text *t, const vv_grid *grid)
{
    const vv_affine *map = &grid->index_to_world;
    double spacing[3], direction[9];
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = map->axis[a];
        spacing[a] = vvi_length(v);
        direction[a] = v.x / spacing[a];
        direction[3 + a] = v.y / spacing[a];
        direction[6 + a] = v.z / spacing[a];
    }
    vvi_text_printf(t, "  <ImageData WholeExtent=\"0 %" PRId64 " 0 %" PRId64 " 0 %" PRId64 "\"", grid->dims[0] - 1,
                    grid->dims[1] - 1, grid->dims[2] - 1);
    add_reals(t, "Origin", (const double[]){map->origin.x, map->origin.y, map->origin.z}, 3);
    add_reals(t, "Spacing", spacing, 3);
    add_reals(t, "Direction", direction, 9);
    vvi_text_add(t, ">\n");
}

/* A text as VTK keeps it: the numbers of its letters, and a 0. */
static void add_note(vvi_text *t, const char *name, const char *text)
{
    if (!text || !*text)
        return;
    vvi_text_printf(t, "      <Array type=\"String\" Name=\"%s\" NumberOfTuples=\"1\" format=\"ascii\">\n        ",
                    name);
    for (; *text; text++)
        vvi_text_printf(t, "%d ", (unsigned char)*text);
    vvi_text_add(t, "0\n      </Array>\n");
}

static const char *meaning_note(const vv_field_info *info)
{
    const bool byte = info->type == VV_TYPE_U8;
    switch (info->meaning) {
    case VV_MEANING_LABEL:
        return "label";
    case VV_MEANING_VECTOR:
        return info->components > 1 ? NULL : "vector";
    case VV_MEANING_RGB:
        return byte ? NULL : "rgb";
    case VV_MEANING_RGBA:
        return byte ? NULL : "rgba";
    case VV_MEANING_SCALAR:
        break;
    }
    return byte && (info->components == 3 || info->components == 4) ? "scalar" : NULL;
}

static void add_notes(vvi_text *t, const vv_field_info *info)
{
    char number[32];
    vvi_text_add(t, "    <FieldData>\n");
    add_note(t, "volvis unit", info->grid.unit);
    if (info->grid.space == VV_SPACE_RAS)
        add_note(t, "volvis space", "RAS");
    add_note(t, "volvis meaning", meaning_note(info));
    add_note(t, "volvis value unit", info->value_unit);
    vvi_print_number(number, info->value_scale);
    add_note(t, "volvis value scale", info->value_scale != 1 ? number : NULL);
    vvi_print_number(number, info->value_offset);
    add_note(t, "volvis value offset", info->value_offset != 0 ? number : NULL);
    vvi_text_add(t, "    </FieldData>\n");
}

static void add_array(vvi_text *t, const vv_field_info *info, const char *form)
{
    static const char *const types[VV_TYPE_COUNT] = {"UInt8", "Int8",   "UInt16", "Int16",   "UInt32",
                                                     "Int32", "UInt64", "Int64",  "Float32", "Float64"};
    const bool vector = info->meaning == VV_MEANING_VECTOR;
    vvi_text_printf(t, "      <PointData %s=\"", vector ? "Vectors" : "Scalars");
    add_escaped(t, info->name[0] ? info->name : "values");
    vvi_text_printf(t, "\">\n        <DataArray type=\"%s\" Name=\"", types[info->type]);
    add_escaped(t, info->name[0] ? info->name : "values");
    vvi_text_printf(t, "\" NumberOfComponents=\"%d\" format=\"%s\"", info->components, form);
}

void vvi_vti_add_head(vvi_text *t, const vv_field_info *info, const char *encoding, bool big_endian)
{
    const int64_t *n = info->grid.dims;
    const bool in_place = strcmp(encoding, "ascii") == 0 || strcmp(encoding, "base64") == 0;
    vvi_text_printf(t,
                    "<?xml version=\"1.0\"?>\n<!-- written by VolVis -->\n<VTKFile type=\"ImageData\" "
                    "version=\"1.0\" byte_order=\"%s\" header_type=\"UInt64\"%s>\n",
                    big_endian ? "BigEndian" : "LittleEndian",
                    strcmp(encoding, "zlib") == 0 ? " compressor=\"vtkZLibDataCompressor\"" : "");
    add_grid(t, &info->grid);
    add_notes(t, info);
    vvi_text_printf(t, "    <Piece Extent=\"0 %" PRId64 " 0 %" PRId64 " 0 %" PRId64 "\">\n", n[0] - 1, n[1] - 1,
                    n[2] - 1);
    add_array(t, info, strcmp(encoding, "ascii") == 0 ? "ascii" : in_place ? "binary" : "appended");
    vvi_text_add(t, in_place ? ">\n" : " offset=\"0\"/>\n");
}

void vvi_vti_add_mark(vvi_text *t)
{
    vvi_text_add(t, "  <AppendedData encoding=\"raw\">\n");
    while ((t->n + 1 + VVI_VTI_WORD) % ALIGNMENT != 0 && !t->bad)
        vvi_text_add(t, " ");
    vvi_text_add(t, "_");
}
