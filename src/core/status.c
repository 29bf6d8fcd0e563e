#define VVI_MAKES_FAILURES /* here they are functions, for the analyzer too */
#include "core/status.h"
#include "core/memory.h"
#include "core/text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MESSAGE_ROOM = 4096, FILE_ROOM = 4096, WHERE_ROOM = 512 };

/* Fixed room: making an error never needs memory, so it cannot fail, and nothing is left to free when a thread ends. */
typedef struct thread_error {
    vv_error shown;
    char message[MESSAGE_ROOM], file[FILE_ROOM], where[WHERE_ROOM];
} thread_error;

static _Thread_local thread_error last;

const vv_error *vv_error_last(void)
{
    last.shown.message = last.message;
    return &last.shown;
}

const char *vv_status_name(vv_status status)
{
    static const char *const names[] = {"ok",    "argument",    "memory",    "limit",     "read",    "format",
                                        "write", "unsupported", "cancelled", "not_found", "internal"};
    const int n = (int)(sizeof names / sizeof *names), code = (int)status;
    return code <= 0 && code > -n ? names[-code] : "unknown";
}

/* Ends a text that was too long with "...", never inside a UTF-8 character. */
static void mark_cut(char *s, size_t room)
{
    size_t n = room - 4;
    while (n > 0 && ((unsigned char)s[n] & 0xc0) == 0x80)
        n--;
    memcpy(s + n, "...", 4);
}

static void format_text(char *out, size_t room, const char *format, va_list args)
{
    const int n = vsnprintf(out, room, format, args);
    if (n < 0)
        snprintf(out, room, "the text of this error could not be made");
    else if ((size_t)n >= room)
        mark_cut(out, room);
}

static void copy_text(char *out, size_t room, const char *s)
{
    const size_t n = strlen(s);
    memmove(out, s, n < room ? n + 1 : room - 1);
    if (n >= room)
        mark_cut(out, room);
}

/* The arguments may be the thread's own last strings. */
static void set_place(const char *file, const char *where)
{
    if (file)
        copy_text(last.file, sizeof last.file, file);
    if (where)
        copy_text(last.where, sizeof last.where, where);
    last.shown.file = file ? last.file : NULL;
    last.shown.where = where ? last.where : NULL;
}

static void set_message(vv_status status, const char *text)
{
    copy_text(last.message, sizeof last.message, text);
    vvi_text_clean(last.message);
    last.shown.status = status;
    last.shown.message = last.message;
}

/* "prefix: text". When both do not fit, the prefix gives way: the reason stands last. */
static void set_prefixed(vv_status status, const char *prefix, const char *text)
{
    char short_prefix[MESSAGE_ROOM / 2], joined[2 * MESSAGE_ROOM];
    if (strlen(prefix) + 2 + strlen(text) >= MESSAGE_ROOM) {
        copy_text(short_prefix, sizeof short_prefix, prefix);
        prefix = short_prefix;
    }
    snprintf(joined, sizeof joined, "%s: %s", prefix, text);
    set_message(status, joined);
}

vv_status vv_fail(vv_status status, const char *format, ...)
{
    char text[MESSAGE_ROOM];
    va_list args;
    va_start(args, format);
    format_text(text, sizeof text, format, args);
    va_end(args);
    set_place(NULL, NULL);
    set_message(status, text);
    return status;
}

vv_status vv_fail_at(vv_status status, const char *file, const char *where, const char *format, ...)
{
    char text[MESSAGE_ROOM], place[FILE_ROOM + WHERE_ROOM];
    va_list args;
    va_start(args, format);
    format_text(text, sizeof text, format, args);
    va_end(args);
    set_place(file, where);
    if (!file && !where) {
        set_message(status, text);
        return status;
    }
    snprintf(place, sizeof place, "%s%s%s", file ? last.file : "", file && where ? ":" : "", where ? last.where : "");
    set_prefixed(status, place, text);
    return status;
}

vv_status vv_fail_in(vv_status status, const char *format, ...)
{
    char prefix[MESSAGE_ROOM], text[MESSAGE_ROOM];
    va_list args;
    va_start(args, format);
    format_text(prefix, sizeof prefix, format, args);
    va_end(args);
    copy_text(text, sizeof text, last.message);
    set_prefixed(status, prefix, text);
    return status;
}

void vvi_error_take(vvi_error_copy *out)
{
    const vv_error *e = vv_error_last();
    *out = (vvi_error_copy){
        .status = e->status,
        .message = vvi_strdup(e->message),
        .file = e->file ? vvi_strdup(e->file) : NULL,
        .where = e->where ? vvi_strdup(e->where) : NULL,
    };
}

vv_status vvi_error_put(vvi_error_copy *copy)
{
    const vv_status status = copy->status;
    set_place(copy->file, copy->where);
    set_message(status, copy->message ? copy->message : "there was no memory left to say what failed");
    vvi_error_copy_free(copy);
    return status;
}

void vvi_error_copy_free(vvi_error_copy *copy)
{
    free(copy->message);
    free(copy->file);
    free(copy->where);
    *copy = (vvi_error_copy){0};
}

void vvi_check_failed(const char *condition, const char *file, int line)
{
    fprintf(stderr, "%s:%d: a broken promise inside volvis: %s\n", file, line, condition);
    abort();
}
