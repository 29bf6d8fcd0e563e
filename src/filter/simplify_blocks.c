#include "filter/simplify_blocks.h"
#include "core/job.h"
#include "core/memory.h"
#include "filter/simplify_seams.h"
#include "measure/bvh.h"
#include "surface/chosen_triangles.h"

#include <string.h>

enum { BLOCK = 1 << 16 }; /* triangles: fewer make more seams, more leave fewer blocks to share out */

/* Neighbours of one part. */
typedef struct block {
    size_t begin, end; /* in the order of the blocks */
    size_t part;
    vvi_chosen made; /* what became of it */
} block;

typedef struct blocks {
    vvi_attempts *a;
    const vv_mesh_info *mesh;
    uint32_t *order; /* triangles of the mesh, part by part, in the order of the tree */
    block *block;
    size_t n;
    vv_job *job;
} blocks;

bool vvi_simplify_is_large(size_t n)
{
    return n > 2 * BLOCK;
}

static size_t n_parts(const vv_mesh_info *m)
{
    return m->parts && m->n_parts ? m->n_parts : 1;
}

static vv_mesh_part part_of(const vv_mesh_info *m, size_t index)
{
    return m->parts && m->n_parts ? m->parts[index] : (vv_mesh_part){.n_triangles = m->n_triangles};
}

static size_t blocks_of(size_t n)
{
    return (n + BLOCK - 1) / BLOCK;
}

/* What they are -----------------------------------------------------------------------------------------------------
 */

/* The part of each triangle, then each to the next place of its part. */
static vv_status order_by_part(blocks *b)
{
    const vv_mesh_info *m = b->mesh;
    uint32_t *part = vvi_alloc(b->job, m->n_triangles * sizeof *part, VVI_MEM_SCRATCH);
    size_t *next = vvi_alloc(b->job, n_parts(m) * sizeof *next, VVI_MEM_SCRATCH);
    for (size_t i = 0; part && next && i < n_parts(m); i++) {
        const vv_mesh_part p = part_of(m, i);
        next[i] = p.first_triangle;
        for (size_t t = p.first_triangle; t < p.first_triangle + p.n_triangles; t++)
            part[t] = (uint32_t)i;
    }
    for (size_t i = 0; part && next && i < m->n_triangles; i++) {
        const uint32_t t = b->a->before->order[i];
        b->order[next[part[t]]++] = t;
    }
    const vv_status st = part && next ? VV_OK : vv_fail_memory(m->n_triangles * sizeof *part);
    vvi_free(part);
    vvi_free(next);
    return st;
}

static vv_status divide(blocks *b)
{
    const vv_mesh_info *m = b->mesh;
    size_t most = 0;
    for (size_t i = 0; i < n_parts(m); i++)
        most += blocks_of(part_of(m, i).n_triangles);
    b->order = vvi_alloc(b->job, m->n_triangles * sizeof *b->order, VVI_MEM_SCRATCH);
    b->block = vvi_alloc_zeroed(b->job, most * sizeof *b->block, VVI_MEM_SCRATCH);
    if (!b->order || !b->block)
        return vv_fail_memory(m->n_triangles * sizeof *b->order);
    for (size_t i = 0; i < n_parts(m); i++) {
        const vv_mesh_part p = part_of(m, i);
        const size_t n = blocks_of(p.n_triangles);
        for (size_t k = 0; k < n; k++)
            b->block[b->n++] = (block){.begin = p.first_triangle + p.n_triangles * k / n,
                                       .end = p.first_triangle + p.n_triangles * (k + 1) / n,
                                       .part = i};
    }
    return order_by_part(b);
}

/* One of them -------------------------------------------------------------------------------------------------------
 */

/* As it was. */
static vv_status gather(block *one, const blocks *b)
{
    const size_t n = one->end - one->begin;
    uint32_t *to = vvi_alloc(b->job, 3 * n * sizeof *to, VVI_MEM_SCRATCH);
    if (!to)
        return vv_fail_memory(3 * n * sizeof *to);
    one->made = (vvi_chosen){.mesh = b->mesh, .triangles = to, .n = n};
    for (size_t i = 0; i < n; i++)
        memcpy(to + 3 * i, b->mesh->triangles + 3 * (size_t)b->order[one->begin + i], 3 * sizeof *to);
    return VV_OK;
}

