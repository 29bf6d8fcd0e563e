/* Places whose triangles lean little from their mean, as all of a smooth mesh, are looked at and left; around others
 * triangles are sorted into groups that smooth edges join.
 */
#include "scene/smooth_mesh.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/mesh.h"
#include "grid/mesh_normals.h"
#include "surface/vertex_places.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Cosines. Triangles at an edge are one smooth surface up to 59 degrees: a prism of six sides has faces, whatever the
 * rounding, one of seven is a cylinder. No two are that far apart where all lean up to half of that from their mean
 * (CALM). From 45 degrees on (TIP) a mean says nothing of a triangle, as at the tip of a cone. */
#define SMOOTH 0.515038
#define CALM 0.870356
#define TIP 0.707107

enum { OFTEN = 1 << 16 };

typedef struct corner {
    uint32_t at;    /* 3 * triangle + which */
    uint32_t group; /* another corner, or itself: the first of its group */
    uint32_t vertex;
    vv_vec3 normal; /* of its triangle, of length 1 */
    double weight;  /* of that in a mean (Max 1999) */
    vv_vec3 sum;    /* of the first: of the group */
    bool alone;     /* of the first: each of the group is one of its own */
} corner;

typedef struct side {
    uint32_t to, corner; /* the place where it ends, and of which triangle it is */
} side;

typedef struct splitting {
    const vv_mesh_info *m;
    uint32_t *place, *of_place; /* of each vertex, and as triangles */
    uint8_t *uneasy;            /* of each place: some lean much */
    uint32_t *first, *list;     /* corners at uneasy places: from first[place] to first[place + 1] */
    size_t n_listed, most;
    corner *corners; /* at one place: up to `most` */
    side *sides;
    uint32_t *triangles; /* with the vertices that are added */
    uint32_t *stand;     /* of each vertex: the one whose normal it has */
    uint32_t *source;    /* of those that are added: of which they are copies */
    bool *taken;         /* of those that were: a group has it */
    size_t n_added;
} splitting;

/* Its normal and weight; false where it has no area. */
static bool look_at(corner *c, const vv_mesh_info *m, const uint32_t *of_place)
{
    const uint32_t t = c->at / 3 * 3, k = c->at % 3;
    vv_vec3 p[3];
    for (uint32_t i = 0; i < 3; i++) {
        const float *q = m->positions + 3 * (size_t)of_place[t + (k + i) % 3];
        p[i] = vvi_vec((double)q[0], (double)q[1], (double)q[2]);
    }
    const vv_vec3 a = vvi_sub(p[1], p[0]), b = vvi_sub(p[2], p[0]), n = vvi_cross(a, b);
    const double length = sqrt(vvi_dot(n, n)); /* of floats: neither overflows nor vanishes */
    c->weight = length / (vvi_dot(a, a) * vvi_dot(b, b));
    c->normal = vvi_scaled(n, 1 / length);
    return length > 0 && isfinite(c->weight);
}

/* Uneasy places --------------------------------------------------------------------------------------------------- */

static vv_status find_uneasy(splitting *s, const float *normals, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < 3 * s->m->n_triangles && st == VV_OK; i += 3) {
        corner c = {.at = (uint32_t)i};
        const bool some = look_at(&c, s->m, s->of_place);
        for (size_t k = 0; k < 3 && some; k++) {
            const float *n = normals + 3 * (size_t)s->of_place[i + k];
            const vv_vec3 mean = {(double)n[0], (double)n[1], (double)n[2]};
            s->uneasy[s->of_place[i + k]] |= vvi_dot(mean, c.normal) < CALM;
        }
        st = i % OFTEN ? VV_OK : vvi_job_poll(job);
    }
    return st;
}

static void list_corners(splitting *s)
{
    const size_t n = 3 * s->m->n_triangles, n_places = s->m->n_vertices;
    uint32_t *end = s->first + 1; /* one behind until it is filled */
    for (size_t i = 0; i < n; i++)
        end[s->of_place[i] + (size_t)1] += s->uneasy[s->of_place[i]];
    for (size_t p = 0; p < n_places; p++) {
        s->most = end[p + 1] > s->most ? end[p + 1] : s->most;
        end[p + 1] += end[p];
    }
    for (size_t i = 0; i < n; i++)
        if (s->uneasy[s->of_place[i]])
            s->list[end[s->of_place[i]]++] = (uint32_t)i;
}

/* Groups at one place --------------------------------------------------------------------------------------------- */

static uint32_t root(corner *c, uint32_t i)
{
    while (c[i].group != i)
        i = c[i].group = c[c[i].group].group; /* paths get shorter: thousands may meet at a tip */
    return i;
}

static void join(corner *c, uint32_t a, uint32_t b)
{
    a = root(c, a);
    b = root(c, b);
    c[a < b ? b : a].group = a < b ? a : b;
}

