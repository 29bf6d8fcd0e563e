/* Chunks of HDF5 data sets: read as they lie, one after another under the lock, and unpacked on all threads. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"
#include <string.h>

#define BATCH_CHUNKS 512
#define ABSENT_ERRORS 2 /* H5Dget_chunk_storage_size() and the function in it that does the work */
#define BATCH_BYTES ((size_t)32 << 20)

typedef struct chunk {
    hsize_t at[VVI_H5_RANK]; /* of its first sample in the data set */
    uint8_t *bytes;          /* NULL: it is not in the file, or cannot be read */
    size_t n;
    unsigned mask; /* filters that were left out for it */
    bool bad;
} chunk;

typedef struct batch {
    const vvi_h5_slab *slab;
    vv_job *job;
    size_t chunk_bytes;
    chunk chunk[BATCH_CHUNKS];
    size_t n, n_bytes;
} batch;

typedef struct scratch {
    uint8_t *buffer[2];
} scratch;

/* Into the slab ---------------------------------------------------------------------------------------------------- */

typedef struct overlap {
    hsize_t lo[VVI_H5_RANK], n[VVI_H5_RANK]; /* of the data set: what chunk and slab share */
    uint64_t count;
} overlap;

static overlap find_overlap(const vvi_h5_slab *s, const hsize_t *at)
{
    overlap o = {.count = 1};
    for (int a = 0; a < s->set->rank; a++) {
        const hsize_t end = at[a] + s->set->chunk[a], slab_end = s->start[a] + s->count[a];
        o.lo[a] = at[a] > s->start[a] ? at[a] : s->start[a];
        o.n[a] = (end < slab_end ? end : slab_end) - o.lo[a];
        o.count *= o.n[a];
    }
    return o;
}

/* One line of the fastest axis from `from`, or of one element again and again where from_step is 0. */
static void copy_line(uint8_t *to, const uint8_t *from, size_t n, size_t element, bool repeat)
{
    if (!repeat) {
        memcpy(to, from, n * element);
        return;
    }
    for (size_t i = 0; i < n; i++)
        memcpy(to + i * element, from, element);
}

/* The shared part of a chunk (repeat: of an element that stands for all) to where it belongs. */
static void copy_overlap(const vvi_h5_slab *s, const hsize_t *at, const uint8_t *from, bool repeat)
{
    const overlap o = find_overlap(s, at);
    const int rank = s->set->rank, last = rank - 1;
    hsize_t step[VVI_H5_RANK] = {0};
    for (;;) {
        uint64_t in = 0, out = 0;
        for (int a = 0; a < rank; a++) {
            in = in * s->set->chunk[a] + (o.lo[a] - at[a] + step[a]);
            out = out * s->count[a] + (o.lo[a] - s->start[a] + step[a]);
        }
        copy_line(s->data + out * s->element, repeat ? from : from + in * s->element, (size_t)o.n[last], s->element,
                  repeat);
        int a = last - 1;
        for (; a >= 0; step[a] = 0, a--)
            if (++step[a] < o.n[a])
                break;
        if (a < 0)
            return;
    }
}

static void *get_scratch(const batch *b)
{
    scratch *s = vvi_alloc_zeroed(b->job, sizeof *s, VVI_MEM_SCRATCH);
    for (int i = 0; s && i < 2; i++)
        s->buffer[i] = vvi_alloc(b->job, b->chunk_bytes + VVI_H5_UNPACK_SLACK, VVI_MEM_SCRATCH);
    return s;
}

static void finish_scratch(void *user, void *shared)
{
    scratch *s = user;
    (void)shared;
    if (!s)
        return;
    vvi_free(s->buffer[0]);
    vvi_free(s->buffer[1]);
    vvi_free(s);
}

static vv_status start_scratch(void **out, void *shared, int worker)
{
    const batch *b = shared;
    scratch *s = get_scratch(b);
    (void)worker;
    *out = s;
    if (s && s->buffer[0] && s->buffer[1])
        return VV_OK;
    finish_scratch(s, NULL);
    *out = NULL;
    return vv_fail_memory(2 * b->chunk_bytes);
}

static vv_status unpack(void *user, void *shared, size_t index)
{
    const scratch *s = user;
    batch *b = shared;
    chunk *c = &b->chunk[index];
    const vvi_h5_set *set = b->slab->set;
    const uint8_t *samples = c->bytes ? vvi_h5_unpack(set, c->bytes, c->n, c->mask, b->chunk_bytes, s->buffer) : NULL;
    c->bad = c->bad || (c->bytes && !samples);
    if (c->bad)
        copy_overlap(b->slab, c->at, set->lost, true);
    else if (!samples)
        copy_overlap(b->slab, c->at, set->fill, true);
    else
        copy_overlap(b->slab, c->at, samples, false);
    return VV_OK;
}

