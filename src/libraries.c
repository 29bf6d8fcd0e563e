/* What VolVis is built with: libraries, instruction sets, compiler. */
#include "config.h"
#include "core/cpu.h"
#include "render/common/mesh_tree.h"
#include "surface/simplify_library.h"
#include <jansson.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
#include <volvis/version.h>
#include <zlib.h>
#if VV_HAVE_BZIP2
#include <bzlib.h>
#endif
#if VV_HAVE_ZSTD
#include <zstd.h>
#endif
#if VV_HAVE_JPEG
#include <jpeglib.h>
#endif
#if VV_HAVE_WEBP
#include <webp/encode.h>
#endif
#if VV_HAVE_EXR
#include <openexr.h>
#endif
#if VV_HAVE_ISAL
#include <isa-l.h>
#endif
#if VV_HAVE_LZ4
#include <lz4.h>
#endif
#if VV_HAVE_LZMA
#include <lzma.h>
#endif
#if VV_HAVE_BLOSC
#include <blosc.h>
#endif
#if VV_HAVE_EXPAT
#include <expat.h>
#endif
#if VV_HAVE_TIFF
#include <tiffio.h>
#endif
#if VV_HAVE_HDF5
#include <hdf5.h>
#endif
#if VV_HAVE_GDCM
#include "io/formats/dicom/dicom_gdcm.h"
#endif
#if VV_HAVE_FONTCONFIG
#include <fontconfig/fontconfig.h>
#endif
#if VV_HAVE_FREETYPE
#include <ft2build.h>
#include FT_FREETYPE_H
#endif
#if VV_HAVE_SECCOMP
#include <seccomp.h>
#endif

typedef enum library {
    LIB_ZLIB,
    LIB_PNG,
    LIB_JANSSON,
    LIB_BZIP2,
    LIB_ZSTD,
    LIB_JPEG,
    LIB_WEBP,
    LIB_EXR,
    LIB_ISAL,
    LIB_LZ4,
    LIB_LZMA,
    LIB_BLOSC,
    LIB_EXPAT,
    LIB_TIFF,
    LIB_HDF5,
    LIB_GDCM,
    LIB_SECCOMP,
    LIB_MESHOPTIMIZER,
    LIB_EMBREE,
    LIB_FREETYPE,
    LIB_FONTCONFIG,
    N_LIBRARIES
} library;

static const struct {
    const char *name, *purpose;
} libraries[N_LIBRARIES] = {
    [LIB_ZLIB] = {"zlib", "gzip data, PNG"},
    [LIB_PNG] = {"libpng", "PNG images"},
    [LIB_JANSSON] = {"jansson", "scene files"},
    [LIB_BZIP2] = {"bzip2", "bzip2 data"},
    [LIB_ZSTD] = {"zstd", "zstd data"},
    [LIB_JPEG] = {"libjpeg", "JPEG images"},
    [LIB_WEBP] = {"libwebp", "WebP images"},
    [LIB_EXR] = {"OpenEXRCore", "EXR images"},
    [LIB_ISAL] = {"ISA-L", "faster gzip"},
    [LIB_LZ4] = {"lz4", "blocks of VTK, chunks of HDF5 and Zarr"},
    [LIB_LZMA] = {"lzma", "blocks of VTK, chunks of Zarr"},
    [LIB_BLOSC] = {"blosc", "chunks of HDF5 and Zarr"},
    [LIB_EXPAT] = {"expat", "XML of VTK, OME and BigDataViewer"},
    [LIB_TIFF] = {"libtiff", "packed TIFF"},
    [LIB_HDF5] = {"HDF5", "HDF5, netCDF-4, MINC, Imaris, BigDataViewer"},
    [LIB_GDCM] = {"GDCM", "lossy DICOM"},
    [LIB_SECCOMP] = {"seccomp", "the lock of --safe"},
    [LIB_MESHOPTIMIZER] = {"meshoptimizer", "simplify"},
    [LIB_EMBREE] = {"Embree", "meshes in clouds"},
    [LIB_FREETYPE] = {"FreeType", "letters in pictures"},
    [LIB_FONTCONFIG] = {"fontconfig", "which font"},
};

/* The first number in what a library says of itself: "expat_2.5.0", "LIBTIFF, Version 4.5.0" and lines of copyright,
 * "1.0.8, 13-Jul-2019". */
static void number_of(char out[24], const char *said)
{
    const char *number = strpbrk(said, "0123456789");
    if (number)
        snprintf(out, 24, "%.*s", (int)strcspn(number, ", \n"), number);
}

static void print_parts(char out[24], unsigned major, unsigned minor, unsigned patch)
{
    snprintf(out, 24, "%u.%u.%u", major, minor, patch);
}