static int by_end(const void *a, const void *b)
{
    const side *p = a, *q = b;
    return p->to != q->to ? (p->to > q->to) - (p->to < q->to) : (p->corner > q->corner) - (p->corner < q->corner);
}

static int by_group(const void *a, const void *b)
{
    const corner *p = a, *q = b;
    if (p->group != q->group)
        return p->group < q->group ? -1 : 1;
    if (p->vertex != q->vertex)
        return p->vertex < q->vertex ? -1 : 1;
    return (p->at > q->at) - (p->at < q->at);
}

/* Those without area are left out, and keep their vertices. */
static uint32_t gather(splitting *s, size_t place)
{
    uint32_t n = 0;
    for (size_t i = s->first[place]; i < s->first[place + 1]; i++) {
        corner c = {.at = s->list[i], .group = n, .vertex = s->m->triangles[s->list[i]]};
        const uint32_t t = c.at / 3 * 3, k = c.at % 3;
        if (!look_at(&c, s->m, s->of_place))
            continue;
        s->sides[2 * (size_t)n] = (side){s->of_place[t + (k + 1) % 3], n};
        s->sides[2 * (size_t)n + 1] = (side){s->of_place[t + (k + 2) % 3], n};
        s->corners[n++] = c;
    }
    return n;
}

static void find_groups(corner *c, side *sides, uint32_t n)
{
    qsort(sides, 2 * (size_t)n, sizeof *sides, by_end);
    for (size_t i = 1; i < 2 * (size_t)n; i++)
        if (sides[i].to == sides[i - 1].to &&
            vvi_dot(c[sides[i].corner].normal, c[sides[i - 1].corner].normal) >= SMOOTH)
            join(c, sides[i - 1].corner, sides[i].corner);
    for (uint32_t i = 0; i < n; i++) {
        corner *first = &c[c[i].group = root(c, i)];
        first->sum = vvi_add(first->sum, vvi_scaled(c[i].normal, c[i].weight));
    }
    for (uint32_t i = 0; i < n; i++) {
        corner *first = &c[c[i].group];
        first->alone |= vvi_dot(c[i].normal, first->sum) < TIP * vvi_length(first->sum);
    }
    for (uint32_t i = n; i-- > 0;) /* the first of a group last */
        if (c[c[i].group].alone)
            c[i].group = i;
}

/* A group has the vertex that was, if it is the first that wants it, else a copy. */
static void share_vertices(splitting *s, uint32_t n)
{
    const corner *c = s->corners;
    uint32_t own = 0, stand = 0;
    qsort(s->corners, n, sizeof *s->corners, by_group);
    for (uint32_t i = 0; i < n; i++) {
        const bool other = i == 0 || c[i].group != c[i - 1].group;
        if (other || c[i].vertex != c[i - 1].vertex) {
            own = c[i].vertex;
            if (s->taken[own]) {
                s->source[s->n_added] = own;
                own = (uint32_t)(s->m->n_vertices + s->n_added++);
            } else {
                s->taken[own] = true;
            }
            stand = other ? own : stand;
            s->stand[own] = stand;
        }
        s->triangles[c[i].at] = own;
    }
}

static vv_status split(splitting *s, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t p = 0; p < s->m->n_vertices && st == VV_OK; p++) {
        const uint32_t n = s->uneasy[p] ? gather(s, p) : 0;
        bool several = false;
        if (n)
            find_groups(s->corners, s->sides, n);
        for (uint32_t i = 1; i < n && !several; i++)
            several = s->corners[i].group != s->corners[0].group;
        if (several)
            share_vertices(s, n);
        st = p % OFTEN ? VV_OK : vvi_job_poll(job);
    }
    return st;
}

/* The mesh -------------------------------------------------------------------------------------------------------- */

static void copy_vertices(const vvi_mesh_arrays *a, const splitting *s)
{
    const vv_mesh_info *m = s->m;
    for (size_t i = 0; i < m->n_vertices + s->n_added; i++) {
        const size_t v = i < m->n_vertices ? i : s->source[i - m->n_vertices];
        memcpy(a->positions + 3 * i, m->positions + 3 * v, 3 * sizeof *a->positions);
        if (a->values)
            a->values[i] = m->values[v];
        if (a->colors)
            memcpy(a->colors + 4 * i, m->colors + 4 * v, 4);
        if (m->coordinates && !m->coordinate_of)
            memcpy(a->coordinates + 2 * i, m->coordinates + 2 * v, 2 * sizeof *a->coordinates);
    }
}

