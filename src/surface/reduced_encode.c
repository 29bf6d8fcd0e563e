/* A slab of bricks is one item: its slices become rows of bits, 17 of which, of four rows, are 16 cells of a brick. */
#include "surface/reduced_encode.h"
#include "core/job.h"
#include "core/memory.h"
#include "surface/cell.h"
#include "surface/reduced_records.h"

#include <stdatomic.h>
#include <string.h>

enum { SIDE = VVI_REDUCED_SIDE, SLICES = SIDE + 1, ALL = (1 << SLICES) - 1 };

/* What one item has made. */
typedef struct slab {
    uint8_t *records;
    vvi_reduced_brick *bricks;
    size_t n_bytes, room, n_bricks;
} slab;

typedef struct encoding {
    const vvi_lattice_samples *samples;
    const vvi_march *m;
    const vvi_march_kernels *kernels;
    vvi_reduced *r;
    slab *slabs;
    size_t words; /* of a row of bits */
    size_t max_triangles, max_bytes;
    _Atomic size_t n_triangles, n_bytes;
    atomic_bool over;
} encoding;

/* Rows of bits of the slices of a slab. */
typedef struct rows {
    uint64_t *inside, *known;
    bool all_known;
} rows;

/* Bits ------------------------------------------------------------------------------------------------------------ */

static size_t row_words(const encoding *e)
{
    return e->words * (size_t)e->samples->n[1];
}

static void classify_row(uint64_t *inside, uint64_t *known, bool *all_known, const encoding *e, const void *row)
{
    const vvi_lattice_samples *s = e->samples;
    const size_t words = (size_t)(s->n[0] + 63) / 64;
    const uint64_t last = s->n[0] & 63 ? ((uint64_t)1 << (s->n[0] & 63)) - 1 : ~(uint64_t)0;
    vvi_march_span span = {0, (uint16_t)words};
    memset(inside, 0, e->words * sizeof *inside);
    e->kernels->classify[s->type](inside, row, s->n[0], s->threshold, &span);
    for (size_t w = 0; w < words && s->inverted; w++)
        inside[w] = ~inside[w] & (w + 1 < words ? ~(uint64_t)0 : last);
    if (s->type == VVI_MARCH_F32) {
        known[words] = 0;
        *all_known &= e->kernels->known(known, row, s->n[0]);
    }
}

static void classify_slab(rows *b, const encoding *e, int64_t first, int64_t n)
{
    const vvi_lattice_samples *s = e->samples;
    b->all_known = true;
    for (int64_t k = 0; k < n; k++)
        for (int64_t j = 0; j < s->n[1]; j++) {
            const size_t at = (size_t)k * row_words(e) + (size_t)j * e->words;
            classify_row(b->inside + at, b->known + at, &b->all_known, e,
                         s->data + j * s->stride[1] + (first + k) * s->stride[2]);
        }
}

/* Seventeen bits of a row from x on. */
static unsigned take(const uint64_t *row, int64_t x)
{
    const unsigned at = (unsigned)x & 63;
    const uint64_t *w = row + (x >> 6);
    return (unsigned)(w[0] >> at | (at ? w[1] << (64 - at) : 0)) & ALL;
}

/* Cells ----------------------------------------------------------------------------------------------------------- */

#define CORNERS(march_type, ctype)                                                                                     \
    case march_type:                                                                                                   \
        for (int c = 0; c < 8; c++)                                                                                    \
            v[c] = (float)*(const ctype *)(corner + (c & 1) * s->stride[0] + (c >> 1 & 1) * s->stride[1] +             \
                                           (c >> 2) * s->stride[2]) -                                                  \
                   s->iso;                                                                                             \
        break

static void corners(float v[8], const vvi_lattice_samples *s, const char *corner)
{
    switch (s->type) {
        CORNERS(VVI_MARCH_U8, uint8_t);
        CORNERS(VVI_MARCH_U16, uint16_t);
        CORNERS(VVI_MARCH_I16, int16_t);
    default:
        for (int c = 0; c < 8; c++)
            v[c] = vvi_cell_corner(*(const float *)(corner + (c & 1) * s->stride[0] + (c >> 1 & 1) * s->stride[1] +
                                                    (c >> 2) * s->stride[2]) -
                                   s->iso);
    }
}

/* Which of the four places: floor(4 t), by comparisons, so that what is not finite does no harm. */
static unsigned place_on_edge(float low, float high)
{
    const float t = low / (low - high);
    return (t >= 0.25f) + (t >= 0.5f) + (t >= 0.75f);
}

