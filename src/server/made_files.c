/* Files that are made for pages to fetch: pictures and shapes. */
#include "core/memory.h"
#include "server/session_impl.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* Pictures that are kept to be fetched, of all pages and of one. */
enum { PICTURES = 64, PICTURES_EACH = 4 };

static void free_memory(vvi_made_memory *memory)
{
    if (memory->fd > 0)
        close(memory->fd);
    vvi_memory_give_back(memory->counted_in, memory->n, VVI_MEM_IMAGE);
    *memory = (vvi_made_memory){0};
}

/* A picture's file goes with it; a shape's is the cache's. */
void vvi_made_file_free(vvi_made_file *file)
{
    if (!file->shape && file->path)
        vvi_files_remove(file->path);
    vvi_cache_release(file->shape);
    free_memory(&file->memory);
    free(file->path);
    free(file->name);
    free(file);
}

void vvi_made_memory_free(vvi_made_memory *memory)
{
    free_memory(memory);
}

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

vv_status vvi_made_memory_new(vvi_made_memory *out, const uint8_t *bytes, size_t n, vv_job *job)
{
    *out = (vvi_made_memory){.n = n};
    vv_status st = vvi_memory_take(&out->counted_in, job, n, VVI_MEM_IMAGE);
    if (st != VV_OK) {
        *out = (vvi_made_memory){0};
        return st;
    }
    out->fd = memfd_create("volvis-picture", MFD_CLOEXEC);
    st = out->fd > 0 ? write_all(out->fd, bytes, n) : vv_fail(VV_E_MEMORY, "no file in memory: %s", strerror(errno));
    if (st != VV_OK)
        free_memory(out);
    return st;
}

/* The oldest go, where there are many of its page's or of all. */
void vvi_made_files_add_picture(vvi_session *s, vvi_made_file *file)
{
    int all = 0, own = 0;
    file->next = s->files;
    s->files = file;
    for (vvi_made_file **at = &s->files; *at;) {
        vvi_made_file *f = *at;
        const bool is_own = f->serial == file->serial;
        all += !f->shape;
        own += !f->shape && is_own;
        if (f->shape || (all <= PICTURES && !(is_own && own > PICTURES_EACH))) {
            at = &f->next;
            continue;
        }
        *at = f->next;
        vvi_made_file_free(f);
    }
}

void vvi_made_files_leave(vvi_session *s, uint64_t serial)
{
    for (vvi_made_file **at = &s->files; *at;) {
        vvi_made_file *f = *at;
        if (f->memory.fd <= 0 || f->serial != serial) {
            at = &f->next;
            continue;
        }
        *at = f->next;
        vvi_made_file_free(f);
    }
}

int vvi_session_open_result(const vvi_session *s, int64_t number, const char **name_out)
{
    char path[32];
    for (const vvi_made_file *f = s->files; f; f = f->next) {
        if (f->number != number)
            continue;
        *name_out = f->name;
        if (f->memory.fd <= 0)
            return open(f->path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
        snprintf(path, sizeof path, "/proc/self/fd/%d", f->memory.fd); /* from its beginning */
        return open(path, O_RDONLY | O_CLOEXEC);
    }
    return -1;
}
