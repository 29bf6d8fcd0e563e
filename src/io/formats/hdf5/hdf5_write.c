/* Writing HDF5: one data set /volume, (t, z, y, x, c) without the axes of one entry t and c, and attributes that say
 * all that is known of it (docs/formats.md). */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"
#include "io/sample_writer.h"
#include <errno.h>
#include <stdio.h>
#include <string.h>

enum { COPIES = 6 }; /* of a chunk: as it comes, shuffled, packed, in its cache, and some to spare */

typedef struct writing {
    vv_sink *sink;
    const char *name;
    hid_t file, data, native;
    int rank, z; /* z: which axis */
    hsize_t dims[VVI_H5_RANK], chunk[VVI_H5_RANK];
    uint8_t *slab;
    size_t slice_bytes, room, used;
    size_t copies;        /* bytes of the chunks that the library holds while it writes one */
    hsize_t frame, slice; /* where the slab begins */
    bool time;
} writing;

static vv_status fail_writing(const char *name)
{
    const int error = errno;
    H5Eclear2(H5E_DEFAULT);
    return vv_fail_at(VV_E_WRITE, name, NULL, "writing HDF5 failed: %s; the old file, if any, is unchanged",
                      error ? strerror(error) : "the library gives no details");
}

static hid_t file_type(vv_type type, bool big)
{
    const hid_t little_types[VV_TYPE_COUNT] = {H5T_STD_U8LE,   H5T_STD_I8LE,  H5T_STD_U16LE, H5T_STD_I16LE,
                                               H5T_STD_U32LE,  H5T_STD_I32LE, H5T_STD_U64LE, H5T_STD_I64LE,
                                               H5T_IEEE_F32LE, H5T_IEEE_F64LE};
    const hid_t big_types[VV_TYPE_COUNT] = {H5T_STD_U8BE,   H5T_STD_I8BE,  H5T_STD_U16BE, H5T_STD_I16BE,
                                            H5T_STD_U32BE,  H5T_STD_I32BE, H5T_STD_U64BE, H5T_STD_I64BE,
                                            H5T_IEEE_F32BE, H5T_IEEE_F64BE};
    return big ? big_types[type] : little_types[type];
}

static hsize_t at_most(int64_t n, hsize_t most)
{
    return (hsize_t)n < most ? (hsize_t)n : most;
}

static void shape(writing *w, char axes[VVI_H5_RANK + 1], const vv_field_info *info, size_t n_frames)
{
    const int64_t *n = info->grid.dims;
    int a = 0;
    w->time = n_frames > 1;
    if (w->time) {
        axes[a] = 't';
        w->dims[a] = n_frames;
        w->chunk[a++] = 1;
    }
    w->z = a;
    for (int i = 2; i >= 0; i--) { /* z, y, x: pieces of about 256 Ki samples */
        axes[a] = (char)('x' + i);
        w->dims[a] = (hsize_t)n[i];
        w->chunk[a++] = at_most(n[i], i == 2 ? 32 : 96);
    }
    if (info->components > 1) {
        axes[a] = 'c';
        w->dims[a] = (hsize_t)info->components;
        w->chunk[a++] = at_most(info->components, 16);
    }
    axes[a] = 0;
    w->rank = a;
}

