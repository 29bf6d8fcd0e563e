#include "surface/clip.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/mesh.h"
#include "surface/fill.h"
#include "surface/vertex_places.h"

#include <string.h>

#define NONE UINT32_MAX
#define MIX 0x9e3779b97f4a7c15u

/* A vertex where an edge goes through the plane. */
typedef struct crossing {
    uint32_t kept, gone; /* the ends of the edge */
    uint32_t next;       /* the crossing that follows it on a cap, NONE: none */
} crossing;

typedef struct clipper {
    const vv_mesh_info *m;
    size_t n_parts; /* of the mesh; 0: all of it is one */
    vv_plane plane;
    bool cap, only_cap;
    const uint32_t *place; /* the vertex that stands for each; NULL: itself */
    crossing *crossings;
    size_t n_crossings, first_of_part;
    uint32_t *slots; /* crossings by their edge: 1 + number, 0: free; n_slots is a power of 2 */
    size_t n_slots;
    uint32_t *triangles; /* vertices of the mesh, and after them crossings */
    size_t n_triangles, room, n_cut;
    vv_mesh_part *parts;
    size_t n_capped, n_gaps; /* chains that do not close */
    vv_job *job;
} clipper;

static double distance(const clipper *c, uint32_t v)
{
    const float *p = c->m->positions + 3 * (size_t)v;
    const vv_vec3 o = c->m->origin;
    return vvi_dot(c->plane.normal, vvi_vec(o.x + (double)p[0], o.y + (double)p[1], o.z + (double)p[2])) -
           c->plane.offset;
}

static bool is_kept(const clipper *c, uint32_t v)
{
    return !(distance(c, v) < 0);
}

/* Triangles ------------------------------------------------------------------------------------------------------- */

static vv_status add_triangle(clipper *c, uint32_t u, uint32_t v, uint32_t w)
{
    if (c->n_triangles == c->room) {
        const size_t room = c->room + c->room / 2 + 1024;
        uint32_t *more = vvi_realloc(c->job, c->triangles, 3 * room * sizeof *more, VVI_MEM_SCRATCH);
        if (!more)
            return vv_fail_memory(3 * room * sizeof *more);
        c->triangles = more;
        c->room = room;
    }
    uint32_t *t = c->triangles + 3 * c->n_triangles++;
    t[0] = u;
    t[1] = v;
    t[2] = w;
    return VV_OK;
}

/* The crossing of an edge, a new one where it has none yet: there is room for two a triangle that is cut. */
static uint32_t cross(clipper *c, uint32_t kept, uint32_t gone)
{
    size_t slot = (((uint64_t)kept << 32 | gone) * MIX) >> 20 & (c->n_slots - 1);
    for (; c->slots[slot]; slot = (slot + 1) & (c->n_slots - 1)) {
        const crossing *at = &c->crossings[c->slots[slot] - 1];
        if (at->kept == kept && at->gone == gone)
            return c->slots[slot] - 1;
    }
    c->crossings[c->n_crossings] = (crossing){kept, gone, NONE};
    c->slots[slot] = (uint32_t)++c->n_crossings;
    return c->slots[slot] - 1;
}

/* t[0] is alone on its side. */
static vv_status cut(clipper *c, const uint32_t t[3], bool kept)
{
    const uint32_t n = (uint32_t)c->m->n_vertices;
    const uint32_t a = kept ? cross(c, t[0], t[1]) : cross(c, t[1], t[0]);
    const uint32_t b = kept ? cross(c, t[0], t[2]) : cross(c, t[2], t[0]);
    crossing *from = &c->crossings[kept ? b : a]; /* a cap runs against the triangle */
    c->n_gaps += from->next != NONE;
    from->next = kept ? a : b;
    if (c->only_cap)
        return VV_OK;
    if (kept)
        return add_triangle(c, t[0], n + a, n + b);
    const vv_status st = add_triangle(c, n + a, t[1], t[2]);
    return st == VV_OK ? add_triangle(c, n + a, t[2], n + b) : st;
}

static uint32_t vertex_at(const clipper *c, uint32_t v)
{
    return c->place ? c->place[v] : v;
}

