/* The samples of one frame: where they lie, out of what they are packed in, into the machine's numbers. */
#include "config.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/formats/dicom/dicom_gdcm.h"
#include "io/sample_writer.h"
#include <string.h>

vv_status vvi_dicom_make_room(vvi_dicom_room *room, size_t n, vv_job *job)
{
    if (room->n >= n)
        return VV_OK;
    vvi_free(room->data);
    room->n = 0;
    room->data = vvi_alloc(job, n, VVI_MEM_SCRATCH);
    if (!room->data)
        return vv_fail_memory(n);
    room->n = n;
    return VV_OK;
}

void vvi_dicom_scratch_finish(vvi_dicom_scratch *s)
{
    vvi_free(s->packed.data);
    vvi_free(s->clean.data);
    vvi_free(s->plain.data);
    vvi_free(s->whole.data);
}

/* Pieces of packed frames ---------------------------------------------------------------------------------------- */

typedef struct piece {
    uint64_t at;
    uint32_t length;
} piece;

/* The next piece; length 0 and *end at the end of the pieces or of the file, which may be cut short. */
static vv_status next_piece(piece *out, bool *end, vvi_dicom_stream *s)
{
    uint8_t b[8];
    size_t n;
    *end = true;
    vv_status st = vvi_dicom_bytes(s, s->at, b, sizeof b, &n);
    if (st != VV_OK || n < sizeof b)
        return st;
    const uint32_t length = (uint32_t)b[4] | (uint32_t)b[5] << 8 | (uint32_t)b[6] << 16 | (uint32_t)b[7] << 24;
    if (memcmp(b, "\xfe\xff\x00\xe0", 4) != 0)
        return VV_OK;
    *out = (piece){s->at + 8, length};
    if (out->length > s->size - out->at)
        out->length = (uint32_t)(s->size - out->at);
    s->at = out->at + out->length;
    *end = false;
    return VV_OK;
}

/* A picture begins in this piece: JPEG and JPEG-LS with FF D8, JPEG 2000 with FF 4F or a box. RLE frames are one piece
 * each. */
static vv_status begins_picture(bool *out, const vvi_dicom_image *image, const piece *p, vvi_dicom_stream *s)
{
    uint8_t b[4] = {0};
    size_t n;
    const vv_status st = vvi_dicom_bytes(s, p->at, b, sizeof b, &n);
    *out = image->coding == VVI_DICOM_RLE ||
           (b[0] == 0xff && b[1] == (image->coding == VVI_DICOM_JPEG_2000 ? 0x4f : 0xd8)) ||
           (image->coding == VVI_DICOM_JPEG_2000 && memcmp(b, "\0\0\0\x0c", 4) == 0);
    return st;
}

/* Frames begin where pictures begin: offset tables are missing or wrong too often to be asked. */
vv_status vvi_dicom_find_frames(vvi_dicom_image *image, vvi_dicom_stream *s)
{
    const size_t n = (size_t)image->n_frames;
    piece p;
    bool end;
    size_t found = 0;
    image->fragment = vvi_alloc_zeroed(s->job, (n + 1) * sizeof *image->fragment, VVI_MEM_MODEL);
    if (!image->fragment)
        return vv_fail_memory((n + 1) * sizeof *image->fragment);
    s->at = image->pixels.at;
    vv_status st = next_piece(&p, &end, s); /* the table */
    while (st == VV_OK && !end) {
        const uint64_t at = s->at;
        bool begins;
        if ((st = next_piece(&p, &end, s)) != VV_OK || end || (st = begins_picture(&begins, image, &p, s)) != VV_OK)
            break;
        if (begins && found < n)
            image->fragment[found++] = at;
    }
    if (st == VV_OK && found < n - n / 2)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                        "promises %zu frames, but holds %zu; the file is cut short or its header wrong", n, found);
    for (; st == VV_OK && found <= n; found++)
        image->fragment[found] = s->at;
    return st;
}

