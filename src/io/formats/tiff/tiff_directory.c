/* Directories of TIFF 6.0 and BigTIFF: https://www.itu.int/itudoc/itu-t/com16/tiff-fx/docs/tiff6.pdf,
 * http://bigtiff.org. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include <string.h>

#define ENTRIES_MOST 4096

/* Numbers of either byte order ------------------------------------------------------------------------------------ */

static uint64_t number(const vvi_tiff_reader *r, const uint8_t *at, int bytes)
{
    uint64_t v = 0;
    for (int i = 0; i < bytes; i++)
        v = v << 8 | at[r->big_endian ? i : bytes - 1 - i];
    return v;
}

static int type_bytes(uint16_t type)
{
    static const uint8_t bytes[] = {0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    return type < sizeof bytes ? bytes[type] : 0;
}

static vv_status read_at(const vvi_tiff_reader *r, uint64_t where, void *out, size_t n, const char *what)
{
    const char *name = vvi_source_name(r->source);
    if (where > r->n_bytes || n > r->n_bytes - where)
        return vv_fail_at(VV_E_FORMAT, name, NULL,
                          "%s should lie at byte %llu, but the file ends after %llu; it is cut short or damaged", what,
                          (unsigned long long)where, (unsigned long long)r->n_bytes);
    vv_status st = vvi_source_seek(r->source, where);
    return st == VV_OK ? vvi_source_read(r->source, out, n, what) : st;
}

vv_status vvi_tiff_numbers(uint64_t *out, const vvi_tiff_reader *r, const vvi_tiff_array *array, uint64_t first,
                           size_t n)
{
    uint8_t piece[4096];
    const size_t bytes = (size_t)type_bytes(array->type);
    if ((n == 1 && first == 0) || bytes == 0) {
        *out = array->first;
        return VV_OK;
    }
    while (n > 0) {
        const size_t m = n < sizeof piece / bytes ? n : sizeof piece / bytes;
        vv_status st = read_at(r, array->where + first * bytes, piece, m * bytes, "its table of strips");
        if (st != VV_OK)
            return st;
        for (size_t i = 0; i < m; i++)
            *out++ = number(r, piece + i * bytes, (int)bytes);
        first += m;
        n -= m;
    }
    return VV_OK;
}

vv_status vvi_tiff_text(char **out, const vvi_tiff_reader *r, const vvi_tiff_array *array, uint64_t most)
{
    uint64_t lacks;
    const vv_status st = vvi_tiff_text_there(out, &lacks, r, array, most);
    if (st != VV_OK || !lacks)
        return st;
    vvi_free(*out); /* a text that is cut off is no reason to refuse the samples */
    *out = NULL;
    return VV_OK;
}

vv_status vvi_tiff_text_there(char **out, uint64_t *lacks_out, const vvi_tiff_reader *r, const vvi_tiff_array *array,
                              uint64_t most)
{
    *out = NULL;
    *lacks_out = 0;
    if (array->n == 0)
        return VV_OK;
    const uint64_t left = array->where < r->n_bytes ? r->n_bytes - array->where : 0;
    size_t n = (size_t)(array->n < most ? array->n : most);
    if (n > left) {
        *lacks_out = n - left;
        n = (size_t)left;
    }
    if (n == 0)
        return VV_OK;
    char *text = vvi_alloc(r->job, n + 1, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory(n + 1);
    vv_status st = read_at(r, array->where, text, n, "its description");
    text[n] = 0;
    if (st != VV_OK)
        vvi_free(text);
    else
        *out = text;
    return st;
}

/* Entries --------------------------------------------------------------------------------------------------------- */

typedef struct entry {
    uint16_t tag, type;
    uint64_t n, where; /* where: of its values, in the file */
    uint64_t first;    /* the first value of whole numbers */
} entry;

static bool is_whole(uint16_t type)
{
    return type == 1 || type == 3 || type == 4 || type == 13 || type == 16 || type == 18;
}

static vv_status read_entry(entry *e, const vvi_tiff_reader *r, const uint8_t *at, uint64_t where)
{
    const int value_at = r->big ? 12 : 8, room = r->big ? 8 : 4;
    uint8_t first[8] = {0};
    vv_status st = VV_OK;
    *e = (entry){.tag = (uint16_t)number(r, at, 2),
                 .type = (uint16_t)number(r, at + 2, 2),
                 .n = number(r, at + 4, r->big ? 8 : 4),
                 .where = where + (uint64_t)value_at};
    const int bytes = type_bytes(e->type);
    if (bytes == 0 || e->n > r->n_bytes / (uint64_t)bytes)
        e->n = 0; /* an entry of an unknown kind, or longer than the file: as if it were not there */
    if (e->n == 0)
        return VV_OK;
    memcpy(first, at + value_at, (size_t)room);
    if (e->n * (uint64_t)bytes > (uint64_t)room) {
        e->where = number(r, at + value_at, room);
        if (!is_whole(e->type))
            return VV_OK;
        if (e->where > r->n_bytes || (uint64_t)bytes > r->n_bytes - e->where)
            e->n = 0;
        else
            st = read_at(r, e->where, first, (size_t)bytes, "a value of its directory");
    }
    e->first = is_whole(e->type) ? number(r, first, bytes) : 0;
    return st;
}

/* TIFF has a number for each sample of a pixel; all must be the same. */
static vv_status same_for_samples(uint16_t *out, const vvi_tiff_reader *r, const entry *e, const char *what)
{
    uint64_t values[16] = {0};
    const size_t n = (size_t)(e->n < 16 ? e->n : 16);
    const vvi_tiff_array array = {e->where, e->n, e->first, e->type};
    vv_status st = VV_OK;
    *out = (uint16_t)e->first;
    if (n > 1 && (st = vvi_tiff_numbers(values, r, &array, 0, n)) != VV_OK)
        return st;
    for (size_t i = 1; i < n; i++)
        if (values[i] != values[0])
            return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(r->source), NULL,
                              "its samples have different %s; save it with one kind of samples", what);
    return VV_OK;
}

static vv_status read_ratio(double *out, const vvi_tiff_reader *r, const entry *e)
{
    uint8_t bytes[8];
    if (e->type != 5 || e->n != 1 || e->where > r->n_bytes || r->n_bytes - e->where < 8)
        return VV_OK;
    vv_status st = read_at(r, e->where, bytes, 8, "its resolution");
    if (st == VV_OK && number(r, bytes + 4, 4) > 0)
        *out = (double)number(r, bytes, 4) / (double)number(r, bytes + 4, 4);
    return st;
}

static uint16_t to_u16(uint64_t v)
{
    return (uint16_t)(v < UINT16_MAX ? v : UINT16_MAX);
}

static uint32_t to_u32(uint64_t v)
{
    return (uint32_t)(v < UINT32_MAX ? v : UINT32_MAX);
}

static vv_status take_picture(vvi_tiff_page *p, const vvi_tiff_reader *r, const entry *e)
{
    switch (e->tag) {
    case 254:
        p->subfile = to_u32(e->first);
        return VV_OK;
    case 32997: /* ImageDepth, TileDepth */
    case 32998:
        return e->first <= 1
                   ? VV_OK
                   : vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(r->source), NULL,
                                "a page or its tiles are %llu slices deep, which is not read; save a page for "
                                "each slice",
                                (unsigned long long)e->first);
    case 256:
        p->width = to_u32(e->first);
        return VV_OK;
    case 257:
        p->height = to_u32(e->first);
        return VV_OK;
    case 258:
        return same_for_samples(&p->bits, r, e, "numbers of bits");
    case 259:
        p->compression = to_u16(e->first);
        return VV_OK;
    case 262:
        p->photometric = to_u16(e->first);
        return VV_OK;
    case 266:
        p->fill_order = to_u16(e->first);
        return VV_OK;
    case 274:
        p->orientation = to_u16(e->first);
        return VV_OK;
    case 277:
        p->samples = to_u16(e->first);
        return VV_OK;
    case 284:
        p->planar = to_u16(e->first);
        return VV_OK;
    case 317:
        p->predictor = to_u16(e->first);
        return VV_OK;
    case 338:
        p->n_extra = to_u16(e->n);
        p->extra = to_u16(e->first);
        return VV_OK;
    case 339:
        return same_for_samples(&p->format, r, e, "formats");
    default:
        return VV_OK;
    }
}

