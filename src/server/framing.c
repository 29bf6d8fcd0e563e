#include "server/framing.h"
#include "core/memory.h"
#include "core/text.h"

#include <stdlib.h>
#include <string.h>

enum { CONTINUES = 0, LEAST_ROOM = 512, KEPT_ROOM = 4096 };

static vvi_framed fail(vvi_framing *f, int code, const char *why)
{
    f->code = code;
    f->why = why;
    return VVI_FRAMED_BAD;
}

static bool is_control(const vvi_framing *f)
{
    return f->kind >= VVI_FRAME_CLOSE;
}

/* Of a message's room, what is not its client's own. */
static size_t shared_part(size_t room)
{
    return room > VVI_MESSAGE_OWN ? room - VVI_MESSAGE_OWN : 0;
}

static void free_room(vvi_framing *f)
{
    if (f->shared)
        *f->shared -= shared_part(f->room);
    free(f->message);
    f->message = NULL;
    f->room = 0;
}

void vvi_framing_clear(vvi_framing *framing)
{
    free_room(framing);
    *framing = (vvi_framing){.n_head = 0};
}

void vvi_framing_forget(vvi_framing *framing)
{
    if (framing->room > KEPT_ROOM)
        free_room(framing);
}

size_t vvi_framing_head(uint8_t out[10], int kind, size_t n)
{
    return vvi_framing_part(out, kind, n, true);
}

size_t vvi_framing_part(uint8_t out[10], int kind, size_t n, bool last)
{
    const size_t n_length = n < 126 ? 0 : n < 65536 ? 2 : 8;
    out[0] = (uint8_t)((last ? 0x80 : 0) | kind);
    out[1] = (uint8_t)(n_length == 0 ? n : n_length == 2 ? 126 : 127);
    for (size_t i = 0; i < n_length; i++)
        out[2 + i] = (uint8_t)((uint64_t)n >> (8 * (n_length - 1 - i)));
    return 2 + n_length;
}

/* Heads ---------------------------------------------------------------------------------------------------------- */

static size_t length_bytes(const vvi_framing *f)
{
    const int n = f->head[1] & 127;
    return n < 126 ? 0 : n == 126 ? 2 : 8;
}

static vvi_framed check_first(vvi_framing *f)
{
    const uint8_t kind = f->head[0] & 15;
    const bool final = f->head[0] & 0x80;
    if (f->head[0] & 0x70)
        return fail(f, VVI_CLOSE_PROTOCOL, "a frame has bits that were not agreed on");
    if (kind != CONTINUES && kind != VVI_FRAME_TEXT && kind != VVI_FRAME_BINARY &&
        (kind < VVI_FRAME_CLOSE || kind > VVI_FRAME_PONG))
        return fail(f, VVI_CLOSE_PROTOCOL, "a frame is of no known kind");
    if (!(f->head[1] & 0x80))
        return fail(f, VVI_CLOSE_PROTOCOL, "a frame is not masked");
    if (kind == VVI_FRAME_BINARY)
        return fail(f, VVI_CLOSE_KIND, "binary messages are not taken");
    if (kind >= VVI_FRAME_CLOSE && (!final || (f->head[1] & 127) > VVI_CONTROL_MOST))
        return fail(f, VVI_CLOSE_PROTOCOL, "a ping, pong or farewell is too long or in pieces");
    if (kind < VVI_FRAME_CLOSE && (kind == CONTINUES) != f->in_message)
        return fail(f, VVI_CLOSE_PROTOCOL, "the pieces of a message are not in turn");
    return VVI_FRAMED_MORE;
}

/* One length has one way to be written. */
static vvi_framed check_length(vvi_framing *f, size_t n)
{
    f->length = n ? 0 : f->head[1] & 127;
    for (size_t i = 0; i < n; i++)
        f->length = f->length << 8 | f->head[2 + i];
    if ((n == 2 && f->length < 126) || (n == 8 && (f->length < 65536 || f->length >> 63)))
        return fail(f, VVI_CLOSE_PROTOCOL, "the length of a frame is not written as it should be");
    if (!is_control(f) && f->length + f->n_message > (f->most ? f->most : VVI_MESSAGE_MOST))
        return fail(f, VVI_CLOSE_TOO_LARGE,
                    f->most ? "a first message is longer than 4 KiB" : "a message is longer than 1 MiB");
    return VVI_FRAMED_MORE;
}

static vvi_framed begin_frame(vvi_framing *f, size_t n_length)
{
    f->kind = f->head[0] & 15;
    f->final = f->head[0] & 0x80;
    f->at = 0;
    memcpy(f->mask, f->head + 2 + n_length, 4);
    if (is_control(f)) {
        f->n_control = 0;
        return check_length(f, n_length);
    }
    if (f->kind == VVI_FRAME_TEXT) {
        f->n_message = 0;
        f->pieces = 0;
    }
    f->in_message = true;
    if (++f->pieces > VVI_MESSAGE_PIECES)
        return fail(f, VVI_CLOSE_POLICY, "a message is in too many pieces");
    return check_length(f, n_length);
}

