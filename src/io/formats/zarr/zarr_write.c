/* Writing OME-Zarr 0.4 (Zarr 2) and 0.5 (Zarr 3). All levels grow together, slab by slab: one pass over the field, and
 * no more of it is held than one slab a level. */
#include "io/formats/zarr/zarr_write.h"
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "registry.h"
#include <ctype.h>
#include <string.h>

#define EDGE 64                          /* of chunks; levels end when no axis is longer */
#define SHARD_EDGE 8                     /* chunks of a shard along x and y at most */
#define SHARD_BYTES ((uint64_t)64 << 20) /* of one before it is packed, at most */

/* Levels --------------------------------------------------------------------------------------------------------- */

/* Shards are as deep as a chunk, and files of tens of megabytes at most. */
static void choose_shard(vvi_zarr_level *l, const vvi_zarr_writing *w)
{
    const uint64_t bytes = (uint64_t)(l->chunk[0] * l->chunk[1] * l->chunk[2]) * w->type_bytes;
    int64_t edge = SHARD_EDGE;
    while (edge > 1 && bytes * (uint64_t)(edge * edge) > SHARD_BYTES)
        edge /= 2;
    for (int a = 0; a < 2; a++) {
        const int64_t n = (l->dims[a] + l->chunk[a] - 1) / l->chunk[a];
        l->shard[a] = !w->sharded ? 0 : n < edge ? n : edge;
    }
    if (l->shard[0] * l->shard[1] == 1) /* one chunk alone needs no index */
        l->shard[0] = l->shard[1] = 0;
}

static void choose_chunk(vvi_zarr_level *l, const vvi_zarr_writing *w)
{
    /* flat images have wide chunks instead of deep ones */
    const int64_t wide = l->dims[2] >= EDGE / 2 ? EDGE : l->dims[2] >= EDGE / 8 ? 2 * EDGE : 4 * EDGE;
    const int64_t most[3] = {wide, wide, EDGE};
    for (int a = 0; a < 3; a++)
        l->chunk[a] = l->dims[a] < most[a] ? l->dims[a] : most[a];
    choose_shard(l, w);
}

static void plan_levels(vvi_zarr_writing *w)
{
    vvi_zarr_level *l = w->level;
    for (int a = 0; a < 3; a++) {
        l->dims[a] = w->info->grid.dims[w->source_axis[a]];
        l->factor[a] = 1;
    }
    choose_chunk(l, w);
    w->n_levels = 1;
    for (bool more = true; w->n_levels < VVI_ZARR_LEVELS; w->n_levels++, l++) {
        more = false;
        l[1] = (vvi_zarr_level){0};
        for (int a = 0; a < 3; a++) {
            const bool halve = l->dims[a] > EDGE;
            l[1].dims[a] = halve ? (l->dims[a] + 1) / 2 : l->dims[a];
            l[1].factor[a] = halve ? 2 * l->factor[a] : l->factor[a];
            more = more || halve;
        }
        if (!more)
            break;
        choose_chunk(&l[1], w);
    }
}

/* Slabs ---------------------------------------------------------------------------------------------------------- */

/* A full slab, or the last one of its level: its chunks, and what it adds to the next level. */
static vv_status flush(vvi_zarr_writing *w, int first)
{
    vv_status st = VV_OK;
    for (int i = first; i < w->n_levels && st == VV_OK; i++) {
        vvi_zarr_level *l = &w->level[i];
        if (l->n < l->chunk[2] && l->at + l->n < l->dims[2])
            return VV_OK;
        st = l->shard[0] > 0 ? vvi_zarr_write_shards(w, i) : vvi_zarr_write_chunks(w, i);
        if (st == VV_OK && i + 1 < w->n_levels)
            st = vvi_zarr_halve(w, i);
        l->at += l->n;
        l->n = 0;
    }
    return st;
}

static vv_status write_frame(vvi_zarr_writing *w, const vv_field *field)
{
    vvi_zarr_level *l = w->level;
    vv_status st = VV_OK;
    for (int i = 0; i < w->n_levels; i++)
        w->level[i].at = w->level[i].n = 0;
    while (st == VV_OK && l->at < l->dims[2]) {
        l->n = l->dims[2] - l->at < l->chunk[2] ? l->dims[2] - l->at : l->chunk[2];
        st = vvi_zarr_fill_slab(w, field);
        if (st == VV_OK)
            st = flush(w, 0);
        if (st == VV_OK)
            st = vvi_job_progress(w->job, "write", (uint64_t)(w->frame * l->dims[2] + l->at),
                                  (uint64_t)(w->n_frames * l->dims[2]));
    }
    return st == VV_OK ? vv_field_health(field) : st;
}

