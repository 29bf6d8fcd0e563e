#include "dicoms.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNDEFINED UINT32_MAX

const char *const test_dicom_names[TEST_DICOMS] = {"explicit", "implicit",  "big",     "bare", "enhanced",
                                                   "nested",   "cine",      "dose",    "rle",  "lossless",
                                                   "jpeg_ls",  "jpeg_2000", "baseline"};

typedef struct writer {
    uint8_t *data;
    size_t n;
    bool implicit, big, undefined;
    const test_dicom_change *change;
} writer;

static void put(writer *w, const void *bytes, size_t n)
{
    w->data = realloc(w->data, w->n + n + 1);
    if (!w->data)
        abort();
    memcpy(w->data + w->n, bytes, n);
    w->n += n;
}

static void put_number(writer *w, uint32_t value, int n_bytes)
{
    for (int i = 0; i < n_bytes; i++) {
        const uint8_t byte = (uint8_t)(value >> 8 * (w->big ? n_bytes - 1 - i : i));
        put(w, &byte, 1);
    }
}

static void put_head(writer *w, uint32_t tag, const char *vr, uint32_t length)
{
    put_number(w, tag >> 16, 2);
    put_number(w, tag & 0xffff, 2);
    const bool is_long = strcmp(vr, "OB") == 0 || strcmp(vr, "OW") == 0 || strcmp(vr, "SQ") == 0;
    if (w->implicit || tag >> 16 == 0xfffe) {
        put_number(w, length, 4);
        return;
    }
    put(w, vr, 2);
    if (is_long)
        put_number(w, 0, 2);
    put_number(w, length, is_long ? 4 : 2);
}

static void put_text(writer *w, uint32_t tag, const char *vr, const char *text)
{
    const test_dicom_change *c = w->change && w->change->tag == tag && !w->change->number ? w->change : NULL;
    if (c && !c->value)
        return;
    const char *value = c ? c->value : text;
    const size_t n = strlen(value);
    put_head(w, tag, vr, (uint32_t)(n + n % 2));
    put(w, value, n);
    if (n % 2)
        put(w, strcmp(vr, "UI") == 0 ? "" : " ", 1);
}

static void put_short(writer *w, uint32_t tag, uint32_t value)
{
    const test_dicom_change *c = w->change && w->change->tag == tag ? w->change : NULL;
    if (c && !c->value)
        return;
    put_head(w, tag, "US", 2);
    put_number(w, c ? (uint32_t)strtoul(c->value, NULL, 10) : value, 2);
}

/* Sequences are written behind what is in them: their length is known then. */
static void put_sequence(writer *w, uint32_t tag, const writer *inside)
{
    put_head(w, tag, "SQ", w->undefined ? UNDEFINED : (uint32_t)inside->n);
    put(w, inside->data, inside->n);
    if (w->undefined)
        put_head(w, 0xfffee0dd, "", 0);
    free(inside->data);
}

static void put_item(writer *w, const writer *inside)
{
    put_head(w, 0xfffee000, "", w->undefined ? UNDEFINED : (uint32_t)inside->n);
    put(w, inside->data, inside->n);
    if (w->undefined)
        put_head(w, 0xfffee00d, "", 0);
    free(inside->data);
}

static writer inner(const writer *w)
{
    return (writer){.implicit = w->implicit, .big = w->big, .undefined = w->undefined, .change = w->change};
}

/* An item that holds a sequence of one item of one text. */
static writer group(const writer *w, uint32_t sequence, uint32_t tag, const char *text)
{
    writer element = inner(w), item = inner(w), whole = inner(w);
    put_text(&element, tag, "DS", text);
    put_item(&item, &element);
    put_sequence(&whole, sequence, &item);
    return whole;
}

static void put_groups(writer *w)
{
    writer shared = inner(w), frames = inner(w);
    writer place = group(w, 0x00209116, 0x00200037, "1\\0\\0\\0\\1\\0");
    put_item(&shared, &place);
    put_sequence(w, 0x52009229, &shared);
    for (int k = 0; k < 2; k++) {
        writer at = group(w, 0x00209113, 0x00200032, k ? "1\\2\\5" : "1\\2\\3");
        put_item(&frames, &at);
    }
    put_sequence(w, 0x52009230, &frames);
}

static const uint8_t lossless[] = {
    0xff, 0xd8, 0xff, 0xc3, 0x00, 0x0b, 0x08, 0x00, 0x08, 0x00, 0x08, 0x01, 0x01, 0x11, 0x00, 0xff, 0xc4, 0x00, 0x15,
    0x00, 0x01, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0x08,
    0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x01, 0x00, 0x00, 0x9f, 0xd2, 0x94, 0xa5, 0x29, 0x4a, 0x52, 0x94, 0xa5,
    0x29, 0x4a, 0x52, 0x94, 0xa5, 0x29, 0x4a, 0x52, 0x94, 0xa5, 0x29, 0x4a, 0x52, 0x94, 0xa5, 0x29, 0x4a, 0x52, 0x94,
    0xa5, 0x29, 0x4a, 0x52, 0x94, 0xa5, 0x29, 0x4a, 0x52, 0x94, 0xa5, 0x29, 0x4f, 0xff, 0xd9, 0x00};
