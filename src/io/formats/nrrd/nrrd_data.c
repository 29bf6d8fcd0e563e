/* The samples of a NRRD as one run of elements in the order of the file, whatever files and encodings they lie in. */
#include "core/memory.h"
#include "io/coding.h"
#include "io/formats/nrrd/nrrd.h"
#include "io/numbers.h"
#include <ctype.h>
#include <string.h>

#define TEXT_ROOM ((size_t)64 << 10)
#define SCRATCH_ROOM ((size_t)256 << 10) /* one element of the most layers, and more */

typedef struct reader {
    const vvi_nrrd *h;
    vv_source *header;
    vv_job *job;
    size_t element_bytes;
    size_t file;        /* which is open; n_files (or 1): none yet */
    vv_source *raw;     /* detached data; NULL: the header's own source */
    vv_source *section; /* where coded elements come from; NULL: raw bytes at `base` */
    uint64_t base;
    vvi_numbers numbers;
    uint64_t at; /* element in the file that the hexadecimal text stands at */
    char *text;
    size_t text_at, text_end;
    uint8_t *scratch; /* of layers */
} reader;

static size_t n_files(const vvi_nrrd *h)
{
    return h->n_files ? h->n_files : 1;
}

static void close_file(reader *r)
{
    vvi_numbers_end(&r->numbers);
    vvi_source_close(r->section);
    vvi_source_close(r->raw);
    r->section = r->raw = NULL;
    r->file = SIZE_MAX;
}

static vvi_coding coding_of(const vvi_nrrd *h)
{
    switch (h->encoding) {
    case VVI_NRRD_GZIP:
        return VVI_CODING_GZIP;
    case VVI_NRRD_BZIP2:
        return VVI_CODING_BZIP2;
    case VVI_NRRD_ZSTD:
        return VVI_CODING_ZSTD;
    default:
        return VVI_CODING_NONE;
    }
}

static vv_status skip_lines(uint64_t *base, vv_source *source, int64_t n)
{
    const char *line;
    bool end = false;
    vv_status st = vvi_source_seek(source, *base);
    for (int64_t i = 0; i < n && st == VV_OK; i++) {
        st = vvi_source_line(source, &line, (size_t)vvi_source_limits(source)->string_bytes, &end);
        if (st == VV_OK && end)
            st = vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "has %lld lines; 'line skip' is %lld",
                            (long long)i, (long long)n);
    }
    *base = vvi_source_tell(source);
    return st;
}

/* Where the data of a file begin, after the lines and bytes to be skipped that are not coded. */
static vv_status find_base(uint64_t *base, const vvi_nrrd *h, vv_source *source, uint64_t bytes)
{
    vv_status st = VV_OK;
    bool exact;
    *base = h->n_files ? 0 : h->data_offset;
    if (h->line_skip > 0 && (st = skip_lines(base, source, h->line_skip)) != VV_OK)
        return st;
    if (h->encoding != VVI_NRRD_RAW)
        return VV_OK;
    if (h->byte_skip >= 0) {
        *base += (uint64_t)h->byte_skip;
        return VV_OK;
    }
    const uint64_t left = vvi_source_left(source, &exact), all = vvi_source_tell(source) + left;
    if (!exact)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL,
                          "'byte skip' is -1 (the data end the file), but how long the file is can only be known of a "
                          "plain one; decompress it or save it to a file first");
    if (all < *base || all - *base < bytes)
        return vvi_source_expect(source, *base, bytes, "samples");
    *base = all - bytes;
    return VV_OK;
}

/* Packed data in one piece: whoever reads slab after slab goes on where the last read ended. */
static bool goes_on(const vvi_nrrd *h)
{
    return n_files(h) == 1 && coding_of(h) != VVI_CODING_NONE;
}