/* All pieces of a frame, one behind the other. */
static vv_status gather(vvi_dicom_room *room, size_t *n_out, const vvi_dicom_image *image, int64_t frame,
                        vvi_dicom_stream *s)
{
    piece p;
    bool end = false;
    vv_status st = VV_OK;
    *n_out = 0;
    const uint64_t stop = image->fragment ? image->fragment[frame + 1] : UINT64_MAX;
    s->at = image->fragment ? image->fragment[frame] : image->pixels.at;
    if (!image->fragment)
        st = next_piece(&p, &end, s);
    const uint64_t start = s->at;
    uint64_t total = 0;
    while (st == VV_OK && !end && s->at < stop)
        if ((st = next_piece(&p, &end, s)) == VV_OK && !end)
            total += p.length;
    if (st == VV_OK)
        st = vvi_dicom_make_room(room, (size_t)total + 1, s->job);
    s->at = start;
    end = false;
    while (st == VV_OK && !end && s->at < stop && *n_out < total) {
        if ((st = next_piece(&p, &end, s)) != VV_OK || end)
            break;
        size_t got = 0;
        if ((st = vvi_source_seek(s->source, p.at)) == VV_OK)
            st = vvi_source_read_some(s->source, room->data + *n_out, p.length, &got);
        *n_out += got;
    }
    return st;
}

/* Unpacking ------------------------------------------------------------------------------------------------------ */

static vv_status fail_packed(const vvi_dicom_image *image, int64_t frame, vv_source *source)
{
    static const char *const names[] = {"", "RLE", "JPEG", "JPEG-LS", "JPEG 2000"};
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "the %s picture of frame %lld is damaged",
                      names[image->coding], (long long)frame);
}

/* Decoders trust a picture's own size: it is compared with the image's before they see it. */
static bool picture_fits(const vvi_dicom_image *image, const vvi_dicom_picture *p)
{
    const uint32_t allocated = (uint32_t)image->number[VVI_DICOM_ALLOCATED];
    return p->columns == (uint32_t)image->number[VVI_DICOM_COLUMNS] &&
           p->rows == (uint32_t)image->number[VVI_DICOM_ROWS] && p->components == (uint32_t)image->components &&
           p->bits >= 2 && p->bits <= allocated && (image->coding == VVI_DICOM_JPEG_LS) == (p->process == 0xf7) &&
           (allocated == 8 || p->bits > 8 || image->coding != VVI_DICOM_JPEG || p->process == VVI_DICOM_LOSSLESS);
}

#if VV_HAVE_GDCM
/* GDCM stops the process on others, and on grey ones that are said to be colours. */
static const char *photometric(const vvi_dicom_image *image)
{
    static const char *const colours[] = {"RGB", "YBR_FULL", "YBR_FULL_422", "YBR_RCT", "YBR_ICT"};
    for (size_t i = 0; i < sizeof colours / sizeof *colours && image->components == 3; i++)
        if (strcmp(image->text[VVI_DICOM_PHOTOMETRIC], colours[i]) == 0)
            return colours[i];
    return image->components == 3 ? "RGB" : "MONOCHROME2";
}

static bool unpack_by_gdcm(uint8_t *out, size_t n_out, const vvi_dicom_image *image, const vvi_dicom_picture *picture,
                           const uint8_t *in, size_t n_in, bool *planar, bool *ybr)
{
    static const vvi_gdcm_codec codecs[] = {[VVI_DICOM_JPEG] = VVI_GDCM_JPEG,
                                            [VVI_DICOM_JPEG_LS] = VVI_GDCM_JPEG_LS,
                                            [VVI_DICOM_JPEG_2000] = VVI_GDCM_JPEG_2000};
    vvi_gdcm_picture p = {.codec = codecs[image->coding],
                          .syntax = image->text[VVI_DICOM_SYNTAX],
                          .columns = picture->columns,
                          .rows = picture->rows,
                          .components = picture->components,
                          .allocated = (unsigned)image->number[VVI_DICOM_ALLOCATED],
                          .stored = picture->bits,
                          .is_signed = image->number[VVI_DICOM_SIGNED] == 1,
                          .photometric = photometric(image)};
    if (picture->bits > 8 && picture->bits <= 12) /* so it asks its decoder of 12 bits first */
        p.allocated = 12;
    const vvi_gdcm *gdcm = vvi_gdcm_load(); /* was there when the file was opened, unless its header lied */
    const bool done = gdcm && gdcm->unpack(&p, out, n_out, in, n_in);
    *planar = p.planar && image->components > 1;
    *ybr = p.ybr && image->components == 3;
    return done;
}
#else
static bool unpack_by_gdcm(uint8_t *out, size_t n_out, const vvi_dicom_image *image, const vvi_dicom_picture *picture,
                           const uint8_t *in, size_t n_in, bool *planar, bool *ybr)
{
    return false; /* was said when the file was opened */
}
#endif

