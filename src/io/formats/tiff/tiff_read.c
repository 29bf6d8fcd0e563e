/* Samples of a box from chunks: their bytes are read one after another, then decoded side by side, a batch at a time.
 */
#include "io/formats/tiff/tiff_read.h"
#include "core/job.h"
#include "core/memory.h"
#include <string.h>

#define BATCH_BYTES ((uint64_t)32 << 20)

/* Fetching -------------------------------------------------------------------------------------------------------- */

static vv_status make_room(vvi_tiff_reading *r, size_t n)
{
    if (r->used + n <= r->room)
        return VV_OK;
    const size_t room = r->used + n < r->room * 2 ? r->room * 2 : r->used + n;
    uint8_t *grown = vvi_realloc(r->job, r->batch, room, VVI_MEM_SCRATCH);
    if (!grown)
        return vv_fail_memory(room);
    r->batch = grown;
    r->room = room;
    return VV_OK;
}

/* The chunk's bytes into the batch: as many as there are. */
static vv_status fetch(vvi_tiff_reading *r, vvi_tiff_chunk *c, uint64_t offset, uint64_t n)
{
    const uint64_t left = offset < r->reader.n_bytes ? r->reader.n_bytes - offset : 0;
    c->at = r->used;
    c->blank = n == 0;
    c->n = c->blank ? 0 : (size_t)(n < left ? n : left);
    vv_status st = make_room(r, c->n + 16);
    if (st == VV_OK && c->n > 0 && (st = vvi_source_seek(r->source, offset)) == VV_OK)
        st = vvi_source_read_whole(r->source, r->batch + c->at, c->n, &c->n);
    if (st == VV_OK && c->page->compression != VVI_TIFF_PLAIN && n > c->n)
        c->n = 0; /* cut short: what a decoder makes of a part is not to be trusted */
    r->used += (c->n + 15) / 16 * 16;
    return st;
}

static vv_status add_chunk(vvi_tiff_reading *r, const vvi_tiff_chunk *c, uint64_t offset, uint64_t n)
{
    const vvi_tiff_window a = vvi_tiff_window_of(r, c);
    if (a.x0 >= a.x1 || a.y0 >= a.y1)
        return VV_OK;
    if (r->n_chunks == VVI_TIFF_BATCH || (r->n_chunks > 0 && r->used + n > BATCH_BYTES)) {
        vv_status st = vvi_tiff_flush(r);
        if (st != VV_OK)
            return st;
    }
    r->chunks[r->n_chunks] = *c;
    vv_status st = fetch(r, &r->chunks[r->n_chunks], offset, n);
    if (st == VV_OK)
        r->n_chunks++;
    return st;
}

static vv_status use_file(vvi_tiff_reading *r, const vvi_tiff_page *p)
{
    bool exact;
    vv_status st = VV_OK;
    const char *name = r->tiff->files ? r->tiff->files[p->file] : NULL;
    if (name && (!r->beside || p->file != r->file)) {
        vvi_source_close(r->beside);
        r->beside = NULL;
        if ((st = vvi_source_open_beside(&r->beside, r->main, name, r->job)) != VV_OK ||
            (st = vvi_source_spool(r->beside, r->job)) != VV_OK)
            return st;
        r->file = p->file;
    }
    r->source = name ? r->beside : r->main;
    if ((st = vvi_source_seek(r->source, 0)) != VV_OK)
        return st;
    r->reader = (vvi_tiff_reader){r->source, vvi_source_left(r->source, &exact), p->big_endian, p->big, r->job};
    return VV_OK;
}

/* JPEG tables are of a page: chunks of pages with different ones are never in one batch. */
static vv_status use_tables(vvi_tiff_reading *r, const vvi_tiff_page *p)
{
    const bool has = p->compression == VVI_TIFF_JPEG && p->jpeg_tables.n > 0;
    if (!has && !r->tables)
        return VV_OK;
    vv_status st = vvi_tiff_flush(r);
    vvi_free(r->tables);
    r->tables = NULL;
    r->n_tables = 0;
    if (st != VV_OK || !has)
        return st;
    char *text;
    if ((st = vvi_tiff_text(&text, &r->reader, &p->jpeg_tables, vvi_job_limits(r->job)->string_bytes)) != VV_OK ||
        !text)
        return st;
    r->tables = (uint8_t *)text;
    r->n_tables =
        (size_t)(p->jpeg_tables.n < vvi_job_limits(r->job)->string_bytes ? p->jpeg_tables.n
                                                                         : vvi_job_limits(r->job)->string_bytes);
    return VV_OK;
}