static vv_status open_file(reader *r, size_t index)
{
    close_file(r);
    vv_status st = VV_OK;
    const vvi_nrrd *h = r->h;
    if (goes_on(h) && (r->section = vvi_source_kept(r->header, r->job))) {
        r->file = index;
        return VV_OK;
    }
    if (h->n_files)
        st = vvi_source_open_beside(&r->raw, r->header, h->file[index], r->job);
    vv_source *source = h->n_files ? r->raw : r->header;
    if (st != VV_OK || (st = find_base(&r->base, h, source, h->per_file * r->element_bytes)) != VV_OK)
        return st;
    r->at = 0;
    r->text_at = r->text_end = 0;
    r->file = index;
    if (h->encoding == VVI_NRRD_RAW)
        return VV_OK;
    st = vvi_source_section(&r->section, source, r->base, UINT64_MAX, coding_of(h), r->job);
    if (st == VV_OK && h->byte_skip > 0)
        st = vvi_source_skip(r->section, (uint64_t)h->byte_skip);
    if (st == VV_OK && h->encoding == VVI_NRRD_TEXT)
        st = vvi_numbers_begin(&r->numbers, r->section, h->type, h->per_file, r->job);
    return st;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

static vv_status more_text(reader *r, bool *end)
{
    vv_status st = VV_OK;
    if (r->text_at == r->text_end) {
        r->text_at = 0;
        st = vvi_source_read_some(r->section, r->text, TEXT_ROOM, &r->text_end);
    }
    *end = st == VV_OK && r->text_end == 0;
    return st;
}

static int hex_digit(char c)
{
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

static vv_status read_hex(reader *r, uint8_t *out, size_t n_bytes)
{
    bool end;
    vv_status st;
    for (size_t half = 0; half < 2 * n_bytes;) {
        if ((st = more_text(r, &end)) != VV_OK)
            return st;
        if (end)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->section), NULL,
                              "its hexadecimal data end too early; the file is cut short or its header wrong");
        const char c = r->text[r->text_at++];
        const int digit = hex_digit(c);
        if (digit < 0 && !isspace((unsigned char)c))
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(r->section), NULL, "has '%c' in its hexadecimal data",
                              isprint((unsigned char)c) ? c : '?');
        if (digit < 0)
            continue;
        out[half / 2] = (uint8_t)(half % 2 ? out[half / 2] | digit : digit << 4);
        half++;
    }
    r->at += n_bytes / r->element_bytes;
    return VV_OK;
}

/* Text has no positions: go on from where it stands, or begin again. */
static vv_status seek_hex(reader *r, uint64_t element)
{
    uint8_t thrown[256];
    vv_status st = VV_OK;
    if (element < r->at && (st = open_file(r, r->file)) != VV_OK)
        return st;
    while (r->at < element && st == VV_OK) {
        const uint64_t left = element - r->at, room = sizeof thrown / r->element_bytes;
        const size_t n = (size_t)(left < room ? left : room);
        st = read_hex(r, thrown, n * r->element_bytes);
    }
    return st;
}

static vv_status read_numbers(reader *r, void *out, uint64_t element, size_t n)
{
    vv_status st = VV_OK;
    if (element < r->numbers.at && (st = open_file(r, r->file)) != VV_OK)
        return st;
    st = vvi_numbers_skip(&r->numbers, element - r->numbers.at);
    return st == VV_OK ? vvi_numbers_read(&r->numbers, out, n) : st;
}

/* Elements -------------------------------------------------------------------------------------------------------- */

/* Less than n only where the file ends, and only of data that is one file: which of several is cut, its error tells. */
static vv_status read_in_file(reader *r, void *out, uint64_t element, size_t n, size_t *n_got)
{
    const vvi_nrrd *h = r->h;
    size_t bytes;
    vv_status st;
    *n_got = n;
    if (h->encoding == VVI_NRRD_TEXT)
        return read_numbers(r, out, element, n);
    if (h->encoding == VVI_NRRD_HEX) {
        st = seek_hex(r, element);
        return st == VV_OK ? read_hex(r, out, n * r->element_bytes) : st;
    }
    vv_source *source = r->section ? r->section : r->raw ? r->raw : r->header;
    const uint64_t base = r->section ? (uint64_t)h->byte_skip : r->base;
    st = vvi_source_seek(source, base + element * r->element_bytes);
    if (st != VV_OK || n_files(h) > 1)
        return st == VV_OK ? vvi_source_read(source, out, n * r->element_bytes, "samples") : st;
    st = vvi_source_read_whole(source, out, n * r->element_bytes, &bytes);
    *n_got = bytes / r->element_bytes;
    return st;
}