static void take_array(vvi_tiff_page *p, const entry *e)
{
    const vvi_tiff_array array = {e->where, e->n, e->first, e->type};
    const bool text = e->type == 2 || e->type == 1 || e->type == 7;
    if ((e->tag == 273 || e->tag == 324) && is_whole(e->type)) {
        p->offsets = array;
        p->tiled = e->tag == 324;
    } else if ((e->tag == 279 || e->tag == 325) && is_whole(e->type)) {
        p->counts = array;
    } else if (e->tag == 320 && e->type == 3) {
        p->colors = array;
    } else if (e->tag == 50838 && is_whole(e->type)) {
        p->imagej_lengths = array;
    } else if (text && e->tag == 50839) {
        p->imagej_data = array;
    } else if (text && e->tag == 270 && p->description.n == 0) {
        p->description = array;
    } else if (text && e->tag == 305) {
        p->software = array;
    } else if (text && e->tag == 306) {
        p->date = array;
    } else if (text && e->tag == 700) {
        p->xmp = array;
    } else if (text && e->tag == 347) {
        p->jpeg_tables = array;
    }
}

static vv_status take_entry(vvi_tiff_page *p, const vvi_tiff_reader *r, const entry *e)
{
    if (e->n == 0)
        return VV_OK;
    if (e->tag == 282 || e->tag == 283)
        return read_ratio(&p->resolution[e->tag - 282], r, e);
    if (e->tag == 296)
        p->resolution_unit = to_u16(e->first);
    else if (e->tag == 278 || e->tag == 323)
        p->chunk_height = to_u32(e->first);
    else if (e->tag == 322)
        p->chunk_width = to_u32(e->first);
    take_array(p, e);
    return is_whole(e->type) ? take_picture(p, r, e) : VV_OK;
}

