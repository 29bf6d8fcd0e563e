#include "input/record.h"

#include <string.h>

static const char head[] = "volvis input 1";
enum { LONGEST = 160 };

void vvi_record_begin(vvi_text *out)
{
    vvi_text_printf(out, "%s\n", head);
}

static vv_status fail_line(size_t number, const char *what)
{
    return vv_fail(VV_E_FORMAT, "recording, line %zu: %s", number, what);
}

/* The next line without its end. False: it is too long, or has bytes that are no text. */
static bool next_line(char out[LONGEST], const char **at, const char *end)
{
    const char *stop = memchr(*at, '\n', (size_t)(end - *at));
    const size_t n = (size_t)((stop ? stop : end) - *at);
    if (n >= LONGEST || memchr(*at, 0, n))
        return false;
    memcpy(out, *at, n);
    out[n] = 0;
    *at = stop ? stop + 1 : end;
    return true;
}

static vv_status play_line(int64_t *before, const char *line, size_t number, vvi_replay_fn *take, void *user)
{
    vvi_input_event event;
    if (!*line || *line == '#')
        return VV_OK;
    if (vvi_event_parse(&event, line) != VV_OK) {
        char why[256];
        const char *message = vv_error_last()->message;
        const size_t n = strnlen(message, sizeof why - 1);
        memcpy(why, message, n);
        why[n] = 0;
        return fail_line(number, why);
    }
    if (event.t < *before)
        return fail_line(number, "time runs back");
    *before = event.t;
    return take(user, &event);
}

vv_status vvi_replay(const char *text, size_t n, vvi_replay_fn *take, void *user)
{
    const char *at = text, *end = text + n;
    char line[LONGEST];
    int64_t before = 0;
    vv_status st = VV_OK;
    for (size_t number = 1; at < end && st == VV_OK; number++) {
        if (!next_line(line, &at, end))
            return fail_line(number, "is too long for an event");
        if (number > 1)
            st = play_line(&before, line, number, take, user);
        else if (strcmp(line, head) != 0)
            return fail_line(1, "a recording begins with \"volvis input 1\"");
    }
    return n ? st : fail_line(1, "a recording begins with \"volvis input 1\"");
}
