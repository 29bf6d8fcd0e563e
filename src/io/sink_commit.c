/* How what was written becomes the target: synced and renamed, so a crash leaves the old file or the new one. Files
 * that belong together are all synced before any is renamed, and the first is renamed last, so that a header never
 * names data that is not there. */
#include "core/job.h"
#include "core/memory.h"
#include "io/sink_headers.h"
#include "io/sink_impl.h"
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* What is not replaced --------------------------------------------------------------------------------------------- */

/* Whether a file that is there may be replaced. */
static vv_status spare_input(const vv_sink *s)
{
    struct stat info;
    if (!s->spares_inputs || !s->path || stat(s->path, &info) != 0 ||
        !vvi_job_has_read(s->job, (uint64_t)info.st_dev, (uint64_t)info.st_ino))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                      "would be replaced, and samples were read from it; choose another name%s",
                      vvi_job_or_overwrite(s->job));
}

/* Nor is what a header other than its own (NULL: it has none) names as its data. */
static vv_status spare_header(const vv_sink *s, const char *own)
{
    struct stat info;
    if (!s->spares_inputs || !s->path || stat(s->path, &info) != 0)
        return VV_OK;
    char *header = vvi_header_that_names(s->path, own);
    if (!header)
        return VV_OK;
    const vv_status st = vv_fail_at(VV_E_ARGUMENT, s->name, NULL,
                                    "would be replaced, and '%.200s' beside it names it as its data; choose another "
                                    "name%s",
                                    header, vvi_job_or_overwrite(s->job));
    free(header);
    return st;
}

/* A new name, taken by one alone of all that want it at once. Not every file system can do that while it renames; then
 * what is written gets the name as a second one, or the name is taken by something empty first. */
static int rename_to_new(const char *temporary, const char *path)
{
    struct stat about;
    if (renameat2(AT_FDCWD, temporary, AT_FDCWD, path, RENAME_NOREPLACE) == 0)
        return 0;
    if ((errno != EINVAL && errno != ENOSYS) || lstat(temporary, &about) != 0)
        return -1;
    if (S_ISDIR(about.st_mode)) {
        if (mkdir(path, 0777) != 0)
            return -1;
    } else {
        if (link(temporary, path) == 0)
            return unlink(temporary);
        const int fd = errno == EEXIST ? -1 : open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
        if (fd < 0)
            return -1;
        close(fd);
    }
    if (rename(temporary, path) == 0)
        return 0;
    const int error = errno;
    remove(path); /* what was empty */
    errno = error;
    return -1;
}

int vvi_sink_rename(const char *temporary, const char *path, const vv_job *job)
{
    return vvi_job_keeps_existing(job) ? rename_to_new(temporary, path) : rename(temporary, path);
}

vv_status vvi_sink_fail_existing(const char *name)
{
    return vv_fail_at(VV_E_WRITE, name, NULL, "already exists, and is left as it is; choose another name");
}

/* Committing ----------------------------------------------------------------------------------------------------- */

/* What a library wrote to it by itself is seen in the end. */
static vv_status count_all(vv_sink *s)
{
    struct stat info;
    return s->path && fstat(s->fd, &info) == 0 ? vvi_sink_count(s, (uint64_t)info.st_size) : VV_OK;
}

static vv_status settle(vv_sink *s)
{
    vv_status st = vvi_sink_coding(s, VVI_CODING_NONE, 0);
    if (st != VV_OK)
        return st;
    if (s->failed)
        return vv_fail_at(VV_E_WRITE, s->name, NULL, "is not written: an earlier write failed");
    if ((st = vvi_sink_copy_library(s)) != VV_OK || (st = count_all(s)) != VV_OK)
        return st;
    if (s->path && fsync(s->fd) != 0)
        return vvi_sink_fail(s, "syncing", errno);
    if (s->path && !s->temporary && (st = vvi_sink_name_temporary(s, 0)) != VV_OK)
        return st;
    const int fd = s->fd;
    s->fd = -1;
    return close(fd) == 0 ? VV_OK : vvi_sink_fail(s, "closing", errno);
}

vv_status vvi_sink_take(uint8_t **data_out, size_t *n_out, vv_sink *s)
{
    *data_out = NULL;
    *n_out = 0;
    vvi_check(s->in_memory);
    vv_status st = vvi_sink_coding(s, VVI_CODING_NONE, 0);
    if (st == VV_OK && s->failed)
        st = vv_fail_at(VV_E_WRITE, s->name, NULL, "is incomplete: an earlier write failed");
    if (st == VV_OK)
        st = vvi_sink_copy_library(s);
    if (st == VV_OK) {
        *data_out = s->memory;
        *n_out = (size_t)s->written;
        s->memory = NULL;
    }
    vvi_sink_free(s);
    return st;
}

static vv_status put_in_place(vv_sink *s)
{
    if (!s->path)
        return VV_OK;
    if (vvi_sink_rename(s->temporary, s->path, s->job) != 0)
        return errno == EEXIST ? vvi_sink_fail_existing(s->name) : vvi_sink_fail(s, "renaming", errno);
    free(s->temporary);
    s->temporary = NULL;
    s->placed = true;
    vvi_sink_sync_parent(s->path);
    return VV_OK;
}

vv_status vvi_sink_commit(vv_sink *s)
{
    vv_status st = s->folder ? vvi_sink_folder_commit(s->folder) : VV_OK;
    if (s->folder) {
        vvi_sink_abandon(s);
        return st;
    }
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        st = settle(b);
    if (st == VV_OK)
        st = settle(s);
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        if ((st = spare_input(b)) == VV_OK)
            st = spare_header(b, s->path);
    if (st == VV_OK && (st = spare_input(s)) == VV_OK)
        st = spare_header(s, NULL);
    for (vv_sink *b = s->beside; b && st == VV_OK; b = b->next)
        st = put_in_place(b);
    if (st == VV_OK)
        st = put_in_place(s);
    for (vv_sink *b = s->beside; b && st != VV_OK && vvi_job_keeps_existing(s->job); b = b->next)
        if (b->placed) /* new, and of no use without the first */
            unlink(b->path);
    vvi_sink_abandon(s);
    return st;
}