/* Directories ------------------------------------------------------------------------------------------------------ */

static void finish_page(vvi_tiff_page *p)
{
    if (!p->tiled) {
        p->chunk_width = p->width;
        if (p->chunk_height > p->height)
            p->chunk_height = p->height;
    }
    if (p->format == 4 || p->format == 0)
        p->format = VVI_TIFF_UNSIGNED; /* "undefined" */
}

/* The directory at `where`; *next is where the one after it lies, 0 at the end. */
static vv_status read_directory(vvi_tiff_page *page, uint64_t *next, const vvi_tiff_reader *r, uint64_t where,
                                uint8_t *room)
{
    const size_t n_bytes = r->big ? 8 : 2, entry_bytes = r->big ? 20 : 12, link = r->big ? 8 : 4;
    uint8_t head[8];
    vv_status st = read_at(r, where, head, n_bytes, "a directory of a page");
    if (st != VV_OK)
        return st;
    const uint64_t n = number(r, head, (int)n_bytes);
    if (n == 0 || n > ENTRIES_MOST)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                          "the directory at byte %llu has %llu entries; 1 to %d are allowed", (unsigned long long)where,
                          (unsigned long long)n, ENTRIES_MOST);
    const size_t bytes = (size_t)n * entry_bytes;
    if ((st = read_at(r, where + n_bytes, room, bytes + link, "a directory of a page")) != VV_OK)
        return st;
    *page = (vvi_tiff_page){.bits = 1,
                            .samples = 1,
                            .compression = 1,
                            .photometric = 1,
                            .planar = 1,
                            .predictor = 1,
                            .format = 1,
                            .fill_order = 1,
                            .orientation = 1,
                            .resolution_unit = 2,
                            .chunk_height = UINT32_MAX,
                            .big_endian = r->big_endian,
                            .big = r->big};
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        entry e;
        st = read_entry(&e, r, room + i * entry_bytes, where + n_bytes + i * entry_bytes);
        if (st == VV_OK)
            st = take_entry(page, r, &e);
    }
    *next = number(r, room + bytes, (int)link);
    finish_page(page);
    return st;
}

