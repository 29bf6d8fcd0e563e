/* Writing .npz: a ZIP archive of one .npy file, in one go. Its CRC-32 and its sizes are known only behind it, so they
 * stand there (a data descriptor) and in the directory, which is what readers take them from. Sizes of 4 GiB and more
 * have 64 bits, as NumPy's own archives. ZIP: https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT */
#include "core/text.h"
#include "grid/crc.h"
#include "grid/field.h"
#include "io/formats/npy/npy.h"
#include "io/sample_writer.h"
#include <stdio.h>
#include <string.h>

const char *const vvi_npz_encodings[] = {"deflate", "raw", NULL};

enum {
    LOCAL = 30,       /* bytes of a local header */
    BIG_EXTRA = 20,   /* of 64-bit sizes in it */
    BIG = 0x10000000, /* a quarter of the 32 bits is for what deflate may add to samples that it cannot pack */
    HAS_DESCRIPTOR = 1 << 3,
    IS_UTF8 = 1 << 11,
    DATE = 1 << 5 | 1 /* 1980-01-01, the first there is: the same volume makes the same bytes */
};

typedef struct archive {
    vv_sink *sink;
    char name[80]; /* of the .npy file */
    bool deflate, big;
    uint32_t crc;
    uint64_t bytes, packed_bytes; /* of the .npy file */
    uint64_t written;             /* of the archive, so far */
    bool fold, swap;
    size_t element_bytes;
} archive;

/* Little-endian numbers, one after the other. */
static uint8_t *put(uint8_t *at, uint64_t v, int n)
{
    for (int i = 0; i < n; i++, v >>= 8)
        *at++ = (uint8_t)v;
    return at;
}

static vv_status write_plain(archive *a, const void *data, size_t n)
{
    a->written += n;
    return vvi_sink_write(a->sink, data, n);
}

/* Archives that are unpacked make files of these names: they stay in the folder. */
static void name_array(archive *a, const char *name)
{
    snprintf(a->name, sizeof a->name, "%.63s.npy", name[0] ? name : "data");
    for (char *c = a->name; *c; c++)
        if (*c == '/' || *c == '\\' || *c == ':' || *c == ',')
            *c = '_';
    vvi_text_clean(a->name);
}

static int flags(const archive *a)
{
    int out = HAS_DESCRIPTOR;
    for (const char *c = a->name; *c; c++)
        out |= (unsigned char)*c > 127 ? IS_UTF8 : 0;
    return out;
}

/* What both headers of an array have in common. */
static uint8_t *put_kind(uint8_t *at, const archive *a)
{
    at = put(at, a->big ? 45 : 20, 2); /* the version that is needed to unpack it */
    at = put(at, (uint64_t)flags(a), 2);
    at = put(at, a->deflate ? 8 : 0, 2);
    at = put(at, 0, 2);
    return put(at, DATE, 2);
}

static vv_status write_local(archive *a)
{
    uint8_t head[LOCAL + sizeof a->name + BIG_EXTRA], *at = head;
    const size_t n_name = strlen(a->name);
    at = put(at, 0x04034b50, 4);
    at = put_kind(at, a);
    at = put(at, 0, 4);
    at = put(at, a->big ? UINT32_MAX : 0, 4);
    at = put(at, a->big ? UINT32_MAX : 0, 4);
    at = put(at, n_name, 2);
    at = put(at, a->big ? BIG_EXTRA : 0, 2);
    memcpy(at, a->name, n_name);
    at += n_name;
    if (a->big)
        at = put(put(put(put(at, 1, 2), 16, 2), 0, 8), 0, 8);
    return write_plain(a, head, (size_t)(at - head));
}

static vv_status write_descriptor(archive *a)
{
    uint8_t d[24], *at = d;
    at = put(at, 0x08074b50, 4);
    at = put(at, a->crc, 4);
    at = put(at, a->packed_bytes, a->big ? 8 : 4);
    at = put(at, a->bytes, a->big ? 8 : 4);
    return write_plain(a, d, (size_t)(at - d));
}

