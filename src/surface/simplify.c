#include "surface/simplify.h"
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "grid/mesh.h"
#include "surface/chosen_triangles.h"
#include "surface/place_copies.h"
#include "surface/self_contacts.h"
#include "surface/simplify_library.h"
#include "surface/vertex_places.h"
#include "surface/weld.h"

#include <math.h>
#include <string.h>

bool vvi_can_simplify(void)
{
    return VV_HAVE_MESHOPTIMIZER != 0;
}

#if !VV_HAVE_MESHOPTIMIZER
bool vvi_simplify_with_library(vvi_simplify_call *call)
{
    (void)call;
    return false;
}

const char *vvi_meshoptimizer_version(void)
{
    return "";
}
#endif

/* A mesh while its parts are simplified one after another. */
typedef struct work {
    const vv_mesh_info *mesh;
    const vvi_simplify_options *options;
    vv_job *job;
    uint32_t *number;  /* of vertices within the part; UINT32_MAX: not in it; in the end within the new mesh */
    uint32_t *vertex;  /* and back */
    float *positions;  /* of the part's vertices */
    uint32_t *indices; /* of the part, by those numbers */
    uint32_t *kept;    /* triangles that stay, by the mesh's numbers */
    size_t n_kept;     /* indices in kept */
    uint32_t *copied;  /* vertices that are copies: of which ones; they follow the mesh's in number */
    size_t n_copies, n_crowded;
    uint32_t *piece; /* by vertex: the first one of its piece */
    uint8_t *there;  /* by first vertex: the piece has triangles */
    bool fix_border;
    vv_mesh_part *parts; /* the new ones */
    double error;
} work;

static size_t n_parts(const vv_mesh_info *m)
{
    return m->parts && m->n_parts ? m->n_parts : 1;
}

static vv_mesh_part part_of(const vv_mesh_info *m, size_t index)
{
    return m->parts && m->n_parts ? m->parts[index] : (vv_mesh_part){.n_triangles = m->n_triangles};
}

/* Whether two parts have a vertex in common. Leaves number[] at UINT32_MAX. */
static bool parts_touch(work *w)
{
    const vv_mesh_info *m = w->mesh;
    bool touch = false;
    memset(w->number, 0xff, m->n_vertices * sizeof *w->number);
    for (size_t i = 0; n_parts(m) > 1 && i < n_parts(m); i++) {
        const vv_mesh_part part = part_of(m, i);
        const uint32_t *t = m->triangles + 3 * part.first_triangle;
        for (size_t k = 0; k < 3 * part.n_triangles; k++) {
            touch |= w->number[t[k]] != UINT32_MAX && w->number[t[k]] != i;
            w->number[t[k]] = (uint32_t)i;
        }
    }
    memset(w->number, 0xff, m->n_vertices * sizeof *w->number);
    return touch;
}

/* The part's own vertices and indices; how many vertices. */
static size_t take_out(work *w, const vv_mesh_part *part)
{
    const uint32_t *t = w->mesh->triangles + 3 * part->first_triangle;
    size_t n = 0;
    for (size_t k = 0; k < 3 * part->n_triangles; k++) {
        if (w->number[t[k]] == UINT32_MAX) {
            memcpy(w->positions + 3 * n, w->mesh->positions + 3 * (size_t)t[k], 3 * sizeof *w->positions);
            w->vertex[n] = t[k];
            w->number[t[k]] = (uint32_t)n++;
        }
        w->indices[k] = w->number[t[k]];
    }
    return n;
}

/* Of the budget, what falls to the triangles up to `triangle`. */
static uint64_t share(const work *w, size_t triangle)
{
    const double all = (double)w->mesh->n_triangles;
    return all > 0 ? (uint64_t)((double)w->options->triangles * ((double)triangle / all)) : 0;
}

/* Nothing solid has less than 4 triangles. */
static size_t target_of(const work *w, const vv_mesh_part *part, size_t n_triangles)
{
    const uint64_t budget = share(w, part->first_triangle + part->n_triangles) - share(w, part->first_triangle);
    const uint64_t least = w->options->triangles ? 4 : 0;
    const uint64_t target = budget > least ? budget : least;
    return target < n_triangles ? (size_t)target : n_triangles;
}

/* Edges that are nothing but rounding stand in the library's way, and so do vertices at one place. How many indices are
 * left. */