static vv_status read_head(vvi_tiff_reader *r, uint64_t *first)
{
    uint8_t head[16];
    const char *name = vvi_source_name(r->source);
    vv_status st = read_at(r, 0, head, 8, "the TIFF header");
    if (st != VV_OK)
        return st;
    r->big_endian = head[0] == 'M';
    const uint64_t version = number(r, head + 2, 2);
    if (head[0] != head[1] || (head[0] != 'I' && head[0] != 'M') || (version != 42 && version != 43))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is not a TIFF file: it does not begin with II*, MM* or BigTIFF's");
    r->big = version == 43;
    if (!r->big) {
        *first = number(r, head + 4, 4);
        return VV_OK;
    }
    if (number(r, head + 4, 2) != 8)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "is a BigTIFF file whose offsets have %llu bytes instead of 8",
                          (unsigned long long)number(r, head + 4, 2));
    if ((st = read_at(r, 0, head, 16, "the BigTIFF header")) == VV_OK)
        *first = number(r, head + 8, 8);
    return st;
}

vv_status vvi_tiff_add_page(vvi_tiff *tiff, const vvi_tiff_page *page, vv_job *job)
{
    if (tiff->n_pages == tiff->room_pages) {
        const size_t room = tiff->room_pages ? tiff->room_pages * 2 : 16;
        vvi_tiff_page *grown = vvi_realloc(job, tiff->pages, room * sizeof *grown, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        tiff->pages = grown;
        tiff->room_pages = room;
    }
    tiff->pages[tiff->n_pages++] = *page;
    return VV_OK;
}

/* Links that lead back are found with a second, slower walker: the chain is met at every power of two (Brent). */
static vv_status read_chain(vvi_tiff *tiff, const vvi_tiff_reader *r, uint64_t where, uint32_t file, bool one,
                            uint8_t *room)
{
    uint64_t met = 0, steps = 0, power = 1;
    const size_t before = tiff->n_pages;
    vv_status st = VV_OK;
    while (where != 0 && st == VV_OK) {
        vvi_tiff_page page;
        uint64_t next = 0;
        if (where == met || tiff->n_pages - before >= vvi_job_limits(r->job)->dim) {
            st = vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL,
                            where == met ? "its chain of pages is circular"
                                         : "has more pages than an axis may have samples (--limit dim=N allows more)");
            break;
        }
        if (++steps == power) {
            met = where;
            power *= 2;
        }
        if ((st = vvi_job_poll(r->job)) != VV_OK || (st = read_directory(&page, &next, r, where, room)) != VV_OK)
            break;
        page.file = file;
        st = vvi_tiff_add_page(tiff, &page, r->job);
        where = one ? 0 : next;
    }
    /* A chain that breaks off, in a file that is cut short, leaves the pages before. */
    if (st == VV_E_FORMAT && tiff->n_pages > before) {
        tiff->cut = true;
        return VV_OK;
    }
    return st;
}

static vv_status read_pages(vvi_tiff *tiff, vvi_tiff_reader *r, vv_source *source, uint32_t file, bool one, vv_job *job)
{
    bool exact;
    uint64_t first = 0;
    *r = (vvi_tiff_reader){.source = source, .job = job};
    vv_status st = vvi_source_seek(source, 0);
    if (st != VV_OK)
        return st;
    r->n_bytes = vvi_source_left(source, &exact);
    tiff->n_bytes += r->n_bytes;
    if ((st = read_head(r, &first)) != VV_OK)
        return st;
    if (first == 0)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "is a TIFF file without pages");
    uint8_t *room = vvi_alloc(job, ENTRIES_MOST * 20 + 8, VVI_MEM_SCRATCH);
    if (!room)
        return vv_fail_memory(ENTRIES_MOST * 20 + 8);
    st = read_chain(tiff, r, first, file, one, room);
    vvi_free(room);
    return st;
}

vv_status vvi_tiff_read_pages(vvi_tiff *tiff, vvi_tiff_reader *r, vv_source *source, uint32_t file, vv_job *job)
{
    return read_pages(tiff, r, source, file, false, job);
}

vv_status vvi_tiff_read_first_page(vvi_tiff *tiff, vvi_tiff_reader *r, vv_source *source, vv_job *job)
{
    return read_pages(tiff, r, source, 0, true, job);
}
