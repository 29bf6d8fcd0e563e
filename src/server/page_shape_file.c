/* The file of a shape, on the disk or in memory. */
#include "core/memory.h"
#include "server/memory_file.h"
#include "server/page_shape_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void vvi_shape_file_drop(void *value)
{
    vvi_page_shape_file *file = value;
    if (file->path)
        unlink(file->path);
    if (file->fd > 0)
        close(file->fd);
    free(file->path);
    free(file->name);
    free(file);
}

static vv_status write_all(int fd, const uint8_t *bytes, size_t n, const char *path)
{
    while (n > 0) {
        const ssize_t done = write(fd, bytes, n);
        if (done < 0 && errno != EINTR)
            return vv_fail_at(VV_E_WRITE, path, NULL, "cannot be written: %s", strerror(errno));
        bytes += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return VV_OK;
}

vv_status vvi_shape_file_write(vvi_page_shape_file *file, const vvi_compact *compact, const vvi_page_shape_options *o)
{
    file->number = ++*o->numbers;
    file->n_bytes = compact->n;
    file->name = vvi_asprintf("shape-%" PRId64 ".vvs", file->number);
    if (file->name && !o->folder)
        return vvi_memory_file_new(&file->fd, compact->bytes, compact->n);
    file->path = file->name ? vvi_asprintf("%s/%s", o->folder, file->name) : NULL;
    if (!file->path)
        return vv_fail_memory(256);
    const int fd = open(file->path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0)
        return vv_fail_at(VV_E_WRITE, file->path, NULL, "cannot be written: %s", strerror(errno));
    const vv_status st = write_all(fd, compact->bytes, compact->n, file->path);
    close(fd);
    return st;
}
