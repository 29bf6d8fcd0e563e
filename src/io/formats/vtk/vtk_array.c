/* One array of VTK's XML files: its header, and its numbers wherever they lie. Blocks are read one after another and
 * unpacked side by side. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/vtk/vtk_block.h"
#include "io/formats/vtk/vtk_stream.h"
#include "io/number_text.h"
#include "io/sample_writer.h"
#include <stdio.h>
#include <string.h>

#define PACKED_BYTES ((size_t)4 << 20) /* of blocks read at once, unless one alone has more */

struct vvi_vtk_reader {
    const vvi_vtk_file *file;
    const vvi_vtk_array *array;
    vvi_vtk_stream stream;
    vv_job *job;
    size_t element;
    uint64_t bytes;           /* of all numbers */
    uint64_t data;            /* where the stream of the data begins in the file */
    uint64_t skip;            /* bytes of the stream before the first number */
    vvi_number_text *numbers; /* of text */
    /* compressed */
    uint64_t n_blocks, block, last; /* bytes of a block; of the last one when it is shorter, else 0 */
    uint64_t *at;                   /* where each block begins in the stream; n_blocks + 1 */
    uint8_t *state;                 /* of each block: bits below */
    uint8_t *packed, *kept;
    size_t packed_room;
    uint64_t kept_block; /* which block `kept` has; UINT64_MAX: none */
};

enum { BLOCK_READ = 1, BLOCK_BAD = 2 };

/* Headers -----------------------------------------------------------------------------------------------------------
 */

static uint64_t word_at(const vvi_vtk_reader *r, const uint8_t *at)
{
    uint64_t v = 0;
    for (size_t i = 0; i < r->file->word; i++)
        v = v << 8 | at[r->file->big_endian ? i : r->file->word - 1 - i];
    return v;
}

static vv_status fail_array(const vvi_vtk_reader *r, const char *text, uint64_t expected, uint64_t found)
{
    return vv_fail_at(VV_E_FORMAT, r->file->name, NULL,
                      "its array '%.60s' %s: %llu expected, %llu found; the file is cut short or its header wrong",
                      r->array->name, text, (unsigned long long)expected, (unsigned long long)found);
}

static vv_status read_words(const vvi_vtk_reader *r, uint64_t from, uint8_t *out, uint64_t n)
{
    size_t got;
    vv_status st =
        vvi_vtk_stream_read(&r->stream, r->array->begin, from * r->file->word, out, (size_t)n * r->file->word, &got);
    if (st == VV_OK && got < n * r->file->word)
        return fail_array(r, "has too short a header, in bytes", n * r->file->word, got);
    return st;
}

/* Half of it is enough: what is missing is told when it is read. */
static vv_status check_length(const vvi_vtk_reader *r, uint64_t need)
{
    const uint64_t there = r->data < r->array->end ? r->array->end - r->data : 0;
    return there < need / 2 ? fail_array(r, "needs more bytes than there are", need, there) : VV_OK;
}

static vv_status open_plain(vvi_vtk_reader *r)
{
    uint8_t word[8] = {0};
    r->data = r->array->begin;
    if (r->file->word == 0)
        return check_length(r, r->bytes);
    vv_status st = read_words(r, 0, word, 1);
    if (st != VV_OK)
        return st;
    if (word_at(r, word) != r->bytes)
        return fail_array(r, "has another size than its grid needs, in bytes", r->bytes, word_at(r, word));
    r->skip = r->file->word;
    return check_length(r, vvi_vtk_stream_length(r->array, r->skip + r->bytes));
}

static vv_status open_text(vvi_vtk_reader *r)
{
    r->data = r->array->begin;
    vv_status st = check_length(r, 2 * (r->bytes / r->element) - 1); /* a digit each, something between them */
    if (st != VV_OK)
        return st;
    const vv_type type = r->array->fractions ? VV_TYPE_F32 : r->array->type;
    return vvi_number_text_open(&r->numbers, r->stream.source, r->array->begin, r->array->end, type, r->job);
}