static void put_cell(vvi_reduced_bits *to, unsigned local, unsigned pattern, const float v[8])
{
    uint64_t record = (uint64_t)pattern << 12 | local;
    int bits = 20;
    for (unsigned rest = vvi_reduced_case(pattern)->edges; rest; rest &= rest - 1, bits += 2) {
        const unsigned e = (unsigned)__builtin_ctz(rest), axis = e / 4;
        const unsigned low = (e & 1) << vvi_across((int)axis, 0) | (e >> 1) % 2 << vvi_across((int)axis, 1);
        record |= (uint64_t)place_on_edge(v[low], v[low | 1u << axis]) << bits;
    }
    vvi_reduced_put(to, record, bits);
}

/* Bits of the cells that the surface passes among 16 of a row. */
static unsigned active_cells(const unsigned row[4], const unsigned known[4], int64_t n)
{
    const unsigned any = row[0] | row[1] | row[2] | row[3], all = row[0] & row[1] & row[2] & row[3];
    const unsigned all_known = known[0] & known[1] & known[2] & known[3];
    const unsigned inside = n >= SIDE ? (1u << SIDE) - 1 : (1u << n) - 1;
    return (any | any >> 1) & ~(all & all >> 1) & all_known & all_known >> 1 & inside;
}

static void put_row(vvi_reduced_brick *b, vvi_reduced_bits *to, const encoding *e, const unsigned row[4],
                    unsigned active, const int32_t at[3], const char *samples)
{
    for (; active; active &= active - 1) {
        const unsigned x = (unsigned)__builtin_ctz(active);
        const unsigned pattern =
            (row[0] >> x & 3) | (row[1] >> x & 3) << 2 | (row[2] >> x & 3) << 4 | (row[3] >> x & 3) << 6;
        float v[8];
        corners(v, e->samples, samples + x * e->samples->stride[0]);
        put_cell(to, (unsigned)at[2] << 8 | (unsigned)at[1] << 4 | x, pattern, v);
        b->n_cells++;
        b->n_triangles += vvi_reduced_case(pattern)->n_triangles;
    }
}

/* The records of one brick, with its place in index coordinates. */
static void put_brick(vvi_reduced_brick *b, vvi_reduced_bits *to, const encoding *e, const rows *bits,
                      const int64_t first[3])
{
    const vvi_lattice_samples *s = e->samples;
    const size_t slice = row_words(e);
    for (int32_t z = 0; z < SIDE && first[2] + z < s->n[2] - 1; z++)
        for (int32_t y = 0; y < SIDE && first[1] + y < s->n[1] - 1; y++) {
            const size_t at = (size_t)z * slice + (size_t)(first[1] + y) * e->words;
            const size_t place[4] = {at, at + e->words, at + slice, at + slice + e->words};
            unsigned row[4], known[4] = {ALL, ALL, ALL, ALL};
            for (int i = 0; i < 4; i++)
                row[i] = take(bits->inside + place[i], first[0]);
            if ((row[0] | row[1] | row[2] | row[3]) == 0 || (row[0] & row[1] & row[2] & row[3]) == ALL)
                continue;
            for (int i = 0; i < 4 && !bits->all_known; i++)
                known[i] = take(bits->known + place[i], first[0]);
            put_row(b, to, e, row, active_cells(row, known, s->n[0] - 1 - first[0]), (const int32_t[3]){0, y, z},
                    s->data + first[0] * s->stride[0] + (first[1] + y) * s->stride[1] + (first[2] + z) * s->stride[2]);
        }
    vvi_reduced_end(to);
}

/* Slabs ----------------------------------------------------------------------------------------------------------- */