static vv_status write_directory(archive *a)
{
    uint8_t d[46 + sizeof a->name + BIG_EXTRA + 56 + 20 + 22], *at = d;
    const size_t n_name = strlen(a->name);
    const uint64_t start = a->written;
    at = put(at, 0x02014b50, 4);
    at = put(at, a->big ? 45 : 20, 2);
    at = put_kind(at, a);
    at = put(at, a->crc, 4);
    at = put(at, a->big ? UINT32_MAX : a->packed_bytes, 4);
    at = put(at, a->big ? UINT32_MAX : a->bytes, 4);
    at = put(at, n_name, 2);
    at = put(at, a->big ? BIG_EXTRA : 0, 2);
    at = put(at, 0, 2 + 2 + 2 + 4 + 4); /* no comment, disk 0, no attributes, at byte 0 */
    memcpy(at, a->name, n_name);
    at += n_name;
    if (a->big)
        at = put(put(put(put(at, 1, 2), 16, 2), a->bytes, 8), a->packed_bytes, 8);
    const uint64_t n = (uint64_t)(at - d);
    if (a->big) {
        const uint64_t end = start + n;
        at = put(put(put(put(at, 0x06064b50, 4), 44, 8), 45, 2), 45, 2);
        at = put(put(put(put(at, 0, 8), 1, 8), 1, 8), n, 8);
        at = put(at, start, 8);
        at = put(put(put(put(at, 0x07064b50, 4), 0, 4), end, 8), 1, 4);
    }
    at = put(put(put(at, 0x06054b50, 4), 0, 4), 1, 2);
    at = put(put(at, 1, 2), n, 4);
    at = put(put(at, a->big ? UINT32_MAX : start, 4), 0, 2);
    return write_plain(a, d, (size_t)(at - d));
}

/* Bytes of the .npy file, as they will be unpacked. */
static vv_status write_counted(archive *a, const void *data, size_t n)
{
    a->crc = vvi_crc32(a->crc, data, n, a->fold);
    a->bytes += n;
    return vvi_sink_write(a->sink, data, n);
}

static vv_status write_piece(void *user, void *data, size_t n)
{
    archive *a = user;
    if (a->swap)
        vvi_swap_bytes(data, a->element_bytes, n / a->element_bytes);
    return write_counted(a, data, n);
}

static vv_status write_array(archive *a, const vv_field *const *frames, size_t n_frames, bool big_endian, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    vvi_text t = {0};
    a->element_bytes = vv_type_bytes(info->type);
    a->swap = a->element_bytes > 1 && vvi_order_swapped(big_endian);
    vv_status st = vvi_npy_add_header(&t, info, n_frames, big_endian, (size_t)(a->written % 64));
    if (st == VV_OK)
        st = write_counted(a, t.s, t.n);
    vvi_text_free(&t);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = vvi_samples_each(frames[f], -1, write_piece, a, job);
    return st;
}

static vv_status write_packed(archive *a, const vv_field *const *frames, size_t n_frames,
                              const vv_write_options *options, vv_job *job)
{
    if (!a->deflate) {
        const vv_status st = write_array(a, frames, n_frames, options->big_endian, job);
        a->packed_bytes = a->bytes;
        return st;
    }
    vv_status st = vvi_sink_coding(a->sink, VVI_CODING_DEFLATE, options->level);
    const uint64_t before = vvi_sink_tell(a->sink);
    if (st == VV_OK)
        st = write_array(a, frames, n_frames, options->big_endian, job);
    if (st == VV_OK)
        st = vvi_sink_coding(a->sink, VVI_CODING_NONE, 0);
    a->packed_bytes = vvi_sink_tell(a->sink) - before;
    return st;
}

vv_status vvi_npz_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                        vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    archive a = {.sink = sink, .fold = vvi_crc_has_fold()};
    uint64_t bytes;
    vv_status st = vv_field_info_bytes(&bytes, info);
    if (st != VV_OK)
        return st;
    a.deflate = !options->encoding || strcmp(options->encoding, "raw") != 0;
    a.big = bytes > (UINT32_MAX - BIG) / n_frames;
    name_array(&a, info->name);
    vvi_log_loss(sink, info, n_frames, "npz", job);
    vvi_log_lost_names(sink, options, 0, "npz", job);
    if ((st = write_local(&a)) == VV_OK)
        st = write_packed(&a, frames, n_frames, options, job);
    a.written += a.packed_bytes;
    if (st == VV_OK && (st = write_descriptor(&a)) == VV_OK)
        st = write_directory(&a);
    return st;
}
