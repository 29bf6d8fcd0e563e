#include "server/memory_file.h"
#include "core/status.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static vv_status write_all(int fd, const uint8_t *bytes, size_t n)
{
    while (n > 0) {
        const ssize_t done = write(fd, bytes, n);
        if (done < 0 && errno != EINTR)
            return vv_fail(VV_E_MEMORY, "there is no memory for a file of %zu bytes: %s", n, strerror(errno));
        bytes += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return VV_OK;
}

vv_status vvi_memory_file_new(int *fd_out, const uint8_t *bytes, size_t n)
{
    *fd_out = 0;
    const int fd = memfd_create("volvis", MFD_CLOEXEC);
    if (fd < 0)
        return vv_fail(VV_E_MEMORY, "no file in memory: %s", strerror(errno));
    const vv_status st = write_all(fd, bytes, n);
    if (st == VV_OK)
        *fd_out = fd;
    else
        close(fd);
    return st;
}

int vvi_memory_file_open(int fd)
{
    char path[32];
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    return open(path, O_RDONLY | O_CLOEXEC);
}
