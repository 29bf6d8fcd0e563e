/* What an image's elements say, by a table of those that matter. */
#include "core/memory.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/scan.h"
#include <math.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* Elements that matter ------------------------------------------------------------------------------------------- */

typedef enum field_kind { OF_VALUES, OF_IMAGE, OF_TEXT } field_kind;

typedef struct field_row {
    uint32_t tag;
    char vr[3]; /* where the syntax does not say; "TM": a time of day */
    field_kind kind;
    size_t n, offset; /* of doubles in the values; of OF_IMAGE and OF_TEXT, the number and text */
} field_row;

#define IN_VALUES(member) offsetof(vvi_dicom_values, member)
#define KEY(k) (offsetof(vvi_dicom_values, key) + sizeof(double) * (k))
static const field_row rows[] = {
    {0x0008002a, "DT", OF_VALUES, 1, KEY(VVI_DICOM_KEY_ACQUISITION_TIME)},
    {0x00080032, "TM", OF_VALUES, 1, KEY(VVI_DICOM_KEY_ACQUISITION_TIME)},
    {0x00080033, "TM", OF_VALUES, 1, KEY(VVI_DICOM_KEY_CONTENT_TIME)},
    {0x00080018, "UI", OF_TEXT, 0, VVI_DICOM_IMAGE_UID},
    {0x00080060, "CS", OF_TEXT, 0, VVI_DICOM_MODALITY},
    {0x0008103e, "LO", OF_TEXT, 0, VVI_DICOM_DESCRIPTION},
    {0x00180050, "DS", OF_VALUES, 1, IN_VALUES(thickness)},
    {0x00180081, "DS", OF_VALUES, 1, KEY(VVI_DICOM_KEY_ECHO)},
    {0x00180088, "DS", OF_VALUES, 1, IN_VALUES(between)},
    {0x00181060, "DS", OF_VALUES, 1, KEY(VVI_DICOM_KEY_TRIGGER)},
    {0x00181063, "DS", OF_IMAGE, 1, VVI_DICOM_FRAME_TIME},
    {0x00181164, "DS", OF_IMAGE, 2, VVI_DICOM_DETECTOR_SPACING},
    {0x00189082, "FD", OF_VALUES, 1, KEY(VVI_DICOM_KEY_ECHO)},
    {0x00189087, "FD", OF_VALUES, 1, KEY(VVI_DICOM_KEY_B_VALUE)},
    {0x0020000e, "UI", OF_TEXT, 0, VVI_DICOM_SERIES_UID},
    {0x00200011, "IS", OF_IMAGE, 1, VVI_DICOM_SERIES},
    {0x00200012, "IS", OF_VALUES, 1, KEY(VVI_DICOM_KEY_ACQUISITION)},
    {0x00200013, "IS", OF_VALUES, 1, KEY(VVI_DICOM_KEY_INSTANCE)},
    {0x00200032, "DS", OF_VALUES, 3, IN_VALUES(position)},
    {0x00200037, "DS", OF_VALUES, 6, IN_VALUES(row)},
    {0x00200052, "UI", OF_TEXT, 0, VVI_DICOM_PLACE_UID},
    {0x00200100, "IS", OF_VALUES, 1, KEY(VVI_DICOM_KEY_TEMPORAL)},
    {0x00200110, "DS", OF_IMAGE, 1, VVI_DICOM_TEMPORAL_RESOLUTION},
    {0x00209128, "UL", OF_VALUES, 1, KEY(VVI_DICOM_KEY_TEMPORAL)},
    {0x00209153, "FD", OF_VALUES, 1, KEY(VVI_DICOM_KEY_TRIGGER)},
    {0x00280002, "US", OF_IMAGE, 1, VVI_DICOM_SAMPLES},
    {0x00280004, "CS", OF_TEXT, 0, VVI_DICOM_PHOTOMETRIC},
    {0x00280006, "US", OF_IMAGE, 1, VVI_DICOM_PLANAR},
    {0x00280008, "IS", OF_IMAGE, 1, VVI_DICOM_FRAMES},
    {0x00280010, "US", OF_IMAGE, 1, VVI_DICOM_ROWS},
    {0x00280011, "US", OF_IMAGE, 1, VVI_DICOM_COLUMNS},
    {0x00280030, "DS", OF_VALUES, 2, IN_VALUES(spacing)},
    {0x00280100, "US", OF_IMAGE, 1, VVI_DICOM_ALLOCATED},
    {0x00280101, "US", OF_IMAGE, 1, VVI_DICOM_STORED},
    {0x00280102, "US", OF_IMAGE, 1, VVI_DICOM_HIGH},
    {0x00280103, "US", OF_IMAGE, 1, VVI_DICOM_SIGNED},
    {0x00280120, "US", OF_IMAGE, 1, VVI_DICOM_PADDING},
    {0x00280121, "US", OF_IMAGE, 1, VVI_DICOM_PADDING_LIMIT},
    {0x00281050, "DS", OF_IMAGE, 1, VVI_DICOM_WINDOW_CENTER},
    {0x00281051, "DS", OF_IMAGE, 1, VVI_DICOM_WINDOW_WIDTH},
    {0x00281052, "DS", OF_VALUES, 1, IN_VALUES(intercept)},
    {0x00281053, "DS", OF_VALUES, 1, IN_VALUES(slope)},
    {0x00281054, "LO", OF_TEXT, 0, VVI_DICOM_RESCALE_TYPE},
    {0x00541001, "CS", OF_TEXT, 0, VVI_DICOM_UNITS},
    {0x00620001, "CS", OF_TEXT, 0, VVI_DICOM_SEGMENTATION_TYPE},
    {0x0062000b, "US", OF_VALUES, 1, KEY(VVI_DICOM_KEY_SEGMENT)},
    {0x0062000e, "US", OF_IMAGE, 1, VVI_DICOM_FRACTION_MOST},
    {0x30040002, "CS", OF_TEXT, 0, VVI_DICOM_DOSE_UNITS},
    {0x3004000e, "DS", OF_IMAGE, 1, VVI_DICOM_DOSE_SCALING},
};

