/* A box of an array: the chunks that it touches are read and decoded side by side, each into its own part of the field.
 * A chunk that is not there is made of the fill value; one that is damaged is left empty and reported. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/zarr/zarr.h"
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <string.h>

/* More files than anybody has in one box: without the bound, metadata of a few bytes could keep us busy for hours. */
#define CHUNKS_MOST ((uint64_t)1 << 20)

typedef struct reading {
    const vvi_zarr_array *array;
    const vv_source *folder;
    const char *path;
    vv_job *job;
    int64_t lo[VVI_ZARR_AXES], hi[VVI_ZARR_AXES];   /* what is wanted of each axis */
    int64_t step[VVI_ZARR_AXES];                    /* bytes of the field from one to the next */
    int64_t first[VVI_ZARR_AXES], n[VVI_ZARR_AXES]; /* chunks touched */
    int64_t shard_first[VVI_ZARR_AXES], shard_n[VVI_ZARR_AXES];
    vvi_zarr_shard *shards;
    size_t n_shards;
    uint8_t *out;
    size_t out_bytes;
    bool floats; /* there */
    uint64_t n_samples;
    atomic_uint_fast64_t n_lost, n_lost_chunks;
    pthread_mutex_t mutex; /* of what follows: what is said of the first damaged chunk */
    size_t lost_index;
    char lost_text[320];
} reading;

/* Chunks ------------------------------------------------------------------------------------------------------------
 */

/* The part of the chunk at `place` that is wanted; from: its first sample, of `from_bytes` each, or of one value for
 * all (0). */
static void copy_chunk(const reading *r, const int64_t *place, const uint8_t *from, size_t from_bytes)
{
    const vvi_zarr_array *a = r->array;
    vvi_zarr_copying c = {
        .n_axes = a->n_axes, .bytes = r->out_bytes, .half = a->type.half && !a->gaps.any && from_bytes > 0};
    uint8_t *to = r->out;
    int64_t step = (int64_t)from_bytes;
    for (int k = a->n_axes - 1; k >= 0; k--) {
        const int axis = a->order[k];
        const int64_t start = place[axis] * a->chunk[axis];
        const int64_t lo = start > r->lo[axis] ? start : r->lo[axis];
        const int64_t hi = start + a->chunk[axis] < r->hi[axis] ? start + a->chunk[axis] : r->hi[axis];
        c.n[k] = hi - lo;
        c.from_step[k] = step;
        c.to_step[k] = r->step[axis];
        from += (lo - start) * step;
        to += (lo - r->lo[axis]) * r->step[axis];
        step *= a->chunk[axis];
    }
    vvi_zarr_copy_box(&c, from, to);
}

/* Samples of a chunk that are wanted. */
static uint64_t wanted(const reading *r, const int64_t *place)
{
    uint64_t n = 1;
    for (int i = 0; i < r->array->n_axes; i++) {
        const int64_t start = place[i] * r->array->chunk[i], end = start + r->array->chunk[i];
        n *= (uint64_t)((end < r->hi[i] ? end : r->hi[i]) - (start > r->lo[i] ? start : r->lo[i]));
    }
    return n;
}

/* One chunk ------------------------------------------------------------------------------------------------------ */

/* n bytes of a source, or all that are left. */
static vv_status take(vvi_zarr_bytes *out, vv_source *source, uint64_t n, vv_job *job)
{
    bool exact;
    if (n == UINT64_MAX)
        n = vvi_source_left(source, &exact);
    out->data = vvi_alloc(job, n ? (size_t)n : 1, VVI_MEM_SCRATCH);
    if (!out->data)
        return vv_fail_memory((size_t)n);
    out->n = (size_t)n;
    return vvi_source_read(source, out->data, out->n, "a chunk");
}

/* Place of a chunk's shard among those that are touched, and its number in that. */
static size_t shard_of(const reading *r, const int64_t *place, int64_t *shard_place, uint64_t *inside)
{
    const vvi_zarr_array *a = r->array;
    size_t index = 0;
    *inside = 0;
    for (int i = 0; i < a->n_axes; i++) {
        const int64_t per = a->shard[i] / a->chunk[i];
        shard_place[i] = place[i] / per;
        *inside = *inside * (uint64_t)per + (uint64_t)(place[i] % per);
        index = index * (size_t)r->shard_n[i] + (size_t)(shard_place[i] - r->shard_first[i]);
    }
    return index;
}

/* What is stored of a chunk; data NULL: nothing is. name: room for the file's name. A file that may not be opened, as
 * one to which a link leads out of the folder, is no damage: *refused. */
