#include "io/images/image_bytes.h"

#include "core/job.h"
#include "core/memory.h"

#define FIRST_ROOM ((size_t)1 << 16)

/* Room for all at once where the length is known, else twice as much each time. */
static size_t next_room(size_t room, bool exact, uint64_t left)
{
    const size_t twice = room > 0 ? 2 * room : FIRST_ROOM;
    const size_t whole = exact && left < SIZE_MAX - 1 ? (size_t)left + 1 : 0;
    return whole > room ? whole : twice;
}

vv_status vvi_image_bytes(uint8_t **out, size_t *n_out, vv_source *source, vv_job *job)
{
    bool exact;
    const uint64_t left = vvi_source_left(source, &exact);
    uint8_t *data = NULL;
    size_t n = 0, room = 0, got = 1;
    *out = NULL;
    *n_out = 0;
    vv_status st = exact ? vvi_memory_plan(job, left, "the file of the image") : VV_OK;
    while (st == VV_OK && got > 0) {
        if (n == room) {
            const size_t more = next_room(room, exact, left);
            uint8_t *grown = vvi_realloc(job, data, more, VVI_MEM_SCRATCH);
            if (!grown) {
                st = vv_fail_memory(more);
                break;
            }
            data = grown;
            room = more;
        }
        const size_t want = room - n < FIRST_ROOM ? room - n : FIRST_ROOM;
        if ((st = vvi_source_read_some(source, data + n, want, &got)) == VV_OK)
            st = vvi_job_poll(job);
        n += got;
    }
    if (st != VV_OK) {
        vvi_free(data);
        return st;
    }
    *out = data;
    *n_out = n;
    return VV_OK;
}
