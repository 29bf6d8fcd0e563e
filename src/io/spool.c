#include "io/spool.h"
#include "core/job.h"
#include "core/memory.h"
#include <errno.h>
#include <string.h>
#include <sys/statvfs.h>
#include <unistd.h>

#define PIECE_BYTES ((size_t)256 << 10)

static vv_status fail_too_large(const char *name)
{
    return vv_fail_at(VV_E_LIMIT, name, NULL,
                      "is larger than a temporary file may be; --limit import_spool=N allows more");
}

/* A little data may unpack to more than the disk has, which others need as well. */
static uint64_t room_on_disk(int fd)
{
    struct statvfs about;
    if (fstatvfs(fd, &about) != 0)
        return UINT64_MAX;
    const uint64_t there = (uint64_t)about.f_bavail * about.f_frsize;
    return there - there / 8;
}

vv_status vvi_spool_begin(vvi_spool *out, const char *name, vv_job *job)
{
    *out = (vvi_spool){.name = name, .most = vvi_job_limits(job)->import_spool};
    const vv_status st = vvi_store_temporary(&out->store, name, job);
    if (st == VV_OK)
        out->room = room_on_disk(out->store->fd);
    return st;
}

vv_status vvi_spool_put(vvi_spool *spool, const void *data, size_t n)
{
    spool->total += n;
    if (spool->total > spool->most)
        return fail_too_large(spool->name);
    if (spool->total > spool->room)
        return vv_fail_at(VV_E_LIMIT, spool->name, NULL, "would fill the disk of temporary files; set TMPDIR");
    for (size_t at = 0; at < n;) {
        const ssize_t put = write(spool->store->fd, (const char *)data + at, n - at);
        if (put < 0 && errno == EFBIG)
            return fail_too_large(spool->name);
        if (put < 0 && errno != EINTR)
            return vv_fail_at(VV_E_READ, spool->name, NULL, "cannot be kept in a temporary file: %s; set TMPDIR",
                              strerror(errno));
        at += put > 0 ? (size_t)put : 0;
    }
    return VV_OK;
}

vv_status vvi_spool_fill(vvi_spool *spool, vvi_spool_next *next, void *user, vv_job *job)
{
    uint8_t *piece = vvi_alloc(job, PIECE_BYTES, VVI_MEM_SCRATCH);
    if (!piece)
        return vv_fail_memory(PIECE_BYTES);
    vv_status st = VV_OK;
    for (size_t n = 1; n > 0 && st == VV_OK;) {
        st = next(user, piece, PIECE_BYTES, &n, job);
        if (st == VV_OK)
            st = vvi_spool_put(spool, piece, n);
        if (st == VV_OK)
            st = vvi_job_poll(job);
    }
    vvi_free(piece);
    return st;
}