static vv_status take_triangle(clipper *c, const uint32_t *corner)
{
    const uint32_t t[3] = {vertex_at(c, corner[0]), vertex_at(c, corner[1]), vertex_at(c, corner[2])};
    const bool kept[3] = {is_kept(c, t[0]), is_kept(c, t[1]), is_kept(c, t[2])};
    const int n = kept[0] + kept[1] + kept[2];
    if (n == 3 && !c->only_cap)
        return add_triangle(c, t[0], t[1], t[2]);
    if (n == 0 || n == 3)
        return VV_OK;
    for (int i = 0; i < 3; i++)
        if (kept[i] == (n == 1))
            return cut(c, (const uint32_t[3]){t[i], t[(i + 1) % 3], t[(i + 2) % 3]}, n == 1);
    return VV_OK;
}

/* Caps ------------------------------------------------------------------------------------------------------------ */

static void put_place(float out[3], const clipper *c, const crossing *at)
{
    const double in = distance(c, at->kept), beyond = distance(c, at->gone), t = in / (in - beyond);
    const float *p = c->m->positions + 3 * (size_t)at->kept, *q = c->m->positions + 3 * (size_t)at->gone;
    for (int a = 0; a < 3; a++)
        out[a] = (float)((double)p[a] + t * ((double)q[a] - (double)p[a]));
}

/* Axes of the plane; seen from where the cap faces, u, v turn counter-clockwise. */
static void axes_of(vv_vec3 *u, vv_vec3 *v, vv_vec3 normal)
{
    const vv_vec3 n = vvi_scaled(normal, -1);
    const double x = fabs(n.x), y = fabs(n.y), z = fabs(n.z);
    const vv_vec3 least = x <= y && x <= z ? vvi_vec(1, 0, 0) : y <= z ? vvi_vec(0, 1, 0) : vvi_vec(0, 0, 1);
    *u = vvi_cross(least, n);
    vvi_unit(u);
    *v = vvi_cross(n, *u);
}

/* From a crossing on, as far as it goes; how many. The last one leads to *end. */
static size_t follow_chain(uint32_t *points, uint32_t *end, clipper *c, size_t from)
{
    size_t n = 0;
    uint32_t at = (uint32_t)from;
    while (c->crossings[at].next != NONE) {
        const uint32_t next = c->crossings[at].next;
        c->crossings[at].next = NONE;
        points[n++] = at;
        at = next;
    }
    *end = at;
    return n;
}

/* Loops of the part's crossings; chains that do not close are left out. `points`: room for all; begin: n + 1; led: n,
 * zeroed. */
static size_t follow(clipper *c, uint32_t *points, size_t *begin, uint8_t *led)
{
    size_t n = 0, n_loops = 0;
    uint32_t end;
    for (size_t i = c->first_of_part; i < c->n_crossings; i++)
        if (c->crossings[i].next != NONE)
            led[c->crossings[i].next] = 1;
    for (size_t i = c->first_of_part; i < c->n_crossings; i++)
        c->n_gaps += !led[i] && follow_chain(points, &end, c, i) > 0;
    for (size_t i = c->first_of_part; i < c->n_crossings; i++) {
        const size_t more = follow_chain(points + n, &end, c, i);
        c->n_gaps += more > 0 && end != i; /* two ways lead there */
        if (more < 3 || end != i)          /* two sides there and back: nothing is open */
            continue;
        begin[n_loops++] = n;
        n += more;
    }
    begin[n_loops] = n;
    return n_loops;
}

/* The surface of a mesh that is inside out has its loops the wrong way round. */
static void turn_loops(uint32_t *points, const vvi_loops *loops)
{
    double area = 0;
    for (size_t i = 0; i < loops->n; i++)
        for (size_t k = loops->begin[i], last = loops->begin[i + 1] - 1; k < loops->begin[i + 1]; last = k++) {
            const double *p = loops->at + 2 * (size_t)points[last], *q = loops->at + 2 * (size_t)points[k];
            area += p[0] * q[1] - p[1] * q[0];
        }
    for (size_t i = 0; i < loops->n && area < 0; i++)
        for (size_t k = loops->begin[i], end = loops->begin[i + 1]; k + 1 < end; k++) {
            const uint32_t other = points[--end];
            points[end] = points[k];
            points[k] = other;
        }
}