/* Of the library in use, but where it says only at build time what it is. */
static void version_of(char out[24], library which)
{
    out[0] = 0;
    switch (which) {
    case LIB_ZLIB:
        number_of(out, zlibVersion());
        break;
    case LIB_PNG:
        number_of(out, png_get_libpng_ver(NULL));
        break;
    case LIB_JANSSON:
        number_of(out, jansson_version_str());
        break;
    case LIB_MESHOPTIMIZER:
        snprintf(out, 24, "%s", vvi_meshoptimizer_version());
        break;
    case LIB_EMBREE:
        snprintf(out, 24, "%s", vvi_mesh_tree_version());
        break;
#if VV_HAVE_BZIP2
    case LIB_BZIP2:
        number_of(out, BZ2_bzlibVersion());
        break;
#endif
#if VV_HAVE_ZSTD
    case LIB_ZSTD:
        number_of(out, ZSTD_versionString());
        break;
#endif
#if VV_HAVE_JPEG && defined(LIBJPEG_TURBO_VERSION_NUMBER)
    case LIB_JPEG:
        snprintf(out, 24, "turbo %d.%d.%d", LIBJPEG_TURBO_VERSION_NUMBER / 1000000,
                 LIBJPEG_TURBO_VERSION_NUMBER / 1000 % 1000, LIBJPEG_TURBO_VERSION_NUMBER % 1000);
        break;
#elif VV_HAVE_JPEG
    case LIB_JPEG:
        snprintf(out, 24, "%d", JPEG_LIB_VERSION);
        break;
#endif
#if VV_HAVE_WEBP
    case LIB_WEBP: {
        const unsigned version = (unsigned)WebPGetEncoderVersion();
        print_parts(out, version >> 16, version >> 8 & 255, version & 255);
        break;
    }
#endif
#if VV_HAVE_EXR
    case LIB_EXR: {
        int major = 0, minor = 0, patch = 0;
        exr_get_library_version(&major, &minor, &patch, NULL);
        print_parts(out, (unsigned)major, (unsigned)minor, (unsigned)patch);
        break;
    }
#endif
#if VV_HAVE_ISAL
    case LIB_ISAL:
        print_parts(out, ISAL_MAJOR_VERSION, ISAL_MINOR_VERSION, ISAL_PATCH_VERSION);
        break;
#endif
#if VV_HAVE_LZ4
    case LIB_LZ4:
        number_of(out, LZ4_versionString());
        break;
#endif
#if VV_HAVE_LZMA
    case LIB_LZMA:
        number_of(out, lzma_version_string());
        break;
#endif
#if VV_HAVE_BLOSC
    case LIB_BLOSC:
        number_of(out, blosc_get_version_string());
        break;
#endif
#if VV_HAVE_EXPAT
    case LIB_EXPAT:
        number_of(out, XML_ExpatVersion());
        break;
#endif
#if VV_HAVE_TIFF
    case LIB_TIFF:
        number_of(out, TIFFGetVersion());
        break;
#endif
#if VV_HAVE_HDF5
    case LIB_HDF5: {
        unsigned major = 0, minor = 0, patch = 0;
        H5get_libversion(&major, &minor, &patch);
        print_parts(out, major, minor, patch);
        break;
    }
#endif
#if VV_HAVE_GDCM
    case LIB_GDCM: /* not of the module, which would have to be loaded for it */
        snprintf(out, 24, "%s", VV_GDCM_VERSION);
        break;
#endif
#if VV_HAVE_SECCOMP
    case LIB_SECCOMP: {
        const struct scmp_version *said = seccomp_version();
        if (said)
            print_parts(out, said->major, said->minor, said->micro);
        break;
    }
#endif
#if VV_HAVE_FREETYPE
    case LIB_FREETYPE:
        print_parts(out, FREETYPE_MAJOR, FREETYPE_MINOR, FREETYPE_PATCH);
        break;
#endif
#if VV_HAVE_FONTCONFIG
    case LIB_FONTCONFIG: {
        const unsigned version = (unsigned)FcGetVersion();
        print_parts(out, version / 10000, version / 100 % 100, version % 100);
        break;
    }
#endif
    default:
        break; /* built without it */
    }
}

/* Of what is loaded when a file needs it. */
static const char *problem_of(library which, bool load)
{
#if VV_HAVE_GDCM
    if (which == LIB_GDCM && load)
        return vvi_gdcm_problem();
    if (which == LIB_GDCM && !vvi_gdcm_is_there())
        return "there is no " VVI_GDCM_MODULE;
#endif
    (void)which;
    (void)load;
    return NULL;
}

bool vv_library_nth(vv_library *out, size_t index, bool load)
{
    if (index >= N_LIBRARIES)
        return false;
    *out = (vv_library){.name = libraries[index].name, .purpose = libraries[index].purpose};
    version_of(out->version, (library)index);
    out->problem = problem_of((library)index, load);
    return true;
}

const char *vv_compiler(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown";
#endif
}

bool vv_isa_nth(const char **name_out, bool *usable_out, size_t index)
{
    static const struct {
        const char *name;
        uint32_t bits;
    } builds[] = {
        {"base", 0},
#ifdef VV_HAVE_AVX2
        {"avx2", VVI_CPU_AVX2},
#endif
#ifdef VV_HAVE_AVX512
        {"avx512", VVI_CPU_AVX2 | VVI_CPU_AVX512},
#endif
#ifdef VV_HAVE_NEON
        {"neon", VVI_CPU_NEON},
#endif
    };
    if (index >= sizeof builds / sizeof builds[0])
        return false;
    *name_out = builds[index].name;
    *usable_out = (builds[index].bits & ~vvi_cpu_detect()) == 0;
    return true;
}
