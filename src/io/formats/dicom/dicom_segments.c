/* What a segmentation says of its segments, and a structure set of its regions of interest: numbers, names, colours,
 * and codes for what they are. */
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include "io/notes.h"
#include "io/scan.h"
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>
#include <volvis/image.h>

#define SEGMENTS_MOST 65535 /* numbers have 16 bits */

const char *const vvi_dicom_outlines[VVI_DICOM_OUTLINES] = {
    "CLOSED_PLANAR", "CLOSEDPLANAR_XOR", "OPEN_PLANAR", "OPEN_NONPLANAR", "POINT", "other"};

bool vvi_dicom_is_structure_set(const vvi_dicom_image *image)
{
    return image->pixels.tag == 0 && strcmp(image->text[VVI_DICOM_MODALITY], "RTSTRUCT") == 0;
}

const char *vvi_dicom_word(const vvi_dicom_image *image)
{
    return vvi_dicom_is_structure_set(image) ? "ROI" : "segment";
}

/* Frames of a structure set say where one region is. */
vvi_dicom_segmentation vvi_dicom_segmentation_of(const vvi_dicom_image *image)
{
    if (vvi_dicom_is_structure_set(image))
        return VVI_DICOM_BINARY;
    static const char *const types[] = {"", "BINARY", "FRACTIONAL", "LABELMAP"};
    for (int t = VVI_DICOM_BINARY; t <= VVI_DICOM_LABELMAP; t++)
        if (strcmp(image->text[VVI_DICOM_SEGMENTATION_TYPE], types[t]) == 0)
            return (vvi_dicom_segmentation)t;
    return VVI_DICOM_NO_SEGMENTS;
}

/* Elements -------------------------------------------------------------------------------------------------------- */

/* Segments appear one by one as their items are found in the file. */
static vv_status segment_at(vvi_dicom_segment **out, vvi_dicom_image *image, size_t index, vv_job *job)
{
    *out = NULL;
    if (index >= SEGMENTS_MOST)
        return VV_OK;
    while (image->n_segments <= index) {
        const size_t n = image->n_segments;
        if ((n & (n - 1)) == 0) {
            const size_t bytes = (n ? n * 2 : 1) * sizeof **out;
            void *grown = vvi_realloc(job, image->segment, bytes, VVI_MEM_MODEL);
            if (!grown)
                return vv_fail_memory(bytes);
            image->segment = grown;
        }
        image->segment[image->n_segments++] =
            (vvi_dicom_segment){.number = NAN, .lab = {NAN, NAN, NAN}, .rgb = {NAN, NAN, NAN}};
    }
    *out = &image->segment[index];
    return VV_OK;
}

/* Of several codes the first. */
static vv_status take_text(char *out, size_t room, vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    return out[0] ? VV_OK : vvi_dicom_value(s, e, out, room);
}

vv_status vvi_dicom_code_element(vv_code *code, vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    switch (e->tag) {
    case 0x00080100:
    case 0x00080119: /* one too long for the first */
        return take_text(code->value, sizeof code->value, s, e);
    case 0x00080102:
        return take_text(code->scheme, sizeof code->scheme, s, e);
    case 0x00080104:
        return take_text(code->meaning, sizeof code->meaning, s, e);
    default:
        return VV_OK;
    }
}

vv_status vvi_dicom_segment_element(vvi_dicom_image *image, vvi_dicom_stream *s, const vvi_dicom_element *e,
                                    vvi_dicom_where where, int64_t index)
{
    vvi_dicom_segment *segment;
    if (where > VVI_DICOM_ROI)
        return VV_OK; /* of contours, which are read when they are wanted */
    vv_status st = segment_at(&segment, image, (size_t)index, s->job);
    if (st != VV_OK || !segment)
        return st;
    if (where >= VVI_DICOM_SEGMENT_CATEGORY && where <= VVI_DICOM_SEGMENT_REGION_MODIFIER)
        return vvi_dicom_code_element(&segment->code[where - VVI_DICOM_SEGMENT_CATEGORY], s, e);
    switch (e->tag) {
    case 0x30060022:
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('I', 'S'), &segment->number, 1);
    case 0x30060026:
        return vvi_dicom_value(s, e, segment->label, sizeof segment->label);
    case 0x30060036:
        return vvi_dicom_value(s, e, segment->algorithm, sizeof segment->algorithm);
    case 0x00620004:
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('U', 'S'), &segment->number, 1);
    case 0x00620005:
        return vvi_dicom_value(s, e, segment->label, sizeof segment->label);
    case 0x00620008:
        return vvi_dicom_value(s, e, segment->algorithm, sizeof segment->algorithm);
    case 0x0062000d:
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('U', 'S'), segment->lab, 3);
    default:
        return VV_OK;
    }
}

/* Colours --------------------------------------------------------------------------------------------------------- */

static double from_lab(double t)
{
    return t > 6.0 / 29 ? t * t * t : 3 * (6.0 / 29) * (6.0 / 29) * (t - 4.0 / 29);
}

