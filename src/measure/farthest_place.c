#include "measure/farthest_place.h"
#include "measure/heap.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum { ROUND = 1024, TO_ITEM = 16, QUESTIONS = 1 << 18, A_PIECE = 4 };
enum { TRIANGLE, PIECE }; /* what stands in the queue */
#define ENOUGH 1.002      /* of squares: a thousandth */

/* Part of a triangle of a. */
typedef struct piece {
    vvi_spot corner[3];
    double bound; /* squared */
} piece;

/* What became of a piece. */
typedef struct divided {
    piece part[4];
    int n;        /* 0: its bound became small enough */
    double bound; /* of all of it */
    vvi_spot farthest;
} divided;

typedef struct queue {
    vvi_farthest *f;
    vvi_heap heap;
    piece *pieces;
    size_t n, room;
    piece round[ROUND];
    divided made[ROUND];
    size_t n_round;
    double enough; /* squared: smaller bounds need not be better */
} queue;

/* Bounds ------------------------------------------------------------------------------------------------------------
 */

static double bound_by(const vv_mesh_tree *b, vv_vec3 shift, const vvi_spot p[3], size_t triangle)
{
    const vvi_triangle t = vvi_bvh_triangle(b, triangle);
    double largest = 0;
    for (int i = 0; i < 3; i++)
        largest = fmax(largest, p[i].near == triangle ? p[i].square : vvi_triangle_square(vvi_add(p[i].at, shift), &t));
    return largest;
}

double vvi_spots_bound(const vv_mesh_tree *b, vv_vec3 shift, const vvi_spot p[3])
{
    double bound = INFINITY;
    for (int k = 0; k < 3; k++)
        bound = fmin(bound, bound_by(b, shift, p, p[k].near));
    return bound;
}

static vvi_spot spot_at(const vvi_farthest *f, vv_vec3 at, size_t hint)
{
    vvi_spot s = {.at = at};
    s.near = vvi_bvh_nearest(&s.square, f->b, vvi_add(at, f->shift), hint);
    return s;
}

static void take(divided *d, const vvi_spot *spot)
{
    if (spot->square > d->farthest.square)
        d->farthest = *spot;
}

static void divide(divided *out, const vvi_farthest *f, const piece *whole, double enough)
{
    const vvi_spot *const p = whole->corner;
    const vvi_spot inside = spot_at(f, vvi_scaled(vvi_add(vvi_add(p[0].at, p[1].at), p[2].at), 1 / 3.0), p[0].near);
    vvi_spot m[3];
    *out = (divided){.bound = fmin(whole->bound, bound_by(f->b, f->shift, p, inside.near)), .farthest = inside};
    if (out->bound <= enough)
        return;
    for (int k = 0; k < 3; k++) {
        m[k] = spot_at(f, vvi_between(p[k].at, p[(k + 1) % 3].at, .5), p[k].near);
        take(out, &m[k]);
    }
    const vvi_spot corners[4][3] = {{p[0], m[0], m[2]}, {m[0], p[1], m[1]}, {m[2], m[1], p[2]}, {m[0], m[1], m[2]}};
    out->n = 4;
    for (int k = 0; k < 4; k++) {
        memcpy(out->part[k].corner, corners[k], sizeof corners[k]);
        out->part[k].bound = fmin(out->bound, vvi_spots_bound(f->b, f->shift, corners[k]));
    }
}

static vv_status divide_item(void *scratch, void *shared, size_t item)
{
    (void)scratch;
    queue *q = shared;
    const size_t end = (item + 1) * TO_ITEM < q->n_round ? (item + 1) * TO_ITEM : q->n_round;
    for (size_t i = item * TO_ITEM; i < end; i++)
        divide(&q->made[i], q->f, &q->round[i], q->enough);
    return VV_OK;
}

/* The queue ---------------------------------------------------------------------------------------------------------
 */

/* Nothing nearer than what positions are rounded to is told apart. */
static void set_enough(queue *q)
{
    const double rounding = 4 * (double)FLT_EPSILON * (q->f->a->radius + q->f->b->radius);
    q->enough = fmax(q->f->largest * ENOUGH, rounding * rounding);
}

