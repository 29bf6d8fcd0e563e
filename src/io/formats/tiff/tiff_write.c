/* Pages one after another: channels fastest, then slices, then frames, as ImageJ and our OME-XML say. */
#include "io/formats/tiff/tiff_write.h"
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "registry.h"
#include <math.h>
#include <string.h>
#include <strings.h>

/* Samples of uncompressed files begin at a multiple of this, so that they can be mapped whatever their type. */
#define ALIGNMENT 64
#define STRIP_BYTES ((size_t)256 << 10)
#define SLAB_BYTES ((size_t)16 << 20) /* of the field, fetched at once */
/* A step that strays less than this from its axis is along it. */
#define STRAIGHT 1e-6

/* What offsets of 32 bits can reach, with room for directories and for what compression makes longer. */
static bool needs_big(const vvi_tiff_writing *w)
{
    const double bytes = (double)w->n_pages * ((double)w->page_bytes + 512 + 16.0 * (double)w->n_strips);
    return bytes * (w->compression == VVI_TIFF_PLAIN ? 1 : 2) > 4.2e9;
}

static vv_status choose_encoding(vvi_tiff_writing *w)
{
    static const struct {
        const char *name;
        int compression;
    } known[] = {
        {"raw", VVI_TIFF_PLAIN}, {"deflate", VVI_TIFF_DEFLATE}, {"lzw", VVI_TIFF_LZW}, {"zstd", VVI_TIFF_ZSTD}};
    const char *name = w->options->encoding ? w->options->encoding : "raw";
    w->compression = VVI_TIFF_PLAIN;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(name, known[i].name) == 0)
            w->compression = known[i].compression;
    /* wider numbers and floats gain less, and few programs read them then */
    w->predictor = w->compression != VVI_TIFF_PLAIN && vv_type_bytes(w->info->type) <= 2 ? 2 : 1;
#if !VV_HAVE_ZSTD
    if (w->compression == VVI_TIFF_ZSTD)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_sink_name(w->sink), NULL, "this build of VolVis has no Zstandard");
#endif
    return VV_OK;
}

static vv_status plan(vvi_tiff_writing *w, size_t n_frames)
{
    const vv_field_info *info = w->info;
    w->turn = vvi_turn_pages(&info->grid, STRAIGHT);
    const bool colors = (info->meaning == VV_MEANING_RGB && info->components == 3) ||
                        (info->meaning == VV_MEANING_RGBA && info->components == 4);
    w->samples = colors ? info->components : 1;
    w->channels = colors ? 1 : info->components;
    w->n_pages = (uint64_t)w->channels * (uint64_t)w->turn.grid.dims[2] * n_frames;
    w->big_endian = w->options->big_endian;
    w->resolution[0] = w->resolution[1] = 1;
    w->resolution_unit = 1;
    vv_status st =
        vvi_mul3_size(&w->row_bytes, (size_t)w->turn.grid.dims[0], (size_t)w->samples, vv_type_bytes(info->type));
    if (st == VV_OK)
        st = vvi_mul_size(&w->page_bytes, w->row_bytes, (size_t)w->turn.grid.dims[1]);
    if (st != VV_OK || (st = choose_encoding(w)) != VV_OK)
        return st;
    if (w->row_bytes == 0) /* no field is without samples */
        return vv_fail(VV_E_INTERNAL, "a row of a TIFF has no bytes");
    const size_t rows = STRIP_BYTES / w->row_bytes > 0 ? STRIP_BYTES / w->row_bytes : 1;
    const bool whole = w->compression == VVI_TIFF_PLAIN || rows > (size_t)w->turn.grid.dims[1];
    w->rows = whole ? (uint32_t)w->turn.grid.dims[1] : (uint32_t)rows;
    w->rows = w->rows > 0 ? w->rows : 1;
    w->n_strips = ((uint64_t)w->turn.grid.dims[1] + w->rows - 1) / w->rows;
    w->big = needs_big(w);
    return VV_OK;
}