static const uint8_t jpeg_ls[] = {0xff, 0xd8, 0xff, 0xf7, 0x00, 0x0b, 0x08, 0x00, 0x08, 0x00, 0x08, 0x01,
                                  0x01, 0x11, 0x00, 0xff, 0xda, 0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x00,
                                  0x00, 0x82, 0x85, 0x78, 0x57, 0xb5, 0x61, 0x83, 0x10, 0xe6, 0x29, 0x01,
                                  0xbb, 0xb3, 0x33, 0x28, 0x8a, 0xdb, 0x6d, 0x9d, 0xb6, 0xda, 0x46, 0x49,
                                  0x24, 0x91, 0x55, 0x55, 0x22, 0xaa, 0xae, 0xff, 0xd9, 0x00};
static const uint8_t jpeg_2000[] = {
    0xff, 0x4f, 0xff, 0x51, 0x00, 0x29, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x08, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x01, 0x07, 0x01, 0x01, 0xff, 0x52, 0x00, 0x0c, 0x00, 0x00, 0x00, 0x01, 0x00,
    0x00, 0x04, 0x04, 0x00, 0x01, 0xff, 0x5c, 0x00, 0x04, 0x40, 0x40, 0xff, 0x90, 0x00, 0x0a, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x46, 0x00, 0x01, 0xff, 0x93, 0xdf, 0x81, 0xa8, 0x12, 0x2b, 0x67, 0x11, 0x8d, 0x7d, 0x77, 0x08,
    0x60, 0xc2, 0x3a, 0xa8, 0xd5, 0x55, 0x29, 0xbc, 0x68, 0x43, 0x8a, 0xdc, 0xf8, 0x66, 0x2d, 0x7f, 0xd1, 0x5d,
    0x41, 0xe5, 0xd6, 0xcc, 0xd6, 0x7d, 0x36, 0xd9, 0xea, 0x9d, 0x2b, 0x93, 0x98, 0x2a, 0xe3, 0x6c, 0x4b, 0x5c,
    0x27, 0xe9, 0x48, 0x9c, 0x44, 0xe2, 0x27, 0x11, 0x38, 0xff, 0xd9, 0x00};
static const uint8_t baseline[] = {
    0xff, 0xd8, 0xff, 0xdb, 0x00, 0x43, 0x00, 0x1b, 0x12, 0x14, 0x17, 0x14, 0x11, 0x1b, 0x17, 0x16, 0x17, 0x1e, 0x1c,
    0x1b, 0x20, 0x28, 0x42, 0x2b, 0x28, 0x25, 0x25, 0x28, 0x51, 0x3a, 0x3d, 0x30, 0x42, 0x60, 0x55, 0x65, 0x64, 0x5f,
    0x55, 0x5d, 0x5b, 0x6a, 0x78, 0x99, 0x81, 0x6a, 0x71, 0x90, 0x73, 0x5b, 0x5d, 0x85, 0xb5, 0x86, 0x90, 0x9e, 0xa3,
    0xab, 0xad, 0xab, 0x67, 0x80, 0xbc, 0xc9, 0xba, 0xa6, 0xc7, 0x99, 0xa8, 0xab, 0xa4, 0xff, 0xc0, 0x00, 0x0b, 0x08,
    0x00, 0x08, 0x00, 0x08, 0x01, 0x01, 0x11, 0x00, 0xff, 0xc4, 0x00, 0x14, 0x00, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x05, 0xff, 0xc4, 0x00, 0x17, 0x10, 0x01, 0x00, 0x03,
    0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x04, 0x00, 0x21, 0x31, 0xff, 0xda,
    0x00, 0x08, 0x01, 0x01, 0x00, 0x00, 0x3f, 0x00, 0x30, 0xc7, 0xca, 0x9f, 0xff, 0xd9};

static void put_pieces(writer *w, const uint8_t *picture, size_t n)
{
    put_head(w, 0x7fe00010, "OB", UNDEFINED);
    put_head(w, 0xfffee000, "", 0);
    put_head(w, 0xfffee000, "", (uint32_t)n);
    put(w, picture, n);
    put_head(w, 0xfffee0dd, "", 0);
}