static vv_status weld_part(size_t *n_out, work *w, size_t n_indices, size_t n_vertices)
{
    vvi_weld weld = {.indices = w->indices,
                     .n_indices = n_indices,
                     .positions = w->positions,
                     .n_vertices = n_vertices,
                     .fix_border = w->fix_border};
    const vv_status st = vvi_weld_edges(&weld, vvi_tiny_edge(&weld), w->job);
    *n_out = weld.n_indices;
    return st == VV_OK ? vvi_tell_apart(w->positions, n_vertices, w->indices, weld.n_indices, w->job) : st;
}

/* The library lets surfaces come to touch themselves. `vertex` numbers of the part become those of the whole. */
static vv_status cut_part(work *w, uint32_t *indices, size_t *n_indices, size_t n_vertices)
{
    vvi_cut cut = {.indices = indices, .n_indices = *n_indices, .positions = w->positions, .n_vertices = n_vertices};
    const vv_status st = vvi_cut_apart(&cut, w->job);
    if (st != VV_OK)
        return st;
    const size_t n = w->n_copies + cut.n_copies, first = w->mesh->n_vertices + w->n_copies;
    uint32_t *copied = vvi_realloc(w->job, w->copied, (n + 1) * sizeof *copied, VVI_MEM_SCRATCH);
    w->copied = copied ? copied : w->copied;
    for (size_t i = 0; i < cut.n_copies && copied; i++)
        copied[w->n_copies++] = w->vertex[cut.copied[i]];
    for (size_t k = 0; k < cut.n_indices; k++)
        indices[k] = indices[k] < n_vertices ? w->vertex[indices[k]] : (uint32_t)(first + indices[k] - n_vertices);
    *n_indices = cut.n_indices;
    w->n_crowded += cut.n_crowded;
    vvi_free(cut.copied);
    return copied ? VV_OK : vv_fail_memory((n + 1) * sizeof *copied);
}

static vv_status fail_library(const vv_mesh_part *part)
{
    return vv_fail(VV_E_MEMORY, "there is not enough memory to simplify a mesh of %zu triangles", part->n_triangles);
}

/* Pieces ---------------------------------------------------------------------------------------------------------- */

/* Vertices at the same place are one: so that soups of triangles are the pieces that they look like. */
static vv_status find_pieces(work *w)
{
    uint32_t *place = NULL;
    vv_status st = vvi_number_places(&place, w->mesh->positions, w->mesh->n_vertices, w->job);
    if (st == VV_OK)
        st = vvi_mesh_number_placed_pieces(&w->piece, w->mesh, place, w->job);
    vvi_free(place);
    return st;
}

static bool is_triangle(const uint32_t t[3])
{
    return t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
}

/* The mesh's vertex, of one that may be a copy. */
static uint32_t original(const work *w, uint32_t v)
{
    return v < w->mesh->n_vertices ? v : w->copied[v - w->mesh->n_vertices];
}

static void mark_there(work *w, const uint32_t *indices, size_t n)
{
    for (size_t k = 0; k < n; k++)
        w->there[w->piece[original(w, indices[k])]] = 1;
}

/* The triangles of the part's pieces that have none in the new mesh yet, by the part's numbers, in w->indices. */
static size_t take_vanished(work *w, const vv_mesh_part *part, const vvi_simplify_call *call)
{
    const uint32_t *t = w->mesh->triangles + 3 * part->first_triangle;
    size_t n = 0;
    for (size_t k = 0; k < 3 * part->n_triangles; k++)
        w->there[w->piece[t[k]]] = 0;
    mark_there(w, call->out, call->n_out);
    for (size_t k = 0; k < 3 * part->n_triangles; k += 3)
        for (size_t i = 0; i < 3 && !w->there[w->piece[t[k]]] && is_triangle(t + k); i++)
            w->indices[n++] = w->number[t[k + i]];
    return n;
}

/* Triangles that shall be there, and pieces that are nothing but triangles of no area or back to back: these stay as
 * they were. */
static void keep_as_they_are(work *w, const vv_mesh_part *part, vvi_simplify_call *call)
{
    const size_t n = 3 * part->n_triangles;
    const uint32_t *t = w->mesh->triangles + 3 * part->first_triangle;
    for (size_t k = 0; k < n; k++)
        w->there[w->piece[t[k]]] = 0;
    mark_there(w, call->out, call->n_out);
    for (size_t k = 0; k < n && call->n_out < n; k += 3) {
        const size_t number = part->first_triangle + k / 3;
        if (w->there[w->piece[t[k]]] && !(w->options->keep && w->options->keep[number]))
            continue;
        memcpy(call->out + call->n_out, t + k, 3 * sizeof *t);
        call->n_out += 3;
    }
}