static vv_status fetch(vvi_zarr_bytes *out, char *name, bool *refused, const reading *r, const int64_t *place)
{
    int64_t file_place[VVI_ZARR_AXES];
    uint64_t at = 0, n = UINT64_MAX, inside;
    vv_source *source;
    memcpy(file_place, place, sizeof file_place);
    if (r->array->sharded) {
        const vvi_zarr_shard *shard = &r->shards[shard_of(r, place, file_place, &inside)];
        if (shard->damaged)
            return vv_fail_at(VV_E_FORMAT, r->path, NULL, "a shard is damaged");
        at = shard->there ? shard->entry[2 * inside] : UINT64_MAX;
        n = shard->there ? shard->entry[2 * inside + 1] : 0;
        if (at == UINT64_MAX)
            return VV_OK;
    }
    vv_status st = vvi_zarr_key(name, r->array, r->path, file_place);
    if (st == VV_OK)
        st = vvi_source_find_beside(&source, r->folder, name, r->job);
    *refused = st != VV_OK;
    if (st != VV_OK || !source)
        return st;
    if (at > 0)
        st = vvi_source_seek(source, at);
    if (st == VV_OK)
        st = take(out, source, n, r->job);
    vvi_source_close(source);
    return st;
}

static void place_of(int64_t *place, const reading *r, size_t index)
{
    for (int i = r->array->n_axes - 1; i >= 0; i--) {
        place[i] = r->first[i] + (int64_t)(index % (size_t)r->n[i]);
        index /= (size_t)r->n[i];
    }
}

static void lose(reading *r, size_t index, const int64_t *place)
{
    const uint64_t all = r->floats ? UINT64_MAX : 0; /* NaN, or 0 */
    copy_chunk(r, place, (const uint8_t *)&all, 0);
    atomic_fetch_add(&r->n_lost, wanted(r, place));
    atomic_fetch_add(&r->n_lost_chunks, 1);
    pthread_mutex_lock(&r->mutex);
    if (index < r->lost_index) {
        r->lost_index = index;
        snprintf(r->lost_text, sizeof r->lost_text, "%.300s", vv_error_last()->message);
    }
    pthread_mutex_unlock(&r->mutex);
}

static vv_status read_chunk(void *scratch, void *shared, size_t index)
{
    reading *r = shared;
    const vvi_zarr_array *a = r->array;
    char name[VVI_ZARR_PATH];
    int64_t place[VVI_ZARR_AXES];
    vvi_zarr_bytes bytes = {0};
    bool refused = false;
    (void)scratch;
    place_of(place, r, index);
    vv_status st = vvi_job_poll(r->job);
    if (st == VV_OK)
        st = fetch(&bytes, name, &refused, r, place);
    if (st == VV_OK && bytes.data)
        st = vvi_zarr_decode(&bytes, &a->chain, (size_t)a->chunk_bytes, name, r->job);
    if (st == VV_OK && bytes.data) {
        if (a->type.swap)
            vvi_swap_bytes(bytes.data, a->type.bytes, bytes.n / a->type.bytes);
        if (a->gaps.any)
            st = vvi_zarr_values(&bytes, a, r->job);
        if (st == VV_OK)
            copy_chunk(r, place, bytes.data, a->gaps.any ? r->out_bytes : a->type.bytes);
    } else if (st == VV_OK) {
        const uint64_t fill = vvi_zarr_fill_value(a);
        copy_chunk(r, place, (const uint8_t *)&fill, 0);
    } else if (!refused && (st == VV_E_FORMAT || st == VV_E_READ)) {
        lose(r, index, place);
        st = VV_OK;
    }
    vvi_free(bytes.data);
    return st;
}

/* Planning ------------------------------------------------------------------------------------------------------- */

static void want(reading *r, const vv_field_info *part, const vvi_zarr_axes *axes, int64_t frame, const vv_box *box)
{
    const int64_t *n = part->grid.dims, sample = (int64_t)r->out_bytes * part->components;
    const int64_t lo[VVI_ROLES] = {0, box->lo[0], box->lo[1], box->lo[2], frame};
    const int64_t count[VVI_ROLES] = {part->components, n[0], n[1], n[2], 1};
    const int64_t step[VVI_ROLES] = {(int64_t)r->out_bytes, sample, sample * n[0], sample * n[0] * n[1], 0};
    for (int i = 0; i < r->array->n_axes; i++)
        r->hi[i] = 1; /* axes of one sample that the field has not */
    for (int role = 0; role < VVI_ROLES; role++) {
        const int axis = axes->role[role];
        if (axis < 0)
            continue;
        r->lo[axis] = lo[role];
        r->hi[axis] = lo[role] + count[role];
        r->step[axis] = step[role];
    }
}