static vv_status make(vv_mesh **out, const vv_mesh *mesh, const splitting *s, vv_job *job)
{
    const vv_mesh_info *m = s->m;
    const size_t n = 3 * m->n_triangles;
    vv_mesh_info info = *m;
    vvi_mesh_arrays a;
    info.n_vertices += s->n_added;
    if (m->coordinates && !m->coordinate_of)
        info.n_coordinates = info.n_vertices;
    vv_status st = vvi_mesh_new(out, &a, &info, vvi_mesh_with(mesh) | VVI_MESH_NORMALS, job);
    if (st != VV_OK)
        return st;
    copy_vertices(&a, s);
    if (m->coordinates && m->coordinate_of) {
        memcpy(a.coordinate_of, m->coordinate_of, n * sizeof *a.coordinate_of);
        memcpy(a.coordinates, m->coordinates, 2 * m->n_coordinates * sizeof *a.coordinates);
    }
    if (m->n_parts)
        memcpy(a.parts, m->parts, m->n_parts * sizeof *a.parts);
    vvi_mesh_take_textures(*out, mesh);
    for (size_t i = 0; i < n; i++)
        a.triangles[i] = s->stand[s->triangles[i]];
    st = vvi_normals_of(a.normals, a.positions, info.n_vertices, a.triangles, m->n_triangles, job);
    for (size_t v = 0; v < info.n_vertices && st == VV_OK; v++)
        if (s->stand[v] != v)
            memcpy(a.normals + 3 * v, a.normals + 3 * (size_t)s->stand[v], 3 * sizeof *a.normals);
    if (n)
        memcpy(a.triangles, s->triangles, n * sizeof *a.triangles);
    return st;
}

static vv_status take(void *out, size_t n, size_t size, vv_job *job)
{
    *(void **)out = vvi_alloc_zeroed(job, (n + 1) * size, VVI_MEM_SCRATCH);
    return *(void **)out ? VV_OK : vv_fail_memory((n + 1) * size);
}

/* Of vertices at one place, as along the seam of a map of the Earth, the first stands for all. */
static vv_status find_places(splitting *s, vv_job *job)
{
    const vv_mesh_info *m = s->m;
    const size_t n = 3 * m->n_triangles;
    float *normals = NULL;
    vv_status st = vvi_number_places(&s->place, m->positions, m->n_vertices, job);
    if (st != VV_OK || (st = take(&s->of_place, n, sizeof *s->of_place, job)) != VV_OK ||
        (st = take(&s->uneasy, m->n_vertices, sizeof *s->uneasy, job)) != VV_OK ||
        (st = take(&normals, 3 * m->n_vertices, sizeof *normals, job)) != VV_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        s->of_place[i] = s->place[m->triangles[i]];
    st = vvi_normals_of(normals, m->positions, m->n_vertices, s->of_place, m->n_triangles, job);
    if (st == VV_OK)
        st = find_uneasy(s, normals, job);
    vvi_free(normals);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        s->n_listed += s->uneasy[s->of_place[i]];
    return st;
}

static vv_status find_vertices(splitting *s, vv_job *job)
{
    const vv_mesh_info *m = s->m;
    const size_t n = 3 * m->n_triangles;
    vv_status st;
    if ((st = take(&s->triangles, n, sizeof *s->triangles, job)) != VV_OK ||
        (st = take(&s->stand, m->n_vertices + s->n_listed, sizeof *s->stand, job)) != VV_OK ||
        (st = take(&s->source, s->n_listed, sizeof *s->source, job)) != VV_OK)
        return st;
    if (n)
        memcpy(s->triangles, m->triangles, n * sizeof *s->triangles);
    if (m->n_vertices)
        memcpy(s->stand, s->place, m->n_vertices * sizeof *s->stand);
    if (!s->n_listed)
        return VV_OK;
    if ((st = take(&s->first, m->n_vertices + 1, sizeof *s->first, job)) != VV_OK ||
        (st = take(&s->list, s->n_listed, sizeof *s->list, job)) != VV_OK ||
        (st = take(&s->taken, m->n_vertices, sizeof *s->taken, job)) != VV_OK)
        return st;
    list_corners(s);
    if ((st = take(&s->corners, s->most, sizeof *s->corners, job)) != VV_OK ||
        (st = take(&s->sides, 2 * s->most, sizeof *s->sides, job)) != VV_OK)
        return st;
    return split(s, job);
}

vv_status vvi_mesh_smooth_shaded(vv_mesh **out, const vv_mesh *mesh, vv_job *job)
{
    splitting s = {.m = vv_mesh_get_info(mesh)};
    *out = NULL;
    vv_status st = find_places(&s, job);
    if (st == VV_OK)
        st = find_vertices(&s, job);
    if (st == VV_OK)
        st = make(out, mesh, &s, job);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    void *const room[] = {s.place, s.of_place,  s.uneasy, s.first,  s.list, s.corners,
                          s.sides, s.triangles, s.stand,  s.source, s.taken};
    for (size_t i = 0; i < sizeof room / sizeof *room; i++)
        vvi_free(room[i]);
    return st;
}