/* It has no tree yet. */
static vv_status attempt(vvi_attempts *a, const blocks *b, const vv_mesh *mesh)
{
    vv_mesh_tree *before = NULL;
    vv_status st = vvi_bvh_new(&before, mesh, b->job);
    *a = (vvi_attempts){.mesh = mesh, .before = before, .error = b->a->error, .options = b->a->options};
    a->options.fix_border = true;
    a->options.uncounted = true;
    if (st == VV_OK)
        st = vvi_simplify_attempts(a, b->job);
    vv_mesh_tree_release(before);
    return st;
}

static vv_status take(vvi_chosen *c, const vvi_attempts *a, const uint32_t *vertex, uint32_t *number, vv_job *job)
{
    c->n = a->result.n_triangles;
    for (size_t k = 0; k < 3 * c->n; k++)
        c->triangles[k] = vertex[a->corners[k]];
    return a->out ? vvi_chosen_tell_copies(c, vv_mesh_get_info(a->out), number, job) : VV_OK;
}

static vv_status simplify(block *one, const blocks *b, uint32_t *number)
{
    vvi_attempts a = {0};
    vv_mesh *mesh = NULL;
    uint32_t *vertex = NULL;
    vv_status st = vvi_chosen_places(&mesh, &vertex, &one->made, number, b->job);
    if (st == VV_OK)
        st = attempt(&a, b, mesh);
    if (st == VV_OK && a.kept)
        st = take(&one->made, &a, vertex, number, b->job);
    vvi_attempts_finish(&a);
    vv_mesh_release(mesh);
    vvi_free(vertex);
    return st;
}

