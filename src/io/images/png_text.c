/* The text of a PNG alone: its chunks are walked and those with pixels passed over unread. */
#include "io/images/png.h"

#include "core/job.h"
#include "core/memory.h"
#include "io/images/image_text.h"
#include "io/source.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#define TEXTS_MOST 1000

typedef struct walk {
    vv_source *source;
    vv_job *job;
    vv_text *text;
    size_t n_text;
    size_t held; /* bytes of all texts */
} walk;

static vv_status bad(const walk *w, const char *what)
{
    char where[48];
    snprintf(where, sizeof where, "byte %llu", (unsigned long long)vvi_source_tell(w->source));
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(w->source), where, "the PNG is damaged: %s", what);
}

static vv_status add(walk *w, const char *key, size_t n_key, const char *value, size_t n_value)
{
    if (w->n_text >= TEXTS_MOST || n_value > VVI_PNG_TEXT_MOST - w->held)
        return VV_OK; /* as libpng: what goes beyond the limit is left out */
    w->held += n_value;
    vv_text *more = realloc(w->text, (w->n_text + 1) * sizeof *more);
    if (!more)
        return vv_fail_memory((w->n_text + 1) * sizeof *more);
    w->text = more;
    vv_text *t = &w->text[w->n_text];
    *t = (vv_text){vvi_text_utf8(key, n_key), vvi_text_utf8(value, n_value)};
    w->n_text++;
    return t->key && t->value ? VV_OK : vv_fail_memory(n_value);
}

/* The buffer grows with what has arrived, so that a lying length costs nothing. */
static vv_status inflate_all(char **out, size_t *n_out, const walk *w, const char *in, size_t n)
{
    z_stream z = {.next_in = (Bytef *)(uintptr_t)in, .avail_in = (uInt)n};
    size_t room = 4 * n + 1024;
    char *data = NULL;
    int code = inflateInit(&z) == Z_OK ? Z_OK : Z_MEM_ERROR;
    *out = NULL;
    while (code == Z_OK && z.total_out <= VVI_PNG_TEXT_MOST) {
        char *more = realloc(data, room);
        if (!more) {
            code = Z_MEM_ERROR;
            break;
        }
        data = more;
        z.next_out = (Bytef *)data + z.total_out;
        z.avail_out = (uInt)(room - z.total_out);
        code = inflate(&z, Z_NO_FLUSH);
        if (code == Z_OK && z.avail_out > 0)
            code = Z_DATA_ERROR; /* all input is gone and the end has not come */
        room *= 2;
    }
    *n_out = z.total_out;
    inflateEnd(&z);
    if (code == Z_STREAM_END) {
        *out = data;
        return VV_OK;
    }
    free(data);
    return code == Z_MEM_ERROR ? vv_fail_memory(room) : bad(w, "a compressed text cannot be read");
}

static vv_status add_coded(walk *w, const char *key, size_t n_key, const char *coded, size_t n)
{
    char *value;
    size_t n_value;
    vv_status st = inflate_all(&value, &n_value, w, coded, n);
    if (st == VV_OK)
        st = add(w, key, n_key, value, n_value);
    free(value);
    return st;
}

/* Where the string at `at` ends, n when it does not. */
static size_t end_of(const char *data, size_t at, size_t n)
{
    return at < n ? at + strnlen(data + at, n - at) : n;
}

/* key 0 text | key 0 method coded | key 0 is-coded method language 0 translated-key 0 text */
static vv_status take_chunk(walk *w, const char type[4], const char *data, size_t n)
{
    const size_t key = end_of(data, 0, n);
    if (key == n)
        return bad(w, "a text has no key");
    if (type[0] == 't')
        return add(w, data, key, data + key + 1, n - key - 1);
    if (type[0] == 'z')
        return n - key >= 2 ? add_coded(w, data, key, data + key + 2, n - key - 2) : bad(w, "a text is too short");
    const size_t language = end_of(data, key + 3, n), translated = end_of(data, language + 1, n);
    if (translated == n)
        return bad(w, "a text is too short");
    const char *value = data + translated + 1;
    const size_t n_value = n - translated - 1;
    return data[key + 1] ? add_coded(w, data, key, value, n_value) : add(w, data, key, value, n_value);
}

static uint32_t big_endian(const uint8_t b[4])
{
    return (uint32_t)b[0] << 24 | (uint32_t)b[1] << 16 | (uint32_t)b[2] << 8 | b[3];
}

static bool is_text(const uint8_t type[4])
{
    return memcmp(type, "tEXt", 4) == 0 || memcmp(type, "zTXt", 4) == 0 || memcmp(type, "iTXt", 4) == 0;
}

static vv_status read_chunk(walk *w, const uint8_t type[4], size_t n)
{
    bool exact;
    if (n > VVI_PNG_TEXT_MOST)
        return vvi_source_skip(w->source, (uint64_t)n + 4);
    if (vvi_source_left(w->source, &exact) < (uint64_t)n + 4)
        return bad(w, "the file ends within a text");
    char *data = malloc(n + 4);
    if (!data)
        return vv_fail_memory(n + 4);
    vv_status st = vvi_source_read(w->source, data, n + 4, "a PNG text");
    uint8_t crc[4];
    if (st == VV_OK) {
        memcpy(crc, data + n, 4);
        const uLong sum = crc32_z(crc32_z(0, type, 4), (const Bytef *)data, n);
        st = sum == big_endian(crc) ? take_chunk(w, (const char *)type, data, n) : bad(w, "the checksum of a text");
    }
    free(data);
    return st;
}

static vv_status walk_chunks(walk *w)
{
    uint8_t head[8];
    vv_status st = vvi_source_read(w->source, head, 8, "the PNG signature");
    while (st == VV_OK && (st = vvi_source_read(w->source, head, 8, "a PNG chunk")) == VV_OK) {
        const uint32_t n = big_endian(head);
        if (n > INT32_MAX)
            return bad(w, "a chunk is longer than PNG allows");
        if (memcmp(head + 4, "IEND", 4) == 0)
            return VV_OK;
        st = is_text(head + 4) ? read_chunk(w, head + 4, n) : vvi_source_skip(w->source, (uint64_t)n + 4);
        if (st == VV_OK)
            st = vvi_job_poll(w->job);
    }
    return st;
}

vv_status vvi_png_read_text(vv_text **text_out, size_t *n_text_out, vv_source *source, vv_job *job)
{
    walk w = {.source = source, .job = job};
    *text_out = NULL;
    *n_text_out = 0;
    const vv_status st = walk_chunks(&w);
    if (st != VV_OK) {
        vv_text_free(w.text, w.n_text);
        return st;
    }
    *text_out = w.text;
    *n_text_out = w.n_text;
    return VV_OK;
}
