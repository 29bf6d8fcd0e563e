/* What one page is made of, and whether it can be read. */
#include "io/formats/tiff/tiff.h"

vv_type vvi_tiff_type(const vvi_tiff_page *p)
{
    static const vv_type types[3][4] = {{VV_TYPE_U8, VV_TYPE_U16, VV_TYPE_U32, VV_TYPE_U64},
                                        {VV_TYPE_I8, VV_TYPE_I16, VV_TYPE_I32, VV_TYPE_I64},
                                        {VV_TYPE_F32, VV_TYPE_F32, VV_TYPE_F32, VV_TYPE_F64}};
    const int size = p->bits <= 8 ? 0 : p->bits <= 16 ? 1 : p->bits <= 32 ? 2 : 3;
    return types[p->format - 1][size];
}

static bool has_type(const vvi_tiff_page *p)
{
    const int b = p->bits;
    if (p->format == VVI_TIFF_UNSIGNED)
        return (b >= 1 && b <= 16) || b == 32 || b == 64;
    if (p->format == VVI_TIFF_SIGNED)
        return b == 8 || b == 16 || b == 32 || b == 64;
    return p->format == VVI_TIFF_FLOAT && (b == 16 || b == 32 || b == 64);
}

static vv_status check_samples(const vvi_tiff_page *p, const char *name)
{
    static const char *const formats[] = {"?", "unsigned", "signed", "float", "?", "complex integer", "complex"};
    if (!has_type(p))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "has %d-bit %s samples; integers of 1 to 16, 32 and 64 bits and floats of 16, 32 and 64 can "
                          "be read",
                          p->bits, p->format < 7 ? formats[p->format] : "?");
    if (p->samples < 1 || p->samples > 4096)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has %d samples per pixel; 1 to 4096 are allowed", p->samples);
    if (p->planar != 1 && p->planar != 2)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its PlanarConfiguration is %d; 1 and 2 are known", p->planar);
    if (p->photometric == VVI_TIFF_YCBCR && p->compression != VVI_TIFF_JPEG)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "stores colours as YCbCr without JPEG; save it as RGB and read that");
    return VV_OK;
}

vv_status vvi_tiff_check_page(const vvi_tiff_page *p, vv_source *source)
{
    const char *name = vvi_source_name(source);
    const uint64_t most = vvi_source_limits(source)->dim;
    if (p->width < 1 || p->height < 1 || p->width > most || p->height > most)
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "a page has %lu x %lu pixels; 1 to %llu are allowed (--limit dim=N allows more)",
                          (unsigned long)p->width, (unsigned long)p->height, (unsigned long long)most);
    vv_status st = check_samples(p, name);
    if (st != VV_OK)
        return st;
    if (p->chunk_width < 1 || p->chunk_height < 1 || p->chunk_width > most || p->chunk_height > most)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has tiles or strips of %lu x %lu pixels",
                          (unsigned long)p->chunk_width, (unsigned long)p->chunk_height);
    if (p->offsets.n < vvi_tiff_chunks(p))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "says where %llu of the %llu tiles or strips of a page are",
                          (unsigned long long)p->offsets.n, (unsigned long long)vvi_tiff_chunks(p));
    if (p->counts.n < vvi_tiff_chunks(p) && p->compression != VVI_TIFF_PLAIN && vvi_tiff_chunks(p) > 1)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "does not say how long its tiles or strips are");
    return vvi_tiff_codec_check(p, name);
}

bool vvi_tiff_same_kind(const vvi_tiff_page *a, const vvi_tiff_page *b)
{
    return a->width == b->width && a->height == b->height && a->samples == b->samples && a->bits == b->bits &&
           a->format == b->format && a->photometric == b->photometric && a->orientation == b->orientation;
}

uint32_t vvi_tiff_chunk_rows(const vvi_tiff_page *p, uint64_t chunk)
{
    const uint64_t down = vvi_tiff_chunks_down(p), row = chunk / vvi_tiff_chunks_across(p) % down;
    if (p->tiled || row + 1 < down)
        return p->chunk_height;
    return (uint32_t)(p->height - row * p->chunk_height);
}

vv_status vvi_tiff_chunk_place(uint64_t *offset, uint64_t *n, const vvi_tiff_reader *r, const vvi_tiff_page *p,
                               uint64_t chunk, uint64_t n_chunks)
{
    vv_status st = vvi_tiff_numbers(offset, r, &p->offsets, chunk, (size_t)n_chunks);
    if (st == VV_OK && p->counts.n >= chunk + n_chunks)
        st = vvi_tiff_numbers(n, r, &p->counts, chunk, (size_t)n_chunks);
    else
        for (uint64_t i = 0; i < n_chunks; i++)
            n[i] = UINT64_MAX; /* not said */
    for (uint64_t i = 0; i < n_chunks && p->compression == VVI_TIFF_PLAIN && st == VV_OK; i++) {
        const uint64_t all = vvi_tiff_chunk_row_bytes(p) * vvi_tiff_chunk_rows(p, chunk + i);
        if (n[i] > all || (n[i] == 0 && offset[i] != 0))
            n[i] = all;
    }
    for (uint64_t i = 0; i < n_chunks && st == VV_OK; i++)
        if (n[i] == UINT64_MAX)
            n[i] = offset[i] < r->n_bytes ? r->n_bytes - offset[i] : 0;
    return st;
}
