#include "core/text.h"
#include "core/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool grow(vvi_text *text, size_t more)
{
    if (text->bad)
        return false;
    if (text->s && more < text->room - text->n)
        return true;
    size_t room = text->room ? text->room : 64;
    while (room - text->n <= more && room <= SIZE_MAX / 2)
        room *= 2;
    char *s = room - text->n > more ? vvi_realloc_plain(text->s, room) : NULL;
    if (!s) {
        text->bad = true;
        return false;
    }
    text->s = s;
    text->room = room;
    return true;
}

void vvi_text_add_n(vvi_text *text, const char *s, size_t n)
{
    if (!grow(text, n))
        return;
    memcpy(text->s + text->n, s, n);
    text->n += n;
    text->s[text->n] = 0;
}

void vvi_text_add(vvi_text *text, const char *s)
{
    vvi_text_add_n(text, s, strlen(s));
}

void vvi_text_printf(vvi_text *text, const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    const int n = vsnprintf(NULL, 0, format, args);
    if (n < 0) {
        text->bad = true;
    } else if (grow(text, (size_t)n)) {
        vsnprintf(text->s + text->n, (size_t)n + 1, format, again);
        text->n += (size_t)n;
    }
    va_end(again);
    va_end(args);
}

size_t vvi_utf8_length(const char *s)
{
    const unsigned char *u = (const unsigned char *)s;
    if (u[0] < 0x80)
        return u[0] ? 1 : 0;
    const size_t n = u[0] < 0xc2 ? 0 : u[0] < 0xe0 ? 2 : u[0] < 0xf0 ? 3 : u[0] < 0xf5 ? 4 : 0;
    for (size_t i = 1; i < n; i++)
        if ((u[i] & 0xc0) != 0x80)
            return 0;
    const bool overlong = (u[0] == 0xe0 && u[1] < 0xa0) || (u[0] == 0xf0 && u[1] < 0x90);
    const bool surrogate = u[0] == 0xed && u[1] > 0x9f;
    const bool beyond = u[0] == 0xf4 && u[1] > 0x8f;
    return overlong || surrogate || beyond ? 0 : n;
}

static void add_json_byte(vvi_text *text, char c)
{
    static const char letters[] = "btnvfr"; /* 8 .. 13; 11 has no letter in JSON */
    if (c == '"' || c == '\\')
        vvi_text_printf(text, "\\%c", c);
    else if (c >= 8 && c <= 13 && c != 11)
        vvi_text_printf(text, "\\%c", letters[c - 8]);
    else if ((unsigned char)c < 0x20 || c == 0x7f)
        vvi_text_printf(text, "\\u%04x", (unsigned)c);
    else
        vvi_text_add_n(text, &c, 1);
}

/* A letter of n bytes of UTF-8, n at least 2; beyond 16 bits as a pair of surrogates. */
static void add_json_escape(vvi_text *text, const char *s, size_t n)
{
    uint32_t code = (uint8_t)s[0] & (0x7fu >> n);
    for (size_t i = 1; i < n; i++)
        code = code << 6 | ((uint8_t)s[i] & 63u);
    if (code >= 0x10000) {
        vvi_text_printf(text, "\\u%04x", 0xd800 + ((code - 0x10000) >> 10));
        code = 0xdc00 + ((code - 0x10000) & 0x3ff);
    }
    vvi_text_printf(text, "\\u%04x", code);
}

static void add_json(vvi_text *text, const char *s, bool ascii)
{
    vvi_text_add(text, "\"");
    while (*s) {
        const size_t n = vvi_utf8_length(s);
        if (n == 0)
            vvi_text_add(text,
                         ascii ? "\\ufffd" : "\xef\xbf\xbd"); /* U+FFFD: a file name may be any bytes, JSON may not */
        else if (n == 1)
            add_json_byte(text, *s);
        else if (ascii)
            add_json_escape(text, s, n);
        else
            vvi_text_add_n(text, s, n);
        s += n ? n : 1;
    }
    vvi_text_add(text, "\"");
}

void vvi_text_json(vvi_text *text, const char *s)
{
    add_json(text, s, false);
}

void vvi_text_json_ascii(vvi_text *text, const char *s)
{
    add_json(text, s, true);
}

/* U+EF80 to U+EFFF, "\xee\xbe\x80" to "\xee\xbf\xbf" */
static bool stands_for_byte(const char *s)
{
    const unsigned char *u = (const unsigned char *)s;
    return u[0] == 0xee && (u[1] == 0xbe || u[1] == 0xbf) && (u[2] & 0xc0) == 0x80;
}