/* The slices that have come together go to the file. */
static vv_status flush(writing *w)
{
    hsize_t start[VVI_H5_RANK] = {0}, count[VVI_H5_RANK];
    const hsize_t n = w->used / w->slice_bytes;
    if (n == 0)
        return VV_OK;
    const vv_status st = vvi_h5_reserve(w->copies);
    if (st != VV_OK)
        return st;
    memcpy(count, w->dims, sizeof count);
    if (w->time) {
        start[0] = w->frame;
        count[0] = 1;
    }
    start[w->z] = w->slice;
    count[w->z] = n;
    vvi_h5_lock();
    errno = 0;
    const hid_t to = H5Dget_space(w->data), from = H5Screate_simple(w->rank, count, NULL);
    const bool written = H5Sselect_hyperslab(to, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                         H5Dwrite(w->data, w->native, from, to, H5P_DEFAULT, w->slab) >= 0;
    H5Sclose(to);
    H5Sclose(from);
    const vv_status wrote = written ? VV_OK : fail_writing(w->name);
    vvi_h5_unlock();
    w->slice += n;
    w->used = 0;
    return wrote;
}

static vv_status take_rows(void *user, void *data, size_t n_bytes)
{
    writing *w = user;
    const uint8_t *from = data;
    vv_status st = VV_OK;
    while (n_bytes > 0 && st == VV_OK) {
        const size_t n = n_bytes < w->room - w->used ? n_bytes : w->room - w->used;
        memcpy(w->slab + w->used, from, n);
        w->used += n;
        from += n;
        n_bytes -= n;
        if (w->used == w->room)
            st = flush(w);
    }
    return st;
}

/* The lock is held. */
static vv_status create(writing *w, const vv_field_info *info, size_t n_frames, const vv_write_options *options)
{
    int fd;
    char axes[VVI_H5_RANK + 1];
    const bool raw = options->encoding && strcmp(options->encoding, "raw") == 0;
    shape(w, axes, info, n_frames);
    w->copies = COPIES * vv_type_bytes(info->type);
    for (int a = 0; a < w->rank; a++)
        w->copies *= (size_t)w->chunk[a];
    vv_status st = vvi_h5_reserve(w->copies);
    if (st == VV_OK)
        st = vvi_sink_file(&fd, w->sink);
    if (st != VV_OK)
        return st;
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_obj_track_times(creation, false); /* the same bytes whenever it is written */
    H5Pset_fill_time(creation, H5D_FILL_TIME_NEVER);
    if (!raw) {
        H5Pset_chunk(creation, w->rank, w->chunk);
        H5Pset_shuffle(creation);
        H5Pset_deflate(creation, options->level ? (unsigned)options->level : 4);
    }
    errno = 0;
    w->file = vvi_h5_create_file(fd);
    const hid_t space = H5Screate_simple(w->rank, w->dims, NULL);
    if (w->file >= 0)
        w->data = H5Dcreate2(w->file, "volume", file_type(info->type, options->big_endian), space, H5P_DEFAULT,
                             creation, H5P_DEFAULT);
    H5Sclose(space);
    H5Pclose(creation);
    if (w->data < 0)
        return fail_writing(w->name);
    w->native = vvi_h5_memory_type(&(vvi_h5_set){.convert = true, .type = info->type}, w->data);
    vvi_h5_write_attributes(w->data, axes, info, n_frames, options);
    return VV_OK;
}

static vv_status write_frames(writing *w, const vv_field *const *frames, size_t n_frames, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    vv_status st = vvi_mul3_size(&w->slice_bytes, (size_t)info->grid.dims[0], (size_t)info->grid.dims[1],
                                 (size_t)info->components * vv_type_bytes(info->type));
    if (st == VV_OK)
        st = vvi_mul_size(&w->room, w->slice_bytes, (size_t)w->chunk[w->z]);
    if (st != VV_OK)
        return st;
    w->slab = vvi_alloc(job, w->room, VVI_MEM_SCRATCH);
    if (!w->slab)
        return vv_fail_memory(w->room);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++) {
        w->frame = f;
        w->slice = 0;
        st = vvi_samples_each(frames[f], -1, take_rows, w, job);
        if (st == VV_OK)
            st = flush(w);
    }
    vvi_free(w->slab);
    return st;
}

vv_status vvi_h5_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                       vv_job *job)
{
    writing w = {.sink = sink, .name = vvi_sink_name(sink), .file = -1, .data = -1, .native = -1};
    vv_status st = vvi_h5_reserve(0);
    if (st != VV_OK)
        return st;
    vvi_h5_lock();
    st = create(&w, vv_field_get_info(frames[0]), n_frames, options);
    vvi_h5_unlock();
    if (st == VV_OK)
        st = write_frames(&w, frames, n_frames, job);
    vvi_h5_lock();
    errno = 0;
    if (w.native >= 0)
        H5Tclose(w.native);
    if (w.data >= 0 && H5Dclose(w.data) < 0 && st == VV_OK)
        st = fail_writing(w.name);
    if (w.file >= 0 && H5Fclose(w.file) < 0 && st == VV_OK)
        st = fail_writing(w.name);
    vvi_h5_unlock();
    return st;
}