static vv_status check_end(void *user)
{
    reader *r = user;
    vv_source *source = r->section ? r->section : r->raw ? r->raw : r->header;
    const bool text = r->h->encoding == VVI_NRRD_TEXT || r->h->encoding == VVI_NRRD_HEX;
    if (text)
        return VV_OK;
    return n_files(r->h) > 1 ? vvi_source_check_end(source) : vvi_source_check_tail(source);
}

static vv_status read_elements(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    reader *r = user;
    *n_got = 0;
    for (size_t got = 0, m = 0; n > 0 && got == m; *n_got += got) {
        const size_t file = (size_t)(first / r->h->per_file);
        const uint64_t element = first % r->h->per_file, left = r->h->per_file - element;
        vv_status st = VV_OK;
        m = left < n ? (size_t)left : n;
        if (file != r->file && (st = open_file(r, file)) != VV_OK)
            return st;
        if ((st = read_in_file(r, out, element, m, &got)) != VV_OK)
            return st;
        if (n_files(r->h) > 1 && got == left && (st = check_end(r)) != VV_OK)
            return st;
        out = (uint8_t *)out + m * r->element_bytes;
        first += m;
        n -= m;
    }
    return VV_OK;
}

/* Elements of the layer among the first n of all layers. */
static uint64_t count_in_layer(const vvi_nrrd *h, uint64_t n)
{
    const uint64_t step = h->layer_step > 1 ? h->layer_step : 1, all = step * (uint64_t)h->n_layers;
    const uint64_t before = step * (uint64_t)h->layer, rest = n % all > before ? n % all - before : 0;
    return n / all * step + (rest < step ? rest : step);
}

/* Elements of one layer of segments; `scratch` has room for some of all layers. */
static vv_status read_layer(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    reader *r = user;
    const size_t bytes = r->element_bytes, layers = (size_t)r->h->n_layers, layer = (size_t)r->h->layer;
    const uint64_t step = r->h->layer_step;
    uint8_t *to = out;
    vv_status st = VV_OK;
    *n_got = 0;
    for (size_t m = 0, got = 0; n > 0 && st == VV_OK && got == m; first += m, n -= m, to += m * bytes, *n_got += got) {
        const uint64_t run = step > 1 ? step - first % step : SCRATCH_ROOM / (bytes * layers);
        m = run < n ? (size_t)run : n;
        if (step > 1) {
            st = read_elements(r, to, (first / step * layers + layer) * step + first % step, m, &got);
            continue;
        }
        st = read_elements(r, r->scratch, first * layers, m * layers, &got);
        got = (size_t)count_in_layer(r->h, got);
        for (size_t i = 0; i < got && st == VV_OK; i++)
            memcpy(to + i * bytes, r->scratch + (i * layers + layer) * bytes, bytes);
    }
    return st;
}

static uint64_t end_of_elements(const void *user)
{
    const reader *r = user;
    const vv_source *source = r->section ? r->section : r->raw ? r->raw : r->header;
    const uint64_t base = r->section ? (uint64_t)r->h->byte_skip : r->base, end = vvi_source_end(source);
    const uint64_t n = end > base ? (end - base) / r->element_bytes : 0;
    return r->h->n_layers ? count_in_layer(r->h, n) : n;
}

