#include "libraries.h"
#include "config.h"
#include "core/cpu.h"
#include "render/common/mesh_tree.h"
#include "surface/simplify_library.h"
#include <jansson.h>
#include <png.h>
#include <stdio.h>
#include <string.h>
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

/* libjpeg says at build time alone what it is. */
static void version_of_jpeg(char out[32])
{
    out[0] = 0;
#if VV_HAVE_JPEG && defined(LIBJPEG_TURBO_VERSION_NUMBER)
    snprintf(out, 32, "turbo %d.%d.%d", LIBJPEG_TURBO_VERSION_NUMBER / 1000000,
             LIBJPEG_TURBO_VERSION_NUMBER / 1000 % 1000, LIBJPEG_TURBO_VERSION_NUMBER % 1000);
#elif VV_HAVE_JPEG
    snprintf(out, 32, "%d", JPEG_LIB_VERSION);
#endif
}

static void version_of_webp(char out[32])
{
    out[0] = 0;
#if VV_HAVE_WEBP
    const int version = WebPGetEncoderVersion();
    snprintf(out, 32, "%d.%d.%d", version >> 16, version >> 8 & 255, version & 255);
#endif
}

static void version_of_exr(char out[32])
{
    out[0] = 0;
#if VV_HAVE_EXR
    int major = 0, minor = 0, patch = 0;
    exr_get_library_version(&major, &minor, &patch, NULL);
    snprintf(out, 32, "%d.%d.%d", major, minor, patch);
#endif
}

static const char *version_of_blosc(void)
{
#if VV_HAVE_BLOSC
    return blosc_get_version_string();
#else
    return "";
#endif
}

static const char *version_of_lz4(void)
{
#if VV_HAVE_LZ4
    return LZ4_versionString();
#else
    return "";
#endif
}

static const char *version_of_lzma(void)
{
#if VV_HAVE_LZMA
    return lzma_version_string();
#else
    return "";
#endif
}

/* "expat_2.5.0" */
static const char *version_of_expat(void)
{
#if VV_HAVE_EXPAT
    const char *said = XML_ExpatVersion(), *number = strchr(said, '_');
    return number ? number + 1 : said;
#else
    return "";
#endif
}

/* Not of the module, which would have to be loaded for it: of what it is built with. */
static const char *version_of_gdcm(void)
{
#if VV_HAVE_GDCM
    return VV_GDCM_VERSION;
#else
    return "";
#endif
}

static const char *problem_of_gdcm(bool load)
{
#if VV_HAVE_GDCM
    if (load)
        return vvi_gdcm_problem();
    return vvi_gdcm_is_there() ? NULL : "there is no " VVI_GDCM_MODULE;
#else
    return NULL;
#endif
}

/* ISA-L says at build time alone what it is. */
static void version_of_isal(char out[32])
{
    out[0] = 0;
#if VV_HAVE_ISAL
    snprintf(out, 32, "%d.%d.%d", ISAL_MAJOR_VERSION, ISAL_MINOR_VERSION, ISAL_PATCH_VERSION);
#endif
}

/* "LIBTIFF, Version 4.5.0" and lines of copyright */
static void version_of_tiff(char out[32])
{
    out[0] = 0;
#if VV_HAVE_TIFF
    const char *said = TIFFGetVersion(), *number = strpbrk(said, "0123456789");
    if (number)
        snprintf(out, 32, "%.*s", (int)strspn(number, "0123456789."), number);
#endif
}

static void version_of_hdf5(char out[32])
{
    out[0] = 0;
#if VV_HAVE_HDF5
    unsigned major = 0, minor = 0, patch = 0;
    H5get_libversion(&major, &minor, &patch);
    snprintf(out, 32, "%u.%u.%u", major, minor, patch);
#endif
}