void vvi_text_path(vvi_text *text, const char *path)
{
    for (size_t n; *path; path += n) {
        const unsigned char byte = (unsigned char)*path;
        n = vvi_utf8_length(path);
        if (n > 0 && !stands_for_byte(path)) {
            vvi_text_add_n(text, path, n);
            continue;
        }
        const char as_text[3] = {(char)0xee, (char)(byte < 0xc0 ? 0xbe : 0xbf), (char)(0x80 | (byte & 0x3f))};
        vvi_text_add_n(text, as_text, 3);
        n = 1;
    }
}

void vvi_text_json_path(vvi_text *text, const char *path)
{
    vvi_text plain = {0};
    vvi_text_path(&plain, path);
    text->bad = text->bad || plain.bad;
    vvi_text_json(text, plain.s && !plain.bad ? plain.s : "");
    vvi_text_free(&plain);
}

void vvi_path_of_text(char *s)
{
    char *to = s;
    for (; *s; to++)
        if (stands_for_byte(s)) {
            *to = (char)((s[1] == (char)0xbe ? 0x80 : 0xc0) | (s[2] & 0x3f));
            s += 3;
        } else {
            *to = *s++;
        }
    *to = 0;
}

char *vvi_text_take(vvi_text *text)
{
    vvi_text_add_n(text, "", 0);
    char *s = text->bad ? NULL : text->s;
    if (!s)
        free(text->s);
    *text = (vvi_text){0};
    return s;
}

void vvi_text_free(vvi_text *text)
{
    free(text->s);
    *text = (vvi_text){0};
}

/* What a terminal obeys instead of showing it: control characters of one byte and of two (C1), ends of lines, and marks
 * that turn the direction of writing, so that a name reads as another one. n: bytes of the character. */
static bool is_obeyed(const char *s, size_t n)
{
    const unsigned char *c = (const unsigned char *)s;
    if (n == 1)
        return c[0] < 0x20 || c[0] == 0x7f;
    if (n == 2)
        return (c[0] == 0xc2 && c[1] < 0xa0) || (c[0] == 0xd8 && c[1] == 0x9c);
    if (n != 3 || c[0] != 0xe2)
        return false;
    return (c[1] == 0x80 && ((c[2] >= 0xa8 && c[2] <= 0xae) || c[2] == 0x8e || c[2] == 0x8f)) ||
           (c[1] == 0x81 && c[2] >= 0xa6 && c[2] <= 0xa9);
}

void vvi_text_clean(char *s)
{
    while (*s) {
        const size_t n = vvi_utf8_length(s);
        if (n == 0 || is_obeyed(s, n))
            memset(s, '?', n ? n : 1);
        s += n ? n : 1;
    }
}

void vvi_text_add_clean(vvi_text *text, const char *s)
{
    const size_t n = text->n;
    vvi_text_add(text, s);
    if (!text->bad && text->n > n)
        vvi_text_clean(text->s + n);
}

void vvi_text_cut(vvi_text *text, size_t n)
{
    if (n < text->n) {
        text->n = n;
        text->s[n] = 0;
    }
}

size_t vvi_json_nesting(const char *text, size_t n)
{
    size_t depth = 0, deepest = 0;
    bool quoted = false;
    for (size_t i = 0; i < n; i++) {
        const char c = text[i];
        if (quoted) {
            i += c == '\\';
            quoted = c != '"';
        } else if (c == '"') {
            quoted = true;
        } else if (c == '{' || c == '[') {
            depth++;
            deepest = depth > deepest ? depth : deepest;
        } else if ((c == '}' || c == ']') && depth) {
            depth--;
        }
    }
    return deepest;
}

size_t vvi_text_place(const char *text, int *width_out)
{
    size_t n = 1;
    int width = 0;
    if (text[0] != '%')
        return 0;
    while (text[n] >= '0' && text[n] <= '9' && n < 4)
        width = width * 10 + (text[n++] - '0');
    *width_out = width;
    return text[n] == 'd' ? n + 1 : 0;
}

/* By measure of jansson on 64 bits: an empty object, an empty list, an element of a list, an entry of an object, a text
 * beyond that. */
uint64_t vvi_json_tree_bytes(const char *text, size_t n)
{
    enum { OBJECT = 232, LIST = 136, ELEMENT = 48, ENTRY = 64, TEXT = 32 };
    uint64_t bytes = 0;
    bool quoted = false;
    for (size_t i = 0; i < n; i++) {
        const char c = text[i];
        if (quoted) {
            i += c == '\\';
            quoted = c != '"';
            continue;
        }
        quoted = c == '"';
        bytes += c == '{' ? OBJECT : c == '[' ? LIST : c == ',' ? ELEMENT : c == ':' ? ENTRY : quoted ? TEXT : 0;
    }
    return bytes;
}
