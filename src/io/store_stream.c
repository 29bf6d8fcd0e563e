/* Streams that will be read more than once. Who knows that he will (a step that looks at the samples before it works on
 * them, axes in another order, statistics) knows it only when the header has told how large the volume is, and by then
 * its bytes are taken. So a stream keeps what it gives until the samples are read, which is little. That way a header
 * alone, or one pass, neither waits for the end of a pipe nor fills a disk. */
#include "core/job.h"
#include "core/memory.h"
#include "io/spool.h"
#include "io/store_impl.h"
#include <string.h>
#include <unistd.h>

#define PIECE_BYTES ((size_t)256 << 10)

void vvi_store_forget_head(vvi_store *s)
{
    vvi_free(s->head);
    s->head = NULL;
    s->n_head = s->head_room = 0;
    s->head_gone = true;
}

void vvi_store_keep_head(vvi_store *s, const void *bytes, size_t n, vv_job *job)
{
    const uint64_t most = vvi_job_limits(job)->header_bytes + 2 * PIECE_BYTES; /* with what was read ahead of its end */
    if (s->head_gone)
        return;
    if (n > most || s->n_head > most - n) {
        vvi_store_forget_head(s);
        return;
    }
    if (s->n_head + n > s->head_room) {
        const size_t room = 2 * (s->n_head + n);
        uint8_t *more = vvi_realloc(job, s->head, room, VVI_MEM_SCRATCH);
        if (!more) { /* it may never be needed */
            vvi_store_forget_head(s);
            return;
        }
        s->head = more;
        s->head_room = room;
    }
    memcpy(s->head + s->n_head, bytes, n);
    s->n_head += n;
}

static vv_status next_of_store(void *store, void *out, size_t room, size_t *n, vv_job *job)
{
    vvi_store *s = store;
    return vvi_store_read(s, s->stream_at, out, room, n, job);
}

static vv_status copy_rest(vvi_spool *spool, vvi_store *s, vv_job *job)
{
    const vv_status st = vvi_spool_put(spool, s->head, s->n_head);
    vvi_store_forget_head(s);
    return st == VV_OK ? vvi_spool_fill(spool, next_of_store, s, job) : st;
}

static void become(vvi_store *s, vvi_store *file)
{
    const int stream = s->fd;
    char *stream_path = s->open_path;
    s->fd = file->fd;
    s->open_path = file->open_path;
    s->seekable = true;
    s->size = file->size;
    file->fd = stream; /* closed with it */
    file->open_path = stream_path;
}

vv_status vvi_store_make_repeatable(vvi_store *s, vv_job *job)
{
    vvi_spool spool;
    if (s->seekable || s->folder || s->fd < 0)
        return VV_OK;
    if (s->head_gone)
        return vv_fail_at(VV_E_UNSUPPORTED, s->name, NULL,
                          "is a stream and cannot be read twice; save it to a file first");
    vv_status st = vvi_spool_begin(&spool, s->name, job);
    if (st != VV_OK)
        return st;
    if ((st = copy_rest(&spool, s, job)) == VV_OK && (st = vvi_store_measure(spool.store)) == VV_OK)
        become(s, spool.store);
    vvi_store_release(spool.store);
    return st;
}
