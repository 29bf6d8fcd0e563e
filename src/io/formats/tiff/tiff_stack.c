/* Which page is which plane of the volume, what its samples are, and whether they lie as plain bytes. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include "io/placement.h"
#include "io/sample_writer.h"

/* Reduced copies and masks, as NewSubfileType marks them. */
static bool is_secondary(const vvi_tiff_page *p)
{
    return (p->subfile & 5) != 0;
}

vv_status vvi_tiff_stack(vvi_tiff *tiff, vv_source *source, vv_notes *notes, vv_job *job)
{
    size_t first = 0, n = 0, others = 0;
    while (first + 1 < tiff->n_pages && is_secondary(&tiff->pages[first]))
        first++;
    vv_status st = vvi_tiff_check_page(&tiff->pages[first], source);
    if (st != VV_OK)
        return st;
    tiff->planes = vvi_alloc(job, tiff->n_pages * sizeof *tiff->planes, VVI_MEM_MODEL);
    if (!tiff->planes)
        return vv_fail_memory(tiff->n_pages * sizeof *tiff->planes);
    for (size_t i = first; i < tiff->n_pages && st == VV_OK; i++) {
        const vvi_tiff_page *p = &tiff->pages[i];
        if (i != first && is_secondary(p))
            continue;
        if (!vvi_tiff_same_kind(p, &tiff->pages[first])) {
            others++;
            continue;
        }
        tiff->planes[n++] = (uint32_t)i;
        st = vvi_tiff_check_page(p, source);
    }
    tiff->channels = tiff->frames = 1;
    tiff->slices = (int64_t)n;
    if (st == VV_OK && others > 0)
        st =
            vvi_notes_warn(notes, "%zu of its pages have another size or type than the first and are left out", others);
    if (st == VV_OK && tiff->cut)
        st = vvi_notes_warn(notes, "its chain of pages breaks off after page %zu: the file is cut short or damaged",
                            tiff->n_pages);
    return st;
}

/* Plain bytes ----------------------------------------------------------------------------------------------------- */

/* Whether a page's strips follow each other without gaps, and where the first lies. */
static vv_status find_run(bool *is_run, uint64_t *offset, const vvi_tiff_reader *r, const vvi_tiff_page *p)
{
    const uint64_t n = vvi_tiff_chunks(p);
    *is_run = false;
    if (p->tiled || p->counts.n < n)
        return n == 1 && !p->tiled ? (*is_run = true, vvi_tiff_numbers(offset, r, &p->offsets, 0, 1)) : VV_OK;
    uint64_t *at = vvi_alloc(r->job, (size_t)n * 2 * sizeof *at, VVI_MEM_SCRATCH);
    if (!at)
        return vv_fail_memory((size_t)n * 2 * sizeof *at);
    vv_status st = vvi_tiff_chunk_place(at, at + n, r, p, 0, n);
    *is_run = st == VV_OK;
    for (uint64_t i = 0; i + 1 < n && *is_run; i++) {
        const uint64_t bytes = vvi_tiff_chunk_row_bytes(p) * vvi_tiff_chunk_rows(p, i);
        *is_run = at[n + i] == bytes && at[i + 1] == at[i] + bytes;
    }
    *offset = at[0];
    vvi_free(at);
    return st;
}