static void version_of_seccomp(char out[32])
{
    out[0] = 0;
#if VV_HAVE_SECCOMP
    const struct scmp_version *said = seccomp_version();
    if (said)
        snprintf(out, 32, "%u.%u.%u", said->major, said->minor, said->micro);
#endif
}

static const char *version_of_freetype(void)
{
#if VV_HAVE_FREETYPE
#define WORDS(a, b, c) #a "." #b "." #c
#define VERSION(a, b, c) WORDS(a, b, c)
    return VERSION(FREETYPE_MAJOR, FREETYPE_MINOR, FREETYPE_PATCH);
#undef VERSION
#undef WORDS
#else
    return "";
#endif
}

static void version_of_fontconfig(char out[32])
{
    out[0] = 0;
#if VV_HAVE_FONTCONFIG
    const int version = FcGetVersion();
    snprintf(out, 32, "%d.%d.%d", version / 10000, version / 100 % 100, version % 100);
#endif
}

bool cli_library_nth(cli_library *out, size_t index)
{
    char jpeg[32], webp[32], exr[32], isal[32], tiff[32], hdf5[32], seccomp[32], fontconfig[32];
    version_of_jpeg(jpeg);
    version_of_webp(webp);
    version_of_exr(exr);
    version_of_isal(isal);
    version_of_tiff(tiff);
    version_of_hdf5(hdf5);
    version_of_seccomp(seccomp);
    version_of_fontconfig(fontconfig);
    const struct {
        const char *name, *purpose, *version;
        const char *(*problem)(bool load);
    } libraries[] = {
        {"zlib", "gzip data, PNG", zlibVersion()},
        {"libpng", "PNG images", png_get_libpng_ver(NULL)},
        {"jansson", "scene files", jansson_version_str()},
#if VV_HAVE_BZIP2
        {"bzip2", "bzip2 data", BZ2_bzlibVersion()},
#else
        {"bzip2", "bzip2 data", ""},
#endif
#if VV_HAVE_ZSTD
        {"zstd", "zstd data", ZSTD_versionString()},
#else
        {"zstd", "zstd data", ""},
#endif
        {"libjpeg", "JPEG images", jpeg},
        {"libwebp", "WebP images", webp},
        {"OpenEXRCore", "EXR images", exr},
        {"ISA-L", "faster gzip", isal},
        {"lz4", "blocks of VTK, chunks of HDF5 and Zarr", version_of_lz4()},
        {"lzma", "blocks of VTK, chunks of Zarr", version_of_lzma()},
        {"blosc", "chunks of HDF5 and Zarr", version_of_blosc()},
        {"expat", "XML of VTK, OME and BigDataViewer", version_of_expat()},
        {"libtiff", "packed TIFF", tiff},
        {"HDF5", "HDF5, netCDF-4, MINC, Imaris, BigDataViewer", hdf5},
        {"GDCM", "lossy DICOM", version_of_gdcm(), problem_of_gdcm},
        {"seccomp", "the lock of --safe", seccomp},
        {"meshoptimizer", "simplify", vvi_meshoptimizer_version()},
        {"Embree", "meshes in clouds", vvi_mesh_tree_version()},
        {"FreeType", "letters in pictures", version_of_freetype()},
        {"fontconfig", "which font", fontconfig},
    };
    if (index >= sizeof libraries / sizeof libraries[0])
        return false;
    *out = (cli_library){
        .name = libraries[index].name, .purpose = libraries[index].purpose, .problem = libraries[index].problem};
    const size_t n = strcspn(libraries[index].version, ","); /* bzip2 says its date as well */
    snprintf(out->version, sizeof out->version, "%.*s", (int)n, libraries[index].version);
    return true;
}

const char *cli_compiler(void)
{
#if defined(__clang__)
    return "clang " __clang_version__;
#elif defined(__GNUC__)
    return "gcc " __VERSION__;
#else
    return "unknown";
#endif
}

bool cli_isa_nth(const char **name_out, bool *usable_out, size_t index)
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