static vv_status unpack_picture(uint8_t *out, size_t n_out, const vvi_dicom_image *image, int64_t frame,
                                vvi_dicom_scratch *scratch, size_t n_in, bool *planar, bool *ybr, vv_source *source,
                                vv_job *job)
{
    vvi_dicom_picture p;
    const uint8_t *in = scratch->packed.data;
    if (image->coding == VVI_DICOM_JPEG_2000) {
        if (!vvi_dicom_size_of_jpeg_2000(&p, in, n_in))
            return fail_packed(image, frame, source);
    } else {
        vv_status st = vvi_dicom_make_room(&scratch->clean, n_in + 1, job);
        if (st != VV_OK)
            return st;
        n_in = vvi_dicom_clean_jpeg(scratch->clean.data, &p, in, n_in);
        in = scratch->clean.data;
    }
    if (n_in == 0 || !picture_fits(image, &p))
        return fail_packed(image, frame, source);
    *ybr = false;
    if (p.process != VVI_DICOM_LOSSLESS)
        return unpack_by_gdcm(out, n_out, image, &p, in, n_in, planar, ybr) ? VV_OK : fail_packed(image, frame, source);
    vv_status st = vvi_dicom_make_room(&scratch->plain, (size_t)p.columns * p.components * 4, job);
    if (st != VV_OK)
        return st;
    *ybr = strncmp(image->text[VVI_DICOM_PHOTOMETRIC], "YBR_FULL", 8) == 0;
    return vvi_dicom_unpack_lossless(out, vv_type_bytes(image->type), &p, scratch->plain.data, in, n_in)
               ? VV_OK
               : fail_packed(image, frame, source);
}

/* Machine's order for what came out little-endian. */
static void to_machine(uint8_t *data, size_t bytes, size_t n, bool big_endian)
{
    if (bytes > 1 && vvi_order_swapped(big_endian))
        vvi_swap_bytes(data, bytes, n);
}

static vv_status unpack(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_source *source,
                        vvi_dicom_scratch *scratch, bool *planar, bool *ybr, vv_job *job)
{
    vvi_dicom_stream s;
    size_t n_in = 0;
    vv_status st = vvi_dicom_stream_init(&s, source, job);
    if (st == VV_OK)
        st = gather(&scratch->packed, &n_in, image, frame, &s);
    vvi_dicom_stream_finish(&s);
    if (st != VV_OK)
        return st;
    const size_t bytes = vv_type_bytes(image->type), n_out = (size_t)vvi_dicom_frame_bytes(image);
    const size_t n = n_out / bytes / (size_t)image->components;
    if (image->coding != VVI_DICOM_RLE) {
        st = unpack_picture(out, n_out, image, frame, scratch, n_in, planar, ybr, source, job);
    } else {
        *ybr = image->components == 3 && strcmp(image->text[VVI_DICOM_PHOTOMETRIC], "YBR_FULL") == 0;
        if (!vvi_dicom_unpack_rle(out, n, image->components, bytes, scratch->packed.data, n_in))
            st = fail_packed(image, frame, source);
    }
    if (st == VV_OK)
        to_machine(out, bytes, n * (size_t)image->components, false);
    return st;
}

/* Plain samples -------------------------------------------------------------------------------------------------- */

static vv_status read_plain(uint8_t *out, size_t n, uint64_t at, vv_source *source, const vvi_dicom_image *image,
                            size_t *n_missing)
{
    size_t got = 0;
    const uint64_t there = at < image->size ? image->size - at : 0;
    const size_t want = there < n ? (size_t)there : n;
    vv_status st = vvi_source_seek(source, at);
    if (st == VV_OK && want > 0)
        st = vvi_source_read_whole(source, out, want, &got);
    memset(out + got, 0, n - got);
    *n_missing = n - got;
    return st;
}

/* Bits go on from frame to frame without a gap, the least significant first. */
static vv_status read_bits(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_source *source,
                           vvi_dicom_scratch *scratch, size_t *n_missing, vv_job *job)
{
    const uint64_t n = vvi_dicom_frame_bytes(image), first = (uint64_t)frame * n;
    const size_t bytes = (size_t)((first + n + 7) / 8 - first / 8);
    vv_status st = vvi_dicom_make_room(&scratch->plain, bytes, job);
    if (st == VV_OK)
        st = read_plain(scratch->plain.data, bytes, image->pixels.at + first / 8, source, image, n_missing);
    *n_missing *= 8;
    for (uint64_t i = 0; st == VV_OK && i < n; i++) {
        const uint64_t bit = first % 8 + i;
        out[i] = scratch->plain.data[bit / 8] >> bit % 8 & 1;
    }
    return st;
}