static double within(double v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

/* PS3.3 C.10.7.1.1: L from 0 to 100, a and b from -128 to 127, each over 16 bits, under the light D50. Colours that no
 * screen has become the nearest in each primary. */
static vv_color lab_color(const double lab[3])
{
    /* XYZ of D50 to linear sRGB, whose light is D65, with Bradford's adaptation (Lindbloom) */
    static const double to_rgb[3][3] = {
        {3.1338561, -1.6168667, -0.4906146}, {-0.9787684, 1.9161415, 0.0334540}, {0.0719453, -0.2289914, 1.4052427}};
    static const double white[3] = {0.9642, 1, 0.8251};
    const double l = lab[0] / 65535 * 100, a = lab[1] / 65535 * 255 - 128, b = lab[2] / 65535 * 255 - 128;
    const double y = (l + 16) / 116;
    const double xyz[3] = {white[0] * from_lab(y + a / 500), white[1] * from_lab(y), white[2] * from_lab(y - b / 200)};
    double c[3];
    for (int i = 0; i < 3; i++)
        c[i] = within(to_rgb[i][0] * xyz[0] + to_rgb[i][1] * xyz[1] + to_rgb[i][2] * xyz[2]);
    return (vv_color){c[0], c[1], c[2], 1};
}

static vv_color rgb_color(const double rgb[3])
{
    return (vv_color){vv_srgb_decode(within(rgb[0] / 255)), vv_srgb_decode(within(rgb[1] / 255)),
                      vv_srgb_decode(within(rgb[2] / 255)), 1};
}

vv_label vvi_dicom_segment_label(const vvi_dicom_segment *segment, uint16_t number)
{
    vv_label label = {.value = number};
    if (!segment)
        return label;
    label.codes = segment->code;
    const char *name = segment->label[0] ? segment->label : segment->code[VV_LABEL_TYPE].meaning;
    snprintf(label.name, sizeof label.name, "%.*s", (int)vvi_utf8_cut(name, strlen(name), sizeof label.name - 1), name);
    const double *lab = segment->lab, *rgb = segment->rgb;
    label.has_color = isfinite(lab[0] + lab[1] + lab[2]) || isfinite(rgb[0] + rgb[1] + rgb[2]);
    if (label.has_color)
        label.color = isfinite(rgb[0] + rgb[1] + rgb[2]) ? rgb_color(rgb) : lab_color(lab);
    return label;
}

/* Codes ----------------------------------------------------------------------------------------------------------- */

/* "Liver (10200004, SCT)" */
static vv_status note_code(const vvi_dicom_segment *segment, const char *word, const char *what, const vv_code *code,
                           vv_notes *notes)
{
    char key[48], text[256];
    if (!code->value[0] && !code->meaning[0])
        return VV_OK;
    snprintf(key, sizeof key, "%s %.0f %s", word, segment->number, what);
    snprintf(text, sizeof text, "%s (%s, %s)", code->meaning, code->value, code->scheme);
    return vvi_notes_add(notes, key, text);
}

/* "Liver, ORGAN, 45 CLOSED_PLANAR, #ff8000" */
static vv_status note_region(const vvi_dicom_segment *region, vv_notes *notes)
{
    char key[48], text[256];
    const double *rgb = region->rgb;
    size_t n = 0, total = 0;
    snprintf(key, sizeof key, "ROI %.0f", region->number);
    n = (size_t)snprintf(text, sizeof text, "%s%s%s", region->label[0] ? region->label : "without a name",
                         region->kind[0] ? ", " : "", region->kind);
    for (int o = 0; o < VVI_DICOM_OUTLINES; o++) {
        total += region->n_contours[o];
        if (region->n_contours[o] > 0 && n < sizeof text)
            n += (size_t)snprintf(text + n, sizeof text - n, ", %u %s", (unsigned)region->n_contours[o],
                                  vvi_dicom_outlines[o]);
    }
    if (total == 0 && n < sizeof text)
        n += (size_t)snprintf(text + n, sizeof text - n, ", no contours");
    if (isfinite(rgb[0] + rgb[1] + rgb[2]) && n < sizeof text)
        snprintf(text + n, sizeof text - n, ", #%02x%02x%02x", (unsigned)(within(rgb[0] / 255) * 255 + 0.5),
                 (unsigned)(within(rgb[1] / 255) * 255 + 0.5), (unsigned)(within(rgb[2] / 255) * 255 + 0.5));
    return vvi_notes_add(notes, key, text);
}

vv_status vvi_dicom_note_regions(const vvi_dicom_image *image, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (size_t i = 0; vvi_dicom_is_structure_set(image) && i < image->n_segments && st == VV_OK; i++)
        st = note_region(&image->segment[i], notes);
    return st;
}

vv_status vvi_dicom_note_segment(const vvi_dicom_segment *segment, const char *word, vv_notes *notes)
{
    char key[48];
    static const char *const what[VV_LABEL_CODES] = {"category", "type", "type modifier", "region", "region modifier"};
    vv_status st = VV_OK;
    for (int c = 0; c < VV_LABEL_CODES && st == VV_OK; c++)
        st = note_code(segment, word, what[c], &segment->code[c], notes);
    if (st != VV_OK || !segment->algorithm[0])
        return st;
    snprintf(key, sizeof key, "%s %.0f algorithm", word, segment->number);
    return vvi_notes_add(notes, key, segment->algorithm);
}
