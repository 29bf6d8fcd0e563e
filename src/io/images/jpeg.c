/* JPEG: the row of the table, and how libjpeg's failures are caught. */
#include "io/images/jpeg.h"

#include "registry.h"

#include <jerror.h>
#include <string.h>

static void leave(j_common_ptr jpeg)
{
    vvi_jpeg_error *error = (vvi_jpeg_error *)(void *)jpeg->err;
    jpeg->err->format_message(jpeg, error->text);
    if (jpeg->err->msg_code == JERR_OUT_OF_MEMORY)
        error->status = vv_fail(VV_E_MEMORY, "there is no memory for what libjpeg has to keep");
    longjmp(error->jump, 1);
}

/* Level -1 is damage that libjpeg would fill in for: a picture that is not what was stored is none. Bytes between
 * markers and odd versions of JFIF change nothing. */
static void judge_message(j_common_ptr jpeg, int level)
{
    const int code = jpeg->err->msg_code;
    if (level < 0 && code != JWRN_EXTRANEOUS_DATA && code != JWRN_JFIF_MAJOR && code != JWRN_ADOBE_XFORM)
        leave(jpeg);
}

struct jpeg_error_mgr *vvi_jpeg_error_init(vvi_jpeg_error *error)
{
    jpeg_std_error(&error->base);
    error->base.error_exit = leave;
    error->base.emit_message = judge_message;
    error->status = VV_OK;
    error->text[0] = 0;
    return &error->base;
}

bool vvi_jpeg_guard(vvi_jpeg_error *error, void (*step)(void *user), void *user)
{
    if (setjmp(error->jump))
        return false;
    step(user);
    return true;
}

void vvi_jpeg_leave(j_common_ptr jpeg, vv_status st)
{
    vvi_jpeg_error *error = (vvi_jpeg_error *)(void *)jpeg->err;
    error->status = st;
    longjmp(error->jump, 1);
}

bool vvi_jpeg_is_key(const char *key, size_t n)
{
    bool fine = n >= 1 && n <= VVI_JPEG_KEY_MOST;
    for (size_t i = 0; i < n && fine; i++)
        fine = key[i] > 32 && key[i] < 127 && key[i] != '=' && key[i] != '+';
    return fine;
}

/* Three bytes are little to go by: the name of the first segment makes it certain. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    if (n < 4 || head[0] != 0xff || head[1] != 0xd8 || head[2] != 0xff)
        return 0;
    return n >= 10 && (memcmp(head + 6, "JFIF", 4) == 0 || memcmp(head + 6, "Exif", 4) == 0) ? 2 : 1;
}

static const char *const suffixes[] = {".jpg", ".jpeg", NULL};
static const int bits[] = {8, 0};

const vv_image_format vvi_image_format_jpeg = {
    .api = VV_IMAGE_FORMAT_API,
    .name = "jpeg",
    .doc = "JPEG with full colour resolution and text; sRGB, no transparency, slightly lossy",
    .suffixes = suffixes,
    .probe = probe,
    .write = vvi_jpeg_write,
    .read = vvi_jpeg_read,
    .read_text = vvi_jpeg_read_text,
    .bits = bits,
    .lossy = true,
    .paper = true,
    .quality = 90,
    .side_most = JPEG_MAX_DIMENSION,
};