/* What VolVis itself cannot read back, and what others will not see. */
static void warn_of_loss(const vvi_tiff_writing *w, bool ome)
{
    const char *name = vvi_sink_name(w->sink);
    vvi_text t = {0};
    if (w->options->n_labels > 0)
        vvi_text_add(&t, ", names of labels");
    for (size_t c = 0, told = 0; ome && c < w->options->n_channels && w->options->channels; c++)
        if (w->options->channels[c].lo < w->options->channels[c].hi && told++ == 0)
            vvi_text_add(&t, ", ranges of channels");
    if (t.n > 2 && !t.bad)
        vvi_log(w->job, VV_LOG_WARNING, "io", "%s: TIFF cannot keep: %s; write .nrrd to keep all", name, t.s + 2);
    vvi_text_free(&t);
    if (!w->turn.straight && w->turn.grid.dims[2] > 1)
        vvi_log(w->job, VV_LOG_WARNING, "io",
                "%s: TIFF has no directions of axes: VolVis reads them back, but other programs will show it as if it "
                "were upright%s",
                name, w->turn.mirrored ? ", and mirrored" : "");
}

/* Samples of one page ------------------------------------------------------------------------------------------------
 */

/* Slices of the file that are fetched together: where they lie across those of the field, one alone would cost as much
 * as many. */
typedef struct slab {
    vv_brick brick;
    int64_t first, n;
} slab;

static void free_slab(slab *s)
{
    if (s->n > 0)
        vv_brick_release(&s->brick);
    s->n = 0;
}

static vv_status fetch_slab(slab *s, const vvi_tiff_writing *w, const vv_field *field, int64_t slice)
{
    const int64_t slices = w->turn.grid.dims[2], most = (int64_t)(SLAB_BYTES / (w->page_bytes * (size_t)w->channels));
    const int64_t wanted = w->turn.axis[2] == 2 || most < 1 ? 1 : most, left = slices - slice;
    if (slice >= s->first && slice < s->first + s->n)
        return VV_OK;
    free_slab(s);
    s->first = slice;
    const int64_t n = wanted < left ? wanted : left;
    const vv_box box = vvi_turn_slices(&w->turn, slice, n);
    vv_status st = vv_field_brick(&s->brick, field, &box, w->job);
    s->n = st == VV_OK ? n : 0;
    return st;
}

static void pack_page(uint8_t *out, const vvi_tiff_writing *w, const slab *s, int64_t slice, int component)
{
    const int64_t *n = w->turn.grid.dims;
    const size_t bytes = vv_type_bytes(w->info->type), pixel = bytes * (size_t)w->samples;
    int64_t step[3];
    const uint8_t *first = vvi_turn_brick(step, &w->turn, &s->brick) + (slice - s->first) * step[2];
    for (int64_t j = 0; j < n[1]; j++) {
        const uint8_t *row = first + j * step[1] + (size_t)component * bytes;
        uint8_t *to = out + (size_t)j * w->row_bytes;
        if (step[0] == (int64_t)pixel)
            memcpy(to, row, w->row_bytes);
        else
            for (int64_t i = 0; i < n[0]; i++)
                memcpy(to + (size_t)i * pixel, row + i * step[0], pixel);
    }
    if (bytes > 1 && vvi_order_swapped(w->big_endian))
        vvi_swap_bytes(out, bytes, w->page_bytes / bytes);
}

typedef struct page_sink {
    const vvi_tiff_writing *w;
    uint8_t *samples; /* of one page */
    uint8_t *coded;   /* strips of it, strip_room apart */
    size_t strip_room;
    uint64_t *offsets, *counts;
    uint64_t at; /* bytes written */
} page_sink;

