/** @file
 * The undecoded bytes behind sources: a regular file, a stream that is read once, or memory.
 */
#ifndef VVI_IO_STORE_H
#define VVI_IO_STORE_H
#include "io/source.h"

typedef struct vvi_store {
    int users; /* sources on it; all of one thread at a time */
    int fd;    /* -1: memory */
    bool seekable, folder;
    uint64_t size;      /* UINT64_MAX for a stream */
    uint64_t stream_at; /* of a stream: how many bytes were taken */
    uint8_t *head;      /* of a stream: all that was taken, as long as it is kept */
    size_t n_head, head_room;
    bool head_gone;
    const uint8_t *memory; /* or NULL */
    char *path;            /* NULL for memory and standard input */
    char *open_path;       /* under which a regular file can be opened again; NULL when it cannot */
    char *name;            /* stands in errors */
} vvi_store;

vv_status vvi_store_open(vvi_store **out, const char *path, vv_job *job);
vv_status vvi_store_memory(vvi_store **out, const void *data, size_t n, const char *name, vv_job *job);
vv_status vvi_store_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job);
/** The same where the file may be absent: *out is NULL then. */
vv_status vvi_store_find_beside(vvi_store **out, const vvi_store *header, const char *name, vv_job *job);
/** An empty file without a name; fill its fd, then measure it. */
vv_status vvi_store_temporary(vvi_store **out, const char *name, vv_job *job);
vv_status vvi_store_measure(vvi_store *store);
/** All that a stream has given and will give goes to a temporary file, which the store is from then on. A stream keeps
 * its first bytes for that, no more than a header may have, until vvi_store_forget_head(). */
vv_status vvi_store_make_repeatable(vvi_store *store, vv_job *job);
void vvi_store_forget_head(vvi_store *store);
/** The folder in which a file lies; *out NULL: none that can be read. */
vv_status vvi_store_folder_of(vvi_store **out, const vvi_store *file, vv_job *job);
vv_status vvi_store_list(vvi_names *out, const vvi_store *folder, const char *below, bool deep, vv_job *job);
vv_status vvi_store_list_folders(vvi_names *out, const vvi_store *folder, const char *below, vv_job *job);
vvi_store *vvi_store_retain(vvi_store *store);
void vvi_store_release(vvi_store *store);
/** Up to n bytes at an offset; *n_read less only at the end. A stream can only go on where it stands. */
vv_status vvi_store_read(vvi_store *store, uint64_t offset, void *out, size_t n, size_t *n_read, vv_job *job);
#endif