static const field_row *find_row(uint32_t tag)
{
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (rows[i].tag == tag)
            return &rows[i];
    return NULL;
}

/* "hhmmss.ffffff", behind "yyyymmdd" in a date and time, as seconds. A day more or less does not sort. */
static vv_status read_time(vvi_dicom_stream *s, const vvi_dicom_element *e, bool date, double *out)
{
    char text[32];
    vv_status st = vvi_dicom_value(s, e, text, sizeof text);
    const char *at = text;
    double part[3] = {0, 0, 0}, days = 0;
    if (st != VV_OK || strspn(text, "0123456789") < (date ? 10u : 2u))
        return st;
    if (date) {
        days = (double)(text[4] - '0') * 310 + (double)(text[5] - '0') * 31 + (double)(text[6] - '0') * 10 +
               (double)(text[7] - '0');
        at += 8;
    }
    for (int i = 0; i < 3 && at[0] >= '0' && at[0] <= '9' && at[1] >= '0' && at[1] <= '9'; i++, at += 2)
        part[i] = (double)((at[0] - '0') * 10 + (at[1] - '0'));
    double fraction = 0, place = 0.1;
    for (at += *at == '.'; *at >= '0' && *at <= '9'; at++, place /= 10)
        fraction += (double)(*at - '0') * place;
    *out = days * 86400 + part[0] * 3600 + part[1] * 60 + part[2] + fraction;
    return VV_OK;
}

static void clear_values(vvi_dicom_values *v)
{
    for (size_t i = 0; i < sizeof *v / sizeof(double); i++)
        ((double *)(void *)v)[i] = NAN;
}

/* Frames appear one by one as their items are found in the file: never more than it has bytes for. */
static vv_status values_of(vvi_dicom_values **out, vvi_dicom_image *image, vvi_dicom_where where, int64_t frame,
                           vv_job *job)
{
    *out = &image->values;
    if (where != VVI_DICOM_FRAME)
        return VV_OK;
    while (image->n_frame <= (size_t)frame) {
        const size_t n = image->n_frame;
        if ((n & (n - 1)) == 0) {
            const size_t bytes = (n ? n * 2 : 1) * sizeof **out;
            void *grown = vvi_realloc(job, image->frame, bytes, VVI_MEM_MODEL);
            if (!grown)
                return vv_fail_memory(bytes);
            image->frame = grown;
        }
        clear_values(&image->frame[image->n_frame++]);
    }
    *out = &image->frame[frame];
    return VV_OK;
}

/* What a structure set was drawn on; of several series the first. */
static vv_status read_reference(vvi_dicom_image *image, vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    const vvi_dicom_text text = e->tag == 0x0020000e ? VVI_DICOM_DRAWN_SERIES_UID : VVI_DICOM_DRAWN_PLACE_UID;
    if ((e->tag != 0x0020000e && e->tag != 0x00200052) || image->text[text][0])
        return VV_OK;
    return vvi_dicom_value(s, e, image->text[text], VVI_DICOM_TEXT_BYTES);
}