static vv_status encode_item(void *scratch, void *shared, size_t index)
{
    page_sink *p = shared;
    const vvi_tiff_writing *w = p->w;
    const size_t first = index * w->rows, all = (size_t)w->turn.grid.dims[1];
    const size_t rows = all - first < w->rows ? all - first : w->rows;
    size_t n = 0;
    (void)scratch;
    vv_status st = vvi_tiff_encode(p->coded + index * p->strip_room, p->strip_room, &n,
                                   p->samples + first * w->row_bytes, rows * w->row_bytes, w);
    p->counts[index] = n;
    return st;
}

static vv_status write_text(page_sink *p, vvi_text *t)
{
    vv_status st = t->bad ? vv_fail_memory(t->n) : vvi_sink_write(p->w->sink, t->s, t->n);
    p->at += t->n;
    vvi_text_free(t);
    return st;
}

/* Where the directory's size is needed before what it says is known. */
static uint64_t directory_bytes(const page_sink *p, bool first)
{
    vvi_text t = {0};
    vvi_tiff_put_directory(&t, p->w, first, 0, p->offsets, p->counts, 0);
    const uint64_t n = t.n;
    vvi_text_free(&t);
    return n;
}

static vv_status write_coded_page(page_sink *p, bool first, bool last)
{
    static const uint8_t zero[2] = {0};
    const vvi_tiff_writing *w = p->w;
    const vvi_work work = {.item = encode_item};
    vvi_text t = {0};
    vv_status st = vvi_parallel_for(w->job, &work, p, (size_t)w->n_strips);
    if (st != VV_OK)
        return st;
    uint64_t at = p->at + directory_bytes(p, first);
    for (uint64_t i = 0; i < w->n_strips; i++) {
        p->offsets[i] = at;
        at += p->counts[i];
    }
    vvi_tiff_put_directory(&t, w, first, p->at, p->offsets, p->counts, last ? 0 : at + at % 2);
    st = write_text(p, &t);
    for (uint64_t i = 0; i < w->n_strips && st == VV_OK; i++)
        st = vvi_sink_write(w->sink, p->coded + i * p->strip_room, (size_t)p->counts[i]);
    if (st == VV_OK && at % 2 && !last)
        st = vvi_sink_write(w->sink, zero, 1); /* directories lie at even places */
    p->at = at + at % 2;
    return st;
}

/* All directories first, then all samples in one run. */
static vv_status write_plain_directories(page_sink *p)
{
    static const uint8_t zeros[ALIGNMENT] = {0};
    const vvi_tiff_writing *w = p->w;
    const uint64_t first = directory_bytes(p, true), other = directory_bytes(p, false);
    const uint64_t end = p->at + first + (w->n_pages - 1) * other;
    const uint64_t samples = (end + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    vv_status st = VV_OK;
    for (uint64_t i = 0; i < w->n_pages && st == VV_OK; i++) {
        vvi_text t = {0};
        const uint64_t next = p->at + (i == 0 ? first : other);
        p->offsets[0] = samples + i * w->page_bytes;
        p->counts[0] = w->page_bytes;
        vvi_tiff_put_directory(&t, w, i == 0, p->at, p->offsets, p->counts, i + 1 < w->n_pages ? next : 0);
        st = write_text(p, &t);
    }
    return st == VV_OK ? vvi_sink_write(w->sink, zeros, (size_t)(samples - end)) : st;
}

static vv_status write_page(page_sink *p, slab *s, const vv_field *field, uint64_t page)
{
    const vvi_tiff_writing *w = p->w;
    const int64_t slice = (int64_t)(page / (uint64_t)w->channels % (uint64_t)w->turn.grid.dims[2]);
    vv_status st = fetch_slab(s, w, field, slice);
    if (st != VV_OK)
        return st;
    pack_page(p->samples, w, s, slice, (int)(page % (uint64_t)w->channels));
    st = w->compression == VVI_TIFF_PLAIN ? vvi_sink_write(w->sink, p->samples, w->page_bytes)
                                          : write_coded_page(p, page == 0, page + 1 == w->n_pages);
    return st == VV_OK ? vvi_job_progress(w->job, "write", page + 1, w->n_pages) : st;
}

static vv_status write_pages(page_sink *p, const vv_field *const *frames, size_t n_frames)
{
    const vvi_tiff_writing *w = p->w;
    const uint64_t n = w->n_pages / n_frames;
    uint64_t page = 0;
    vvi_text t = {0};
    vvi_tiff_put_head(&t, w, w->big ? 16 : 8);
    vv_status st = write_text(p, &t);
    if (st == VV_OK && w->compression == VVI_TIFF_PLAIN)
        st = write_plain_directories(p);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++) {
        slab s = {.n = 0};
        for (uint64_t i = 0; i < n && st == VV_OK; i++, page++)
            st = write_page(p, &s, frames[f], page);
        free_slab(&s);
        if (st == VV_OK)
            st = vv_field_health(frames[f]);
    }
    return st;
}