/* Out of the file -------------------------------------------------------------------------------------------------- */

/* The lock is held. */
static vv_status read_chunk(batch *b, vvi_h5 *h5, hid_t data, const hsize_t *at)
{
    chunk *c = &b->chunk[b->n++];
    hsize_t n = 0;
    *c = (chunk){0};
    memcpy(c->at, at, sizeof c->at);
    if (b->slab->set->stored == 0)
        return VV_OK;
    if (H5Dget_chunk_storage_size(data, at, &n) < 0) {
        n = 0; /* 1.10 says so of those that are not there; where its index cannot be read, the failure lies deeper */
        c->bad = H5Eget_num(H5E_DEFAULT) > ABSENT_ERRORS;
        H5Eclear2(H5E_DEFAULT);
    }
    if (n == 0 || h5->st != VV_OK)
        return h5->st;
    c->bad = n > h5->n_bytes || n > 2 * (hsize_t)b->chunk_bytes + 65536; /* no packing makes more of it */
    if (c->bad)
        return VV_OK;
    c->n = (size_t)n;
    c->bytes = vvi_alloc(b->job, c->n, VVI_MEM_SCRATCH);
    if (!c->bytes)
        return vv_fail_memory(c->n);
    b->n_bytes += c->n;
    h5->room = c->bytes; /* without filters the size above is not the file's, and the library reads the file's */
    h5->n_room = c->n;
    const bool read = H5Dread_chunk(data, H5P_DEFAULT, at, &c->mask, c->bytes) >= 0;
    h5->room = NULL;
    if (!read) {
        H5Eclear2(H5E_DEFAULT);
        vvi_free(c->bytes);
        c->bytes = NULL;
        c->bad = true;
    }
    return h5->st;
}

static vv_status flush(batch *b, uint64_t *missing)
{
    static const vvi_work work = {.start = start_scratch, .item = unpack, .finish = finish_scratch};
    vv_status st = b->n > 0 ? vvi_parallel_for(b->job, &work, b, b->n) : VV_OK;
    for (size_t i = 0; i < b->n; i++)
        if (b->chunk[i].bad)
            *missing += find_overlap(b->slab, b->chunk[i].at).count;
    return st;
}

static void empty(batch *b)
{
    for (size_t i = 0; i < b->n; i++)
        vvi_free(b->chunk[i].bytes);
    b->n = 0;
    b->n_bytes = 0;
}

/* The next chunk of the slab; false after the last. */
static bool next_chunk(const vvi_h5_slab *s, hsize_t *at)
{
    for (int a = s->set->rank - 1; a >= 0; a--) {
        if ((at[a] += s->set->chunk[a]) < s->start[a] + s->count[a])
            return true;
        at[a] = s->start[a] - s->start[a] % s->set->chunk[a];
    }
    return false;
}

static vv_status read_batches(batch *b, vvi_h5 *h5, hid_t data, uint64_t *missing)
{
    const vvi_h5_slab *s = b->slab;
    hsize_t at[VVI_H5_RANK] = {0};
    bool more = true;
    vv_status st = VV_OK;
    for (int a = 0; a < s->set->rank; a++)
        at[a] = s->start[a] - s->start[a] % s->set->chunk[a];
    while (more && st == VV_OK) {
        vvi_h5_lock();
        while (more && st == VV_OK && b->n < BATCH_CHUNKS && b->n_bytes < BATCH_BYTES) {
            st = read_chunk(b, h5, data, at);
            more = next_chunk(s, at);
        }
        vvi_h5_unlock();
        if (st == VV_OK && (st = vvi_job_poll(b->job)) == VV_OK)
            st = flush(b, missing);
        empty(b);
    }
    return st;
}

vv_status vvi_h5_read_chunks(const vvi_h5_slab *slab, vvi_h5 *h5, hid_t data, uint64_t *missing, vv_job *job)
{
    batch *b = vvi_alloc_zeroed(job, sizeof *b, VVI_MEM_SCRATCH);
    if (!b)
        return vv_fail_memory(sizeof *b);
    b->slab = slab;
    b->job = job;
    b->chunk_bytes = slab->element;
    for (int a = 0; a < slab->set->rank; a++)
        b->chunk_bytes *= (size_t)slab->set->chunk[a]; /* at most a gigabyte: see vvi_h5_check */
    const vv_status st = read_batches(b, h5, data, missing);
    vvi_free(b);
    return st;
}