static vv_status check_blocks(const vvi_vtk_reader *r)
{
    const uint64_t whole = r->n_blocks - (r->last != 0);
    if (r->block == 0 || r->last >= r->block || whole > r->bytes / r->block || whole * r->block + r->last != r->bytes)
        return vv_fail_at(VV_E_FORMAT, r->file->name, NULL,
                          "its array '%.60s' has %llu blocks of %llu bytes, the last of %llu, which are not the %llu "
                          "bytes that its grid needs",
                          r->array->name, (unsigned long long)r->n_blocks, (unsigned long long)r->block,
                          (unsigned long long)(r->last ? r->last : r->block), (unsigned long long)r->bytes);
    return VV_OK;
}

/* Sizes of the packed blocks to where each begins. */
static vv_status read_block_sizes(vvi_vtk_reader *r)
{
    const uint64_t n = r->n_blocks, header = vvi_vtk_stream_length(r->array, (3 + n) * r->file->word);
    if (header > r->array->end - r->array->begin)
        return fail_array(r, "has too short a header, in bytes", header, r->array->end - r->array->begin);
    r->data = r->array->begin + header;
    uint8_t *words = vvi_alloc(r->job, (size_t)n * r->file->word, VVI_MEM_SCRATCH);
    r->at = vvi_alloc(r->job, (size_t)(n + 1) * sizeof *r->at, VVI_MEM_SCRATCH);
    r->state = vvi_alloc_zeroed(r->job, (size_t)n, VVI_MEM_SCRATCH);
    vv_status st = words && r->at && r->state ? read_words(r, 3, words, n) : vv_fail_memory((size_t)n * 8);
    uint64_t at = 0;
    for (uint64_t b = 0; b < n && st == VV_OK; b++) {
        const uint64_t size = word_at(r, words + b * r->file->word);
        r->at[b] = at;
        if (size > UINT64_MAX / 4 - at)
            st = fail_array(r, "has a packed block of an impossible size", 0, size);
        at += size;
    }
    if (st == VV_OK)
        r->at[n] = at;
    vvi_free(words);
    return st;
}

static vv_status open_blocks(vvi_vtk_reader *r)
{
    uint8_t words[24] = {0};
    vv_status st = vvi_vtk_compressor_available(r->file->compressor, r->file->name);
    if (st != VV_OK || (st = read_words(r, 0, words, 3)) != VV_OK)
        return st;
    r->n_blocks = word_at(r, words);
    r->block = word_at(r, words + r->file->word);
    r->last = word_at(r, words + 2 * r->file->word);
    if (r->last == r->block) /* some writers say so where VTK says 0 */
        r->last = 0;
    if ((st = check_blocks(r)) != VV_OK || (st = read_block_sizes(r)) != VV_OK)
        return st;
    const uint64_t packed = r->at[r->n_blocks];
    if (vvi_vtk_is_bomb(r->file->compressor, r->bytes, packed, r->job))
        return vv_fail_at(
            VV_E_FORMAT, r->file->name, NULL,
            "its array '%.60s' has %llu packed bytes for %llu, which no valid data has; --limit %s=N allows more",
            r->array->name, (unsigned long long)packed, (unsigned long long)r->bytes,
            vvi_vtk_expansion_limit(r->file->compressor));
    return check_length(r, vvi_vtk_stream_length(r->array, packed));
}