static vv_status write_file(const vvi_tiff_writing *w, const vv_field *const *frames, size_t n_frames)
{
    page_sink p = {.w = w, .strip_room = vvi_tiff_encode_bound(w->compression, w->rows * w->row_bytes)};
    const bool coded = w->compression != VVI_TIFF_PLAIN;
    size_t coded_bytes = 0;
    vv_status st = coded ? vvi_mul_size(&coded_bytes, p.strip_room, (size_t)w->n_strips) : VV_OK;
    if (st != VV_OK)
        return st;
    p.samples = vvi_alloc(w->job, w->page_bytes, VVI_MEM_SCRATCH);
    p.coded = coded ? vvi_alloc(w->job, coded_bytes, VVI_MEM_SCRATCH) : NULL;
    p.offsets = vvi_alloc_zeroed(w->job, (size_t)w->n_strips * 2 * sizeof *p.offsets, VVI_MEM_SCRATCH);
    if (!p.samples || (coded && !p.coded) || !p.offsets) {
        st = vv_fail_memory(w->page_bytes + coded_bytes);
    } else {
        p.counts = p.offsets + w->n_strips;
        st = write_pages(&p, frames, n_frames);
    }
    vvi_free(p.samples);
    vvi_free(p.coded);
    vvi_free(p.offsets);
    return st;
}

static vv_status write_as(bool ome, vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                          const vv_write_options *options, vv_job *job)
{
    vvi_tiff_writing w = {.sink = sink, .job = job, .info = vv_field_get_info(frames[0]), .options = options};
    vvi_text description = {0};
    vv_status st = plan(&w, n_frames);
    if (st != VV_OK)
        return st;
    warn_of_loss(&w, ome);
    vvi_tiff_own_fill(&w.own, w.info, &w.turn.grid, n_frames, ome);
    if (ome)
        st = vvi_tiff_ome_text(&description, &w, n_frames);
    else
        vvi_tiff_imagej_text(&description, &w, n_frames);
    if (!ome)
        st = vvi_tiff_extras_build(&w.extras, &w);
    if (st == VV_OK && description.bad)
        st = vv_fail_memory(description.n);
    w.description = description.s;
    if (st == VV_OK)
        st = write_file(&w, frames, n_frames);
    vvi_text_free(&description);
    vvi_tiff_extras_free(&w.extras);
    return st;
}

vv_status vvi_tiff_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                         vv_job *job)
{
    return write_as(false, sink, frames, n_frames, options, job);
}

vv_status vvi_tiff_write_ome(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job)
{
    return write_as(true, sink, frames, n_frames, options, job);
}

static const char *const suffixes[] = {".ome.tif", ".ome.tiff", ".ome.btf", NULL};
static const char *const encodings[] = {"raw", "deflate", "lzw", "zstd", NULL};

const vv_format vvi_format_ome_tiff = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "ome-tiff",
    .doc = "TIFF with OME-XML: channels, spacing, time (for writing; read by the format tiff)",
    .suffixes = suffixes,
    .encodings = encodings,
    .write = vvi_tiff_write_ome,
    .types = ~(1u << VV_TYPE_U64 | 1u << VV_TYPE_I64),
};