/* The library's error is no bound for what it lets vanish as a whole: that is given less and less, and then stays. */
static vv_status keep_pieces(work *w, const vv_mesh_part *part, vvi_simplify_call *call)
{
    enum { TRIES = 3 };
    vvi_simplify_call again = *call;
    vv_status st = VV_OK;
    again.target_indices = 0;
    for (int i = 0; i <= TRIES && st == VV_OK && (again.n_indices = take_vanished(w, part, call)) > 0; i++) {
        again.out = call->out + call->n_out;
        again.indices = w->indices;
        again.n_out = again.n_indices;
        again.error /= 4;
        if (i == TRIES)
            memcpy(again.out, w->indices, again.n_out * sizeof *again.out);
        else if (!vvi_simplify_with_library(&again))
            return fail_library(part);
        st = cut_part(w, again.out, &again.n_out, call->n_vertices);
        call->n_out += again.n_out;
        call->error_out = fmax(call->error_out, again.error_out);
    }
    if (st == VV_OK)
        keep_as_they_are(w, part, call);
    return st;
}

static bool stays(const work *w, const uint32_t t[3])
{
    const uint8_t *still = w->options->still;
    return still && (still[w->vertex[t[0]]] || still[w->vertex[t[1]]] || still[w->vertex[t[2]]]);
}

/* Triangles that stay go behind the room for the others, which the library gets without them: it leaves its border
 * alone. How many indices stay. */
static size_t set_aside(work *w, vvi_simplify_call *call)
{
    const size_t n = call->n_indices;
    size_t n_still = 0, n_loose = 0, to;
    for (size_t k = 0; k < n; k += 3)
        n_still += stays(w, w->indices + k) ? 3 : 0;
    to = n - n_still;
    for (size_t k = 0; k < n; k += 3) {
        uint32_t *at = stays(w, w->indices + k) ? call->out + to : w->indices + n_loose;
        memmove(at, w->indices + k, 3 * sizeof *at);
        if (at == call->out + to)
            to += 3;
        else
            n_loose += 3;
    }
    call->n_indices = n - n_still;
    call->target_indices -= n_still < call->target_indices ? n_still : call->target_indices;
    call->fix_border |= n_still > 0;
    return n_still;
}

static vv_status run_library(work *w, const vv_mesh_part *part, vvi_simplify_call *call)
{
    const size_t n_still = set_aside(w, call);
    if (call->n_indices && !vvi_simplify_with_library(call))
        return fail_library(part);
    memmove(call->out + call->n_out, call->out + call->n_indices, n_still * sizeof *call->out);
    call->n_out += n_still;
    return VV_OK;
}

static vv_status simplify_part(work *w, size_t index)
{
    const vv_mesh_part part = part_of(w->mesh, index);
    const size_t n = take_out(w, &part);
    size_t n_indices;
    vv_status st = weld_part(&n_indices, w, 3 * part.n_triangles, n);
    if (st != VV_OK)
        return st;
    vvi_simplify_call call = {.out = w->kept + w->n_kept,
                              .indices = w->indices,
                              .n_indices = n_indices,
                              .positions = w->positions,
                              .n_vertices = n,
                              .target_indices = target_of(w, &part, n_indices / 3) * 3,
                              .error = w->options->error > 0 ? w->options->error : INFINITY,
                              .fix_border = w->fix_border};
    if ((st = run_library(w, &part, &call)) != VV_OK || (st = cut_part(w, call.out, &call.n_out, n)) != VV_OK ||
        (w->options->error > 0 && (st = keep_pieces(w, &part, &call)) != VV_OK))
        return st;
    for (size_t v = 0; v < n; v++)
        w->number[w->vertex[v]] = UINT32_MAX;
    w->parts[index] = part;
    w->parts[index].first_triangle = w->n_kept / 3;
    w->parts[index].n_triangles = call.n_out / 3;
    w->n_kept += call.n_out;
    w->error = fmax(w->error, call.error_out);
    return w->options->uncounted ? vvi_job_poll(w->job)
                                 : vvi_job_progress(w->job, "simplify", index + 1, n_parts(w->mesh));
}

