/* How a DICOM file begins, and how its elements are written. */
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include <string.h>

/* The beginning of a file ---------------------------------------------------------------------------------------- */

static uint16_t u16(const uint8_t *b, bool big)
{
    return (uint16_t)(big ? b[0] << 8 | b[1] : b[1] << 8 | b[0]);
}

static bool is_vr(const uint8_t *b)
{
    static const uint8_t names[] = "AEASATCSDADSDTFLFDISLOLTOBODOFOLOVOWPNSHSLSQSSSTSVTMUCUIULUNURUSUTUV";
    for (size_t i = 0; i + 1 < sizeof names; i += 2)
        if (b[0] == names[i] && b[1] == names[i + 1])
            return true;
    return false;
}

/* Whether three elements in a row could be the first of a file: growing tags of the first groups, known
 * representations, short values. */
static bool begins_with_elements(const uint8_t *head, size_t n)
{
    const bool big = n >= 2 && head[0] == 0;
    uint32_t last = 0;
    size_t at = 0;
    for (int i = 0; i < 3; i++) {
        if (n < 12 || at > n - 12)
            return i > 1;
        const uint8_t *b = head + at;
        const uint32_t tag = (uint32_t)u16(b, big) << 16 | u16(b + 2, big);
        const bool explicit = is_vr(b + 4);
        const uint64_t length =
            explicit ? u16(b + 6, big) : (uint64_t)u16(b + 4, big) | (uint64_t)u16(b + 6, big) << 16;
        const uint32_t group = tag >> 16;
        if ((group != 2 && group != 8) || (i > 0 && tag <= last) || (i == 0 && (tag & 0xffff) > 0x20) ||
            length > 1024 || length % 2 != 0 || (big && !explicit))
            return false;
        last = tag;
        at += 8 + (size_t)length;
        if (explicit && memcmp(b + 4, "OB", 2) == 0)
            at += 4 + u16(b + 8, big);
    }
    return true;
}

int vvi_dicom_probe(const uint8_t *head, size_t n)
{
    if (n >= 132 && memcmp(head + 128, "DICM", 4) == 0)
        return 2;
    return begins_with_elements(head, n) ? 2 : 0;
}

typedef struct syntax {
    const char *uid;
    bool implicit, big, deflated;
    vvi_dicom_coding coding;
} syntax;

#define UID "1.2.840.10008.1.2"
static const syntax syntaxes[] = {
    {UID, true, false, false, VVI_DICOM_PLAIN},
    {UID ".1", false, false, false, VVI_DICOM_PLAIN},
    {UID ".1.99", false, false, true, VVI_DICOM_PLAIN},
    {UID ".2", false, true, false, VVI_DICOM_PLAIN},
    {UID ".4.50", false, false, false, VVI_DICOM_JPEG},
    {UID ".4.51", false, false, false, VVI_DICOM_JPEG},
    {UID ".4.57", false, false, false, VVI_DICOM_JPEG},
    {UID ".4.70", false, false, false, VVI_DICOM_JPEG},
    {UID ".4.80", false, false, false, VVI_DICOM_JPEG_LS},
    {UID ".4.81", false, false, false, VVI_DICOM_JPEG_LS},
    {UID ".4.90", false, false, false, VVI_DICOM_JPEG_2000},
    {UID ".4.91", false, false, false, VVI_DICOM_JPEG_2000},
    {UID ".5", false, false, false, VVI_DICOM_RLE},
    {"1.2.840.113619.5.2", true, false, false, VVI_DICOM_PLAIN}, /* of GE: only its pixel data is big-endian */
};

static void use_syntax(vvi_dicom_image *image, vvi_dicom_stream *s)
{
    const char *uid = image->text[VVI_DICOM_SYNTAX];
    image->coding = VVI_DICOM_UNKNOWN;
    s->implicit = s->big = false;
    for (size_t i = 0; i < sizeof syntaxes / sizeof *syntaxes; i++)
        if (strcmp(uid, syntaxes[i].uid) == 0) {
            image->coding = syntaxes[i].coding;
            image->deflated = syntaxes[i].deflated;
            image->big = syntaxes[i].big || i == sizeof syntaxes / sizeof *syntaxes - 1;
            s->implicit = syntaxes[i].implicit;
            s->big = syntaxes[i].big;
        }
}

