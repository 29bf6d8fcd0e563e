/* DICOM files whose elements are deflated as one stream. Of such a stream the beginning is unpacked to find the pixels,
 * and then no more than the pixels need: what else it grows to is nobody's. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include <zlib.h>

#define PIECE_BYTES ((size_t)16384)
#define ROOM_BYTES ((uint64_t)65536)

struct vvi_dicom_inflater {
    z_stream z;
    vv_source *source;
    vv_job *job;
    uint64_t n; /* bytes that came out */
    bool ended;
    uint8_t in[PIECE_BYTES];
};

vv_status vvi_dicom_inflater_new(vvi_dicom_inflater **out, vv_source *source, uint64_t at, vv_job *job)
{
    *out = NULL;
    vvi_dicom_inflater *i = vvi_alloc_zeroed(job, sizeof *i, VVI_MEM_SCRATCH);
    if (!i)
        return vv_fail_memory(sizeof *i);
    i->source = source;
    i->job = job;
    if (inflateInit2(&i->z, -15) != Z_OK) {
        vvi_free(i);
        return vv_fail_memory(ROOM_BYTES);
    }
    *out = i;
    return vvi_source_seek(source, at);
}

void vvi_dicom_inflater_free(vvi_dicom_inflater *i)
{
    if (i)
        inflateEnd(&i->z);
    vvi_free(i);
}

/* Up to n bytes; fewer at the end, also of a file that is cut short. */
static vv_status next_bytes(vvi_dicom_inflater *i, uint8_t *out, size_t n)
{
    vv_status st = VV_OK;
    i->z.next_out = out;
    i->z.avail_out = (uInt)n;
    while (st == VV_OK && i->z.avail_out > 0 && !i->ended) {
        size_t got = i->z.avail_in;
        if (got == 0 && (st = vvi_job_poll(i->job)) == VV_OK &&
            (st = vvi_source_read_some(i->source, i->in, PIECE_BYTES, &got)) == VV_OK) {
            i->z.next_in = i->in;
            i->z.avail_in = (uInt)got;
        }
        if (st != VV_OK || got == 0) {
            i->ended = true;
            break;
        }
        const int result = inflate(&i->z, Z_NO_FLUSH);
        i->ended = result == Z_STREAM_END;
        if (result != Z_OK && result != Z_STREAM_END && result != Z_BUF_ERROR)
            st = vv_fail_at(VV_E_FORMAT, vvi_source_name(i->source), NULL,
                            "its deflated elements are damaged after %llu bytes",
                            (unsigned long long)(i->n + n - i->z.avail_out));
    }
    i->n += n - i->z.avail_out;
    return st;
}

vv_status vvi_dicom_inflate(vvi_dicom_file *file, vvi_dicom_inflater *i, uint64_t most)
{
    uint64_t room = 0;
    vv_status st = VV_OK;
    while (st == VV_OK && !i->ended && i->n < most) {
        if (i->n == room) {
            room = room ? 2 * room : ROOM_BYTES;
            room = room < most ? room : most;
            void *grown = vvi_realloc(i->job, file->inflated, (size_t)room, VVI_MEM_SCRATCH);
            if (!grown)
                return vv_fail_memory((size_t)room);
            file->inflated = grown;
        }
        const uint64_t left = room - i->n;
        st = next_bytes(i, (uint8_t *)file->inflated + i->n, left < 1u << 30 ? (size_t)left : (size_t)1 << 30);
    }
    if (st == VV_OK && i->n == 0)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(i->source), NULL, "ends before its deflated elements");
    if (st == VV_OK)
        st = vvi_source_memory(&file->source, file->inflated, (size_t)i->n, vvi_source_name(i->source), i->job);
    file->owned = file->source != NULL;
    return st;
}

vv_status vvi_dicom_inflate_on(uint64_t *size_out, vvi_dicom_inflater *i, uint64_t end)
{
    vv_status st = VV_OK;
    uint8_t *gone = vvi_alloc(i->job, ROOM_BYTES, VVI_MEM_SCRATCH);
    if (!gone)
        return vv_fail_memory(ROOM_BYTES);
    while (st == VV_OK && !i->ended && i->n < end)
        st = next_bytes(i, gone, end - i->n < ROOM_BYTES ? (size_t)(end - i->n) : ROOM_BYTES);
    vvi_free(gone);
    *size_out = i->n;
    return st;
}

bool vvi_dicom_inflated_all(const vvi_dicom_inflater *i)
{
    return i->ended;
}