vv_status vvi_vtk_open(vvi_vtk_reader **out, const vvi_vtk_file *file, const vvi_vtk_array *array, uint64_t n,
                       vv_source *source, vv_job *job)
{
    *out = NULL;
    if (!array->has_type)
        return vv_fail_at(VV_E_UNSUPPORTED, file->name, NULL, "its array '%.60s' is of type %.40s; numbers are needed",
                          array->name, array->type_name);
    vvi_vtk_reader *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(sizeof *r);
    *r = (vvi_vtk_reader){
        .file = file, .array = array, .stream = {file->name, array, source}, .job = job, .kept_block = UINT64_MAX};
    r->element = vv_type_bytes(array->type);
    r->bytes = array->bits && array->form != VVI_VTK_TEXT ? n / 8 + (n % 8 != 0) : n * r->element;
    vv_status st = array->form == VVI_VTK_TEXT         ? open_text(r)
                   : file->compressor == VVI_VTK_PLAIN ? open_plain(r)
                                                       : open_blocks(r);
    if (st != VV_OK)
        vvi_vtk_close(r);
    else
        *out = r;
    return st;
}

void vvi_vtk_close(vvi_vtk_reader *r)
{
    if (!r)
        return;
    vvi_number_text_close(r->numbers);
    vvi_free(r->at);
    vvi_free(r->state);
    vvi_free(r->packed);
    vvi_free(r->kept);
    vvi_free(r);
}

bool vvi_vtk_plain(uint64_t *offset_out, const vvi_vtk_reader *r)
{
    *offset_out = r->data + r->skip;
    return r->array->form == VVI_VTK_RAW && r->file->compressor == VVI_VTK_PLAIN && !r->array->bits;
}

bool vvi_vtk_swapped(const vvi_vtk_file *file, const vvi_vtk_array *array)
{
    return array->form != VVI_VTK_TEXT && vv_type_bytes(array->type) > 1 && vvi_order_swapped(file->big_endian);
}

/* Blocks ----------------------------------------------------------------------------------------------------------- */

static size_t block_bytes(const vvi_vtk_reader *r, uint64_t b)
{
    return (size_t)(b + 1 == r->n_blocks && r->last ? r->last : r->block);
}

static size_t packed_bytes(const vvi_vtk_reader *r, uint64_t b)
{
    return (size_t)(r->at[b + 1] - r->at[b]);
}

typedef struct batch {
    vvi_vtk_reader *r;
    uint64_t first;  /* block */
    size_t n_packed; /* bytes of them that are there */
    uint8_t *out;    /* of the first block */
} batch;

/* What cannot be unpacked is NaN, or 0 in integers. */
static vv_status unpack_one(void *scratch, void *shared, size_t index)
{
    const batch *t = shared;
    vvi_vtk_reader *r = t->r;
    const uint64_t b = t->first + index;
    const size_t from = (size_t)(r->at[b] - r->at[t->first]), n_in = packed_bytes(r, b), n = block_bytes(r, b);
    uint8_t *out = t->out + index * (size_t)r->block;
    const bool good = from + n_in <= t->n_packed && vvi_vtk_unpack(r->file->compressor, out, n, r->packed + from, n_in);
    r->state[b] = (uint8_t)(BLOCK_READ | (good ? 0 : BLOCK_BAD));
    if (!good)
        memset(out, vv_type_is_float(r->array->type) ? 0xff : 0, n);
    return VV_OK;
}

static vv_status make_packed_room(vvi_vtk_reader *r, size_t bytes)
{
    if (bytes <= r->packed_room)
        return VV_OK;
    vvi_free(r->packed);
    r->packed_room = 0;
    r->packed = vvi_alloc(r->job, bytes, VVI_MEM_SCRATCH);
    if (!r->packed)
        return vv_fail_memory(bytes);
    r->packed_room = bytes;
    return VV_OK;
}