static vv_status visit(void *user, vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where,
                       int64_t frame)
{
    vvi_dicom_image *image = user;
    vvi_dicom_values *values;
    const field_row *row = find_row(e->tag);
    if (where >= VVI_DICOM_SEGMENT)
        return vvi_dicom_segment_element(image, s, e, where, frame);
    if (where == VVI_DICOM_REFERENCE)
        return read_reference(image, s, e);
    if (where == VVI_DICOM_TOP && e->tag == 0x3004000c && !image->offset)
        return vvi_dicom_list(&image->offset, &image->n_offset, s, e);
    if (where == VVI_DICOM_TOP && e->tag == 0x30060002 && !image->text[VVI_DICOM_DESCRIPTION][0])
        return vvi_dicom_value(s, e, image->text[VVI_DICOM_DESCRIPTION], VVI_DICOM_TEXT_BYTES);
    if (!row || (where != VVI_DICOM_TOP && row->kind == OF_IMAGE))
        return VV_OK;
    if (row->kind == OF_TEXT)
        return vvi_dicom_value(s, e, image->text[row->offset], VVI_DICOM_TEXT_BYTES);
    const uint16_t vr = VVI_DICOM_VR(row->vr[0], row->vr[1]);
    if (row->kind == OF_IMAGE)
        return vvi_dicom_numbers(s, e, vr, &image->number[row->offset], row->n);
    vv_status st = values_of(&values, image, where, frame, s->job);
    if (st != VV_OK)
        return st;
    double *to = (double *)(void *)((char *)values + row->offset);
    if (row->vr[0] == 'T' || row->vr[1] == 'T')
        return read_time(s, e, row->vr[0] == 'D', to);
    return vvi_dicom_numbers(s, e, vr, to, row->n);
}

/* The image ------------------------------------------------------------------------------------------------------ */

const vvi_dicom_values *vvi_dicom_frame_values(const vvi_dicom_image *image, int64_t frame)
{
    return image->frame && (size_t)frame < image->n_frame ? &image->frame[frame] : &image->values;
}

/* What is said of all frames holds where a frame does not say it. */
static void share_values(vvi_dicom_image *image)
{
    const double *all = (const double *)(const void *)&image->values;
    for (size_t f = 0; f < image->n_frame; f++) {
        double *one = (double *)(void *)&image->frame[f];
        for (size_t i = 0; i < sizeof *image->frame / sizeof(double); i++)
            if (isnan(one[i]))
                one[i] = all[i];
    }
}

static vv_status count_of(double *out, const vvi_dicom_image *image, vvi_dicom_number which, double lo, double hi,
                          const char *what, const char *name)
{
    *out = image->number[which];
    if (isnan(*out))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "does not give its %s; it is not an image, or its header is damaged",
                          what);
    if (*out < lo || *out > hi || *out != floor(*out))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its %s is %g; %g to %g are possible", what, *out, lo, hi);
    return VV_OK;
}

static vv_status find_type(vvi_dicom_image *image, const char *name)
{
    double *number = image->number, bits;
    if (image->pixels.tag != VVI_DICOM_PIXEL_DATA) {
        image->type = image->pixels.tag == VVI_DICOM_PIXEL_F32 ? VV_TYPE_F32 : VV_TYPE_F64;
        number[VVI_DICOM_STORED] = number[VVI_DICOM_ALLOCATED] = (double)(8 * vv_type_bytes(image->type));
        return VV_OK;
    }
    vv_status st =
        count_of(&bits, image, VVI_DICOM_ALLOCATED, 1, 64, "number of bits per sample (BitsAllocated)", name);
    if (st != VV_OK)
        return st;
    if (bits != 1 && bits != 8 && bits != 16 && bits != 32 && bits != 64)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has %g bits per sample; 1, 8, 16, 32 and 64 are read", bits);
    if (isnan(number[VVI_DICOM_STORED]) || number[VVI_DICOM_STORED] < 1 || number[VVI_DICOM_STORED] > bits)
        number[VVI_DICOM_STORED] = bits;
    const double stored = number[VVI_DICOM_STORED];
    if (isnan(number[VVI_DICOM_HIGH]) || number[VVI_DICOM_HIGH] + 1 < stored || number[VVI_DICOM_HIGH] >= bits)
        number[VVI_DICOM_HIGH] = stored - 1;
    const bool negative = number[VVI_DICOM_SIGNED] == 1;
    const vv_type types[2][4] = {{VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_U32, VV_TYPE_U64},
                                 {VV_TYPE_I8, VV_TYPE_I16, VV_TYPE_I32, VV_TYPE_I64}};
    image->type = bits == 1 ? VV_TYPE_U8 : types[negative][bits == 8 ? 0 : bits == 16 ? 1 : bits == 32 ? 2 : 3];
    return VV_OK;
}