static void put_rle(writer *w)
{
    uint8_t bytes[64 + 72] = {1, 0, 0, 0, 64};
    size_t n = 64;
    for (int j = 0; j < 8; j++) {
        bytes[n++] = 7; /* eight as they are */
        for (int i = 0; i < 8; i++)
            bytes[n++] = (uint8_t)(9 * (i + j));
    }
    put_pieces(w, bytes, n);
}

static void put_samples(writer *w, int frames)
{
    put_head(w, 0x7fe00010, "OW", (uint32_t)(64 * frames));
    for (int k = 0; k < frames; k++)
        for (int i = 0; i < 64; i += 2) /* bytes in words of the file's order */
            put_number(w, (uint32_t)(9 * (i % 8 + i / 8)) | (uint32_t)(9 * (i % 8 + 1 + i / 8)) << 8, 2);
}

static void put_pixels(writer *w, test_dicom kind, int frames)
{
    switch (kind) {
    case TEST_DICOM_RLE:
        put_rle(w);
        break;
    case TEST_DICOM_LOSSLESS:
        put_pieces(w, lossless, sizeof lossless);
        break;
    case TEST_DICOM_JPEG_LS:
        put_pieces(w, jpeg_ls, sizeof jpeg_ls);
        break;
    case TEST_DICOM_JPEG_2000:
        put_pieces(w, jpeg_2000, sizeof jpeg_2000);
        break;
    case TEST_DICOM_BASELINE:
        put_pieces(w, baseline, sizeof baseline);
        break;
    default:
        put_samples(w, frames);
    }
}

static const char *syntax_of(test_dicom kind)
{
    switch (kind) {
    case TEST_DICOM_IMPLICIT:
        return "1.2.840.10008.1.2";
    case TEST_DICOM_BIG:
        return "1.2.840.10008.1.2.2";
    case TEST_DICOM_RLE:
        return "1.2.840.10008.1.2.5";
    case TEST_DICOM_LOSSLESS:
        return "1.2.840.10008.1.2.4.70";
    case TEST_DICOM_JPEG_LS:
        return "1.2.840.10008.1.2.4.80";
    case TEST_DICOM_JPEG_2000:
        return "1.2.840.10008.1.2.4.90";
    case TEST_DICOM_BASELINE:
        return "1.2.840.10008.1.2.4.50";
    default:
        return "1.2.840.10008.1.2.1";
    }
}

static void put_image(writer *w, test_dicom kind, int frames)
{
    const bool grouped = kind == TEST_DICOM_ENHANCED || kind == TEST_DICOM_NESTED;
    const bool placed = !grouped && kind != TEST_DICOM_CINE;
    put_text(w, 0x00080016, "UI", "1.2");
    put_text(w, 0x00080018, "UI", "1.2.3");
    put_text(w, 0x00080060, "CS", "OT");
    if (kind == TEST_DICOM_CINE)
        put_text(w, 0x00181063, "DS", "40");
    put_text(w, 0x0020000e, "UI", "1.2.4");
    put_text(w, 0x00200013, "IS", "1");
    if (placed) {
        put_text(w, 0x00200032, "DS", "1\\2\\3");
        put_text(w, 0x00200037, "DS", "1\\0\\0\\0\\1\\0");
    }
    put_short(w, 0x00280002, 1);
    put_text(w, 0x00280004, "CS", "MONOCHROME2");
    if (frames > 1)
        put_text(w, 0x00280008, "IS", "2");
    put_short(w, 0x00280010, 8);
    put_short(w, 0x00280011, 8);
    put_text(w, 0x00280030, "DS", "0.5\\0.75");
    put_short(w, 0x00280100, 8);
    put_short(w, 0x00280101, 8);
    put_short(w, 0x00280102, 7);
    put_short(w, 0x00280103, 0);
    if (kind == TEST_DICOM_DOSE)
        put_text(w, 0x3004000c, "DS", "0\\2");
    if (grouped)
        put_groups(w);
    put_pixels(w, kind, frames);
}

uint8_t *test_dicom_make(test_dicom kind, const test_dicom_change *change, size_t *n_out)
{
    writer w = {.undefined = kind == TEST_DICOM_NESTED, .change = change};
    const bool several =
        kind == TEST_DICOM_ENHANCED || kind == TEST_DICOM_NESTED || kind == TEST_DICOM_CINE || kind == TEST_DICOM_DOSE;
    if (kind != TEST_DICOM_BARE) {
        const uint8_t preamble[128] = {0};
        put(&w, preamble, sizeof preamble);
        put(&w, "DICM", 4);
        put_text(&w, 0x00020010, "UI", syntax_of(kind));
    }
    w.implicit = kind == TEST_DICOM_IMPLICIT || kind == TEST_DICOM_BARE;
    w.big = kind == TEST_DICOM_BIG;
    put_image(&w, kind, several ? 2 : 1);
    *n_out = w.n;
    return w.data;
}
