#include "io/coding.h"
#include "config.h"
#include "core/allowed_places.h"
#include "core/memory.h"
#include "io/coding_step.h"
#include <stdlib.h>
#include <string.h>
#include <zlib.h>
#if VV_HAVE_ISAL
#include <isa-l/igzip_lib.h>
#endif
#if VV_HAVE_BZIP2
#include <bzlib.h>
#endif
#if VV_HAVE_ZSTD
#include <zstd.h>
#include <zstd_errors.h>
#endif

const char *vvi_coding_name(vvi_coding coding)
{
    static const char *const names[] = {"raw", "gzip", "bzip2", "zstd", "zlib", "deflate"};
    return names[(size_t)coding < sizeof names / sizeof *names ? coding : VVI_CODING_NONE];
}

vvi_coding vvi_coding_of(const uint8_t *head, size_t n)
{
    /* More than the two magic bytes, so that samples without a header are hardly ever taken for a coded file. */
    static const uint8_t gzip[] = {0x1f, 0x8b, 8};
    static const uint8_t zstd[] = {0x28, 0xb5, 0x2f, 0xfd};
    static const uint8_t zstd_skippable[] = {0x2a, 0x4d, 0x18};
    static const uint8_t bzip2_block[] = {0x31, 0x41, 0x59, 0x26, 0x53, 0x59};
    static const uint8_t bzip2_empty[] = {0x17, 0x72, 0x45, 0x38, 0x50, 0x90};
    if (n >= 10 && memcmp(head, gzip, 3) == 0 && (head[3] & 0xe0) == 0)
        return VVI_CODING_GZIP;
    if (n >= 10 && memcmp(head, "BZh", 3) == 0 && head[3] >= '1' && head[3] <= '9' &&
        (memcmp(head + 4, bzip2_block, 6) == 0 || memcmp(head + 4, bzip2_empty, 6) == 0))
        return VVI_CODING_BZIP2;
    if (n >= 5 && memcmp(head, zstd, 4) == 0)
        return VVI_CODING_ZSTD;
    if (n >= 8 && (head[0] & 0xf0) == 0x50 && memcmp(head + 1, zstd_skippable, 3) == 0)
        return VVI_CODING_ZSTD;
    return VVI_CODING_NONE;
}

vv_status vvi_coding_available(vvi_coding coding)
{
    const bool have = coding == VVI_CODING_NONE || coding == VVI_CODING_GZIP || coding == VVI_CODING_ZLIB ||
                      coding == VVI_CODING_DEFLATE || (coding == VVI_CODING_BZIP2 && VV_HAVE_BZIP2) ||
                      (coding == VVI_CODING_ZSTD && VV_HAVE_ZSTD);
    return have ? VV_OK : vv_fail(VV_E_UNSUPPORTED, "this build of VolVis has no %s library", vvi_coding_name(coding));
}

/* Decoding ------------------------------------------------------------------------------------------------------ */

struct vvi_decoder {
    vvi_coding coding;
    bool live;    /* the library's state is there to be ended */
    bool checked; /* the first bytes were looked at */
    bool strange; /* whoever made the data is not trusted */
    z_stream gzip;
#if VV_HAVE_ISAL
    struct inflate_state *fast; /* gzip's, twice as fast as zlib's */
#endif
#if VV_HAVE_BZIP2
    bz_stream bzip2;
#endif
#if VV_HAVE_ZSTD
    ZSTD_DStream *zstd;
#endif
};

/* How far back the data of strangers may look, which is memory that is held for them: 8 MiB, which all levels of zstd
 * up to 19 keep to. Others may have the 128 MiB of the library. */
enum { STRANGE_WINDOW_LOG = 23 };

static bool decoder_start(vvi_decoder *d)
{
    switch (d->coding) {
    case VVI_CODING_NONE:
        return true;
    case VVI_CODING_GZIP:
#if VV_HAVE_ISAL
        if (!d->fast)
            d->fast = vvi_calloc(1, sizeof *d->fast);
        if (!d->fast)
            return false;
        isal_inflate_init(d->fast);
        d->fast->crc_flag = ISAL_GZIP;
        return true;
#else
        return inflateInit2(&d->gzip, 15 + 16) == Z_OK;
#endif
    case VVI_CODING_ZLIB:
        return inflateInit2(&d->gzip, 15 + 32) == Z_OK;
    case VVI_CODING_DEFLATE:
        return inflateInit2(&d->gzip, -15) == Z_OK;
    case VVI_CODING_BZIP2:
#if VV_HAVE_BZIP2
        return BZ2_bzDecompressInit(&d->bzip2, 0, 0) == BZ_OK;
#else
        return false;
#endif
    case VVI_CODING_ZSTD:
#if VV_HAVE_ZSTD
        d->zstd = ZSTD_createDStream();
        if (d->zstd && d->strange)
            ZSTD_DCtx_setParameter(d->zstd, ZSTD_d_windowLogMax, STRANGE_WINDOW_LOG);
        return d->zstd != NULL;
#else
        return false;
#endif
    }
    return false;
}