static bool is_photometric(const vvi_dicom_image *image, const char *name)
{
    return strcmp(image->text[VVI_DICOM_PHOTOMETRIC], name) == 0;
}

static vv_status find_components(vvi_dicom_image *image, const char *name)
{
    double samples = isnan(image->number[VVI_DICOM_SAMPLES]) ? 1 : image->number[VVI_DICOM_SAMPLES];
    if (samples != 1 && samples != 3)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has %g samples per pixel; 1 and 3 are read", samples);
    image->components = (int)samples;
    if (samples == 3 && image->type != VV_TYPE_U8 && image->type != VV_TYPE_U16)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has colours of type %s; u8 and u16 are read",
                          vv_type_name(image->type));
    if (samples == 3 && image->type != VV_TYPE_U8 && strncmp(image->text[VVI_DICOM_PHOTOMETRIC], "YBR_FULL", 8) == 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has YBR colours of type %s; u8 is read",
                          vv_type_name(image->type));
    if (samples == 3 && is_photometric(image, "YBR_FULL_422") && (int64_t)image->number[VVI_DICOM_COLUMNS] % 2 != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has colours for every second column, but %g columns",
                          image->number[VVI_DICOM_COLUMNS]);
    return VV_OK;
}

uint64_t vvi_dicom_frame_bytes(const vvi_dicom_image *image)
{
    const uint64_t pixels = (uint64_t)image->number[VVI_DICOM_ROWS] * (uint64_t)image->number[VVI_DICOM_COLUMNS];
    if (image->number[VVI_DICOM_ALLOCATED] == 1)
        return pixels;
    if (image->components == 3 && is_photometric(image, "YBR_FULL_422") && image->coding == VVI_DICOM_PLAIN)
        return pixels * 2;
    return pixels * (uint64_t)image->components * vv_type_bytes(image->type);
}

/* How many frames the file can hold, so that none is promised that is not there. */
static vv_status check_frames(vvi_dicom_image *image, const char *name)
{
    const double n = image->number[VVI_DICOM_FRAMES];
    const uint64_t there = image->size > image->pixels.at ? image->size - image->pixels.at : 0;
    image->n_frames = 1;
    if (!isnan(n) && (n < 1 || n > 1e7 || n != floor(n)))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its NumberOfFrames is %g; 1 to 10000000 are possible", n);
    if (n > 1)
        image->n_frames = (int64_t)n;
    uint64_t least = vvi_dicom_frame_bytes(image);
    if (image->number[VVI_DICOM_ALLOCATED] == 1)
        least = (least + 7) / 8;
    /* Of packed ones, the 8 bytes in front of each and a few of its own; even flat pictures pack to no less than this.
     */
    const bool packed = image->coding != VVI_DICOM_PLAIN;
    if (packed)
        least = 10 + least / 20000;
    const uint64_t need = least * (uint64_t)image->n_frames;
    if (there < (packed ? need : need - need / 2))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "ends after %llu bytes; %llu were expected for pixels; the file is cut short or its header "
                          "wrong",
                          (unsigned long long)image->size, (unsigned long long)(image->pixels.at + need));
    return VV_OK;
}

/* One frame that stands for all: how many there are, and of what size, is known when their contours are. */
static vv_status describe_drawn(vvi_dicom_image *image)
{
    image->number[VVI_DICOM_ROWS] = image->number[VVI_DICOM_COLUMNS] = 0;
    image->number[VVI_DICOM_ALLOCATED] = image->number[VVI_DICOM_STORED] = 8;
    image->coding = VVI_DICOM_PLAIN;
    image->type = VV_TYPE_U8;
    image->components = 1;
    image->n_frames = 1;
    return VV_OK;
}