/* Whole blocks [first, first + n) to `out`; fewer at once where they are many bytes: *n_done. */
/* NOLINTNEXTLINE(readability-non-const-parameter): the blocks are unpacked there */
static vv_status unpack_blocks(vvi_vtk_reader *r, uint64_t first, uint64_t n, uint8_t *out, uint64_t *n_done)
{
    static const vvi_work work = {.item = unpack_one};
    uint64_t m = 1;
    while (m < n && r->at[first + m + 1] - r->at[first] <= PACKED_BYTES)
        m++;
    /* no more than the file has: a single block may claim any size */
    const uint64_t want = r->at[first + m] - r->at[first], all = r->array->end - r->array->begin;
    const size_t bytes = (size_t)(want < all ? want : all);
    batch t = {.r = r, .first = first, .out = out};
    vv_status st = make_packed_room(r, bytes ? bytes : 1);
    if (st == VV_OK)
        st = vvi_vtk_stream_read(&r->stream, r->data, r->at[first], r->packed, bytes, &t.n_packed);
    *n_done = m;
    return st == VV_OK ? vvi_parallel_for(r->job, &work, &t, (size_t)m) : st;
}

/* A part of one block: the block is kept, the next call will want the rest of it. */
static vv_status read_part(vvi_vtk_reader *r, uint64_t b, size_t from, uint8_t *out, size_t n)
{
    uint64_t done;
    if (!r->kept) {
        const size_t room = (size_t)(r->block < r->bytes ? r->block : r->bytes);
        r->kept = vvi_alloc(r->job, room, VVI_MEM_SCRATCH);
        if (!r->kept)
            return vv_fail_memory(room);
    }
    if (r->kept_block != b) {
        r->kept_block = UINT64_MAX;
        vv_status st = unpack_blocks(r, b, 1, r->kept, &done);
        if (st != VV_OK)
            return st;
        r->kept_block = b;
    }
    memcpy(out, r->kept + from, n);
    return VV_OK;
}

static vv_status read_blocks(vvi_vtk_reader *r, uint64_t from, uint8_t *out, uint64_t n)
{
    vv_status st = VV_OK;
    while (n > 0 && st == VV_OK) {
        const uint64_t b = from / r->block, in = from % r->block, left = block_bytes(r, b) - in;
        uint64_t took = left < n ? left : n, done = 1;
        if (in > 0 || took < block_bytes(r, b)) {
            st = read_part(r, b, (size_t)in, out, (size_t)took);
        } else {
            uint64_t whole = n / r->block;
            if (from + n == r->bytes)
                whole = r->n_blocks - b;
            st = unpack_blocks(r, b, whole, out, &done);
            took = (b + done == r->n_blocks ? r->bytes : (b + done) * r->block) - from;
        }
        from += took;
        out += took;
        n -= took;
    }
    return st;
}

/* Elements ----------------------------------------------------------------------------------------------------------
 */

/* Colours as fractions of 1. */
static vv_status read_fractions(vvi_vtk_reader *r, uint8_t *out, uint64_t first, size_t n, size_t *n_got)
{
    float piece[256];
    vv_status st = VV_OK;
    for (*n_got = 0; st == VV_OK && *n_got < n;) {
        size_t got, want = n - *n_got < 256 ? n - *n_got : 256;
        if ((st = vvi_number_text_read(r->numbers, piece, first + *n_got, want, &got)) != VV_OK || got == 0)
            return st;
        for (size_t i = 0; i < got; i++)
            out[*n_got + i] = (uint8_t)(piece[i] >= 1 ? 255 : piece[i] > 0 ? 255 * piece[i] + 0.5f : 0);
        *n_got += got;
    }
    return st;
}

static vv_status read_bytes(vvi_vtk_reader *r, uint8_t *out, uint64_t from, size_t n, size_t *n_got)
{
    *n_got = n;
    return r->at ? read_blocks(r, from, out, n)
                 : vvi_vtk_stream_read(&r->stream, r->data, r->skip + from, out, n, n_got);
}

