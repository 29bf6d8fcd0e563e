/* Rows of image formats whose library was not there when VolVis was built: they say so. */
#include "config.h"
#include "registry.h"

#if !VV_HAVE_JPEG
static const char *const jpeg_suffixes[] = {".jpg", ".jpeg", NULL};

const vv_image_format vvi_image_format_jpeg = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "jpeg",
    .doc = "not in this build, which found no libjpeg",
    .suffixes = jpeg_suffixes,
};
#endif

#if !VV_HAVE_WEBP
static const char *const webp_suffixes[] = {".webp", NULL};

const vv_image_format vvi_image_format_webp = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "webp",
    .doc = "not in this build, which found no libwebp and libwebpmux",
    .suffixes = webp_suffixes,
};
#endif

#if !VV_HAVE_EXR
static const char *const exr_suffixes[] = {".exr", NULL};

const vv_image_format vvi_image_format_exr = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "exr",
    .doc = "not in this build, which found no OpenEXRCore 3.1 or newer",
    .suffixes = exr_suffixes,
};
#endif