static void decoder_stop(vvi_decoder *d)
{
    if (!d->live)
        return;
    if (d->coding == VVI_CODING_ZLIB || d->coding == VVI_CODING_DEFLATE ||
        (d->coding == VVI_CODING_GZIP && !VV_HAVE_ISAL))
        inflateEnd(&d->gzip);
#if VV_HAVE_BZIP2
    if (d->coding == VVI_CODING_BZIP2)
        BZ2_bzDecompressEnd(&d->bzip2);
#endif
#if VV_HAVE_ZSTD
    if (d->coding == VVI_CODING_ZSTD)
        ZSTD_freeDStream(d->zstd);
#endif
    d->live = false;
}

vv_status vvi_decoder_new(vvi_decoder **out, vvi_coding coding, vv_job *job)
{
    *out = NULL;
    vv_status st = vvi_coding_available(coding);
    if (st != VV_OK)
        return st;
    vvi_decoder *d = vvi_alloc_zeroed(job, sizeof *d, VVI_MEM_SCRATCH);
    if (!d)
        return vv_fail_memory(sizeof *d);
    d->coding = coding;
    d->strange = vvi_job_distrusts_all(job);
    d->live = decoder_start(d);
    if (!d->live) {
        vvi_free(d);
        return vv_fail(VV_E_MEMORY, "not enough memory for the %s decoder", vvi_coding_name(coding));
    }
    *out = d;
    return VV_OK;
}

/* The library keeps what it looks back at in its state, and takes pointers anew with every step. */
static bool copy_state(vvi_decoder *to, vvi_decoder *from)
{
#if VV_HAVE_ISAL
    if (from->fast) {
        if ((to->fast = vvi_calloc(1, sizeof *to->fast)) != NULL)
            memcpy(to->fast, from->fast, sizeof *to->fast);
        return to->fast != NULL;
    }
#endif
    return inflateCopy(&to->gzip, &from->gzip) == Z_OK;
}

bool vvi_coding_copies(vvi_coding coding)
{
    return coding == VVI_CODING_GZIP || coding == VVI_CODING_ZLIB || coding == VVI_CODING_DEFLATE;
}

vv_status vvi_decoder_copy(vvi_decoder **out, vvi_decoder *d, vv_job *job)
{
    *out = NULL;
    if (!vvi_coding_copies(d->coding))
        return VV_OK;
    vvi_decoder *copy = vvi_alloc_zeroed(job, sizeof *copy, VVI_MEM_SCRATCH);
    if (!copy)
        return vv_fail_memory(sizeof *copy);
    copy->coding = d->coding;
    copy->checked = d->checked;
    copy->live = copy_state(copy, d);
    if (!copy->live) {
        vvi_decoder_free(copy);
        return vv_fail(VV_E_MEMORY, "not enough memory for the %s decoder", vvi_coding_name(d->coding));
    }
    *out = copy;
    return VV_OK;
}

bool vvi_decoder_reset(vvi_decoder *d)
{
    decoder_stop(d);
    memset(&d->gzip, 0, sizeof d->gzip);
#if VV_HAVE_BZIP2
    memset(&d->bzip2, 0, sizeof d->bzip2);
#endif
    d->checked = false;
    d->live = decoder_start(d);
    return d->live;
}

void vvi_decoder_free(vvi_decoder *d)
{
    if (!d)
        return;
    decoder_stop(d);
#if VV_HAVE_ISAL
    free(d->fast);
#endif
    vvi_free(d);
}

static const char *run_gzip(vvi_decoder *d, vvi_coding_step *step, bool *member_end)
{
    const unsigned in = vvi_clamp_uint(step->n_in), out = vvi_clamp_uint(step->n_out);
    d->gzip.next_in = (Bytef *)(uintptr_t)step->in; /* zlib does not write there, but does not say const either */
    d->gzip.avail_in = in;
    d->gzip.next_out = step->out;
    d->gzip.avail_out = out;
    const int rc = inflate(&d->gzip, Z_NO_FLUSH);
    vvi_coding_advance(step, in - d->gzip.avail_in, out - d->gzip.avail_out);
    *member_end = rc == Z_STREAM_END;
    if (rc == Z_OK || rc == Z_STREAM_END || rc == Z_BUF_ERROR)
        return NULL;
    return rc == Z_MEM_ERROR ? "not enough memory to decode it" : d->gzip.msg ? d->gzip.msg : "damaged data";
}