static vv_status count_chunks(size_t *out, reading *r)
{
    const vvi_zarr_array *a = r->array;
    const uint64_t files = vvi_job_limits(r->job)->files, most = files > CHUNKS_MOST ? files : CHUNKS_MOST;
    uint64_t n = 1, n_shards = 1;
    for (int i = 0; i < a->n_axes; i++) {
        r->first[i] = r->lo[i] / a->chunk[i];
        r->n[i] = (r->hi[i] - 1) / a->chunk[i] - r->first[i] + 1;
        n *= (uint64_t)r->n[i];
        if (a->sharded) {
            r->shard_first[i] = r->lo[i] / a->shard[i];
            r->shard_n[i] = (r->hi[i] - 1) / a->shard[i] - r->shard_first[i] + 1;
            n_shards *= (uint64_t)r->shard_n[i];
        }
        if (n > most)
            return vv_fail_at(
                VV_E_LIMIT, vvi_source_name(r->folder), r->path[0] ? r->path : NULL,
                "is stored in more than %llu chunks; read a smaller box (--crop), or --limit files=N allows more",
                (unsigned long long)most);
    }
    r->n_shards = a->sharded ? (size_t)n_shards : 0;
    *out = (size_t)n;
    return VV_OK;
}

static vv_status open_shard(reading *r, size_t index)
{
    int64_t place[VVI_ZARR_AXES];
    char key[VVI_ZARR_PATH];
    size_t rest = index;
    for (int i = r->array->n_axes - 1; i >= 0; i--) {
        place[i] = r->shard_first[i] + (int64_t)(rest % (size_t)r->shard_n[i]);
        rest /= (size_t)r->shard_n[i];
    }
    vv_status st = vvi_zarr_key(key, r->array, r->path, place);
    if (st == VV_OK)
        st = vvi_zarr_shard_open(&r->shards[index], r->array, r->folder, key, r->job);
    if ((st != VV_E_FORMAT && st != VV_E_READ) || r->shards[index].refused)
        return st;
    r->shards[index].damaged = true;
    if (!r->lost_text[0])
        snprintf(r->lost_text, sizeof r->lost_text, "%.300s", vv_error_last()->message);
    r->lost_index = 0;
    return VV_OK;
}

static vv_status open_shards(reading *r)
{
    if (r->n_shards == 0)
        return VV_OK;
    r->shards = vvi_alloc_zeroed(r->job, r->n_shards * sizeof *r->shards, VVI_MEM_SCRATCH);
    if (!r->shards)
        return vv_fail_memory(r->n_shards * sizeof *r->shards);
    vv_status st = VV_OK;
    for (size_t i = 0; i < r->n_shards && st == VV_OK; i++) {
        st = vvi_job_poll(r->job);
        if (st == VV_OK)
            st = open_shard(r, i);
    }
    return st;
}

static vv_status tell_lost(reading *r, size_t n_chunks)
{
    const uint64_t lost = atomic_load(&r->n_lost);
    const unsigned long long lost_chunks = atomic_load(&r->n_lost_chunks), all = n_chunks;
    if (lost == 0)
        return VV_OK;
    if (lost > r->n_samples / 2)
        return vv_fail(VV_E_FORMAT, "%s; %llu of %llu chunks are damaged, more than half; get a complete copy",
                       r->lost_text, lost_chunks, all);
    vvi_job_damage(r->job, "io", "%s; %llu of %llu chunks are damaged, their samples are %s", r->lost_text, lost_chunks,
                   all, r->floats ? "NaN" : "0");
    return VV_OK;
}

/* Before room is taken ------------------------------------------------------------------------------------------- */

/* Bytes of the file at a place among chunks or shards; 0: there is none. */
static vv_status file_bytes(uint64_t *out, char *name, const reading *r, const int64_t *place)
{
    bool exact;
    vv_source *source;
    *out = 0;
    vv_status st = vvi_zarr_key(name, r->array, r->path, place);
    if (st != VV_OK)
        return st;
    if (vvi_source_find_beside(&source, r->folder, name, r->job) != VV_OK) {
        *out = UINT64_MAX; /* one that may not be opened is told when it is read */
        return VV_OK;
    }
    if (!source)
        return VV_OK;
    *out = vvi_source_left(source, &exact);
    vvi_source_close(source);
    return VV_OK;
}

/* Whether one of the files [first, first + n) holds what can be a chunk; *n_small: files that are too short for that,
 * and what is wrong with the last one is the error that stands. */