/* The first of a byte is its highest; each becomes a byte. */
static vv_status read_bits(vvi_vtk_reader *r, uint8_t *out, uint64_t first, size_t n, size_t *n_got)
{
    uint8_t piece[512];
    vv_status st = VV_OK;
    for (*n_got = 0; st == VV_OK && *n_got < n;) {
        const size_t lead = (size_t)((first + *n_got) % 8), room = 8 * sizeof piece - lead, left = n - *n_got;
        const size_t want = left < room ? left : room;
        size_t bytes;
        st = read_bytes(r, piece, (first + *n_got) / 8, (lead + want + 7) / 8, &bytes);
        const size_t there = 8 * bytes > lead ? 8 * bytes - lead : 0, m = there < want ? there : want;
        for (size_t i = 0; st == VV_OK && i < m; i++)
            out[*n_got + i] = piece[(lead + i) / 8] >> (7 - (lead + i) % 8) & 1;
        *n_got += m;
        if (m < want)
            break;
    }
    return st;
}

static vv_status read_elements(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    vvi_vtk_reader *r = user;
    if (r->numbers && r->array->fractions)
        return read_fractions(r, out, first, n, n_got);
    if (r->numbers)
        return vvi_number_text_read(r->numbers, out, first, n, n_got);
    if (r->array->bits)
        return read_bits(r, out, first, n, n_got);
    size_t bytes;
    vv_status st = read_bytes(r, out, first * r->element, n * r->element, &bytes);
    *n_got = bytes / r->element;
    return st;
}

vvi_elements vvi_vtk_elements(vvi_vtk_reader *r)
{
    return (vvi_elements){.user = r, .read_some = read_elements, .name = r->file->name};
}

vv_status vvi_vtk_check(const vvi_vtk_reader *r)
{
    uint64_t n_read = 0, n_bad = 0;
    for (uint64_t b = 0; r->state && b < r->n_blocks; b++) {
        n_read += r->state[b] & BLOCK_READ;
        n_bad += (r->state[b] & BLOCK_BAD) != 0;
    }
    if (n_bad == 0)
        return VV_OK;
    if (n_bad > n_read / 2)
        return vv_fail_at(VV_E_FORMAT, r->file->name, NULL,
                          "%llu of %llu blocks of its array '%.60s' are damaged or missing; get a complete copy",
                          (unsigned long long)n_bad, (unsigned long long)n_read, r->array->name);
    vvi_job_damage(r->job, "io", "%s: %llu of %llu blocks of its array '%.60s' are damaged or missing and read as %s",
                   r->file->name, (unsigned long long)n_bad, (unsigned long long)n_read, r->array->name,
                   vv_type_is_float(r->array->type) ? "NaN" : "0");
    return VV_OK;
}

vv_status vvi_vtk_numbers(double **out, const vvi_vtk_file *file, const vvi_vtk_array *array, uint64_t n,
                          vv_source *source, vv_job *job)
{
    vvi_vtk_reader *r;
    size_t got = 0;
    vv_status st = vvi_vtk_open(&r, file, array, n, source, job);
    if (st != VV_OK)
        return st;
    double *v = vvi_alloc(job, (size_t)n * sizeof *v, VVI_MEM_MODEL);
    uint8_t *stored = vvi_alloc(job, (size_t)n * r->element, VVI_MEM_SCRATCH);
    st = v && stored ? read_elements(r, stored, 0, (size_t)n, &got) : vv_fail_memory((size_t)n * sizeof *v);
    if (st == VV_OK && got < n)
        st = fail_array(r, "is cut short, in numbers", n, got);
    for (uint64_t b = 0; st == VV_OK && r->state && b < r->n_blocks; b++)
        if (r->state[b] & BLOCK_BAD)
            st = fail_array(r, "has a damaged block", 0, b);
    if (st == VV_OK && vvi_vtk_swapped(file, array))
        vvi_swap_bytes(stored, r->element, (size_t)n);
    if (st == VV_OK)
        vvi_samples_to_f64(v, stored, array->type, (size_t)n);
    vvi_free(stored);
    vvi_vtk_close(r);
    if (st != VV_OK)
        vvi_free(v);
    else
        *out = v;
    return st;
}
