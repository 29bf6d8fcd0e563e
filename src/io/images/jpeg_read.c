/* Reading JPEG: grey and colour, baseline and progressive, taken as sRGB; text from comments. */
#include "io/images/jpeg.h"

#include "core/job.h"
#include "core/memory.h"
#include "image/image_srgb.h"
#include "io/images/image_text.h"
#include "io/source.h"

#include <stdlib.h>
#include <string.h>

#define ROOM ((size_t)16 << 10)
#define TEXTS_MOST 1000
#define PIXELS_PER_BYTE_MOST 1024 /* Huffman codes: at least a bit for each 8 x 8 pixels */
#define SCANS_MOST 500            /* each goes over all pixels: many small ones are an attack */

typedef struct reader {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_source_mgr feed;
    struct jpeg_progress_mgr watch;
    vvi_jpeg_error error;
    vv_source *source;
    vv_job *job;
    vv_text *text;
    size_t n_text, held, n_last; /* held: bytes of all texts; n_last: of the last */
    vv_image *image;
    uint8_t *row;
    float linear[256]; /* by code */
    uint8_t room[ROOM];
} reader;

static reader *of(void *jpeg)
{
    return ((j_common_ptr)jpeg)->client_data;
}

static void leave(j_decompress_ptr jpeg, vv_status st)
{
    vvi_jpeg_leave((j_common_ptr)jpeg, st);
}

/* Feeding -------------------------------------------------------------------------------------------------------- */

static void nothing(j_decompress_ptr jpeg)
{
    (void)jpeg;
}

static boolean fill(j_decompress_ptr jpeg)
{
    reader *r = of(jpeg);
    size_t n = 0;
    vv_status st = vvi_source_read_some(r->source, r->room, ROOM, &n);
    if (st == VV_OK && n == 0)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "the JPEG ends before its last pixel");
    if (st != VV_OK)
        leave(jpeg, st);
    r->feed.next_input_byte = r->room;
    r->feed.bytes_in_buffer = n;
    return TRUE;
}

static void skip(j_decompress_ptr jpeg, long n)
{
    reader *r = of(jpeg);
    while (n > 0) {
        if (r->feed.bytes_in_buffer == 0)
            fill(jpeg);
        const size_t step = (size_t)n < r->feed.bytes_in_buffer ? (size_t)n : r->feed.bytes_in_buffer;
        r->feed.next_input_byte += step;
        r->feed.bytes_in_buffer -= step;
        n -= (long)step;
    }
}

static uint8_t next_byte(j_decompress_ptr jpeg)
{
    reader *r = of(jpeg);
    if (r->feed.bytes_in_buffer == 0)
        fill(jpeg);
    r->feed.bytes_in_buffer--;
    return *r->feed.next_input_byte++;
}

static void watch(j_common_ptr jpeg)
{
    reader *r = of(jpeg);
    vv_status st = vvi_job_poll(r->job);
    if (st == VV_OK && jpeg->is_decompressor && r->jpeg.input_scan_number > SCANS_MOST)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "the JPEG has more than %d scans", SCANS_MOST);
    if (st != VV_OK)
        vvi_jpeg_leave(jpeg, st);
}

/* Text ----------------------------------------------------------------------------------------------------------- */

/* Where the value of "KEY=VALUE" or "KEY+=VALUE" begins; 0 where the comment is none of these. */
static size_t value_of(const char *comment, size_t n, size_t *n_key_out, bool *more_out)
{
    const char *equals = memchr(comment, '=', n);
    size_t key = equals ? (size_t)(equals - comment) : 0;
    *more_out = key > 1 && comment[key - 1] == '+';
    key -= *more_out;
    *n_key_out = key;
    return equals && vvi_jpeg_is_key(comment, key) ? (size_t)(equals - comment) + 1 : 0;
}

static vv_status append(reader *r, const char *value, size_t n)
{
    char **old = &r->text[r->n_text - 1].value;
    char *longer = vvi_realloc_plain(*old, r->n_last + n + 1);
    if (!longer)
        return vv_fail_memory(r->n_last + n + 1);
    memcpy(longer + r->n_last, value, n);
    r->n_last += n;
    longer[r->n_last] = 0;
    *old = longer;
    return VV_OK;
}

/* Takes both, which may be NULL for want of memory. */
static vv_status add(reader *r, char *key, char *value)
{
    vv_text *more = key && value ? vvi_realloc_plain(r->text, (r->n_text + 1) * sizeof *more) : NULL;
    if (!more) {
        free(key);
        free(value);
        return vv_fail_memory((r->n_text + 1) * sizeof *more);
    }
    r->text = more;
    r->text[r->n_text++] = (vv_text){key, value};
    r->n_last = strlen(value);
    return VV_OK;
}

/* Comments of other programs are there under the key "Comment". What goes beyond the limits is left out. */
static vv_status take_comment(reader *r, const char *comment, size_t n)
{
    size_t n_key = 0;
    bool more = false;
    const size_t at = value_of(comment, n, &n_key, &more);
    if (r->n_text >= TEXTS_MOST || n > VVI_JPEG_TEXT_MOST - r->held)
        return VV_OK;
    r->held += n;
    if (at == 0)
        return add(r, vvi_strdup("Comment"), vvi_text_utf8(comment, n));
    const char *last = r->n_text > 0 ? r->text[r->n_text - 1].key : "";
    if (more && strlen(last) == n_key && memcmp(last, comment, n_key) == 0)
        return append(r, comment + at, strnlen(comment + at, n - at));
    return add(r, vvi_asprintf("%.*s", (int)n_key, comment), vvi_asprintf("%.*s", (int)(n - at), comment + at));
}