static vv_status find_stored(bool *found, uint64_t *n_small, const reading *r, const int64_t *first, const int64_t *n)
{
    const vvi_zarr_array *a = r->array;
    const int n_axes = a->n_axes;
    int64_t place[VVI_ZARR_AXES];
    char name[VVI_ZARR_PATH];
    uint64_t bytes, all = 1;
    vv_status st = VV_OK;
    for (int i = 0; i < n_axes; i++)
        all = all > CHUNKS_MOST ? all : all * (uint64_t)n[i];
    *found = all > CHUNKS_MOST; /* nobody looks into so many */
    for (uint64_t index = 0; index < all && !*found && st == VV_OK; index++) {
        uint64_t rest = index;
        for (int from_last = 0; from_last < n_axes; from_last++) {
            const int i = n_axes - 1 - from_last;
            place[i] = first[i] + (int64_t)(rest % (uint64_t)n[i]);
            rest /= (uint64_t)n[i];
        }
        if ((st = vvi_job_poll(r->job)) != VV_OK || (st = file_bytes(&bytes, name, r, place)) != VV_OK || bytes == 0)
            continue;
        *found = vvi_zarr_check_packed(&a->chain, bytes, a->chunk_bytes, name, r->job) == VV_OK;
        *n_small += !*found;
    }
    return st;
}

/* No room for what is certainly damaged, and none for a large volume of which nothing is stored: it is one fill value,
 * however large, and no more of that than packed data may grow to. */
static vv_status check_stored(const reading *r, uint64_t bytes)
{
    static const int64_t zeros[VVI_ZARR_AXES] = {0};
    const vvi_zarr_array *a = r->array;
    int64_t first[VVI_ZARR_AXES], n[VVI_ZARR_AXES], all[VVI_ZARR_AXES];
    uint64_t n_small = 0;
    bool found;
    if (bytes <= vvi_job_limits(r->job)->expansion_after)
        return VV_OK;
    for (int i = 0; i < a->n_axes; i++) {
        const int64_t size = a->sharded ? a->shard[i] : a->chunk[i];
        first[i] = r->lo[i] / size;
        n[i] = (r->hi[i] - 1) / size - first[i] + 1;
        all[i] = (a->shape[i] - 1) / size + 1;
    }
    vv_status st = find_stored(&found, &n_small, r, first, n);
    if (st != VV_OK || found)
        return st;
    if (n_small > 0)
        return vv_error_last()->status;
    if ((st = find_stored(&found, &n_small, r, zeros, all)) != VV_OK || found || n_small > 0)
        return st;
    return vv_fail_at(VV_E_LIMIT, vvi_source_name(r->folder), r->path[0] ? r->path : NULL,
                      "asks for %llu bytes, none of which are stored; --limit expansion_after=%lluG allows reading its "
                      "fill value throughout",
                      (unsigned long long)bytes, (unsigned long long)(bytes >> 30) + 1);
}

static vv_status run(reading *r)
{
    size_t n = 0;
    const vvi_work work = {.stage = "read", .item = read_chunk};
    vv_status st = count_chunks(&n, r);
    if (st == VV_OK)
        st = open_shards(r);
    if (st == VV_OK)
        st = vvi_parallel_for(r->job, &work, r, n);
    if (st == VV_OK)
        st = tell_lost(r, n);
    for (size_t i = 0; r->shards && i < r->n_shards; i++)
        vvi_zarr_shard_close(&r->shards[i]);
    vvi_free(r->shards);
    return st;
}

vv_status vvi_zarr_read(vv_field **out, const vv_field_info *info, const vvi_zarr_array *array,
                        const vvi_zarr_axes *axes, const vv_source *folder, const char *path, int64_t frame,
                        const vv_box *region, vv_job *job)
{
    const int64_t *dims = info->grid.dims;
    const vv_box box = region ? *region : (vv_box){{0, 0, 0}, {dims[0], dims[1], dims[2]}};
    vv_field_info part = *info;
    uint64_t bytes;
    void *data;
    vv_field *field;
    *out = NULL;
    part.grid = vv_grid_crop(&info->grid, &box);
    part.frame = frame;
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st != VV_OK || (st = vvi_memory_plan(job, bytes, "volume")) != VV_OK ||
        (st = vvi_memory_plan(job, array->chunk_bytes, "a chunk")) != VV_OK)
        return st;
    reading r = {.array = array, .folder = folder, .path = path, .job = job, .lost_index = SIZE_MAX};
    r.out_bytes = vv_type_bytes(info->type);
    r.floats = vv_type_is_float(info->type);
    r.n_samples = bytes / r.out_bytes;
    want(&r, &part, axes, frame, &box);
    if ((st = check_stored(&r, bytes)) != VV_OK || (st = vv_field_new_empty(&field, &data, &part, job)) != VV_OK)
        return st;
    r.out = data;
    pthread_mutex_init(&r.mutex, NULL);
    st = run(&r);
    pthread_mutex_destroy(&r.mutex);
    if (st != VV_OK)
        vv_field_release(field);
    else
        *out = field;
    return st;
}