static vv_status check_image(vvi_dicom_image *image, const char *name)
{
    double n;
    vv_status st = VV_OK;
    if (vvi_dicom_is_structure_set(image))
        return describe_drawn(image);
    if (image->pixels.tag == 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "holds no pixels: it is another kind of DICOM file (%s)",
                          image->text[VVI_DICOM_MODALITY][0] ? image->text[VVI_DICOM_MODALITY] : "no modality");
    if (image->coding == VVI_DICOM_UNKNOWN)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "has the transfer syntax %.64s, which is not read; decompress it with the program that made "
                          "it",
                          image->text[VVI_DICOM_SYNTAX]);
    if ((st = count_of(&n, image, VVI_DICOM_ROWS, 1, 65535, "number of rows", name)) != VV_OK ||
        (st = count_of(&n, image, VVI_DICOM_COLUMNS, 1, 65535, "number of columns", name)) != VV_OK ||
        (st = find_type(image, name)) != VV_OK || (st = find_components(image, name)) != VV_OK)
        return st;
    const bool packed = image->pixels.length == VVI_DICOM_UNDEFINED;
    if (packed != (image->coding != VVI_DICOM_PLAIN))
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          packed ? "has fragmented pixel data, which its transfer syntax forbids"
                                 : "has plain pixel data, which its transfer syntax forbids");
    if (packed && image->type != VV_TYPE_U8 && image->type != VV_TYPE_I8 && vv_type_bytes(image->type) > 4)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has packed samples of type %s", vv_type_name(image->type));
    return check_frames(image, name);
}

static uint64_t least_of(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

/* `inflater`: there may be more than the stream shows, whose size is not known then. */
static vv_status walk_image(vvi_dicom_image *out, vvi_dicom_stream *s, vvi_dicom_inflater *inflater)
{
    vv_status st = vvi_dicom_walk(s, &out->pixels, visit, out);
    const bool plain = out->pixels.tag && out->pixels.length != VVI_DICOM_UNDEFINED;
    if (inflater && (st == VV_OK || st == VV_E_FORMAT) && !out->pixels.tag && !vvi_dicom_inflated_all(inflater))
        return vv_fail_at(
            VV_E_LIMIT, vvi_source_name(s->source), NULL,
            "its deflated elements do not come to pixels within %llu bytes; --limit header_bytes=N allows "
            "more",
            (unsigned long long)vvi_job_limits(s->job)->header_bytes);
    if (st == VV_OK && inflater && !vvi_dicom_inflated_all(inflater))
        st = vvi_dicom_inflate_on(&s->size, inflater, out->pixels.at + (plain ? out->pixels.length : 0));
    out->size = s->size;
    /* a plain value that ends before the file does */
    if (st == VV_OK && plain && s->size > out->pixels.at && out->pixels.length < s->size - out->pixels.at)
        out->size = out->pixels.at + out->pixels.length;
    if (st == VV_OK)
        share_values(out);
    if (st == VV_OK)
        st = check_image(out, vvi_source_name(s->source));
    if (st == VV_OK && inflater && out->pixels.tag)
        out->size = least_of(out->size, out->pixels.at + vvi_dicom_frame_bytes(out) * (uint64_t)out->n_frames);
    if (st == VV_OK && out->n_frames > 1 && out->coding != VVI_DICOM_PLAIN)
        st = vvi_dicom_find_frames(out, s);
    return st;
}

static vv_status read_deflated(vvi_dicom_image *out, vv_source *source, uint64_t at, vv_job *job)
{
    vvi_dicom_file file = {0};
    vvi_dicom_stream s = {0};
    vvi_dicom_inflater *inflater;
    vv_status st = vvi_dicom_inflater_new(&inflater, source, at, job);
    if (st == VV_OK)
        st = vvi_dicom_inflate(&file, inflater, vvi_job_limits(job)->header_bytes);
    if (st == VV_OK && (st = vvi_dicom_stream_init(&s, file.source, job)) == VV_OK) {
        if (!vvi_dicom_inflated_all(inflater))
            s.size = INT64_MAX;
        st = walk_image(out, &s, inflater);
    }
    vvi_dicom_stream_finish(&s);
    vvi_dicom_close(&file);
    vvi_dicom_inflater_free(inflater);
    return st;
}

vv_status vvi_dicom_image_read(vvi_dicom_image *out, vv_source *source, vv_job *job)
{
    vvi_dicom_stream s;
    clear_values(&out->values);
    for (size_t i = 0; i < VVI_DICOM_NUMBERS; i++)
        out->number[i] = NAN;
    vv_status st = vvi_dicom_stream_init(&s, source, job);
    if (st == VV_OK)
        st = vvi_dicom_begin(&s, out);
    if (st == VV_OK && strcmp(out->text[VVI_DICOM_SYNTAX], "") != 0 && out->deflated)
        st = read_deflated(out, source, s.at, job);
    else if (st == VV_OK)
        st = walk_image(out, &s, NULL);
    vvi_dicom_stream_finish(&s);
    return st;
}

void vvi_dicom_image_finish(vvi_dicom_image *image)
{
    vvi_free(image->frame);
    vvi_free(image->offset);
    vvi_free(image->fragment);
    vvi_free(image->segment);
    vvi_dicom_structures_free(image->structures);
    free(image->problem);
}