static vv_status start(void **scratch, void *user, int worker)
{
    const encoding *e = user;
    const size_t bits = SLICES * row_words(e) * sizeof(uint64_t), bytes = sizeof(rows) + 2 * bits;
    rows *b = vvi_alloc(e->m->job, bytes, VVI_MEM_SCRATCH);
    (void)worker;
    *scratch = b;
    if (!b)
        return vv_fail_memory(bytes);
    b->inside = (uint64_t *)(void *)(b + 1);
    b->known = b->inside + SLICES * row_words(e);
    return VV_OK;
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

/* Room for a brick more. */
static vv_status make_room(slab *s, vv_job *job)
{
    const size_t most = (size_t)SIDE * SIDE * SIDE * VVI_REDUCED_RECORD_BYTES;
    if (s->room - s->n_bytes >= most)
        return VV_OK;
    const size_t room = 2 * s->room + most;
    uint8_t *records = vvi_realloc(job, s->records, room, VVI_MEM_SCRATCH);
    if (!records)
        return vv_fail_memory(room);
    s->records = records;
    s->room = room;
    return VV_OK;
}

static bool is_over(encoding *e, const vvi_reduced_brick *b, size_t bytes)
{
    const size_t triangles = atomic_fetch_add(&e->n_triangles, b->n_triangles) + b->n_triangles;
    const size_t all = atomic_fetch_add(&e->n_bytes, bytes) + bytes;
    if ((e->max_triangles && triangles > e->max_triangles) || (e->max_bytes && all > e->max_bytes))
        atomic_store(&e->over, true);
    return atomic_load(&e->over);
}

/* Item: the bricks of a slab. Once there is too much it does nothing: that there is depends on the sum alone. */
static vv_status encode_slab(void *scratch, void *user, size_t item)
{
    encoding *e = user;
    const vvi_lattice_samples *s = e->samples;
    const int32_t *n = e->r->n;
    slab *to = &e->slabs[item];
    int64_t first[3] = {0, 0, (int64_t)item * SIDE};
    if (atomic_load(&e->over))
        return VV_OK;
    to->bricks = vvi_alloc(e->m->job, (size_t)n[0] * (size_t)n[1] * sizeof *to->bricks, VVI_MEM_SCRATCH);
    if (!to->bricks)
        return vv_fail_memory((size_t)n[0] * (size_t)n[1] * sizeof *to->bricks);
    classify_slab(scratch, e, first[2], s->n[2] - first[2] < SLICES ? s->n[2] - first[2] : SLICES);
    for (int32_t j = 0; j < n[1]; j++)
        for (int32_t i = 0; i < n[0]; i++) {
            const vv_status st = make_room(to, e->m->job);
            if (st != VV_OK)
                return st;
            vvi_reduced_brick b = {.at = {i, j, (int32_t)item}, .first_byte = to->n_bytes};
            vvi_reduced_bits bits = {.at = to->records + to->n_bytes};
            first[0] = (int64_t)i * SIDE;
            first[1] = (int64_t)j * SIDE;
            put_brick(&b, &bits, e, scratch, first);
            to->n_bytes = (size_t)(bits.at - to->records);
            if (!b.n_cells)
                continue;
            to->bricks[to->n_bricks++] = b;
            if (is_over(e, &b, to->n_bytes - b.first_byte + sizeof b))
                return VV_OK;
        }
    return vvi_job_poll(e->m->job);
}

/* One list of what the slabs have. */
static vv_status join_slabs(vvi_reduced *r, const encoding *e)
{
    vv_job *job = e->m->job;
    for (int32_t k = 0; k < r->n[2]; k++) {
        r->n_bricks += e->slabs[k].n_bricks;
        r->n_bytes += e->slabs[k].n_bytes;
    }
    r->bricks = vvi_alloc(job, r->n_bricks * sizeof *r->bricks + 1, VVI_MEM_DERIVED);
    r->records = vvi_alloc(job, r->n_bytes + 8, VVI_MEM_DERIVED);
    if (!r->bricks || !r->records)
        return vv_fail_memory(r->n_bricks * sizeof *r->bricks + r->n_bytes);
    size_t n = 0, bytes = 0;
    for (int32_t k = 0; k < r->n[2]; k++) {
        const slab *s = &e->slabs[k];
        for (size_t i = 0; i < s->n_bricks; i++, n++) {
            r->bricks[n] = s->bricks[i];
            r->bricks[n].first_byte += bytes;
            r->bricks[n].first_triangle = r->n_triangles;
            r->n_cells += s->bricks[i].n_cells;
            r->n_triangles += s->bricks[i].n_triangles;
        }
        if (s->n_bytes)
            memcpy(r->records + bytes, s->records, s->n_bytes);
        bytes += s->n_bytes;
    }
    memset(r->records + bytes, 0, 8);
    return VV_OK;
}

vv_status vvi_reduced_encode(vvi_reduced *r, bool *over_out, const vvi_lattice_samples *samples, const vvi_march *m,
                             size_t max_triangles, size_t max_bytes)
{
    static const vvi_work work = {.stage = "reducing", .start = start, .item = encode_slab, .finish = finish};
    encoding e = {.samples = samples, .m = m, .kernels = m->kernels, .r = r};
    e.max_triangles = max_triangles;
    e.max_bytes = max_bytes;
    e.words = (size_t)(samples->n[0] + 63) / 64 + 1;
    for (int a = 0; a < 3; a++)
        r->n[a] = samples->n[a] > 1 ? (int32_t)((samples->n[a] - 2) / SIDE + 1) : 0;
    const size_t slabs = r->n[0] && r->n[1] ? (size_t)r->n[2] : 0;
    e.slabs = vvi_alloc_zeroed(m->job, (slabs + 1) * sizeof *e.slabs, VVI_MEM_SCRATCH);
    vv_status st = e.slabs ? VV_OK : vv_fail_memory((slabs + 1) * sizeof *e.slabs);
    if (st == VV_OK)
        st = vvi_parallel_for(m->job, &work, &e, slabs);
    *over_out = atomic_load(&e.over);
    if (slabs == 0)
        r->n[2] = 0;
    if (st == VV_OK && !*over_out)
        st = join_slabs(r, &e);
    for (size_t k = 0; k < slabs && e.slabs; k++) {
        vvi_free(e.slabs[k].records);
        vvi_free(e.slabs[k].bricks);
    }
    vvi_free(e.slabs);
    return st;
}
