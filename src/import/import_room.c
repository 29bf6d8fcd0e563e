#include "import/import_room.h"
#include "core/memory.h"
#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

void vvi_import_room_free(void *user)
{
    vvi_import_room *s = user;
    if (s->data)
        munmap(s->data, s->bytes);
    if (s->counted)
        vvi_memory_give_back(s->counted_in, s->bytes, VVI_MEM_VOXELS);
    free(s);
}

vv_status vvi_import_room_new(vvi_import_room **out, int *fd_out, uint64_t bytes)
{
    *out = NULL;
    *fd_out = -1;
    if (bytes > SIZE_MAX / 2)
        return vv_fail(VV_E_LIMIT, "%llu bytes cannot be shared", (unsigned long long)bytes);
    vvi_import_room *s = vvi_calloc(1, sizeof *s);
    if (!s)
        return vv_fail_memory(sizeof *s);
    const int fd = memfd_create("volvis samples", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (fd < 0 || ftruncate(fd, (off_t)bytes) != 0 || fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW) != 0) {
        vv_status st = vv_fail(VV_E_MEMORY, "no memory can be shared with the import program: %s", strerror(errno));
        if (fd >= 0)
            close(fd);
        free(s);
        return st;
    }
    s->bytes = (size_t)bytes;
    *fd_out = fd;
    *out = s;
    return VV_OK;
}

vv_status vvi_import_room_count(vvi_import_room *s, vv_job *job)
{
    vv_status st = s->counted ? VV_OK : vvi_memory_take(&s->counted_in, job, s->bytes, VVI_MEM_VOXELS);
    s->counted = st == VV_OK;
    return st;
}

bool vvi_import_room_seal(vvi_import_room *s, int fd)
{
    if (fcntl(fd, F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SEAL) != 0)
        return false;
    void *data = mmap(NULL, s->bytes, PROT_READ, MAP_PRIVATE, fd, 0);
    s->data = data == MAP_FAILED ? NULL : data;
    return s->data != NULL;
}
