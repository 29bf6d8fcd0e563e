#include "scene/visible_volume.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/lattice.h"
#include "grid/minmax.h"
#include "scene/label_ids.h"
#include "scene/resolve.h"
#include "scene/transfer.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { SHIFT_SMALL = 2, SHIFT_LARGE = 3 };

#define FAINT 0.02            /* of the largest opacity: no more than this is as good as nothing */
#define MOST 0.9              /* of all that is seen lies in the pieces that are always looked at */
#define GROWS 1.1             /* so much longer may other pieces make the box's diagonal */
#define MOST_BLOCKS (1 << 24) /* beyond, the box of all samples does */

/* What is seen, and how much of it, in data values. */
typedef struct sight {
    const vv_classification *classes;
    bool solid;
    double lo, hi; /* of the solid */
    double least;  /* opacity below which nothing is seen */
} sight;

static double region_opacity(const vv_classification *c, double lo, double hi)
{
    double most = 0;
    for (size_t i = 0; i < c->n_regions; i++) {
        const vv_region *r = &c->regions[i];
        if (fmin(r->value_lo, r->top_lo) <= hi && fmax(r->value_hi, r->top_hi) >= lo)
            most = fmax(most, r->opacity);
    }
    return most;
}

static double seen_between(const sight *s, double lo, double hi)
{
    const vv_classification *c = s->classes;
    if (!(lo <= hi))
        return 0; /* nothing but NaN */
    if (s->solid)
        return lo <= s->hi && hi >= s->lo ? 1 : 0;
    if (c->kind != VV_SEGMENT_TRANSFER)
        return vvi_transfer_visible(c, lo, hi) ? 1 : 0;
    return c->n_regions ? region_opacity(c, lo, hi) : vvi_transfer_most_opaque(c, lo, hi);
}

#define NOT_SEEN 0u
#define NO_PIECE UINT32_MAX

/* Blocks that are seen, and which piece each belongs to. */
typedef struct block_map {
    const vvi_minmax *m;
    size_t n;
    float *seen;     /* how opaque; 0: not seen */
    uint32_t *piece; /* 1 and up; NO_PIECE: none yet, NOT_SEEN: none ever */
    uint32_t *queue; /* of a piece that is being walked */
} block_map;

typedef struct piece {
    double seen;
    int32_t lo[3], hi[3]; /* blocks */
    uint32_t number;
} piece;

static void grow(piece *p, const piece *by)
{
    for (int a = 0; a < 3; a++) {
        p->lo[a] = by->lo[a] < p->lo[a] ? by->lo[a] : p->lo[a];
        p->hi[a] = by->hi[a] > p->hi[a] ? by->hi[a] : p->hi[a];
    }
}

static void place_of(int32_t out[3], const block_map *b, uint32_t at)
{
    const uint32_t nx = (uint32_t)b->m->n[0], ny = (uint32_t)b->m->n[1];
    out[0] = (int32_t)(at % nx);
    out[1] = (int32_t)(at / nx % ny);
    out[2] = (int32_t)(at / nx / ny);
}

/* All blocks that hang together with one get a number. */
static piece walk_piece(block_map *b, uint32_t first, uint32_t number)
{
    const int32_t *n = b->m->n;
    piece p = {.lo = {INT32_MAX, INT32_MAX, INT32_MAX}, .hi = {-1, -1, -1}, .number = number};
    size_t n_queue = 1;
    b->queue[0] = first;
    b->piece[first] = number;
    while (n_queue) {
        const uint32_t at = b->queue[--n_queue];
        piece one = {.number = number};
        place_of(one.lo, b, at);
        memcpy(one.hi, one.lo, sizeof one.hi);
        grow(&p, &one);
        p.seen += b->seen[at];
        for (int d = 0; d < 27; d++) {
            const int32_t x = one.lo[0] + d % 3 - 1, y = one.lo[1] + d / 3 % 3 - 1, z = one.lo[2] + d / 9 - 1;
            if (x < 0 || y < 0 || z < 0 || x >= n[0] || y >= n[1] || z >= n[2])
                continue;
            const uint32_t next = ((uint32_t)z * (uint32_t)n[1] + (uint32_t)y) * (uint32_t)n[0] + (uint32_t)x;
            if (b->piece[next] != NO_PIECE)
                continue;
            b->piece[next] = number;
            b->queue[n_queue++] = next;
        }
    }
    return p;
}

