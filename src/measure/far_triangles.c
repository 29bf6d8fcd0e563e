#include "measure/far_triangles.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "measure/farthest_place.h"

#include <float.h>
#include <math.h>

enum { VERTICES = 2048, TRIANGLES = 1024, DEEPEST = 12, QUESTIONS = 1 << 15, HALVINGS = 12 };

typedef struct search {
    const vv_mesh_tree *a, *b;
    const vv_mesh_info *mesh; /* of a */
    vv_vec3 shift;            /* from the origin of a to that of b */
    double distance, square;  /* what is within them is near enough */
    double *vertex_square;    /* of each vertex of a: squared distance, */
    uint32_t *vertex_near;    /* and what is near it, in the order of b's tree */
    double *largest;          /* squared, by item */
    vvi_beyond *out;
} search;

/* One triangle that is being looked at. */
typedef struct look {
    const search *s;
    int questions; /* that may still be asked */
    size_t near;   /* what is near the last place, in the order of b's tree */
    double largest;
} look;

/* Half the distance leaves the other half for what is around the place. */
static vvi_spot spot_at(const search *s, vv_vec3 at, size_t hint)
{
    vvi_spot spot = {.at = at};
    spot.near = vvi_bvh_within(&spot.square, s->b, vvi_add(at, s->shift), s->square / 4, hint);
    return spot;
}

/* Whether it is beyond. */
static bool take(look *l, const vvi_spot *spot)
{
    l->near = spot->near;
    if (spot->square > l->s->square / 4)
        l->largest = fmax(l->largest, spot->square);
    return spot->square > l->s->square;
}

/* What is known of a piece ------------------------------------------------------------------------------------------
 *
 * The places within a length of one triangle are a convex set. So a convex piece is within it when its corners are.
 */

static bool is_near(const search *s, vv_vec3 at, size_t triangle)
{
    const vvi_triangle t = vvi_bvh_triangle(s->b, triangle);
    return vvi_triangle_square(vvi_add(at, s->shift), &t) <= s->square;
}

static bool all_near(const search *s, const vvi_spot p[3], size_t triangle)
{
    for (int k = 0; k < 3; k++)
        if (p[k].near != triangle && !is_near(s, p[k].at, triangle))
            return false;
    return true;
}

/* No place is farther away than the middle and the way to it together. */
static bool near_middle(const search *s, const vvi_spot *middle, const vvi_spot p[3])
{
    double way = 0; /* squared */
    for (int k = 0; k < 3; k++) {
        const vv_vec3 d = vvi_sub(p[k].at, middle->at);
        way = fmax(way, vvi_dot(d, d));
    }
    return sqrt(middle->square) + sqrt(way) <= s->distance;
}

/* A place on the way between two that is near to what each of them is near to: each triangle has an end of the way. */
static bool meet(vv_vec3 *out, const search *s, const vvi_spot *p, const vvi_spot *q)
{
    double lo = 0, hi = 1;
    for (int i = 0; i < HALVINGS; i++) {
        const double half = (lo + hi) / 2;
        *out = vvi_between(p->at, q->at, half);
        const bool to_p = is_near(s, *out, p->near), to_q = is_near(s, *out, q->near);
        if (to_p && to_q)
            return true;
        if (!to_p && !to_q)
            return false;
        *(to_p ? &lo : &hi) = half;
    }
    return false;
}

/* Two corners near one triangle and the third near another: cut between them. Near three: cut in three, which meet in
 * the middle. */
static bool near_in_parts(const search *s, const vvi_spot p[3], vv_vec3 middle)
{
    vv_vec3 at[3];
    for (int i = 0; i < 6; i++) {
        vvi_spot one = p[i % 3];
        const vvi_spot *other = &p[(i + 1 + i / 3) % 3], *third = &p[(i + 2 - i / 3) % 3];
        if (!is_near(s, one.at, other->near))
            continue;
        one.near = other->near;
        if (meet(&at[0], s, &one, third) && meet(&at[1], s, other, third))
            return true;
    }
    for (int k = 0; k < 3; k++)
        if (!is_near(s, middle, p[k].near) || !meet(&at[k], s, &p[k], &p[(k + 1) % 3]))
            return false;
    return true;
}

/* Whether a place of a triangle is beyond, or could not be decided; its corners are not. */
static bool find(look *l, const vvi_spot p[3], int depth)
{
    for (int k = 0; k < 3; k++)
        if (all_near(l->s, p, p[k].near))
            return false;
    const vv_vec3 at = vvi_scaled(vvi_add(vvi_add(p[0].at, p[1].at), p[2].at), 1 / 3.0);
    if (near_in_parts(l->s, p, at))
        return false;
    const vvi_spot middle = spot_at(l->s, at, p[0].near);
    if (take(l, &middle))
        return true;
    if (near_middle(l->s, &middle, p) || all_near(l->s, p, middle.near))
        return false;
    l->questions -= 4;
    if (depth == DEEPEST || l->questions <= 0)
        return true;
    vvi_spot m[3];
    for (int k = 0; k < 3; k++) {
        m[k] = spot_at(l->s, vvi_between(p[k].at, p[(k + 1) % 3].at, .5), p[k].near);
        if (take(l, &m[k]))
            return true;
    }
    const vvi_spot part[4][3] = {{p[0], m[0], m[2]}, {m[0], p[1], m[1]}, {m[2], m[1], p[2]}, {m[0], m[1], m[2]}};
    for (int k = 0; k < 4; k++)
        if (find(l, part[k], depth + 1))
            return true;
    return false;
}