vv_status vvi_nrrd_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                        const vv_box *region, vv_job *job)
{
    const vvi_nrrd *h = plan;
    reader r = {.h = h, .header = source, .job = job, .element_bytes = vv_type_bytes(h->type), .file = SIZE_MAX};
    vv_status st = VV_OK;
    *out = NULL;
    if (h->encoding == VVI_NRRD_RAW && n_files(h) == 1 && !h->n_layers) {
        if ((st = open_file(&r, 0)) == VV_OK)
            st = vvi_layout_read_plain(out, info, &h->layout, r.raw ? r.raw : source, r.base, frame, region, job);
        close_file(&r);
        return st;
    }
    if (h->encoding == VVI_NRRD_HEX) {
        r.text = vvi_alloc(job, TEXT_ROOM, VVI_MEM_SCRATCH);
        if (!r.text)
            return vv_fail_memory(TEXT_ROOM);
    }
    if (h->n_layers && !(r.scratch = vvi_alloc(job, SCRATCH_ROOM, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(SCRATCH_ROOM);
    vvi_elements elements = {.user = &r,
                             .read_some = h->n_layers ? read_layer : read_elements,
                             .end = end_of_elements,
                             .end_by_bytes = h->encoding != VVI_NRRD_HEX,
                             .name = h->n_files ? h->file[0] : vvi_source_name(source),
                             .check_end = check_end};
    if (st == VV_OK && n_files(h) == 1 && (st = open_file(&r, 0)) == VV_OK)
        elements.source = r.section;
    if (st == VV_OK)
        st = vvi_layout_read(out, info, &h->layout, &elements, frame, region, job);
    if (st == VV_OK && goes_on(h)) {
        vvi_source_keep(source, r.section);
        r.section = NULL;
    }
    close_file(&r);
    vvi_free(r.text);
    vvi_free(r.scratch);
    return st;
}

/* Before anything is read ------------------------------------------------------------------------------------------ */

static vv_status share_among_files(vvi_nrrd *h, uint64_t all)
{
    const size_t n = n_files(h);
    const int sub = h->sub_dimension ? h->sub_dimension : n > 1 ? h->dimension - 1 : h->dimension;
    uint64_t slabs = 1;
    for (int a = sub; a < h->dimension; a++)
        slabs *= (uint64_t)h->axis[a].size;
    if (sub == h->dimension) /* the files divide the slowest axis */
        slabs = (uint64_t)h->axis[h->dimension - 1].size % n == 0 ? n : 0;
    if (slabs != n)
        return vv_fail_at(VV_E_FORMAT, h->name, NULL,
                          "names %zu data files, which do not divide its axes into slabs of %d dimensions", n, sub);
    h->per_file = all / n;
    return VV_OK;
}

/* Samples as text take a digit each and something between them. */
static uint64_t coded_bytes(const vvi_nrrd *h)
{
    if (h->encoding == VVI_NRRD_TEXT)
        return 2 * h->per_file - 1;
    return h->per_file * vv_type_bytes(h->type) * (h->encoding == VVI_NRRD_HEX ? 2 : 1);
}

static vv_status check_file(vvi_nrrd *h, reader *r, size_t index)
{
    vv_status st = open_file(r, index);
    if (st != VV_OK)
        return st;
    vv_source *source = r->section ? r->section : r->raw ? r->raw : r->header;
    const uint64_t from = r->section ? (uint64_t)h->byte_skip : r->base;
    if (r->section && h->byte_skip < 0)
        return VV_OK;
    const bool text = h->encoding == VVI_NRRD_TEXT || h->encoding == VVI_NRRD_HEX;
    return text || n_files(h) > 1 ? vvi_source_expect(source, from, coded_bytes(h), "samples")
                                  : vvi_source_expect_half(source, from, coded_bytes(h), "samples");
}

vv_status vvi_nrrd_check_data(vvi_nrrd *h, vv_source *source, vv_job *job)
{
    uint64_t all = 0;
    vv_status st = vvi_layout_count(&all, &h->layout, h->name);
    all *= h->n_layers ? (uint64_t)h->n_layers : 1;
    if (st != VV_OK || (st = share_among_files(h, all)) != VV_OK)
        return st;
    reader r = {.h = h, .header = source, .job = job, .element_bytes = vv_type_bytes(h->type), .file = SIZE_MAX};
    for (size_t i = 0; i < n_files(h) && st == VV_OK; i++)
        st = check_file(h, &r, i);
    if (st == VV_OK && n_files(h) == 1 && h->encoding == VVI_NRRD_RAW && !h->n_layers)
        h->mappable = vvi_layout_mappable(&h->layout, r.base) &&
                      vvi_source_mappable(r.raw ? r.raw : source, r.base, all * r.element_bytes);
    close_file(&r);
    return st;
}