static int more_seen_first(const void *a, const void *b)
{
    const piece *x = a, *y = b;
    return (x->seen < y->seen) - (x->seen > y->seen);
}

static double diagonal(const piece *p)
{
    double sum = 0;
    for (int a = 0; a < 3; a++)
        sum += (double)(p->hi[a] + 1 - p->lo[a]) * (p->hi[a] + 1 - p->lo[a]);
    return sqrt(sum);
}

/* Sorts them; so many, the first ones, are looked at: their numbers are kept in `wanted`. */
static void choose_pieces(bool *wanted, piece *pieces, size_t n, double all)
{
    qsort(pieces, n, sizeof *pieces, more_seen_first);
    piece box = pieces[0];
    double seen = 0;
    size_t i = 0;
    for (; i < n && seen < MOST * all; i++) {
        grow(&box, &pieces[i]);
        seen += pieces[i].seen;
        wanted[pieces[i].number] = true;
    }
    const double most = GROWS * diagonal(&box);
    for (; i < n; i++) {
        piece wider = box;
        grow(&wider, &pieces[i]);
        if (diagonal(&wider) > most)
            continue;
        box = wider;
        wanted[pieces[i].number] = true;
    }
}

static vv_status add_piece(piece **pieces, size_t *n, size_t *room, const piece *p, vv_job *job)
{
    if (*n == *room) {
        const size_t more = *room ? 2 * *room : 64;
        piece *grown = vvi_realloc(job, *pieces, more * sizeof *grown, VVI_MEM_SCRATCH);
        if (!grown)
            return vv_fail_memory(more * sizeof *grown);
        *pieces = grown;
        *room = more;
    }
    (*pieces)[(*n)++] = *p;
    return VV_OK;
}

/* The pieces, and which of them are looked at, by number; NULL: nothing is seen. */
static vv_status find_pieces(bool **wanted_out, block_map *b, vv_job *job)
{
    piece *pieces = NULL;
    size_t n = 0, room = 0;
    double all = 0;
    vv_status st = VV_OK;
    *wanted_out = NULL;
    for (size_t i = 0; i < b->n && st == VV_OK; i++) {
        if (b->piece[i] != NO_PIECE)
            continue;
        const piece p = walk_piece(b, (uint32_t)i, (uint32_t)n + 1);
        all += p.seen;
        st = add_piece(&pieces, &n, &room, &p, job);
    }
    if (st == VV_OK && n) {
        *wanted_out = vvi_alloc_zeroed(job, n + 1, VVI_MEM_SCRATCH);
        if (*wanted_out)
            choose_pieces(*wanted_out, pieces, n, all);
        else
            st = vv_fail_memory(n + 1);
    }
    vvi_free(pieces);
    return st;
}

/* What lies farthest out along each of the directions to a cube's surface of 5 x 5 x 5 points. */
typedef struct found {
    vv_vec3 point[VVI_VISIBLE_POINTS];
    double along[VVI_VISIBLE_POINTS];
    vv_vec3 slope[VVI_VISIBLE_POINTS]; /* of the way along it, in samples */
    double last[3];                    /* sample of the grid on each axis */
} found;

static void add_box(found *f, const double lo[3], const double hi[3])
{
    for (int i = 0; i < VVI_VISIBLE_POINTS; i++) {
        const vv_vec3 s = f->slope[i];
        const vv_vec3 p = vvi_vec(s.x > 0 ? hi[0] : lo[0], s.y > 0 ? hi[1] : lo[1], s.z > 0 ? hi[2] : lo[2]);
        const double along = vvi_dot(s, p);
        if (along <= f->along[i])
            continue;
        f->along[i] = along;
        f->point[i] = p;
    }
}

