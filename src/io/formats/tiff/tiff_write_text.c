/* What is said of the volume in the first page: as ImageJ does, or as OME-XML. */
#include "core/job.h"
#include "core/units.h"
#include "grid/field.h"
#include "io/formats/tiff/tiff_write.h"
#include "io/scan.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

static void add_number(vvi_text *t, const char *before, double v, const char *after)
{
    char number[32];
    vvi_print_unsigned_zero(number, v);
    vvi_text_printf(t, "%s%s%s", before, number, after);
}

static bool has_spacing(const vv_field_info *info)
{
    return strcmp(info->grid.unit, "voxels") != 0;
}

double vvi_tiff_seconds(const char *unit)
{
    static const struct {
        const char *unit;
        double seconds;
    } known[] = {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"ns", 1e-9}, {"min", 60}, {"h", 3600}, {"d", 86400}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i].unit, unit) == 0)
            return known[i].seconds;
    return 0;
}

static bool has_time(const vv_field_info *info, size_t n_frames)
{
    return n_frames > 1 && info->frame_step > 0 && isfinite(info->frame_step) && vvi_tiff_seconds(info->frame_unit) > 0;
}

/* ImageJ ------------------------------------------------------------------------------------------------------------
 */

static void add_axes(vvi_text *t, const vvi_tiff_writing *w, size_t n_frames)
{
    const int64_t slices = w->turn.grid.dims[2];
    const int axes = (w->channels > 1) + (slices > 1) + (n_frames > 1);
    vvi_text_printf(t, "ImageJ=1.53t\nimages=%" PRIu64 "\n", w->n_pages);
    if (w->channels > 1)
        vvi_text_printf(t, "channels=%" PRId64 "\n", w->channels);
    if (slices > 1)
        vvi_text_printf(t, "slices=%" PRId64 "\n", slices);
    if (n_frames > 1)
        vvi_text_printf(t, "frames=%zu\n", n_frames);
    if (axes > 1)
        vvi_text_add(t, "hyperstack=true\n");
    if (w->channels > 1)
        vvi_text_add(t, w->channels <= 7 ? "mode=composite\n" : "mode=grayscale\n");
}

void vvi_tiff_imagej_text(vvi_text *t, vvi_tiff_writing *w, size_t n_frames)
{
    const vv_field_info *info = w->info;
    add_axes(t, w, n_frames);
    if (has_spacing(info)) {
        w->resolution[0] = 1 / vv_grid_spacing(&w->turn.grid, 0);
        w->resolution[1] = 1 / vv_grid_spacing(&w->turn.grid, 1);
        vvi_text_printf(t, "unit=%s\n", strcmp(info->grid.unit, "um") == 0 ? "micron" : info->grid.unit);
        add_number(t, "spacing=", vv_grid_spacing(&w->turn.grid, 2), "\n");
    }
    if (has_time(info, n_frames))
        add_number(t, "finterval=", info->frame_step * vvi_tiff_seconds(info->frame_unit), "\n");
    if (info->value_scale != 1 || info->value_offset != 0) {
        add_number(t, "cf=0\nc0=", info->value_offset, "\n"); /* a straight line */
        add_number(t, "c1=", info->value_scale, "\n");
    }
    if (info->value_unit[0])
        vvi_text_printf(t, "vunit=%s\n", info->value_unit);
    if (info->name[0]) {
        char name[sizeof info->name];
        memcpy(name, info->name, sizeof name);
        vvi_text_clean(name); /* one line */
        vvi_text_printf(t, "name=%s\n", name);
    }
    for (int k = 0; k < VVI_TIFF_OWN_KEYS; k++)
        if (w->own.text[k][0])
            vvi_text_printf(t, "volvis_%s=%s\n", vvi_tiff_own_keys[k], w->own.text[k]);
    vvi_text_add(t, "loop=false\n");
}

/* OME-XML -----------------------------------------------------------------------------------------------------------
 */

static void add_xml(vvi_text *t, const char *s)
{
    for (; *s; s++)
        switch (*s) {
        case '&':
            vvi_text_add(t, "&amp;");
            break;
        case '<':
            vvi_text_add(t, "&lt;");
            break;
        case '"':
            vvi_text_add(t, "&quot;");
            break;
        default:
            vvi_text_add_n(t, (unsigned char)*s < ' ' ? " " : s, 1);
        }
}

/* Units by the symbols of OME; those that it has not are lengths of a frame of reference, read as "units". */
const char *vvi_tiff_ome_unit(const char *said)
{
    char unit[16];
    vvi_unit_name(unit, said, strlen(said));
    if (strcmp(unit, "um") == 0)
        return "\xc2\xb5m";
    if (strcmp(unit, "A") == 0)
        return "\xc3\x85";
    static const char *const same[] = {"nm", "pm", "mm", "cm", "m", "km", "in", "ft"};
    for (size_t i = 0; i < sizeof same / sizeof *same; i++)
        if (strcmp(unit, same[i]) == 0)
            return same[i];
    return strcmp(unit, "units") == 0 || strcmp(unit, "voxels") == 0 ? "reference frame" : NULL;
}