/* All of it ---------------------------------------------------------------------------------------------------------
 */

static vv_status vertex_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const search *s = shared;
    const size_t n = s->mesh->n_vertices, end = (item + 1) * VERTICES < n ? (item + 1) * VERTICES : n;
    size_t near = 0;
    for (size_t v = item * VERTICES; v < end; v++) {
        const vvi_spot spot = spot_at(s, vvi_bvh_vertex(s->a, v), near);
        near = spot.near;
        s->vertex_near[v] = (uint32_t)near;
        s->vertex_square[v] = spot.square;
    }
    return VV_OK;
}

/* Each vertex was looked at once for all its triangles, but where few triangles are looked at. */
static vvi_spot corner_at(const look *l, uint32_t v)
{
    const search *s = l->s;
    const vv_vec3 at = vvi_bvh_vertex(s->a, v);
    if (!s->vertex_near)
        return spot_at(s, at, l->near);
    return (vvi_spot){at, s->vertex_square[v], s->vertex_near[v]};
}

static bool is_beyond(look *l, const uint32_t corner[3])
{
    vvi_spot p[3];
    for (int k = 0; k < 3; k++) {
        p[k] = corner_at(l, corner[k]);
        if (take(l, &p[k]))
            return true;
    }
    l->questions = QUESTIONS;
    return find(l, p, 0);
}

static bool is_looked_at(const vvi_beyond *b, size_t triangle)
{
    return triangle % b->step == 0 && !(b->skip && b->skip[triangle]);
}

static vv_status triangle_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    const search *s = shared;
    const size_t n = s->mesh->n_triangles, end = (item + 1) * TRIANGLES < n ? (item + 1) * TRIANGLES : n;
    look l = {.s = s};
    for (size_t t = item * TRIANGLES; t < end; t++) {
        const bool is = is_looked_at(s->out, t) && is_beyond(&l, s->mesh->triangles + 3 * t);
        s->out->of[t] = is ? s->b->order[l.near] : VVI_NOT_BEYOND;
    }
    s->largest[item] = l.largest;
    return VV_OK;
}

static size_t count_looks(const vvi_beyond *b, size_t n)
{
    size_t count = 0;
    for (size_t t = 0; t < n; t++)
        count += is_looked_at(b, t);
    return count;
}

static vv_status take_vertex_room(search *s, vv_job *job)
{
    const size_t n = s->mesh->n_vertices;
    s->vertex_square = vvi_alloc(job, n * sizeof *s->vertex_square, VVI_MEM_SCRATCH);
    s->vertex_near = vvi_alloc(job, n * sizeof *s->vertex_near, VVI_MEM_SCRATCH);
    return s->vertex_square && s->vertex_near ? VV_OK : vv_fail_memory(n * sizeof *s->vertex_square);
}

static vv_status run(search *s, vv_job *job)
{
    const size_t n_vertex = (s->mesh->n_vertices + VERTICES - 1) / VERTICES;
    const size_t n_triangle = (s->mesh->n_triangles + TRIANGLES - 1) / TRIANGLES;
    const vvi_work vertices = {.item = vertex_item}, triangles = {.item = triangle_item};
    const bool few = 3 * count_looks(s->out, s->mesh->n_triangles) < s->mesh->n_vertices;
    double largest = 0;
    vv_status st = VV_OK;
    s->largest = vvi_alloc(job, n_triangle * sizeof *s->largest, VVI_MEM_SCRATCH);
    if (!s->largest)
        return vv_fail_memory(n_triangle * sizeof *s->largest);
    if (!few && (st = take_vertex_room(s, job)) == VV_OK)
        st = vvi_parallel_for(job, &vertices, s, n_vertex);
    if (st != VV_OK || (st = vvi_parallel_for(job, &triangles, s, n_triangle)) != VV_OK)
        return st;
    for (size_t i = 0; i < n_triangle; i++)
        largest = fmax(largest, s->largest[i]);
    s->out->largest = sqrt(largest);
    for (size_t t = 0; t < s->mesh->n_triangles; t++)
        s->out->n += s->out->of[t] != VVI_NOT_BEYOND;
    return VV_OK;
}

vv_status vvi_mesh_beyond(vvi_beyond *out, const vv_mesh_tree *a, const vv_mesh_tree *b, double distance, vv_job *job)
{
    const double least = fmax(0, distance - 4 * (double)FLT_EPSILON * (a->radius + b->radius));
    search s = {.a = a,
                .b = b,
                .mesh = vv_mesh_get_info(a->mesh),
                .shift = vvi_sub(a->origin, b->origin),
                .distance = least,
                .square = least * least,
                .out = out};
    out->n = 0;
    out->largest = 0;
    const vv_status st = run(&s, job);
    vvi_free(s.vertex_square);
    vvi_free(s.vertex_near);
    vvi_free(s.largest);
    return st;
}
