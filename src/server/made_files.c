/* Files that are made for pages to fetch: pictures and shapes. */
#include "core/memory.h"
#include "server/memory_file.h"
#include "server/page_shape.h"
#include "server/session_impl.h"

#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
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

vv_status vvi_made_memory_new(vvi_made_memory *out, const uint8_t *bytes, size_t n, vv_job *job)
{
    *out = (vvi_made_memory){.n = n};
    vv_status st = vvi_memory_take(&out->counted_in, job, n, VVI_MEM_IMAGE);
    if (st != VV_OK) {
        *out = (vvi_made_memory){0};
        return st;
    }
    if ((st = vvi_memory_file_new(&out->fd, bytes, n)) != VV_OK)
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

/* NAME_MOST: of a name, that an address has at least. */
enum { NAME_MOST = 64 };

int vvi_session_open_result(const vvi_session *s, const char *place, const char **name_out)
{
    char *name = NULL;
    const int64_t number = *place >= '1' && *place <= '9' ? strtoll(place, &name, 10) : 0;
    const vvi_made_file *f = s->files;
    while (f && f->number != number)
        f = f->next;
    if (!f || !name || *name != '/' || strncmp(name + 1, f->name, NAME_MOST) != 0)
        return -1;
    const int fd = f->shape ? ((const vvi_page_shape_file *)vvi_cached_value(f->shape))->fd : f->memory.fd;
    *name_out = f->name;
    return fd > 0 ? vvi_memory_file_open(fd) : open(f->path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW);
}