static void begin_with_nothing(found *f, const vv_actor *actor)
{
    int n = 0;
    for (int d = 0; d < 125; d++) {
        const int x = d % 5 - 2, y = d / 5 % 5 - 2, z = d / 25 - 2;
        if (abs(x) < 2 && abs(y) < 2 && abs(z) < 2)
            continue;
        const vv_vec3 direction = vvi_vec(x, y, z), *axis = actor->index_to_world.axis;
        f->slope[n] = vvi_vec(vvi_dot(axis[0], direction), vvi_dot(axis[1], direction), vvi_dot(axis[2], direction));
        f->along[n++] = -INFINITY;
    }
    for (int a = 0; a < 3; a++)
        f->last[a] = (double)vv_field_get_info(actor->field)->grid.dims[a] - 1;
}

static void add_all(found *f)
{
    static const double first[3] = {0, 0, 0};
    add_box(f, first, f->last);
}

/* Of a row of blocks along x only the ends lie outside. */
static void add_row(found *f, const block_map *b, const bool *wanted, int32_t y, int32_t z)
{
    const int32_t nx = b->m->n[0];
    const uint32_t *row = b->piece + ((size_t)z * (size_t)b->m->n[1] + (size_t)y) * (size_t)nx;
    int32_t lo = 0, hi = nx - 1;
    while (lo < nx && !wanted[row[lo]])
        lo++;
    while (hi > lo && !wanted[row[hi]])
        hi--;
    if (lo == nx)
        return;
    const int32_t from[3] = {lo, y, z}, to[3] = {hi, y, z};
    double first[3], end[3];
    for (int a = 0; a < 3; a++) {
        first[a] = fmin((double)((int64_t)from[a] << b->m->shift), f->last[a]);
        end[a] = fmin((double)(((int64_t)to[a] + 1) << b->m->shift), f->last[a]);
    }
    add_box(f, first, end);
}

typedef struct request {
    const vv_actor *actor;
    const sight *sight;
} request;

static vv_status look(found *f, const sight *s, const vvi_minmax *m, const vvi_lattice_hold *hold, vv_job *job)
{
    block_map b = {.m = m, .n = (size_t)m->n[0] * (size_t)m->n[1] * (size_t)m->n[2]};
    bool *wanted = NULL;
    if (b.n > MOST_BLOCKS) {
        add_all(f);
        return VV_OK;
    }
    b.seen = vvi_alloc(job, b.n * sizeof *b.seen, VVI_MEM_SCRATCH);
    b.piece = vvi_alloc(job, b.n * sizeof *b.piece, VVI_MEM_SCRATCH);
    b.queue = vvi_alloc(job, b.n * sizeof *b.queue, VVI_MEM_SCRATCH);
    vv_status st = b.seen && b.piece && b.queue ? VV_OK : vv_fail_memory(b.n * sizeof *b.queue);
    for (size_t i = 0; i < b.n && st == VV_OK; i++) {
        const double p = m->lo[i] * hold->value_scale + hold->value_offset;
        const double q = m->hi[i] * hold->value_scale + hold->value_offset;
        b.seen[i] = m->lo[i] <= m->hi[i] ? (float)seen_between(s, fmin(p, q), fmax(p, q)) : 0;
        b.piece[i] = b.seen[i] > s->least ? NO_PIECE : NOT_SEEN;
    }
    if (st == VV_OK)
        st = find_pieces(&wanted, &b, job);
    for (int32_t z = 0; z < m->n[2] && wanted; z++)
        for (int32_t y = 0; y < m->n[1]; y++)
            add_row(f, &b, wanted, y, z);
    if (st == VV_OK && !wanted)
        add_all(f);
    vvi_free(b.seen);
    vvi_free(b.piece);
    vvi_free(b.queue);
    vvi_free(wanted);
    return st;
}

static vv_status look_at(found *f, const sight *s, const vv_actor *actor, vv_job *job)
{
    const int64_t *n = vv_field_get_info(actor->field)->grid.dims;
    const int shift = n[0] * n[1] * n[2] <= (int64_t)1 << 25 ? SHIFT_SMALL : SHIFT_LARGE; /* as the ray caster's */
    const vvi_cache_key key = vvi_minmax_key("minmax", actor->field, actor->component, shift);
    vvi_lattice_hold hold = {0};
    vvi_cached *minmax = NULL;
    vv_status st = vvi_lattice_open_somehow(&hold, actor->field, actor->component, job);
    if (st == VV_OK)
        st = vvi_minmax_get_lattice(&minmax, &key, &hold, shift, job);
    if (st == VV_OK)
        st = look(f, s, vvi_cached_value(minmax), &hold, job);
    vvi_cache_release(minmax);
    vvi_lattice_close(&hold);
    return st;
}

