#include "io/meshes/mesh_write.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/meshes/mesh_builder.h"
#include "io/meshes/mesh_words.h"

#include <math.h>
#include <string.h>

enum { ROOM_BYTES = 1 << 16, SLAB_ROWS = 2048, SLABS = 16 };

void vvi_mesh_place(double out[3], const vv_mesh_info *m, size_t vertex)
{
    for (size_t a = 0; a < 3; a++)
        out[a] = (&m->origin.x)[a] + (double)m->positions[3 * vertex + a];
}

bool vvi_mesh_needs_doubles(const vv_mesh *mesh)
{
    const vv_bounds box = vv_mesh_bounds(mesh);
    return vvi_mesh_is_far(&box);
}

const vv_mesh_part *vvi_mesh_part_at(const vv_mesh_info *m, size_t triangle, size_t *at)
{
    while (*at < m->n_parts && triangle >= m->parts[*at].first_triangle + m->parts[*at].n_triangles)
        ++*at;
    return *at < m->n_parts ? &m->parts[*at] : NULL;
}

bool vvi_mesh_has_part_colors(const vv_mesh_info *m)
{
    for (size_t i = 0; i < m->n_parts; i++)
        if (m->parts[i].color.a >= 0)
            return true;
    return false;
}

void vvi_mesh_line_of(char out[64], const char *name)
{
    size_t n = 0;
    for (; n < 63 && name[n]; n++)
        out[n] = (unsigned char)name[n] < ' ' || name[n] == 127 ? ' ' : name[n];
    out[n] = 0;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

vv_status vvi_mesh_text_begin(vvi_mesh_text *t, vv_sink *sink, vv_job *job)
{
    *t = (vvi_mesh_text){.sink = sink, .job = job, .room_bytes = ROOM_BYTES};
    t->room = vvi_alloc(job, t->room_bytes, VVI_MEM_SCRATCH);
    return t->status = t->room ? VV_OK : vv_fail_memory(t->room_bytes);
}

static void flush(vvi_mesh_text *t)
{
    if (t->status == VV_OK)
        t->status = vvi_sink_write(t->sink, t->room, t->n);
    if (t->status == VV_OK)
        t->status = vvi_job_poll(t->job);
    t->n = 0;
}

static void grow(vvi_mesh_text *t)
{
    char *more = t->status == VV_OK ? vvi_realloc(t->job, t->room, 2 * t->room_bytes, VVI_MEM_SCRATCH) : NULL;
    if (more) {
        t->room = more;
        t->room_bytes *= 2;
        return;
    }
    if (t->status == VV_OK)
        t->status = vv_fail_memory(2 * t->room_bytes);
    t->n = 0;
}

/* n: far less than the room. */
static char *room_for(vvi_mesh_text *t, size_t n)
{
    if (t->n + n > t->room_bytes) {
        if (t->sink)
            flush(t);
        else
            grow(t);
    }
    return t->room + t->n;
}

void vvi_mesh_text_bytes(vvi_mesh_text *t, const void *bytes, size_t n)
{
    const char *s = bytes;
    for (size_t some; n > 0; n -= some, s += some) {
        some = n < 1024 ? n : 1024;
        memcpy(room_for(t, some), s, some);
        t->n += some;
        t->in_line = s[some - 1] != '\n';
    }
}

void vvi_mesh_text_add(vvi_mesh_text *t, const char *s)
{
    vvi_mesh_text_bytes(t, s, strlen(s));
}

/* Slabs of rows: some at a time, each in a room of its own, while those before them are written. */
typedef struct slabs {
    vvi_mesh_rows *rows;
    const void *user;
    size_t n, first; /* rows; the first slab of this round */
    vvi_mesh_text text[2][SLABS];
    vvi_mesh_text *now, *before; /* n_before: that are to be written */
    size_t n_before;
    vvi_mesh_text *out;
} slabs;

static vv_status write_slabs(slabs *s)
{
    vvi_mesh_text *out = s->out;
    if (out->status == VV_OK && out->n > 0)
        flush(out);
    for (size_t i = 0; i < s->n_before && out->status == VV_OK; i++) {
        out->status = vvi_sink_write(out->sink, s->before[i].room, s->before[i].n);
        s->before[i].n = 0;
    }
    return out->status;
}

static vv_status slab_item(void *scratch, void *user, size_t index)
{
    slabs *s = user;
    (void)scratch;
    if (index == 0)
        return write_slabs(s);
    vvi_mesh_text *t = &s->now[index - 1];
    const size_t first = (s->first + index - 1) * SLAB_ROWS, end = first + SLAB_ROWS;
    s->rows(t, s->user, first, end < s->n ? end : s->n);
    return t->status;
}

static vv_status run_slabs(slabs *s)
{
    static const vvi_work work = {.item = slab_item};
    const size_t n_slabs = (s->n + SLAB_ROWS - 1) / SLAB_ROWS;
    vv_job *job = s->out->job;
    vv_status st = VV_OK;
    for (int i = 0; i < 2 * SLABS && st == VV_OK; i++)
        st = vvi_mesh_text_begin(&s->text[i / SLABS][i % SLABS], NULL, job);
    for (int round = 0; st == VV_OK && (s->first < n_slabs || s->n_before); round ^= 1) {
        const size_t left = n_slabs - s->first, n = left < SLABS ? left : SLABS;
        s->now = s->text[round];
        s->before = s->text[round ^ 1];
        st = vvi_parallel_for(job, &work, s, n + 1);
        s->n_before = n;
        s->first += n;
        if (st == VV_OK)
            st = vvi_job_progress(job, "write", s->first, n_slabs);
    }
    for (int i = 0; i < 2 * SLABS; i++)
        vvi_free(s->text[i / SLABS][i % SLABS].room);
    return st;
}

void vvi_mesh_text_rows(vvi_mesh_text *t, vvi_mesh_rows *rows, const void *user, size_t n)
{
    slabs s = {.rows = rows, .user = user, .n = n, .out = t};
    if (n <= SLAB_ROWS || !t->sink) {
        rows(t, user, 0, n);
        return;
    }
    const vv_status st = t->status == VV_OK ? run_slabs(&s) : t->status;
    t->status = t->status == VV_OK ? st : t->status;
    t->in_line = false;
}

/* Where a word of at most 32 letters begins. */
static char *begin_word(vvi_mesh_text *t)
{
    char *at = room_for(t, 40);
    *at = ' ';
    at += t->in_line;
    t->n += t->in_line;
    t->in_line = true;
    return at;
}

void vvi_mesh_text_float(vvi_mesh_text *t, float value)
{
    t->n += vvi_print_float(begin_word(t), value);
}

void vvi_mesh_text_double(vvi_mesh_text *t, double value)
{
    char *at = begin_word(t);
    vvi_print_unsigned_zero(at, value);
    t->n += strlen(at);
}

void vvi_mesh_text_uint(vvi_mesh_text *t, uint64_t value)
{
    t->n += vvi_print_uint(begin_word(t), value);
}

void vvi_mesh_text_place(vvi_mesh_text *t, const vv_mesh_info *m, size_t vertex, bool doubles)
{
    double p[3];
    vvi_mesh_place(p, m, vertex);
    for (int a = 0; a < 3; a++) {
        if (doubles)
            vvi_mesh_text_double(t, p[a]);
        else
            vvi_mesh_text_float(t, (float)p[a]);
    }
}

vv_status vvi_mesh_text_end(vvi_mesh_text *t)
{
    flush(t);
    vvi_free(t->room);
    t->room = NULL;
    return t->status;
}