static void add_sizes(vvi_text *t, const vvi_tiff_writing *w, size_t n_frames)
{
    const vv_field_info *info = w->info;
    const int64_t *n = w->turn.grid.dims;
    vvi_text_printf(t, " SizeX=\"%" PRId64 "\" SizeY=\"%" PRId64 "\" SizeZ=\"%" PRId64 "\" SizeC=\"%d\" SizeT=\"%zu\"",
                    n[0], n[1], n[2], info->components, n_frames);
    const char *unit = vvi_tiff_ome_unit(info->grid.unit);
    for (int a = 0; a < 3 && has_spacing(info); a++) {
        char before[32];
        snprintf(before, sizeof before, " PhysicalSize%c=\"", 'X' + a);
        add_number(t, before, vv_grid_spacing(&w->turn.grid, a), "\"");
        vvi_text_printf(t, " PhysicalSize%cUnit=\"%s\"", 'X' + a, unit ? unit : "reference frame");
    }
    if (has_time(info, n_frames)) {
        add_number(t, " TimeIncrement=\"", info->frame_step, "\"");
        vvi_text_printf(t, " TimeIncrementUnit=\"%s\"",
                        strcmp(info->frame_unit, "us") == 0 ? "\xc2\xb5s" : info->frame_unit);
    }
}

static void add_channels(vvi_text *t, const vvi_tiff_writing *w)
{
    const vv_write_options *o = w->options;
    const bool known = o->channels && o->n_channels == (size_t)w->channels && w->samples == 1;
    for (int64_t c = 0; c < w->channels; c++) {
        vvi_text_printf(t, "<Channel ID=\"Channel:0:%" PRId64 "\" SamplesPerPixel=\"%d\"", c, w->samples);
        if (known && o->channels[c].name[0]) {
            vvi_text_add(t, " Name=\"");
            add_xml(t, o->channels[c].name);
            vvi_text_add(t, "\"");
        }
        if (known && o->channels[c].has_color) {
            const vv_color *p = &o->channels[c].color;
            const double code[3] = {vv_srgb_encode(p->r), vv_srgb_encode(p->g), vv_srgb_encode(p->b)};
            uint32_t v = 0;
            for (int i = 0; i < 3; i++)
                v = v << 8 | (uint32_t)(fmin(fmax(code[i], 0), 1) * 255 + 0.5);
            v = v << 8 | 255;
            int32_t color;
            memcpy(&color, &v, 4);
            vvi_text_printf(t, " Color=\"%" PRId32 "\"", color);
        }
        vvi_text_add(t, "/>");
    }
}

/* What is VolVis' own, to the image and behind it. */
static void add_own(vvi_text *t, const vvi_tiff_own *own)
{
    bool any = false;
    for (int k = 0; k < VVI_TIFF_OWN_KEYS; k++) {
        if (!own->text[k][0])
            continue;
        if (!any)
            vvi_text_add(t, "<AnnotationRef ID=\"Annotation:0\"/></Image><StructuredAnnotations>"
                            "<MapAnnotation ID=\"Annotation:0\" Namespace=\"volvis\"><Value>");
        any = true;
        vvi_text_printf(t, "<M K=\"%s\">", vvi_tiff_own_keys[k]);
        add_xml(t, own->text[k]);
        vvi_text_add(t, "</M>");
    }
    vvi_text_add(t, any ? "</Value></MapAnnotation></StructuredAnnotations></OME>" : "</Image></OME>");
}

vv_status vvi_tiff_ome_text(vvi_text *t, const vvi_tiff_writing *w, size_t n_frames)
{
    static const char *const types[VV_TYPE_COUNT] = {"uint8", "int8", "uint16", "int16", "uint32",
                                                     "int32", NULL,   NULL,     "float", "double"};
    const char *type = types[w->info->type];
    if (!type)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_sink_name(w->sink), NULL,
                          "OME-TIFF has no integers of 64 bits; write .tif or .nrrd, or change the type with volvis "
                          "rescale");
    vvi_text_add(
        t, "<?xml version=\"1.0\" encoding=\"UTF-8\"?><OME xmlns=\"http://www.openmicroscopy.org/Schemas/OME/2016-06\""
           " xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" xsi:schemaLocation=\""
           "http://www.openmicroscopy.org/Schemas/OME/2016-06 "
           "http://www.openmicroscopy.org/Schemas/OME/2016-06/ome.xsd\" Creator=\"VolVis\"><Image ID=\"Image:0\"");
    if (w->info->name[0]) {
        vvi_text_add(t, " Name=\"");
        add_xml(t, w->info->name);
        vvi_text_add(t, "\"");
    }
    vvi_text_printf(t, "><Pixels ID=\"Pixels:0\" DimensionOrder=\"XYCZT\" Type=\"%s\" BigEndian=\"%s\"", type,
                    w->big_endian ? "true" : "false");
    add_sizes(t, w, n_frames);
    vvi_text_add(t, ">");
    add_channels(t, w);
    vvi_text_printf(t, "<TiffData IFD=\"0\" PlaneCount=\"%" PRIu64 "\"/></Pixels>", w->n_pages);
    add_own(t, &w->own);
    return VV_OK;
}