/* Rows ----------------------------------------------------------------------------------------------------------- */

const char *const vvi_zarr_encodings[] = {
#if VV_HAVE_BLOSC
    "blosc",
#endif
#if VV_HAVE_ZSTD
    "zstd",
#endif
    "gzip",  "raw", NULL,
};

static const char *const encodings_0_5[] = {
#if VV_HAVE_BLOSC
    "sharded-blosc",
#endif
#if VV_HAVE_ZSTD
    "sharded-zstd",
#endif
    "sharded-gzip",  "sharded-raw",
#if VV_HAVE_BLOSC
    "blosc",
#endif
#if VV_HAVE_ZSTD
    "zstd",
#endif
    "gzip",          "raw",         NULL,
};

static void use_encoding(vvi_zarr_writing *w, const char *encoding)
{
    static const char *const names[] = {"raw", "gzip", "zstd", "blosc"}; /* as vvi_zarr_packing counts */
    static const char sharded[] = "sharded-";
    w->sharded = strncmp(encoding, sharded, sizeof sharded - 1) == 0;
    encoding += w->sharded ? sizeof sharded - 1 : 0;
    for (int i = 0; i < 4; i++)
        if (strcmp(encoding, names[i]) == 0)
            w->packing = (vvi_zarr_packing)i;
}

static vv_status write_image(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, int version, vv_job *job)
{
    vvi_zarr_writing *w = vvi_alloc_zeroed(job, sizeof *w, VVI_MEM_SCRATCH);
    if (!w)
        return vv_fail_memory(sizeof *w);
    w->sink = sink;
    w->job = job;
    w->options = options;
    w->info = vv_field_get_info(frames[0]);
    w->n_frames = (int64_t)n_frames;
    w->version = version;
    use_encoding(w, options->encoding ? options->encoding : version == 3 ? encodings_0_5[0] : vvi_zarr_encodings[0]);
    w->label = w->info->meaning == VV_MEANING_LABEL && w->info->components == 1 && !vv_type_is_float(w->info->type);
    w->type_bytes = vv_type_bytes(w->info->type);
    w->sample_bytes = w->type_bytes * (size_t)w->info->components;
    vvi_zarr_write_place(w);
    plan_levels(w);
    vv_status st = vvi_zarr_make_slabs(w);
    if (st == VV_OK)
        st = vvi_zarr_write_meta(w);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++) {
        w->frame = (int64_t)f;
        st = write_frame(w, frames[f]);
    }
    vvi_zarr_free_slabs(w);
    vvi_free(w);
    return st;
}

static vv_status write_0_5(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                           const vv_write_options *options, vv_job *job)
{
    return write_image(sink, frames, n_frames, options, 3, job);
}

vv_status vvi_zarr_write_0_4(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job)
{
    return write_image(sink, frames, n_frames, options, 2, job);
}

/* Metadata, or chunks: numbers, dots between them, perhaps a c in front. */
int vvi_zarr_folder_file(const char *name)
{
    static const char *const marks[] = {".zarray", ".zgroup", "zarr.json"};
    static const char *const others[] = {".zattrs", ".zmetadata", "METADATA.ome.xml"};
    const char *slash = strrchr(name, '/');
    const char *last = slash ? slash + 1 : name;
    for (size_t i = 0; i < 3; i++)
        if (strcmp(last, marks[i]) == 0)
            return 2;
    for (size_t i = 0; i < 3; i++)
        if (strcmp(last, others[i]) == 0)
            return 1;
    if (*last == 'c')
        last += last[1] == '.' ? 2 : 1;
    for (bool digit = false; *last; last++) {
        if (!isdigit((unsigned char)*last) && (*last != '.' || !digit))
            return 0;
        digit = *last != '.';
    }
    return 1;
}

static const char *const suffixes[] = {".ome.zarr", ".zarr", NULL};

const vv_format vvi_format_ome_zarr_0_5 = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "ome-zarr-0.5",
    .doc = "OME-Zarr 0.5 (Zarr 3); read as ome-zarr",
    .suffixes = suffixes,
    .encodings = encodings_0_5,
    .write = write_0_5,
    .folder_file = vvi_zarr_folder_file,
};