static vv_status simplify(vv_mesh **out, work *w)
{
    vv_status st = VV_OK;
    w->fix_border = parts_touch(w) || w->options->fix_border;
    st = find_pieces(w);
    for (size_t i = 0; i < n_parts(w->mesh) && st == VV_OK; i++)
        st = simplify_part(w, i);
    const vvi_chosen chosen = {.mesh = w->mesh,
                               .triangles = w->kept,
                               .n = w->n_kept / 3,
                               .copied = w->copied,
                               .n_copies = w->n_copies,
                               .parts = w->mesh->parts && w->mesh->n_parts ? w->parts : NULL};
    return st == VV_OK ? vvi_chosen_mesh(out, &chosen, w->job) : st;
}

static vv_status take_arrays(work *w)
{
    const size_t v = w->mesh->n_vertices + 1, t = 3 * w->mesh->n_triangles + 1;
    /* The library takes about 100 bytes a vertex and 30 an index, which nobody counts: they should at least be there.
     */
    const vv_status st = vvi_memory_plan(w->job, 120 * (uint64_t)v + 40 * (uint64_t)t, "simplifying a mesh");
    if (st != VV_OK)
        return st;
    w->number = vvi_alloc(w->job, v * sizeof *w->number, VVI_MEM_SCRATCH);
    w->vertex = vvi_alloc(w->job, v * sizeof *w->vertex, VVI_MEM_SCRATCH);
    w->positions = vvi_alloc(w->job, 3 * v * sizeof *w->positions, VVI_MEM_SCRATCH);
    w->indices = vvi_alloc(w->job, t * sizeof *w->indices, VVI_MEM_SCRATCH);
    w->kept = vvi_alloc(w->job, t * sizeof *w->kept, VVI_MEM_SCRATCH);
    w->there = vvi_alloc(w->job, v, VVI_MEM_SCRATCH);
    w->parts = vvi_alloc(w->job, n_parts(w->mesh) * sizeof *w->parts, VVI_MEM_SCRATCH);
    const bool all = w->number && w->vertex && w->positions && w->indices && w->kept && w->there && w->parts;
    return all ? VV_OK : vv_fail_memory(t * sizeof *w->indices);
}

static void give_back_arrays(work *w)
{
    vvi_free(w->number);
    vvi_free(w->vertex);
    vvi_free(w->positions);
    vvi_free(w->indices);
    vvi_free(w->kept);
    vvi_free(w->copied);
    vvi_free(w->piece);
    vvi_free(w->there);
    vvi_free(w->parts);
}

static vv_status check(const vvi_simplify_options *o)
{
    if (!vvi_can_simplify())
        return vv_fail(VV_E_UNSUPPORTED,
                       "simplify: this build has no meshoptimizer; install it (libmeshoptimizer-dev) and build again");
    if (!(o->error >= 0) || !isfinite(o->error))
        return vv_fail(VV_E_ARGUMENT, "simplify: an error of %g is not a length", o->error);
    if (o->triangles == 0 && !(o->error > 0))
        return vv_fail(VV_E_ARGUMENT, "simplify: give a number of triangles or an error, to say how far to simplify");
    return VV_OK;
}

vv_status vvi_mesh_simplify(vv_mesh **out, vvi_simplify_result *result_out, const vv_mesh *mesh,
                            const vvi_simplify_options *options, vv_job *job)
{
    work w = {.mesh = vv_mesh_get_info(mesh), .options = options, .job = job};
    vv_status st;
    *out = NULL;
    if ((st = check(options)) != VV_OK)
        return st;
    if ((st = take_arrays(&w)) == VV_OK)
        st = simplify(out, &w);
    if (st == VV_OK && result_out) {
        *result_out = (vvi_simplify_result){
            .n_triangles = w.n_kept / 3,
            .error = w.error,
            .n_crowded = w.n_crowded,
            .over_budget = options->triangles != 0 && w.n_kept / 3 > options->triangles,
        };
    }
    for (size_t k = 0; st == VV_OK && k < w.n_kept; k++)
        w.kept[k] = original(&w, w.kept[k]);
    if (st == VV_OK && options->corners)
        memcpy(options->corners, w.kept, w.n_kept * sizeof *w.kept);
    if (st == VV_OK && result_out && !options->uncounted)
        st = vvi_simplify_count_pieces(result_out, w.mesh, vv_mesh_get_info(*out), w.kept, job);
    give_back_arrays(&w);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
