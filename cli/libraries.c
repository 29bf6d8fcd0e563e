#include "libraries.h"
#include "config.h"
#include "core/cpu.h"
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
#if VV_HAVE_EXR
#include <openexr.h>
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

static void version_of_exr(char out[32])
{
    out[0] = 0;
#if VV_HAVE_EXR
    int major = 0, minor = 0, patch = 0;
    exr_get_library_version(&major, &minor, &patch, NULL);
    snprintf(out, 32, "%d.%d.%d", major, minor, patch);
#endif
}

bool cli_library_nth(cli_library *out, size_t index)
{
    char jpeg[32], exr[32];
    version_of_jpeg(jpeg);
    version_of_exr(exr);
    const struct {
        const char *name, *purpose, *version;
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
        {"OpenEXRCore", "EXR images", exr},
    };
    if (index >= sizeof libraries / sizeof libraries[0])
        return false;
    *out = (cli_library){.name = libraries[index].name, .purpose = libraries[index].purpose};
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