static vv_status fill(clipper *c, const vvi_loops *loops)
{
    uint32_t *triangles;
    size_t n;
    const uint32_t first = (uint32_t)c->m->n_vertices;
    vv_status st = vvi_fill_loops(&triangles, &n, loops, c->job);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = add_triangle(c, first + triangles[3 * i], first + triangles[3 * i + 1], first + triangles[3 * i + 2]);
    c->n_capped += n;
    vvi_free(triangles);
    return st;
}

static vv_status cap_part(clipper *c)
{
    const size_t n = c->n_crossings;
    vv_vec3 u, v;
    double *at = vvi_alloc(c->job, (2 * n + 1) * sizeof *at, VVI_MEM_SCRATCH);
    uint32_t *points = vvi_alloc(c->job, (n + 1) * sizeof *points, VVI_MEM_SCRATCH);
    size_t *begin = vvi_alloc(c->job, (n + 1) * sizeof *begin, VVI_MEM_SCRATCH);
    uint8_t *led = vvi_alloc_zeroed(c->job, n + 1, VVI_MEM_SCRATCH);
    vv_status st = at && points && begin && led ? VV_OK : vv_fail_memory((2 * n + 1) * sizeof *at);
    axes_of(&u, &v, c->plane.normal);
    for (size_t i = c->first_of_part; i < n && st == VV_OK; i++) {
        float p[3];
        put_place(p, c, &c->crossings[i]);
        at[2 * i] = vvi_dot(u, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
        at[2 * i + 1] = vvi_dot(v, vvi_vec((double)p[0], (double)p[1], (double)p[2]));
    }
    if (st == VV_OK) {
        const vvi_loops loops = {.at = at, .points = points, .begin = begin, .n = follow(c, points, begin, led)};
        if (c->only_cap)
            turn_loops(points, &loops);
        st = fill(c, &loops);
    }
    vvi_free(at);
    vvi_free(points);
    vvi_free(begin);
    vvi_free(led);
    return st;
}

/* All of it ------------------------------------------------------------------------------------------------------- */

static vv_status count(clipper *c)
{
    const vv_mesh_info *m = c->m;
    size_t n_gone = 0;
    for (size_t t = 0; t < m->n_triangles; t++) {
        const uint32_t *v = m->triangles + 3 * t;
        const int n = is_kept(c, v[0]) + is_kept(c, v[1]) + is_kept(c, v[2]);
        c->n_cut += n == 1 || n == 2;
        n_gone += n == 0;
        if (t % 65536 == 0 && vvi_job_poll(c->job) != VV_OK)
            return vv_error_last()->status;
    }
    c->room = c->only_cap ? c->n_cut : m->n_triangles - n_gone + c->n_cut;
    if ((n_gone == 0 || c->only_cap) && c->n_cut == 0)
        return VV_OK;
    if (m->n_vertices + 2 * c->n_cut >= NONE)
        return vv_fail(VV_E_LIMIT, "a mesh of %zu vertices is too large to be cut; 2^32 are possible", m->n_vertices);
    for (c->n_slots = 16; c->n_slots < 4 * c->n_cut; c->n_slots *= 2)
        ;
    const size_t bytes = c->n_slots * sizeof *c->slots;
    c->slots = vvi_alloc_zeroed(c->job, bytes, VVI_MEM_SCRATCH);
    c->crossings = vvi_alloc(c->job, (2 * c->n_cut + 1) * sizeof *c->crossings, VVI_MEM_SCRATCH);
    c->triangles = vvi_alloc(c->job, (3 * c->room + 1) * sizeof *c->triangles, VVI_MEM_SCRATCH);
    c->parts = vvi_alloc(c->job, (m->n_parts + 1) * sizeof *c->parts, VVI_MEM_SCRATCH);
    return c->slots && c->crossings && c->triangles && c->parts ? VV_OK : vv_fail_memory(bytes);
}

static vv_status cut_part(clipper *c, size_t first, size_t n)
{
    vv_status st = VV_OK;
    for (size_t t = first; t < first + n && st == VV_OK; t++) {
        st = take_triangle(c, c->m->triangles + 3 * t);
        if (st == VV_OK && t % 65536 == 0)
            st = vvi_job_poll(c->job);
    }
    if (st == VV_OK && c->cap && c->n_crossings > c->first_of_part)
        st = cap_part(c);
    c->first_of_part = c->n_crossings;
    return st;
}

static vv_status cut_all(clipper *c)
{
    const vv_mesh_info *m = c->m;
    vv_status st = VV_OK;
    for (size_t i = 0; i < c->n_parts && st == VV_OK; i++) {
        const size_t first = c->n_triangles;
        st = cut_part(c, m->parts[i].first_triangle, m->parts[i].n_triangles);
        c->parts[i] = m->parts[i];
        c->parts[i].first_triangle = first;
        c->parts[i].n_triangles = c->n_triangles - first;
    }
    return c->n_parts == 0 ? cut_part(c, 0, m->n_triangles) : st;
}

static void put_crossing(const vvi_mesh_arrays *to, size_t v, const clipper *c, const crossing *at)
{
    const vv_mesh_info *m = c->m;
    const double in = distance(c, at->kept), beyond = distance(c, at->gone), t = in / (in - beyond);
    const size_t p = at->kept, q = at->gone;
    put_place(to->positions + 3 * v, c, at);
    if (to->normals) {
        vv_vec3 n = vvi_vec((1 - t) * (double)m->normals[3 * p] + t * (double)m->normals[3 * q],
                            (1 - t) * (double)m->normals[3 * p + 1] + t * (double)m->normals[3 * q + 1],
                            (1 - t) * (double)m->normals[3 * p + 2] + t * (double)m->normals[3 * q + 2]);
        if (!vvi_unit(&n))
            n = vvi_vec(0, 0, 0);
        const float unit[3] = {(float)n.x, (float)n.y, (float)n.z};
        memcpy(to->normals + 3 * v, unit, sizeof unit);
    }
    if (to->values)
        to->values[v] = (float)((1 - t) * (double)m->values[p] + t * (double)m->values[q]);
    for (size_t k = 0; k < 4 && to->colors; k++)
        to->colors[4 * v + k] = (uint8_t)((1 - t) * m->colors[4 * p + k] + t * m->colors[4 * q + k] + 0.5);
}

static void copy_vertex(const vvi_mesh_arrays *to, size_t v, const vv_mesh_info *m, size_t from)
{
    memcpy(to->positions + 3 * v, m->positions + 3 * from, 3 * sizeof(float));
    if (to->normals && m->normals)
        memcpy(to->normals + 3 * v, m->normals + 3 * from, 3 * sizeof(float));
    if (to->values && m->values)
        to->values[v] = m->values[from];
    if (to->colors && m->colors)
        memcpy(to->colors + 4 * v, m->colors + 4 * from, 4);
}

/* Vertices that are used, in their order; *numbers: theirs, NONE of the others. */
static vv_status number_vertices(uint32_t **numbers_out, size_t *n_out, const clipper *c)
{
    const size_t n = c->m->n_vertices + c->n_crossings;
    uint32_t *numbers = vvi_alloc(c->job, (n + 1) * sizeof *numbers, VVI_MEM_SCRATCH);
    *numbers_out = numbers;
    *n_out = 0;
    if (!numbers)
        return vv_fail_memory(n * sizeof *numbers);
    memset(numbers, 0xff, n * sizeof *numbers);
    for (size_t i = 0; i < 3 * c->n_triangles; i++)
        numbers[c->triangles[i]] = 0;
    for (size_t v = 0; v < n; v++)
        if (numbers[v] == 0)
            numbers[v] = (uint32_t)(*n_out)++;
    return VV_OK;
}

static vv_status make(vv_mesh **out, const clipper *c)
{
    const vv_mesh_info *m = c->m;
    vv_mesh_info info = *m;
    vvi_mesh_arrays to;
    uint32_t *numbers;
    vv_status st = number_vertices(&numbers, &info.n_vertices, c);
    info.n_triangles = c->n_triangles;
    info.n_parts = c->n_parts;
    const unsigned kept = VVI_MESH_VALUES | VVI_MESH_COLORS | (c->n_capped ? 0u : VVI_MESH_NORMALS);
    const unsigned with = c->only_cap ? 0 : vvi_mesh_arrays_of(m) & kept;
    if (st == VV_OK)
        st = vvi_mesh_new(out, &to, &info, with, c->job);
    for (size_t v = 0; v < m->n_vertices + c->n_crossings && st == VV_OK; v++) {
        if (numbers[v] == NONE)
            continue;
        if (v < m->n_vertices)
            copy_vertex(&to, numbers[v], m, v);
        else
            put_crossing(&to, numbers[v], c, &c->crossings[v - m->n_vertices]);
    }
    for (size_t i = 0; i < 3 * c->n_triangles && st == VV_OK; i++)
        to.triangles[i] = numbers[c->triangles[i]];
    for (size_t i = 0; i < c->n_parts && st == VV_OK; i++)
        to.parts[i] = c->parts[i];
    if (st == VV_OK)
        vvi_mesh_leave_textures(*out);
    vvi_free(numbers);
    return st;
}

static clipper begin(const vv_mesh *mesh, const vv_plane *plane, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    return (clipper){.m = m, .n_parts = m->n_parts, .plane = *plane, .job = job};
}

static void finish(clipper *c)
{
    vvi_free(c->crossings);
    vvi_free(c->slots);
    vvi_free(c->triangles);
    vvi_free(c->parts);
}

/* *n_gaps: grows by the chains that do not close. */
static vv_status clip(vv_mesh **out, size_t *n_gaps, const vv_mesh *mesh, const vv_plane *plane, bool cap, vv_job *job)
{
    clipper c = begin(mesh, plane, job);
    c.cap = cap;
    vv_status st = count(&c);
    if (st == VV_OK && !c.slots) {
        *out = vv_mesh_retain(mesh);
        return VV_OK;
    }
    if (st == VV_OK && (st = cut_all(&c)) == VV_OK)
        st = make(out, &c);
    *n_gaps += c.n_gaps;
    finish(&c);
    return st;
}

vv_status vvi_mesh_clip(vv_mesh **out, const vv_mesh *mesh, const vv_plane *planes, size_t n_planes, bool cap,
                        vv_job *job)
{
    vv_mesh *now = vv_mesh_retain(mesh);
    vv_status st = VV_OK;
    size_t n_gaps = 0;
    *out = NULL;
    for (size_t i = 0; i < n_planes && st == VV_OK; i++) {
        vv_mesh *next = NULL;
        st = clip(&next, &n_gaps, now, &planes[i], cap, job);
        vv_mesh_release(now);
        now = next;
    }
    if (st == VV_OK && cap && n_gaps)
        vvi_log(job, VV_LOG_WARNING, "surface",
                "the surface has a border of its own where it is cut: it stays open there, at %zu %s", n_gaps,
                n_gaps == 1 ? "place" : "places");
    *out = now;
    return st;
}

/* Only the face; *out NULL: the plane does not meet it. */
static vv_status cut_face(vv_mesh **out, size_t *n_gaps, clipper *c)
{
    c->cap = c->only_cap = true;
    vv_status st = count(c);
    if (st == VV_OK && c->slots && (st = cut_all(c)) == VV_OK && c->n_triangles)
        st = make(out, c);
    *n_gaps = c->n_gaps;
    finish(c);
    return st;
}

vv_status vvi_mesh_section(vv_mesh **out, size_t *n_gaps, const vv_mesh *mesh, const vv_plane *plane, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    uint32_t *place = NULL;
    vv_status st = VV_OK;
    *out = NULL;
    *n_gaps = SIZE_MAX;
    for (int way = 0; way < 3 && *n_gaps && st == VV_OK; way++) {
        clipper c = begin(mesh, plane, job);
        vv_mesh *face = NULL;
        size_t n;
        if (way == 1)
            st = vvi_number_places(&place, m->positions, m->n_vertices, job);
        if (way == 2 && !m->n_parts)
            break;
        c.place = place;
        c.n_parts = way == 2 ? 0 : m->n_parts;
        if (st == VV_OK)
            st = cut_face(&face, &n, &c);
        if (st == VV_OK && n < *n_gaps) {
            vv_mesh_release(*out);
            *out = face;
            *n_gaps = n;
        } else {
            vv_mesh_release(face);
        }
    }
    vvi_free(place);
    if (st == VV_OK)
        return VV_OK;
    vv_mesh_release(*out);
    *out = NULL;
    return st;
}