/* Labels that doubles do not tell apart are looked at as the ray caster does, by their numbers. */
static vv_status look_at_numbers(found *f, const vv_actor *actor, vv_job *job)
{
    vvi_cached *ids;
    vv_actor numbered;
    const vv_status st = vvi_label_ids_get(&ids, actor->field, actor->component, job);
    if (st != VV_OK)
        return st;
    vvi_label_ids_actor(&numbered, actor, vvi_cached_value(ids));
    const vv_status looked = look_at(f, &(sight){.classes = &numbered.classes}, &numbered, job);
    vv_field_release((vv_field *)numbered.field);
    vvi_cache_release(ids);
    return looked;
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const request *r = user;
    const vv_actor *actor = r->actor;
    found *f = vvi_alloc(job, sizeof *f, VVI_MEM_DERIVED);
    if (!f)
        return vv_fail_memory(sizeof *f);
    begin_with_nothing(f, actor);
    const bool numbers = !r->sight->solid && actor->classes.kind == VV_SEGMENT_LABELS &&
                         vvi_label_ids_needed(vv_field_get_info(actor->field), actor->statistics);
    const vv_status st = numbers ? look_at_numbers(f, actor, job) : look_at(f, r->sight, actor, job);
    *value_out = f;
    *bytes_out = sizeof *f;
    if (st == VV_OK)
        return VV_OK;
    vvi_free(f);
    return st;
}

static uint64_t hash_sight(const sight *s, const vv_actor *actor)
{
    const vv_classification *c = s->classes;
    const double numbers[] = {s->solid, s->lo, s->hi, c->kind, c->lo, c->hi, c->label_opacity};
    uint64_t h = vvi_hash(numbers, sizeof numbers, (uint64_t)actor->component);
    h = vvi_hash(actor->index_to_world.axis, sizeof actor->index_to_world.axis, h);
    h = vvi_hash(c->opacity, 2 * c->n_opacity * sizeof *c->opacity, h);
    h = vvi_hash(c->labels, 5 * c->n_labels * sizeof *c->labels, h);
    if (c->label_ids)
        h = vvi_hash(c->label_ids, c->n_labels * sizeof *c->label_ids, h);
    for (size_t i = 0; i < c->n_regions; i++) {
        const vv_region *r = &c->regions[i];
        const double of_region[] = {r->value_lo, r->value_hi, r->top_lo, r->top_hi, r->opacity};
        h = vvi_hash(of_region, sizeof of_region, h);
    }
    return h;
}

static sight sight_of(const vv_scene *scene, const vv_actor *actor)
{
    sight s = {.classes = &actor->classes};
    s.solid = scene->renderer->solid && scene->renderer->solid(&s.lo, &s.hi, scene, actor);
    s.least = FAINT * seen_between(&s, -INFINITY, INFINITY);
    return s;
}

vv_status vvi_visible_points(vv_vec3 out[VVI_VISIBLE_POINTS], const vv_scene *scene, const vv_actor *actor, vv_job *job)
{
    const sight s = sight_of(scene, actor);
    request r = {actor, &s};
    vvi_cached *cached = NULL;
    found all;
    begin_with_nothing(&all, actor);
    add_all(&all);
    memcpy(out, all.point, sizeof all.point);
    if (vvi_actor_projects(scene, actor))
        return VV_OK;
    const vvi_cache_key key = {"visible", vv_field_identity(actor->field), hash_sight(&s, actor)};
    const vv_status st = vvi_cache_get(&cached, &key, make, vvi_free, &r, job);
    if (st == VV_OK)
        memcpy(out, ((const found *)vvi_cached_value(cached))->point, sizeof all.point);
    vvi_cache_release(cached);
    return st == VV_E_MEMORY || st == VV_E_LIMIT ? VV_OK : st; /* methods that need less memory may go on */
}
