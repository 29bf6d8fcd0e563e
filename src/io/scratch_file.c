#include "io/scratch_file.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/store.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

struct vvi_scratch_file {
    vvi_store *store;
    void *map; /* of n_bytes; NULL: it is not mapped */
    size_t n_bytes;
};

static vv_status reserve(const vvi_scratch_file *f, uint64_t bytes)
{
    const char *folder = getenv("TMPDIR");
    const int error = bytes > 0 ? posix_fallocate(f->store->fd, 0, (off_t)bytes) : 0;
    char need[32];
    vvi_print_bytes(need, bytes);
    if (error)
        return vv_fail(VV_E_WRITE, "%s: needs a temporary file of %s, and %.200s has no room for it: %s; set TMPDIR",
                       f->store->name, need, folder && *folder ? folder : "/tmp", strerror(error));
    return vvi_store_measure(f->store);
}

vv_status vvi_scratch_file_new(vvi_scratch_file **out, uint64_t bytes, const char *name, vv_job *job)
{
    vvi_scratch_file *f = vvi_alloc_zeroed(job, sizeof *f, VVI_MEM_SCRATCH);
    *out = NULL;
    if (!f)
        return vv_fail_memory(sizeof *f);
    vv_status st = vvi_store_temporary(&f->store, name, job);
    f->n_bytes = (size_t)bytes;
    if (st == VV_OK)
        st = reserve(f, bytes);
    if (st != VV_OK) {
        vvi_scratch_file_free(f);
        return st;
    }
    *out = f;
    return VV_OK;
}

void vvi_scratch_file_free(vvi_scratch_file *file)
{
    if (!file)
        return;
    if (file->map)
        munmap(file->map, file->n_bytes);
    vvi_store_release(file->store);
    vvi_free(file);
}

vv_status vvi_scratch_file_map(void **out, vvi_scratch_file *file)
{
    if (!file->map && file->n_bytes > 0) {
        void *map = mmap(NULL, file->n_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file->store->fd, 0);
        if (map == MAP_FAILED)
            return vv_fail(VV_E_MEMORY, "%s: a temporary file cannot be mapped: %s", file->store->name,
                           strerror(errno));
        file->map = map;
    }
    *out = file->map;
    return VV_OK;
}

vv_status vvi_scratch_file_write(vvi_scratch_file *file, uint64_t at, const void *data, size_t n, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t done = 0; done < n && st == VV_OK;) {
        const ssize_t now = pwrite(file->store->fd, (const char *)data + done, n - done, (off_t)(at + done));
        if (now < 0 && errno != EINTR)
            return vv_fail(VV_E_WRITE, "%s: writing to a temporary file: %s", file->store->name, strerror(errno));
        done += now > 0 ? (size_t)now : 0;
        st = vvi_job_poll(job);
    }
    return st;
}

vv_status vvi_scratch_file_read(vvi_scratch_file *file, uint64_t at, void *out, size_t n, vv_job *job)
{
    size_t got;
    vv_status st = vvi_store_read(file->store, at, out, n, &got, job);
    if (st == VV_OK && got < n)
        return vv_fail(VV_E_READ, "%s: a temporary file ends early", file->store->name);
    return st == VV_OK ? vvi_job_poll(job) : st;
}