/* Which of the orders of channel, slice and frame is the file's: planes lie one after another in it. */
static bool find_order(int order[3], const vvi_tiff *tiff, const uint64_t *at, uint64_t plane_bytes)
{
    static const int orders[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
    const uint64_t n[3] = {(uint64_t)tiff->channels, (uint64_t)tiff->slices, (uint64_t)tiff->frames};
    for (int o = 0; o < 6; o++) {
        uint64_t step[3], at_step = 1;
        bool fits = true;
        for (int a = 0; a < 3; a++) {
            step[orders[o][a]] = at_step;
            at_step *= n[orders[o][a]];
        }
        for (uint64_t i = 0; i < at_step && fits; i++) {
            const uint64_t c = i % n[0], z = i / n[0] % n[1], t = i / n[0] / n[1];
            fits = at[i] == at[0] + (c * step[0] + z * step[1] + t * step[2]) * plane_bytes;
        }
        if (fits) {
            for (int a = 0; a < 3; a++)
                order[a] = orders[o][a];
            return true;
        }
    }
    return false;
}

static void add_axis(vvi_layout *layout, int64_t n, vvi_role role)
{
    layout->axis[layout->n_axes++] = (vvi_layout_axis){n, role};
}

static void lay_out(vvi_tiff *tiff, const vvi_tiff_page *p, const int order[3])
{
    vvi_layout *layout = &tiff->layout;
    *layout = (vvi_layout){
        .type = vvi_tiff_type(p), .half = tiff->half, .swap = p->bits > 8 && vvi_order_swapped(p->big_endian)};
    if (p->samples > 1 && p->planar == 1)
        add_axis(layout, p->samples, VVI_ROLE_COMPONENT);
    add_axis(layout, p->width, VVI_ROLE_X);
    add_axis(layout, p->height, VVI_ROLE_Y);
    if (p->samples > 1 && p->planar == 2)
        add_axis(layout, p->samples, VVI_ROLE_COMPONENT);
    for (int a = 0; a < 3; a++) {
        if (order[a] == 0 && p->samples == 1)
            add_axis(layout, tiff->channels, VVI_ROLE_COMPONENT);
        if (order[a] == 1)
            add_axis(layout, tiff->slices, VVI_ROLE_Z);
        if (order[a] == 2)
            add_axis(layout, tiff->frames, VVI_ROLE_FRAME);
    }
}

static bool may_be_plain(const vvi_tiff *tiff, size_t n_planes)
{
    for (size_t i = 0; i < n_planes; i++) {
        if (tiff->planes[i] == VVI_TIFF_NO_PAGE)
            return false;
        const vvi_tiff_page *p = &tiff->pages[tiff->planes[i]];
        if (p->compression != VVI_TIFF_PLAIN || p->tiled || p->fill_order != 1 || p->bits % 8 != 0 || p->file != 0 ||
            (p->samples > 1 && tiff->channels > 1))
            return false;
    }
    return !tiff->files || !tiff->files[0];
}

static vv_status find_plain(vvi_tiff *tiff, const vvi_tiff_page *page, vv_source *source, size_t n, vv_job *job)
{
    int order[3];
    bool run = true;
    const vvi_tiff_reader r = {source, tiff->n_bytes, page->big_endian, page->big, job};
    const uint64_t plane_bytes = (uint64_t)page->width * page->height * page->samples * (page->bits / 8u);
    if (!may_be_plain(tiff, n))
        return VV_OK;
    uint64_t *at = vvi_alloc(job, n * sizeof *at, VVI_MEM_SCRATCH);
    if (!at)
        return vv_fail_memory(n * sizeof *at);
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK && run; i++)
        st = find_run(&run, &at[i], &r, &tiff->pages[tiff->planes[i]]);
    if (st == VV_OK && run && find_order(order, tiff, at, plane_bytes)) {
        lay_out(tiff, page, order);
        tiff->plain = true;
        tiff->offset = at[0];
        tiff->mappable =
            vvi_layout_mappable(&tiff->layout, at[0]) && vvi_source_mappable(source, at[0], plane_bytes * n);
        st = vvi_source_expect_half(source, at[0], plane_bytes * n, "its pages");
    }
    vvi_free(at);
    return st;
}

/* What samples are ------------------------------------------------------------------------------------------------ */

/* How many bytes one byte of the file can become. */
static uint64_t expansion(const vvi_tiff_page *p, const vvi_limits *limits)
{
    switch (p->compression) {
    case VVI_TIFF_PLAIN:
        return p->bits < 8 ? 16 : 2; /* half of the samples are enough */
    case VVI_TIFF_LZW:
        return 4096;
    case VVI_TIFF_DEFLATE:
    case VVI_TIFF_PNG:
    case 32946:
        return limits->expansion_gzip;
    default:
        return limits->expansion_zstd;
    }
}