static vv_status plain(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_source *source,
                       vvi_dicom_scratch *scratch, size_t *n_missing, vv_job *job)
{
    const size_t bytes = vv_type_bytes(image->type), n = (size_t)vvi_dicom_frame_bytes(image);
    const bool half_colours = image->components == 3 && strcmp(image->text[VVI_DICOM_PHOTOMETRIC], "YBR_FULL_422") == 0;
    uint8_t *to = out;
    if (image->number[VVI_DICOM_ALLOCATED] == 1)
        return read_bits(out, image, frame, source, scratch, n_missing, job);
    if (half_colours) {
        vv_status st = vvi_dicom_make_room(&scratch->plain, n, job);
        if (st != VV_OK)
            return st;
        to = scratch->plain.data;
    }
    vv_status st = read_plain(to, n, image->pixels.at + (uint64_t)frame * n, source, image, n_missing);
    /* bytes in 16-bit words of the file's order */
    if (image->big && bytes == 1 && image->pixels.vr == VVI_DICOM_VR('O', 'W'))
        vvi_swap_bytes(to, 2, n / 2);
    to_machine(to, bytes, n / bytes, image->big);
    if (st == VV_OK && half_colours)
        vvi_dicom_ybr422_to_rgb(out, to, n / 2);
    return st;
}

#define MASK(U, S)                                                                                                     \
    do {                                                                                                               \
        U *v = (U *)(void *)data;                                                                                      \
        for (size_t i = 0; i < n; i++) {                                                                               \
            const U up = (U)((U)v[i] << left);                                                                         \
            v[i] = negative ? (U)((S)up >> right) : (U)(up >> right);                                                  \
        }                                                                                                              \
    } while (0)

/* Bits that belong to the sample, out of those that it has room for; others may hold an overlay of old. */
static void mask_bits(uint8_t *data, size_t n, const vvi_dicom_image *image)
{
    const int allocated = (int)image->number[VVI_DICOM_ALLOCATED], stored = (int)image->number[VVI_DICOM_STORED];
    const int left = allocated - 1 - (int)image->number[VVI_DICOM_HIGH], right = allocated - stored;
    const bool negative = image->number[VVI_DICOM_SIGNED] == 1;
    if (right <= 0 || allocated == 1)
        return;
    switch (allocated) {
    case 8:
        MASK(uint8_t, int8_t);
        break;
    case 16:
        MASK(uint16_t, int16_t);
        break;
    case 32:
        MASK(uint32_t, int32_t);
        break;
    default:
        MASK(uint64_t, int64_t);
    }
}

static vv_status interleave(uint8_t *out, const vvi_dicom_image *image, vvi_dicom_scratch *scratch, vv_job *job)
{
    const size_t bytes = vv_type_bytes(image->type);
    const size_t n = (size_t)(image->number[VVI_DICOM_ROWS] * image->number[VVI_DICOM_COLUMNS]);
    const size_t all = n * (size_t)image->components * bytes;
    vv_status st = vvi_dicom_make_room(&scratch->plain, all, job);
    if (st != VV_OK)
        return st;
    memcpy(scratch->plain.data, out, all);
    vvi_dicom_interleave(out, scratch->plain.data, n, image->components, bytes);
    return VV_OK;
}

vv_status vvi_dicom_pixels(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_source *source,
                           vvi_dicom_scratch *scratch, size_t *n_missing, vv_job *job)
{
    const size_t n = (size_t)(image->number[VVI_DICOM_ROWS] * image->number[VVI_DICOM_COLUMNS]);
    bool planar = image->components > 1 && image->number[VVI_DICOM_PLANAR] == 1;
    bool ybr = image->components == 3 && strcmp(image->text[VVI_DICOM_PHOTOMETRIC], "YBR_FULL") == 0;
    vv_status st;
    *n_missing = 0;
    if (image->structures)
        return vvi_dicom_draw_frame(out, image, frame, job);
    if (image->coding == VVI_DICOM_PLAIN) {
        st = plain(out, image, frame, source, scratch, n_missing, job);
    } else {
        planar = false;
        st = unpack(out, image, frame, source, scratch, &planar, &ybr, job);
    }
    if (st == VV_OK && planar)
        st = interleave(out, image, scratch, job);
    if (st == VV_OK && ybr)
        vvi_dicom_ybr_to_rgb(out, n);
    if (st == VV_OK && image->components == 1 && !vv_type_is_float(image->type))
        mask_bits(out, n, image);
    return st;
}
