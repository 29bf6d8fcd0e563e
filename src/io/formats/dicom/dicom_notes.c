/* What an image says beyond its samples: notes for people. Names, numbers and birth dates of patients are left out:
 * notes are printed, and written into other files. */
#include "core/units.h"
#include "io/formats/dicom/dicom.h"
#include "io/notes.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct note_row {
    uint32_t tag;
    const char *key;
} note_row;

static const note_row rows[] = {
    {0x00080008, "ImageType"},
    {0x00080020, "StudyDate"},
    {0x00080060, "Modality"},
    {0x00080070, "Manufacturer"},
    {0x00081030, "StudyDescription"},
    {0x0008103e, "SeriesDescription"},
    {0x00081090, "ManufacturerModelName"},
    {0x00180015, "BodyPartExamined"},
    {0x00180020, "ScanningSequence"},
    {0x00180050, "SliceThickness"},
    {0x00180060, "KVP"},
    {0x00180080, "RepetitionTime"},
    {0x00180081, "EchoTime"},
    {0x00180082, "InversionTime"},
    {0x00180087, "MagneticFieldStrength"},
    {0x00181020, "SoftwareVersions"},
    {0x00181030, "ProtocolName"},
    {0x00181120, "GantryDetectorTilt"},
    {0x00181151, "XRayTubeCurrent"},
    {0x00181210, "ConvolutionKernel"},
    {0x00181314, "FlipAngle"},
    {0x00185100, "PatientPosition"},
    {0x0020000e, "SeriesInstanceUID"},
    {0x00200011, "SeriesNumber"},
    {0x00200052, "FrameOfReferenceUID"},
    {0x00204000, "ImageComments"},
    {0x00280004, "PhotometricInterpretation"},
    {0x00281050, "WindowCenter"},
    {0x00281051, "WindowWidth"},
    {0x00281054, "RescaleType"},
    {0x00282110, "LossyImageCompression"},
    {0x00541001, "Units"},
    {0x30040004, "DoseType"},
    {0x3004000a, "DoseSummationType"},
    {0x30060002, "StructureSetLabel"},
    {0x30060006, "StructureSetDescription"},
    {0x30060008, "StructureSetDate"},
};

static vv_status visit(void *user, vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where,
                       int64_t frame)
{
    char text[256];
    if (where != VVI_DICOM_TOP || e->length == 0)
        return VV_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].tag == e->tag) {
            vv_status st = vvi_dicom_value(s, e, text, sizeof text);
            return st == VV_OK && text[0] ? vvi_notes_add(user, rows[i].key, text) : st;
        }
    return VV_OK;
}

static vv_status note_padding(const vvi_dicom_image *image, vvi_dicom_number which, const char *key, vv_notes *notes)
{
    char text[32];
    double padding = image->number[which];
    if (isnan(padding))
        return VV_OK;
    if (image->number[VVI_DICOM_SIGNED] == 1 && padding > 32767)
        padding -= 65536; /* written as unsigned where the syntax does not say */
    vvi_print_number(text, padding);
    return vvi_notes_add(notes, key, text);
}

/* The window, in values, is how the first channel should be shown. */
static vv_status note_window(const vvi_dicom_image *image, const vv_field_info *info, vv_notes *notes)
{
    const double center = image->number[VVI_DICOM_WINDOW_CENTER], width = image->number[VVI_DICOM_WINDOW_WIDTH];
    if (info->components != 1 || !isfinite(center) || !(width >= 1))
        return VV_OK;
    vv_channel channel = {.lo = center - width / 2, .hi = center + width / 2};
    return vvi_notes_channel(notes, &channel);
}

vv_status vvi_dicom_note(const vvi_dicom_image *image, const vv_field_info *info, vv_source *source, vv_notes *notes,
                         vv_job *job)
{
    vvi_dicom_file file;
    vvi_dicom_stream s;
    vvi_dicom_image again = {0};
    vvi_dicom_element pixels;
    vvi_dicom_image head = *image; /* of a deflated file, no more than the elements before the pixels */
    if (image->pixels.tag && image->pixels.at < image->size)
        head.size = image->pixels.at;
    head.structures = NULL;
    vv_status st = vvi_dicom_open(&file, &head, source, job);
    if (st != VV_OK)
        return st;
    st = vvi_dicom_stream_init(&s, file.source, job);
    if (st == VV_OK && !image->deflated)
        st = vvi_dicom_begin(&s, &again);
    if (st == VV_OK)
        st = vvi_dicom_walk(&s, &pixels, visit, notes);
    vvi_dicom_stream_finish(&s);
    vvi_dicom_close(&file);
    if (st == VV_OK)
        st = note_padding(image, VVI_DICOM_PADDING, "PixelPaddingValue", notes);
    if (st == VV_OK)
        st = note_padding(image, VVI_DICOM_PADDING_LIMIT, "PixelPaddingRangeLimit", notes);
    if (vvi_dicom_segmentation_of(image))
        return st;
    if (st == VV_OK && strcmp(image->text[VVI_DICOM_PHOTOMETRIC], "MONOCHROME1") == 0)
        st =
            vvi_notes_add(notes, "shown", "small values are meant to be bright (MONOCHROME1); they are kept as stored");
    if (st == VV_OK && strcmp(image->text[VVI_DICOM_PHOTOMETRIC], "PALETTE COLOR") == 0)
        st = vvi_notes_add(notes, "shown", "values are indices into a colour palette; they are kept as stored");
    return st == VV_OK ? note_window(image, info, notes) : st;
}