/* True where the head is whole; found: BAD, where it is refused. */
static bool take_head(vvi_framing *f, vvi_framed *found, const uint8_t **at, const uint8_t *end)
{
    while (*at < end) {
        f->head[f->n_head++] = *(*at)++;
        if (f->n_head == 2 && (*found = check_first(f)) != VVI_FRAMED_MORE)
            return false;
        if (f->n_head < 2 || f->n_head < 6 + length_bytes(f))
            continue;
        *found = begin_frame(f, length_bytes(f));
        return *found == VVI_FRAMED_MORE;
    }
    return false;
}

/* Bytes ---------------------------------------------------------------------------------------------------------- */

/* As it comes, and no more than it says that it has. */
static bool reserve(vvi_framing *f, size_t n)
{
    if (f->n_message + n + 1 <= f->room)
        return true;
    const size_t told = f->n_message + (size_t)(f->length - f->at) + 1;
    size_t room = f->room ? f->room : LEAST_ROOM;
    while (room < f->n_message + n + 1)
        room *= 2;
    room = room > LEAST_ROOM && room > told ? told : room;
    const size_t more = shared_part(room) - shared_part(f->room);
    if (f->shared && more > 0 && *f->shared + more > VVI_MESSAGES_SHARED)
        return false;
    char *grown = vvi_realloc_plain(f->message, room);
    if (!grown)
        return false;
    f->message = grown;
    f->room = room;
    if (f->shared)
        *f->shared += more;
    return true;
}

static bool take_bytes(vvi_framing *f, const uint8_t **at, const uint8_t *end)
{
    const uint64_t left = f->length - f->at;
    const size_t n = (uint64_t)(end - *at) < left ? (size_t)(end - *at) : (size_t)left;
    if (!is_control(f) && !reserve(f, n))
        return false;
    uint8_t *out = is_control(f) ? f->control + f->n_control : (uint8_t *)f->message + f->n_message;
    for (size_t i = 0; i < n; i++)
        out[i] = (uint8_t)((*at)[i] ^ f->mask[(f->at + i) & 3]);
    *(is_control(f) ? &f->n_control : &f->n_message) += n;
    f->at += n;
    *at += n;
    return true;
}

static bool is_utf8(const char *s, size_t n)
{
    for (size_t i = 0; i < n;) {
        const size_t length = s[i] ? vvi_utf8_length(s + i) : 1;
        if (length == 0)
            return false;
        i += length;
    }
    return true;
}

static bool is_code(int code)
{
    return (code >= 1000 && code <= 1003) || (code >= 1007 && code <= 1014) || (code >= 3000 && code < 5000);
}

static vvi_framed end_close(vvi_framing *f)
{
    char text[VVI_CONTROL_MOST + 1] = "";
    f->code = f->n_control >= 2 ? f->control[0] << 8 | f->control[1] : 0;
    if (f->n_control > 2)
        memcpy(text, f->control + 2, f->n_control - 2);
    if (f->n_control == 1 || (f->n_control >= 2 && !is_code(f->code)) ||
        (f->n_control > 2 && !is_utf8(text, f->n_control - 2)))
        return fail(f, VVI_CLOSE_PROTOCOL, "the farewell cannot be read");
    return VVI_FRAMED_CLOSE;
}

static vvi_framed end_frame(vvi_framing *f)
{
    f->n_head = 0;
    if (f->kind == VVI_FRAME_CLOSE)
        return end_close(f);
    if (is_control(f))
        return f->kind == VVI_FRAME_PING ? VVI_FRAMED_PING : VVI_FRAMED_PONG;
    if (!f->final)
        return VVI_FRAMED_MORE;
    f->in_message = false;
    f->message[f->n_message] = 0;
    return is_utf8(f->message, f->n_message) ? VVI_FRAMED_MESSAGE : fail(f, VVI_CLOSE_NO_TEXT, "a message is no UTF-8");
}

static bool has_head(const vvi_framing *f)
{
    return f->n_head >= 6 && f->n_head == 6 + length_bytes(f);
}

vvi_framed vvi_framing_take(vvi_framing *f, const uint8_t **at, const uint8_t *end)
{
    vvi_framed found = VVI_FRAMED_MORE;
    do {
        if (!has_head(f) && !take_head(f, &found, at, end))
            return found;
        if (!take_bytes(f, at, end))
            return fail(f, VVI_CLOSE_TRY_LATER, "too many long messages come at this time");
        if (f->at < f->length)
            return VVI_FRAMED_MORE;
        found = end_frame(f);
    } while (found == VVI_FRAMED_MORE && *at < end);
    return found;
}
