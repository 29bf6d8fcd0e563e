/* Sources read by lines. */
#include "core/memory.h"
#include "io/source_impl.h"
#include <string.h>

static vv_status line_add(vv_source *s, size_t used, const uint8_t *from, size_t n)
{
    if (used + n + 1 > s->line_room) {
        const size_t room = (used + n + 1) * 2;
        char *grown = vvi_realloc(s->job, s->line, room, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(room);
        s->line = grown;
        s->line_room = room;
    }
    if (n > 0)
        memcpy(s->line + used, from, n);
    s->line[used + n] = 0;
    return VV_OK;
}

vv_status vvi_source_line(vv_source *s, const char **line_out, size_t most, bool *end)
{
    vv_status st;
    size_t used = 0, there;
    *line_out = NULL;
    *end = false;
    for (bool whole = false; !whole;) {
        const uint8_t *head = vvi_source_peek(s, VVI_SOURCE_PEEK_MOST, &there);
        if (!head)
            return vv_error_last()->status;
        const uint8_t *stop = memchr(head, '\n', there);
        const size_t n = stop ? (size_t)(stop - head) : there;
        if (used + n > most)
            return vv_fail_at(
                VV_E_FORMAT, s->name, NULL, "a line has more than %zu bytes; this is not a text header%s", most,
                most < vvi_source_limits(s)->string_bytes ? "" : ", or --limit string_bytes=N allows more");
        if ((st = line_add(s, used, head, n)) != VV_OK)
            return st;
        used += n;
        if ((st = vvi_source_hand(s, n)) != VV_OK)
            return st;
        whole = stop || there == 0;
        *end = !stop && there == 0 && used == 0;
        if ((st = vvi_source_skip(s, n + (stop != NULL))) != VV_OK)
            return st;
    }
    if (*end && s->problem[0])
        return vvi_source_fail(s);
    if (used > 0 && s->line[used - 1] == '\r')
        s->line[--used] = 0;
    *line_out = s->line;
    return VV_OK;
}