static vv_status check_size(const vv_field_info *info, const vvi_tiff *tiff, const vvi_tiff_page *p, vv_source *source)
{
    uint64_t bytes, largest = 0;
    const uint64_t times = expansion(p, vvi_source_limits(source));
    vv_status st = vv_field_info_bytes(&bytes, info);
    for (size_t i = 0; i < tiff->n_pages && p->compression != VVI_TIFF_PLAIN; i++) {
        const vvi_tiff_page *q = &tiff->pages[i];
        const uint64_t chunk = vvi_tiff_chunk_row_bytes(q) * q->chunk_height;
        largest = chunk > largest ? chunk : largest;
    }
    if (st == VV_OK &&
        (bytes / times > tiff->n_bytes / (uint64_t)info->n_frames + 4096 || largest / times > tiff->n_bytes + 4096))
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "promises %llu bytes of samples, more than a file of %llu bytes can hold; it is cut short or "
                          "damaged",
                          (unsigned long long)(largest > bytes ? largest : bytes), (unsigned long long)tiff->n_bytes);
    return st;
}

static vv_status describe_colors(vv_field_info *info, const vvi_tiff *tiff, const vvi_tiff_page *p, vv_notes *notes)
{
    const bool colors = p->photometric == VVI_TIFF_RGB || p->photometric == VVI_TIFF_YCBCR;
    if (tiff->channels == 1 && colors && p->samples == 3)
        info->meaning = VV_MEANING_RGB;
    if (tiff->channels == 1 && colors && p->samples == 4)
        info->meaning = VV_MEANING_RGBA;
    if (info->meaning == VV_MEANING_RGBA && p->extra == 1)
        return vvi_notes_warn(notes, "its colours are multiplied by their alpha and are read as they are stored");
    if (p->photometric == VVI_TIFF_WHITE_IS_ZERO && p->bits > 1)
        return vvi_notes_warn(notes, "its zeros mean white; samples are read as they are stored");
    if (p->photometric == VVI_TIFF_PALETTE)
        return vvi_notes_warn(notes, "its samples are indices into a colour palette and are read as numbers");
    return VV_OK;
}

/* The picture stands as the orientation tag says: rows of the file may be its columns, and run backwards. */
static void orient(vv_affine *a, int orientation, const int64_t dims[3])
{
    if (orientation < 2 || orientation > 8)
        return;
    const bool turned = orientation >= 5;
    const bool flip[2] = {orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7,
                          orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8};
    const double length[2] = {a->axis[0].x, a->axis[1].y};
    for (int i = 0; i < 2; i++) {
        const int along = turned ? 1 - i : i;
        const double step = flip[along] ? -length[i] : length[i];
        a->axis[i] = along == 0 ? (vv_vec3){step, 0, 0} : (vv_vec3){0, step, 0};
        if (flip[along])
            *(along == 0 ? &a->origin.x : &a->origin.y) += (double)(dims[i] - 1) * length[i];
    }
}

vv_status vvi_tiff_describe(vv_field_info *info, vvi_tiff *tiff, vv_source *source, vv_notes *notes, vv_job *job)
{
    const size_t n = (size_t)(tiff->channels * tiff->slices * tiff->frames);
    const char *name = vvi_source_name(source);
    size_t first = 0;
    while (first < n && tiff->planes[first] == VVI_TIFF_NO_PAGE)
        first++;
    if (first == n)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "none of its planes is there");
    const vvi_tiff_page *p = &tiff->pages[tiff->planes[first]];
    info->grid.dims[0] = p->width;
    info->grid.dims[1] = p->height;
    info->grid.dims[2] = tiff->slices;
    info->n_frames = tiff->frames;
    info->components = (int)(tiff->channels * p->samples);
    info->type = vvi_tiff_type(p);
    tiff->half = p->format == VVI_TIFF_FLOAT && p->bits == 16;
    orient(&info->grid.index_to_world, p->orientation, info->grid.dims);
    vv_status st = describe_colors(info, tiff, p, notes);
    if (st == VV_OK && (st = vvi_source_lacks(source, check_size(info, tiff, p, source))) == VV_OK)
        st = find_plain(tiff, p, source, n, job);
    return st;
}
