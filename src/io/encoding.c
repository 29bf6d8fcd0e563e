/* Encoding: deflate with either wrapper or none, bzip2 and zstd. */
#include "config.h"
#include "core/memory.h"
#include "io/coding_step.h"
#include <zlib.h>
#if VV_HAVE_BZIP2
#include <bzlib.h>
#endif
#if VV_HAVE_ZSTD
#include <zstd.h>
#endif

struct vvi_encoder {
    vvi_coding coding;
    z_stream gzip;
#if VV_HAVE_BZIP2
    bz_stream bzip2;
#endif
#if VV_HAVE_ZSTD
    ZSTD_CStream *zstd;
#endif
};

/* As zlib's window says it; 0: it is another library's. */
static int wrapper_of(vvi_coding coding)
{
    return coding == VVI_CODING_GZIP      ? 15 + 16
           : coding == VVI_CODING_ZLIB    ? 15
           : coding == VVI_CODING_DEFLATE ? -15
                                          : 0;
}

static bool encoder_start(vvi_encoder *e, int level)
{
    if (wrapper_of(e->coding))
        return deflateInit2(&e->gzip, level ? level : Z_DEFAULT_COMPRESSION, Z_DEFLATED, wrapper_of(e->coding), 8,
                            Z_DEFAULT_STRATEGY) == Z_OK;
#if VV_HAVE_BZIP2
    if (e->coding == VVI_CODING_BZIP2)
        return BZ2_bzCompressInit(&e->bzip2, level ? level : 9, 0, 0) == BZ_OK;
#endif
#if VV_HAVE_ZSTD
    if (e->coding == VVI_CODING_ZSTD) {
        e->zstd = ZSTD_createCStream();
        return e->zstd && !ZSTD_isError(ZSTD_initCStream(e->zstd, level ? level * 2 : 3));
    }
#endif
    return false;
}

vv_status vvi_encoder_new(vvi_encoder **out, vvi_coding coding, int level, vv_job *job)
{
    *out = NULL;
    vv_status st = vvi_coding_available(coding);
    if (st != VV_OK)
        return st;
    vvi_encoder *e = vvi_alloc_zeroed(job, sizeof *e, VVI_MEM_SCRATCH);
    if (!e)
        return vv_fail_memory(sizeof *e);
    e->coding = coding;
    if (!encoder_start(e, level)) {
        vvi_encoder_free(e);
        return vv_fail(VV_E_MEMORY, "not enough memory for the %s encoder", vvi_coding_name(coding));
    }
    *out = e;
    return VV_OK;
}

void vvi_encoder_free(vvi_encoder *e)
{
    if (!e)
        return;
    if (wrapper_of(e->coding))
        deflateEnd(&e->gzip);
#if VV_HAVE_BZIP2
    if (e->coding == VVI_CODING_BZIP2)
        BZ2_bzCompressEnd(&e->bzip2);
#endif
#if VV_HAVE_ZSTD
    if (e->coding == VVI_CODING_ZSTD)
        ZSTD_freeCStream(e->zstd);
#endif
    vvi_free(e);
}

static bool encode_gzip(vvi_encoder *e, vvi_coding_step *step, bool finish, bool *done)
{
    const unsigned in = vvi_clamp_uint(step->n_in), out = vvi_clamp_uint(step->n_out);
    e->gzip.next_in = (Bytef *)(uintptr_t)step->in;
    e->gzip.avail_in = in;
    e->gzip.next_out = step->out;
    e->gzip.avail_out = out;
    const int rc = deflate(&e->gzip, finish && in == step->n_in ? Z_FINISH : Z_NO_FLUSH);
    vvi_coding_advance(step, in - e->gzip.avail_in, out - e->gzip.avail_out);
    *done = rc == Z_STREAM_END;
    return rc == Z_OK || rc == Z_STREAM_END || rc == Z_BUF_ERROR;
}

static bool encode_bzip2(vvi_encoder *e, vvi_coding_step *step, bool finish, bool *done)
{
#if VV_HAVE_BZIP2
    const unsigned in = vvi_clamp_uint(step->n_in), out = vvi_clamp_uint(step->n_out);
    e->bzip2.next_in = (char *)(uintptr_t)step->in;
    e->bzip2.avail_in = in;
    e->bzip2.next_out = (char *)step->out;
    e->bzip2.avail_out = out;
    const int rc = BZ2_bzCompress(&e->bzip2, finish ? BZ_FINISH : BZ_RUN);
    vvi_coding_advance(step, in - e->bzip2.avail_in, out - e->bzip2.avail_out);
    *done = rc == BZ_STREAM_END;
    return rc == BZ_RUN_OK || rc == BZ_FINISH_OK || rc == BZ_STREAM_END;
#else
    return false;
#endif
}

static bool encode_zstd(vvi_encoder *e, vvi_coding_step *step, bool finish, bool *done)
{
#if VV_HAVE_ZSTD
    ZSTD_inBuffer in = {step->in, step->n_in, 0};
    ZSTD_outBuffer out = {step->out, step->n_out, 0};
    const size_t rc = ZSTD_compressStream2(e->zstd, &out, &in, finish ? ZSTD_e_end : ZSTD_e_continue);
    vvi_coding_advance(step, in.pos, out.pos);
    *done = finish && rc == 0;
    return !ZSTD_isError(rc);
#else
    return false;
#endif
}

bool vvi_encoder_run(vvi_encoder *e, vvi_coding_step *step, bool finish, bool *done)
{
    *done = false;
    switch (e->coding) {
    case VVI_CODING_GZIP:
    case VVI_CODING_ZLIB:
    case VVI_CODING_DEFLATE:
        return encode_gzip(e, step, finish, done);
    case VVI_CODING_BZIP2:
        return encode_bzip2(e, step, finish, done);
    case VVI_CODING_ZSTD:
        return encode_zstd(e, step, finish, done);
    case VVI_CODING_NONE:
        break;
    }
    return false;
}
