#include "io/meshes/mesh_write.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/meshes/mesh_builder.h"
#include "io/meshes/mesh_words.h"

#include <math.h>
#include <string.h>

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

void vvi_mesh_line_of(char out[64], const char name[64])
{
    size_t n = 0;
    for (; n < 63 && name[n]; n++)
        out[n] = (unsigned char)name[n] < ' ' || name[n] == 127 ? ' ' : name[n];
    out[n] = 0;
}

/* Text ------------------------------------------------------------------------------------------------------------ */

vv_status vvi_mesh_text_begin(vvi_mesh_text **out, vv_sink *sink, vv_job *job)
{
    vvi_mesh_text *t = vvi_alloc(job, sizeof *t, VVI_MEM_SCRATCH);
    *out = t;
    if (!t)
        return vv_fail_memory(sizeof *t);
    t->sink = sink;
    t->job = job;
    t->status = VV_OK;
    t->n = 0;
    t->in_line = false;
    return VV_OK;
}

static void flush(vvi_mesh_text *t)
{
    if (t->status == VV_OK)
        t->status = vvi_sink_write(t->sink, t->room, t->n);
    if (t->status == VV_OK)
        t->status = vvi_job_poll(t->job);
    t->n = 0;
}

static char *room_for(vvi_mesh_text *t, size_t n)
{
    if (t->n + n > sizeof t->room)
        flush(t);
    return t->room + t->n;
}

void vvi_mesh_text_add(vvi_mesh_text *t, const char *s)
{
    for (size_t n = strlen(s), some; n > 0; n -= some, s += some) {
        some = n < 1024 ? n : 1024;
        memcpy(room_for(t, some), s, some);
        t->n += some;
        t->in_line = s[some - 1] != '\n';
    }
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
    const vv_status st = t->status;
    vvi_free(t);
    return st;
}