static vv_status start(void **scratch_out, void *shared, int worker)
{
    (void)worker;
    const blocks *b = shared;
    const size_t bytes = (b->mesh->n_vertices + 1) * sizeof(uint32_t);
    if (!(*scratch_out = vvi_alloc(b->job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    memset(*scratch_out, 0xff, bytes);
    return VV_OK;
}

static void finish(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

static vv_status item(void *scratch, void *shared, size_t index)
{
    const blocks *b = shared;
    block *one = &b->block[index];
    const vv_status st = gather(one, b);
    return st == VV_OK ? simplify(one, b, scratch) : st;
}

/* All of them -------------------------------------------------------------------------------------------------------
 */

/* Vertices between blocks of one part: 1, all others 0. */
static void find_seams(uint8_t *seam, uint32_t *number, const blocks *b)
{
    for (size_t i = 0; i < b->n; i++) {
        const vvi_chosen *made = &b->block[i].made;
        for (size_t k = 0; k < 3 * made->n; k++) {
            const uint32_t v = vvi_chosen_original(made, made->triangles[k]), was = number[v];
            seam[v] |= was != UINT32_MAX && was != i && b->block[was].part == b->block[i].part;
            number[v] = (uint32_t)i;
        }
    }
}

/* On seams a vertex's copies are the vertex, to which other blocks come. */
static void add(vvi_chosen *c, const vvi_chosen *made, const uint8_t *seam)
{
    const size_t n_vertices = c->mesh->n_vertices;
    for (size_t k = 0; k < 3 * made->n; k++) {
        const uint32_t v = made->triangles[k], original = vvi_chosen_original(made, v);
        c->triangles[3 * c->n + k] = v < n_vertices || seam[original] ? original : (uint32_t)(v + c->n_copies);
    }
    for (size_t i = 0; i < made->n_copies; i++)
        c->copied[c->n_copies + i] = made->copied[i];
    c->n += made->n;
    c->n_copies += made->n_copies;
}

static void begin_parts(vvi_chosen *c, size_t *part, size_t end)
{
    for (; c->parts && *part < end; ++*part) {
        c->parts[*part] = c->mesh->parts[*part];
        c->parts[*part].first_triangle = c->n;
        c->parts[*part].n_triangles = 0;
    }
}

/* Behind one another, with their parts. */
static void join(vvi_chosen *c, const blocks *b, const uint8_t *seam)
{
    size_t part = 0;
    for (size_t i = 0; i < b->n; i++) {
        const block *one = &b->block[i];
        begin_parts(c, &part, one->part + 1);
        add(c, &one->made, seam);
        if (c->parts)
            c->parts[one->part].n_triangles += one->made.n;
    }
    begin_parts(c, &part, n_parts(b->mesh));
}

/* The mesh, and by whose vertices it is made. */
static vv_status make(vvi_attempts *a, vvi_chosen *c, size_t n_crowded, vv_job *job)
{
    const vv_status st = vvi_chosen_mesh(&a->out, c, job);
    a->result = (vvi_simplify_result){.n_triangles = c->n, .n_crowded = n_crowded};
    for (size_t k = 0; k < 3 * c->n; k++)
        c->triangles[k] = vvi_chosen_original(c, c->triangles[k]);
    a->corners = c->triangles;
    c->triangles = NULL;
    return st;
}

static vv_status take_room(vvi_chosen *c, const blocks *b)
{
    const vv_mesh_info *m = b->mesh;
    size_t n = 0, n_copies = 0;
    for (size_t i = 0; i < b->n; i++) {
        n += b->block[i].made.n;
        n_copies += b->block[i].made.n_copies;
    }
    const bool with_parts = m->parts && m->n_parts;
    c->triangles = vvi_alloc(b->job, (3 * n + 1) * sizeof *c->triangles, VVI_MEM_SCRATCH);
    c->copied = vvi_alloc(b->job, (n_copies + 1) * sizeof *c->copied, VVI_MEM_SCRATCH);
    c->parts = with_parts ? vvi_alloc(b->job, m->n_parts * sizeof *c->parts, VVI_MEM_SCRATCH) : NULL;
    return c->triangles && c->copied && (c->parts || !with_parts) ? VV_OK : vv_fail_memory(3 * n * sizeof(uint32_t));
}

static void give_blocks_back(blocks *b)
{
    for (size_t i = 0; i < b->n; i++) {
        vvi_free(b->block[i].made.triangles);
        vvi_free(b->block[i].made.copied);
    }
    vvi_free(b->block);
    vvi_free(b->order);
    b->n = 0;
    b->block = NULL;
    b->order = NULL;
}

static vv_status put_together(blocks *b)
{
    const size_t n = b->mesh->n_vertices;
    vvi_chosen c = {.mesh = b->mesh};
    size_t n_crowded = 0;
    uint8_t *seam = vvi_alloc_zeroed(b->job, n + 1, VVI_MEM_SCRATCH);
    uint32_t *number = vvi_alloc(b->job, (n + 1) * sizeof *number, VVI_MEM_SCRATCH);
    vv_status st = seam && number ? take_room(&c, b) : vv_fail_memory((n + 1) * sizeof *number);
    if (st == VV_OK) {
        memset(number, 0xff, (n + 1) * sizeof *number);
        find_seams(seam, number, b);
        join(&c, b, seam);
    }
    vvi_free(number);
    give_blocks_back(b);
    if (st == VV_OK && (st = vvi_simplify_seams(&c, &n_crowded, seam, b->a, b->job)) == VV_OK)
        st = make(b->a, &c, n_crowded, b->job);
    vvi_free(seam);
    vvi_free(c.triangles);
    vvi_free(c.copied);
    vvi_free(c.parts);
    return st;
}

vv_status vvi_simplify_in_blocks(vvi_attempts *a, vv_job *job)
{
    const vvi_work work = {.stage = "simplify", .start = start, .item = item, .finish = finish};
    blocks b = {.a = a, .mesh = vv_mesh_get_info(a->mesh), .job = job};
    a->out = NULL;
    a->after = NULL;
    a->corners = NULL;
    vv_status st = divide(&b);
    if (st == VV_OK && (st = vvi_parallel_for(job, &work, &b, b.n)) == VV_OK)
        st = put_together(&b);
    give_blocks_back(&b);
    a->kept = true;
    a->largest = 0;
    if (st != VV_OK)
        vvi_attempts_finish(a);
    return st;
}