/* Bytes behind the end of a member that the library has already taken go back, so that the next member begins there. */
static const char *run_fast_gzip(vvi_decoder *d, vvi_coding_step *step, bool *member_end)
{
#if VV_HAVE_ISAL
    struct inflate_state *s = d->fast;
    const unsigned in = vvi_clamp_uint(step->n_in), out = vvi_clamp_uint(step->n_out);
    s->next_in = (uint8_t *)(uintptr_t)step->in; /* nothing is written there, but it does not say const either */
    s->avail_in = in;
    s->next_out = step->out;
    s->avail_out = out;
    const int rc = isal_inflate(s);
    *member_end = s->block_state == ISAL_BLOCK_FINISH;
    vvi_coding_advance(step, in - s->avail_in, out - s->avail_out);
    switch (rc) {
    case ISAL_DECOMP_OK:
    case ISAL_END_INPUT:
    case ISAL_OUT_OVERFLOW:
        return NULL;
    case ISAL_INCORRECT_CHECKSUM:
        return "incorrect data check";
    default:
        return "damaged data";
    }
#else
    return "no gzip library";
#endif
}

static const char *run_bzip2(vvi_decoder *d, vvi_coding_step *step, bool *member_end)
{
#if VV_HAVE_BZIP2
    const unsigned in = vvi_clamp_uint(step->n_in), out = vvi_clamp_uint(step->n_out);
    d->bzip2.next_in = (char *)(uintptr_t)step->in;
    d->bzip2.avail_in = in;
    d->bzip2.next_out = (char *)step->out;
    d->bzip2.avail_out = out;
    const int rc = BZ2_bzDecompress(&d->bzip2);
    vvi_coding_advance(step, in - d->bzip2.avail_in, out - d->bzip2.avail_out);
    *member_end = rc == BZ_STREAM_END;
    if (rc == BZ_OK || rc == BZ_STREAM_END)
        return NULL;
    return rc == BZ_MEM_ERROR ? "not enough memory to decode it" : "damaged data";
#else
    return "no bzip2 library";
#endif
}

static const char *run_zstd(vvi_decoder *d, vvi_coding_step *step, bool *member_end)
{
#if VV_HAVE_ZSTD
    /* The library also takes the formats that zstd had before its first release. Those decoders are old code that
     * nobody tests any more, and nobody's volumes are written so. They differ in the first byte already. */
    if (!d->checked && step->n_in > 0) {
        const bool now = step->n_in >= 8 ? vvi_coding_of(step->in, step->n_in) == VVI_CODING_ZSTD
                                         : step->in[0] == 0x28 || (step->in[0] & 0xf0) == 0x50;
        if (!now)
            return "this is not zstd data";
        d->checked = true;
    }
    ZSTD_inBuffer in = {step->in, step->n_in, 0};
    ZSTD_outBuffer out = {step->out, step->n_out, 0};
    const size_t rc = ZSTD_decompressStream(d->zstd, &out, &in);
    vvi_coding_advance(step, in.pos, out.pos);
    if (ZSTD_getErrorCode(rc) == ZSTD_error_frameParameter_windowTooLarge)
        return d->strange ? "looks back further than the 8 MiB that files of strangers may; unpack it with 'zstd -d'"
                          : "looks back further than 128 MiB; unpack it with 'zstd -d --long=31'";
    if (ZSTD_isError(rc))
        return ZSTD_getErrorName(rc);
    *member_end = rc == 0;
    return NULL;
#else
    return "no zstd library";
#endif
}

const char *vvi_decoder_run(vvi_decoder *d, vvi_coding_step *step, bool *member_end)
{
    *member_end = false;
    switch (d->coding) {
    case VVI_CODING_GZIP:
        return VV_HAVE_ISAL ? run_fast_gzip(d, step, member_end) : run_gzip(d, step, member_end);
    case VVI_CODING_ZLIB:
    case VVI_CODING_DEFLATE:
        return run_gzip(d, step, member_end);
    case VVI_CODING_BZIP2:
        return run_bzip2(d, step, member_end);
    case VVI_CODING_ZSTD:
        return run_zstd(d, step, member_end);
    case VVI_CODING_NONE:
        break;
    }
    const size_t n = step->n_in < step->n_out ? step->n_in : step->n_out;
    memcpy(step->out, step->in, n);
    vvi_coding_advance(step, n, n);
    return NULL;
}