static vv_status read_page(vvi_tiff_reading *r, const vvi_tiff_page *p, int64_t slice, int component)
{
    const uint64_t n = vvi_tiff_chunks(p), plane = n / (p->planar == 2 ? p->samples : 1u);
    vv_status st = use_file(r, p);
    if (st != VV_OK || (st = use_tables(r, p)) != VV_OK)
        return st;
    uint64_t *places = vvi_alloc(r->job, (size_t)n * 2 * sizeof *places, VVI_MEM_SCRATCH);
    if (!places)
        return vv_fail_memory((size_t)n * 2 * sizeof *places);
    st = vvi_tiff_chunk_place(places, places + n, &r->reader, p, 0, n);
    if (st == VV_E_FORMAT) { /* the table itself is cut off: nothing of the page is there */
        for (uint64_t i = 0; i < n; i++) {
            places[i] = UINT64_MAX;
            places[n + i] = 1;
        }
        st = VV_OK;
    }
    for (uint64_t i = 0; i < n && st == VV_OK; i++) {
        const vvi_tiff_chunk c = {.page = p, .number = i, .slice = slice, .component = component + (int)(i / plane)};
        st = add_chunk(r, &c, places[i], places[n + i]);
    }
    vvi_free(places);
    return st;
}

static void leave_out(vvi_tiff_reading *r, int64_t slice, int component, int n)
{
    const size_t pixels = (size_t)(r->box->n[0] * r->box->n[1]);
    uint8_t *out = r->out + (size_t)slice * pixels * r->pixel + (size_t)component * r->element;
    const int byte = vv_type_is_float(r->info->type) ? 0xff : 0;
    for (size_t i = 0; i < pixels; i++)
        memset(out + i * r->pixel, byte, (size_t)n * r->element);
    r->missing += pixels * (size_t)n;
}

static vv_status read_planes(vvi_tiff_reading *r, int64_t frame)
{
    const vvi_tiff *t = r->tiff;
    const int samples = r->info->components / (int)t->channels;
    vv_status st = VV_OK;
    for (int64_t k = 0; k < r->box->n[2] && st == VV_OK; k++)
        for (int64_t c = 0; c < t->channels && st == VV_OK; c++) {
            const int64_t z = r->box->lo[2] + k;
            const uint32_t page = t->planes[(frame * t->slices + z) * t->channels + c];
            if (page == VVI_TIFF_NO_PAGE)
                leave_out(r, k, (int)c * samples, samples);
            else
                st = read_page(r, &t->pages[page], k, (int)c * samples);
        }
    return st == VV_OK ? vvi_tiff_flush(r) : st;
}

static vv_status tell_missing(const vvi_tiff_reading *r)
{
    const unsigned long long there = r->total - r->missing, total = r->total;
    if (r->missing == 0)
        return VV_OK;
    if (r->missing > r->total / 2)
        return vv_fail_at(VV_E_FORMAT, r->name, NULL,
                          "is cut short or damaged: %llu of %llu numbers are there, less than half%s%s", there, total,
                          r->why[0] ? "; libtiff says: " : "", r->why);
    vvi_job_damage(r->job, "io", "%s: is cut short or damaged: %llu of %llu numbers are there, the rest is %s", r->name,
                   there, total, vv_type_is_float(r->info->type) ? "NaN" : "0");
    return VV_OK;
}

vv_status vvi_tiff_read(vv_field **out, const vv_field_info *info, const vvi_tiff *tiff, vv_source *source,
                        int64_t frame, const vv_box *region, vv_job *job)
{
    const vv_box box =
        region ? *region : (vv_box){{0, 0, 0}, {info->grid.dims[0], info->grid.dims[1], info->grid.dims[2]}};
    vv_field_info part = *info;
    uint64_t bytes;
    void *data;
    vv_field *field = NULL;
    *out = NULL;
    part.grid = vv_grid_crop(&info->grid, &box);
    part.frame = frame;
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK)
        return st;
    vvi_tiff_reading *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->info = info;
    r->tiff = tiff;
    r->box = &box;
    r->job = job;
    r->name = vvi_source_name(source);
    r->main = source;
    r->element = vv_type_bytes(info->type);
    r->pixel = r->element * (size_t)info->components;
    r->total = (uint64_t)(box.n[0] * box.n[1] * box.n[2]) * (uint64_t)info->components;
    if ((st = vv_field_new_empty(&field, &data, &part, job)) == VV_OK) {
        r->out = data;
        if ((st = read_planes(r, frame)) == VV_OK)
            st = tell_missing(r);
    }
    vvi_source_close(r->beside);
    vvi_free(r->batch);
    vvi_free(r->tables);
    vvi_free(r);
    if (st == VV_OK)
        *out = field;
    else
        vv_field_release(field);
    return st;
}
