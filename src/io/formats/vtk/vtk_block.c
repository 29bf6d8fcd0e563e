#include "io/formats/vtk/vtk_block.h"
#include "config.h"
#include "core/limits.h"
#include "io/inflate.h"
#include <limits.h>
#if VV_HAVE_LZ4
#include <lz4.h>
#endif
#if VV_HAVE_LZMA
#include <lzma.h>
#endif

#define LZMA_MEMORY_MOST (UINT64_C(128) << 20)

static bool unpack_zlib(void *out, size_t n_out, const void *in, size_t n_in)
{
    size_t n;
    return vvi_inflate_block(out, n_out, &n, in, n_in, VVI_INFLATE_ZLIB) && n == n_out;
}

static bool unpack_lz4(void *out, size_t n_out, const void *in, size_t n_in)
{
#if VV_HAVE_LZ4
    return n_out <= INT_MAX && n_in <= INT_MAX && LZ4_decompress_safe(in, out, (int)n_in, (int)n_out) == (int)n_out;
#else
    return false;
#endif
}

static bool unpack_lzma(void *out, size_t n_out, const void *in, size_t n_in)
{
#if VV_HAVE_LZMA
    uint64_t memory = LZMA_MEMORY_MOST;
    size_t in_at = 0, out_at = 0;
    return lzma_stream_buffer_decode(&memory, 0, NULL, in, &in_at, n_in, out, &out_at, n_out) == LZMA_OK &&
           out_at == n_out;
#else
    return false;
#endif
}

bool vvi_vtk_unpack(vvi_vtk_compressor compressor, void *out, size_t n_out, const void *in, size_t n_in)
{
    switch (compressor) {
    case VVI_VTK_ZLIB:
        return unpack_zlib(out, n_out, in, n_in);
    case VVI_VTK_LZ4:
        return unpack_lz4(out, n_out, in, n_in);
    case VVI_VTK_LZMA:
        return unpack_lzma(out, n_out, in, n_in);
    case VVI_VTK_PLAIN:
    case VVI_VTK_UNKNOWN:
        break;
    }
    return false;
}

const char *vvi_vtk_expansion_limit(vvi_vtk_compressor compressor)
{
    return compressor == VVI_VTK_LZMA ? "expansion_zstd" : "expansion_gzip";
}

bool vvi_vtk_is_bomb(vvi_vtk_compressor compressor, uint64_t bytes, uint64_t packed, const vv_job *job)
{
    const vv_limits *limits = vvi_job_limits(job);
    const uint64_t most = compressor == VVI_VTK_LZMA ? limits->expansion_zstd : limits->expansion_gzip;
    return bytes > limits->expansion_after && packed < bytes / most;
}

vv_status vvi_vtk_compressor_available(vvi_vtk_compressor compressor, const char *name)
{
    const char *missing = compressor == VVI_VTK_LZ4 && !VV_HAVE_LZ4     ? "liblz4"
                          : compressor == VVI_VTK_LZMA && !VV_HAVE_LZMA ? "liblzma"
                                                                        : NULL;
    return missing ? vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                                "is compressed in a way that this build does not read; build it with %s", missing)
                   : VV_OK;
}