static boolean read_comment(j_decompress_ptr jpeg)
{
    reader *r = of(jpeg);
    const size_t hi = next_byte(jpeg), length = hi << 8 | next_byte(jpeg);
    char comment[65536];
    if (length < 2)
        leave(jpeg, vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "the JPEG has a comment of no length"));
    for (size_t i = 0; i + 2 < length; i++)
        comment[i] = (char)next_byte(jpeg);
    const vv_status st = take_comment(r, comment, length - 2);
    if (st != VV_OK)
        leave(jpeg, st);
    return TRUE;
}

/* Pixels --------------------------------------------------------------------------------------------------------- */

static void read_head(void *user)
{
    reader *r = user;
    jpeg_create_decompress(&r->jpeg);
    r->jpeg.client_data = r;
    r->feed = (struct jpeg_source_mgr){.init_source = nothing,
                                       .fill_input_buffer = fill,
                                       .skip_input_data = skip,
                                       .resync_to_restart = jpeg_resync_to_restart,
                                       .term_source = nothing};
    r->watch = (struct jpeg_progress_mgr){.progress_monitor = watch};
    r->jpeg.src = &r->feed;
    r->jpeg.progress = &r->watch;
    jpeg_set_marker_processor(&r->jpeg, JPEG_COM, read_comment);
    jpeg_read_header(&r->jpeg, TRUE);
}

/* libjpeg itself holds all coefficients of a picture of several scans. */
static vv_status take_room(reader *r)
{
    bool exact;
    const uint64_t width = r->jpeg.image_width, height = r->jpeg.image_height;
    const uint64_t left = vvi_source_left(r->source, &exact) + r->feed.bytes_in_buffer;
    if (width * height / PIXELS_PER_BYTE_MOST > left)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "the JPEG says %u x %u pixels, but the %llu bytes that follow cannot hold them",
                          r->jpeg.image_width, r->jpeg.image_height, (unsigned long long)left);
    const uint64_t coefficients = jpeg_has_multiple_scans(&r->jpeg) ? width * height * 3 * sizeof(JCOEF) : 0;
    vv_status st = vvi_memory_plan(r->job, width * height * 16 + coefficients, "the image");
    if (st == VV_OK)
        st = vv_image_new(&r->image, (int32_t)width, (int32_t)height, 0, r->job);
    if (st == VV_OK && !(r->row = vvi_alloc(r->job, (size_t)width * 3, VVI_MEM_SCRATCH)))
        st = vv_fail_memory((size_t)width * 3);
    for (int code = 0; code < 256; code++)
        r->linear[code] = (float)vv_srgb_decode(code / 255.0);
    return st;
}

static void read_pixels(void *user)
{
    reader *r = user;
    r->jpeg.out_color_space = JCS_RGB;
    r->jpeg.dct_method = JDCT_ISLOW;
    jpeg_start_decompress(&r->jpeg);
    while (r->jpeg.output_scanline < r->jpeg.output_height) {
        float *rgba = r->image->rgba + (size_t)r->jpeg.output_scanline * r->jpeg.output_width * 4;
        JSAMPROW row = r->row;
        jpeg_read_scanlines(&r->jpeg, &row, 1);
        for (size_t x = 0; x < r->jpeg.output_width; x++, rgba += 4) {
            for (size_t c = 0; c < 3; c++)
                rgba[c] = r->linear[r->row[3 * x + c]];
            rgba[3] = 1;
        }
    }
    jpeg_finish_decompress(&r->jpeg);
}

static vv_status step(reader *r, void (*fn)(void *user))
{
    if (vvi_jpeg_guard(&r->error, fn, r))
        return VV_OK;
    if (r->error.status != VV_OK)
        return r->error.status;
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                      "the JPEG is damaged or of a kind that is not "
                      "read: %s",
                      r->error.text);
}

static vv_status read_all(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    reader *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->source = source;
    r->job = job;
    r->jpeg.err = vvi_jpeg_error_init(&r->error);
    vv_status st = step(r, read_head);
    if (st == VV_OK && out && (st = take_room(r)) == VV_OK)
        st = step(r, read_pixels);
    jpeg_destroy_decompress(&r->jpeg); /* zeroed is fine */
    if (st == VV_OK && out) {
        *out = r->image;
        r->image = NULL;
    }
    if (st == VV_OK && text_out && n_text_out) {
        *text_out = r->text;
        *n_text_out = r->n_text;
    } else {
        vv_text_free(r->text, r->n_text);
    }
    vv_image_release(r->image);
    vvi_free(r->row);
    vvi_free(r);
    return st;
}

vv_status vvi_jpeg_read(vv_image **out, vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    *out = NULL;
    return read_all(out, text_out, n_text_out, source, job);
}

vv_status vvi_jpeg_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    *text_out = NULL;
    *n_text_out = 0;
    return read_all(NULL, text_out, n_text_out, source, job);
}