static vv_status push(queue *q, double bound, uint32_t index, uint32_t kind, vv_job *job)
{
    if (bound > q->enough)
        return vvi_heap_push(&q->heap, (vvi_heap_item){.key = -bound, .index = index, .kind = kind}, job);
    q->f->most = fmax(q->f->most, bound);
    return VV_OK;
}

static vv_status push_piece(queue *q, const piece *p, vv_job *job)
{
    if (q->n == q->room) {
        const size_t room = q->room ? 2 * q->room : 4 * ROUND;
        piece *pieces = vvi_realloc(job, q->pieces, room * sizeof *pieces, VVI_MEM_SCRATCH);
        if (!pieces)
            return vv_fail_memory(room * sizeof *pieces);
        q->pieces = pieces;
        q->room = room;
    }
    if (p->bound > q->enough)
        q->pieces[q->n++] = *p;
    return push(q, p->bound, (uint32_t)(q->n - 1), PIECE, job);
}

static piece whole_triangle(const vvi_farthest *f, uint32_t triangle)
{
    const uint32_t *corner = vv_mesh_get_info(f->a->mesh)->triangles + 3 * (size_t)triangle;
    piece p = {.bound = f->bound[triangle]};
    for (int k = 0; k < 3; k++)
        p.corner[k] = (vvi_spot){vvi_bvh_vertex(f->a, corner[k]), f->square[corner[k]], f->nearest[corner[k]]};
    return p;
}

/* The pieces with the largest bounds, as long as they matter. */
static void fill_round(queue *q)
{
    q->n_round = 0;
    while (q->n_round < ROUND && q->heap.n > 0 && -q->heap.items[0].key > q->enough) {
        const vvi_heap_item item = vvi_heap_pop(&q->heap);
        q->round[q->n_round++] = item.kind == TRIANGLE ? whole_triangle(q->f, item.index) : q->pieces[item.index];
    }
}

static vv_status take_round(queue *q, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < q->n_round; i++) {
        const vvi_spot *found = &q->made[i].farthest;
        if (found->square > q->f->largest) {
            q->f->largest = found->square;
            q->f->worst = found->at;
        }
    }
    set_enough(q);
    for (size_t i = 0; i < q->n_round && st == VV_OK; i++) {
        const divided *d = &q->made[i];
        if (!d->n)
            q->f->most = fmax(q->f->most, d->bound);
        for (int k = 0; k < d->n && st == VV_OK; k++)
            st = push_piece(q, &d->part[k], job);
    }
    return st;
}

static vv_status search(queue *q, vv_job *job)
{
    const size_t n = vv_mesh_get_info(q->f->a->mesh)->n_triangles;
    const size_t rounds = 1 + (QUESTIONS + q->f->a->n + q->f->b->n) / (A_PIECE * ROUND);
    vv_status st = VV_OK;
    set_enough(q);
    for (size_t t = 0; t < n && st == VV_OK; t++)
        st = push(q, q->f->bound[t], (uint32_t)t, TRIANGLE, job);
    for (size_t r = 0; r < rounds && st == VV_OK; r++) {
        const vvi_work work = {.stage = "bounds",
                               .item = divide_item,
                               .n_before = r * (ROUND / TO_ITEM),
                               .n_after = (rounds - 1 - r) * (ROUND / TO_ITEM)};
        fill_round(q);
        if (q->n_round == 0)
            break;
        if ((st = vvi_parallel_for(job, &work, q, (q->n_round + TO_ITEM - 1) / TO_ITEM)) == VV_OK)
            st = take_round(q, job);
    }
    q->f->most = fmax(q->f->most, q->f->largest);
    if (q->heap.n > 0)
        q->f->most = fmax(q->f->most, -q->heap.items[0].key);
    return st;
}

vv_status vvi_farthest_search(vvi_farthest *f, vv_job *job)
{
    queue *q = vvi_alloc_zeroed(job, sizeof *q, VVI_MEM_SCRATCH);
    if (!q)
        return vv_fail_memory(sizeof *q);
    q->f = f;
    f->most = 0;
    const vv_status st = search(q, job);
    vvi_free(q->heap.items);
    vvi_free(q->pieces);
    vvi_free(q);
    return st;
}
