/* PNG and JPEG files as pages of one chunk: all of the file. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices.h"
#include <string.h>

static uint32_t be(const uint8_t *at, int bytes)
{
    uint32_t v = 0;
    for (int i = 0; i < bytes; i++)
        v = v << 8 | at[i];
    return v;
}

static void set_size(vvi_tiff_page *p, uint32_t width, uint32_t height, uint32_t bits, uint32_t samples)
{
    p->width = p->chunk_width = width;
    p->height = p->chunk_height = height;
    p->bits = (uint16_t)bits;
    p->samples = (uint16_t)samples;
}

/* IHDR comes first. Palettes become colours; grey loses its transparency. */
static bool png_page(vvi_tiff_page *p, const uint8_t *head, size_t n)
{
    static const uint8_t signature[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    if (n < 33 || memcmp(head, signature, 8) != 0 || memcmp(head + 12, "IHDR", 4) != 0)
        return false;
    const uint32_t bits = head[24], type = head[25], samples = type == 2 || type == 3 ? 3 : type == 6 ? 4 : 1;
    set_size(p, be(head + 16, 4), be(head + 20, 4), bits == 16 ? 16 : 8, samples);
    p->compression = VVI_TIFF_PNG;
    p->photometric = samples > 1 ? VVI_TIFF_RGB : VVI_TIFF_BLACK_IS_ZERO;
    return true;
}

/* The frame header tells size and components; segments before it are stepped over. */
static bool jpeg_page(vvi_tiff_page *p, const uint8_t *head, size_t n)
{
    if (n < 4 || head[0] != 0xff || head[1] != 0xd8)
        return false;
    for (size_t at = 2; at + 10 <= n && head[at] == 0xff;) {
        const uint8_t marker = head[at + 1];
        if (marker == 0xff) { /* fill */
            at++;
            continue;
        }
        if (marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc) {
            set_size(p, be(head + at + 7, 2), be(head + at + 5, 2), head[at + 4], head[at + 9]);
            p->compression = VVI_TIFF_JPEG;
            p->photometric = head[at + 9] == 3 ? VVI_TIFF_YCBCR : VVI_TIFF_BLACK_IS_ZERO;
            return true;
        }
        at += 2 + be(head + at + 2, 2);
    }
    return false;
}

bool vvi_slices_page(vvi_tiff_page *p, const uint8_t *head, size_t n)
{
    const uint16_t one = 1;
    *p = (vvi_tiff_page){.planar = 1,
                         .predictor = 1,
                         .format = VVI_TIFF_UNSIGNED,
                         .fill_order = 1,
                         .orientation = 1,
                         .resolution_unit = 1,
                         .offsets = {.n = 1},
                         .is_file = true,
                         .big_endian = *(const uint8_t *)&one == 0};
    return png_page(p, head, n) || jpeg_page(p, head, n);
}

#define HEAD_BYTES ((size_t)1 << 18) /* JPEG may have a profile and a thumbnail before its frame header */

vv_status vvi_slices_add(vvi_tiff *t, vv_source *source, uint32_t file, vv_job *job)
{
    bool exact;
    vvi_tiff_page page;
    vvi_tiff_reader r;
    size_t n = 0;
    const size_t before = t->n_pages;
    uint8_t *head = vvi_alloc(job, HEAD_BYTES, VVI_MEM_SCRATCH);
    if (!head)
        return vv_fail_memory(HEAD_BYTES);
    vv_status st = vvi_source_read_some(source, head, 64, &n);
    if (st == VV_OK && n >= 2 && head[0] == 0xff && head[1] == 0xd8) {
        size_t more = 0;
        st = vvi_source_read_some(source, head + n, HEAD_BYTES - n, &more);
        n += more;
    }
    if (st == VV_OK && n >= 4 && head[0] == head[1] && (head[0] == 'I' || head[0] == 'M')) {
        st = vvi_tiff_read_pages(t, &r, source, file, job);
    } else if (st == VV_OK && vvi_slices_page(&page, head, n)) {
        page.file = file;
        t->n_bytes += vvi_source_tell(source) + vvi_source_left(source, &exact);
        st = vvi_tiff_add_page(t, &page, job);
    } else if (st == VV_OK) {
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "is neither TIFF nor PNG nor JPEG");
    }
    for (size_t i = before; i < t->n_pages && st == VV_OK; i++)
        st = vvi_tiff_check_page(&t->pages[i], source);
    vvi_free(head);
    if (st != VV_OK)
        t->n_pages = before;
    return st;
}