/* The meta group is always little-endian and explicit. */
static vv_status read_meta(vvi_dicom_image *image, vvi_dicom_stream *s)
{
    uint8_t b[4];
    size_t n;
    vv_status st = VV_OK;
    while (st == VV_OK) {
        vvi_dicom_element e;
        if ((st = vvi_dicom_bytes(s, s->at, b, sizeof b, &n)) != VV_OK || n < 4 || u16(b, false) != 2)
            return st;
        if ((st = vvi_dicom_next(s, &e)) != VV_OK)
            return st;
        if (e.length == VVI_DICOM_UNDEFINED)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                              "has an element without a length at byte %llu of its meta group; its header is damaged",
                              (unsigned long long)e.at);
        if (e.tag == 0x00020010)
            st = vvi_dicom_value(s, &e, image->text[VVI_DICOM_SYNTAX], VVI_DICOM_TEXT_BYTES);
        s->at = e.at + e.length;
    }
    return st;
}

/* Files that say one thing and do the other: how the first element is written decides. */
static vv_status look_at_elements(vvi_dicom_image *image, vvi_dicom_stream *s)
{
    uint8_t b[8];
    size_t n;
    vv_status st = vvi_dicom_bytes(s, s->at, b, sizeof b, &n);
    if (st != VV_OK || n < sizeof b || image->deflated)
        return st;
    if (!image->text[VVI_DICOM_SYNTAX][0]) {
        image->coding = VVI_DICOM_PLAIN;
        image->big = s->big = b[0] == 0 && b[1] != 0;
    }
    s->implicit = !is_vr(b + 4);
    return VV_OK;
}

vv_status vvi_dicom_begin(vvi_dicom_stream *s, vvi_dicom_image *image)
{
    uint8_t head[132];
    size_t n;
    vv_status st = vvi_dicom_bytes(s, 0, head, sizeof head, &n);
    if (st != VV_OK)
        return st;
    s->at = n == sizeof head && memcmp(head + 128, "DICM", 4) == 0 ? sizeof head : 0;
    s->implicit = s->big = false;
    if ((st = read_meta(image, s)) != VV_OK)
        return st;
    use_syntax(image, s);
    return look_at_elements(image, s);
}

/* Opening an image again ----------------------------------------------------------------------------------------- */

static void keep_source(vvi_dicom_file *file, vv_source *opened)
{
    if (!file->source) {
        file->source = opened;
        file->owned = opened != NULL;
    } else {
        vvi_source_close(opened);
    }
}

vv_status vvi_dicom_open(vvi_dicom_file *out, const vvi_dicom_image *image, vv_source *source, vv_job *job)
{
    vv_source *opened = NULL;
    *out = (vvi_dicom_file){0};
    if (image->structures)
        return VV_OK; /* its contours are in memory */
    vv_status st = image->name ? vvi_source_open_beside(&opened, source, image->name, job)
                               : vvi_source_section(&opened, source, 0, UINT64_MAX, VVI_CODING_NONE, job);
    if (st == VV_OK && image->deflated) {
        vvi_dicom_image again = {0};
        vvi_dicom_stream s;
        vvi_dicom_inflater *inflater = NULL;
        if ((st = vvi_dicom_stream_init(&s, opened, job)) == VV_OK && (st = vvi_dicom_begin(&s, &again)) == VV_OK &&
            (st = vvi_dicom_inflater_new(&inflater, opened, s.at, job)) == VV_OK)
            st = vvi_dicom_inflate(out, inflater, image->size);
        vvi_dicom_inflater_free(inflater);
        vvi_dicom_stream_finish(&s);
    }
    keep_source(out, opened);
    if (st != VV_OK)
        vvi_dicom_close(out);
    return st;
}

void vvi_dicom_close(vvi_dicom_file *file)
{
    if (file->owned)
        vvi_source_close(file->source);
    vvi_free(file->inflated);
    *file = (vvi_dicom_file){0};
}
