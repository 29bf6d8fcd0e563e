#include "render/common/mesh_caps.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "grid/mesh.h"
#include "surface/clip.h"
#include <string.h>

/* Sections -------------------------------------------------------------------------------------------------------- */

/* Where a plane cuts a mesh; the mesh NULL: nowhere. */
typedef struct section {
    vv_mesh *mesh;
    bool whole; /* it closes everywhere */
} section;

typedef struct wanted {
    const vv_mesh_actor *actor;
    vv_plane plane; /* in the mesh's space */
} wanted;

static void drop(void *value)
{
    section *s = value;
    vv_mesh_release(s->mesh);
    vvi_free(s);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const wanted *w = user;
    size_t n_gaps;
    section *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_DERIVED);
    if (!s)
        return vv_fail_memory(sizeof *s);
    const vv_status st = vvi_mesh_section(&s->mesh, &n_gaps, w->actor->mesh, &w->plane, job);
    s->whole = n_gaps == 0;
    if (st != VV_OK) {
        drop(s);
        return st;
    }
    if (n_gaps)
        vvi_log(job, VV_LOG_WARNING, "render",
                "volumes.%s: the mesh is open where a plane cuts it, in %zu places: it is hollow there, as only closed "
                "surfaces have an inside to show",
                w->actor->look.id, n_gaps);
    *value_out = s;
    *bytes_out = sizeof *s + (s->mesh ? vvi_mesh_bytes(s->mesh) : 0);
    return VV_OK;
}

/* Told once of a mesh: where a plane cuts it all round, one does not see that it ends elsewhere. */
static vv_status make_rim(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    const vv_mesh_actor *actor = user;
    vv_mesh_topology *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_DERIVED);
    if (!t)
        return vv_fail_memory(sizeof *t);
    const vv_status st = vv_mesh_count_topology(t, actor->mesh, job);
    if (st != VV_OK) {
        vvi_free(t);
        return st;
    }
    if (t->n_open_edges)
        vvi_log(job, VV_LOG_WARNING, "render",
                "volumes.%s: the mesh is open (%zu edges belong to one triangle only), so that it has no inside; where "
                "a plane cuts it all round it has a face as if it were closed, which shading.cap=false leaves out",
                actor->look.id, t->n_open_edges);
    *value_out = t;
    *bytes_out = sizeof *t;
    return VV_OK;
}

static vv_status tell_of_rim(const vv_mesh_actor *actor, vv_job *job)
{
    struct vvi_cached *rim;
    const vvi_cache_key key = {"mesh rim", 0, vv_mesh_checksum(actor->mesh)};
    const vv_status st = vvi_cache_get(&rim, &key, make_rim, vvi_free, (void *)(uintptr_t)actor, job);
    if (st == VV_OK)
        vvi_cache_release(rim);
    return st;
}

static vv_status find_section(struct vvi_cached **out, const vv_mesh_actor *actor, const vv_plane *plane, vv_job *job)
{
    wanted w = {actor, vvi_plane_mapped(plane, &actor->place)};
    const double numbers[4] = {w.plane.normal.x, w.plane.normal.y, w.plane.normal.z, w.plane.offset};
    const vvi_cache_key key = {"mesh section", 0, vvi_hash(numbers, sizeof numbers, vv_mesh_checksum(actor->mesh))};
    return vvi_cache_get(out, &key, make, drop, &w, job);
}

/* Faces ----------------------------------------------------------------------------------------------------------- */

static bool is_same(const vv_plane *a, const vv_plane *b)
{
    return a->offset == b->offset && a->normal.x == b->normal.x && a->normal.y == b->normal.y &&
           a->normal.z == b->normal.z;
}

/* The section's parts in the colours in which the mesh is shown. */
static vv_status color_parts(vv_mesh_actor *cap, const vv_mesh_actor *actor, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(cap->mesh);
    const vv_mesh_part *shown = actor->parts ? actor->parts : vv_mesh_get_info(actor->mesh)->parts;
    const size_t bytes = m->n_parts * sizeof *m->parts;
    if (!m->n_parts)
        return VV_OK;
    vv_mesh_part *parts = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    cap->parts = parts;
    if (!parts)
        return vv_fail_memory(bytes);
    memcpy(parts, m->parts, bytes);
    for (size_t i = 0; i < m->n_parts; i++) { /* that of an image's part is a factor of it */
        parts[i].color = shown[i].color;
        if (shown[i].texture)
            parts[i].color.a = -1;
    }
    return VV_OK;
}

/* All planes but those that lie where this one does. */
static vv_status take_planes(vv_mesh_actor *cap, const vv_actor *look, size_t plane, vv_job *job)
{
    cap->look.n_planes = 0;
    cap->look.planes = vvi_alloc(job, look->n_planes * sizeof *look->planes, VVI_MEM_SCRATCH);
    if (!cap->look.planes)
        return vv_fail_memory(look->n_planes * sizeof *look->planes);
    for (size_t i = 0; i < look->n_planes; i++)
        if (!is_same(&look->planes[i], &look->planes[plane]))
            cap->look.planes[cap->look.n_planes++] = look->planes[i];
    return VV_OK;
}

static vv_status add_cap(vvi_mesh_caps *caps, const vv_scene *scene, size_t owner, size_t plane, vv_job *job)
{
    const vv_mesh_actor *actor = &scene->mesh_actors[owner];
    struct vvi_cached *cached;
    for (size_t i = 0; i < plane; i++)
        if (is_same(&actor->look.planes[i], &actor->look.planes[plane]))
            return VV_OK;
    vv_status st = find_section(&cached, actor, &actor->look.planes[plane], job);
    if (st != VV_OK)
        return vv_fail_in(st, "volumes.%s", actor->look.id);
    const section *s = vvi_cached_value(cached);
    vv_mesh *mesh = s->mesh;
    if (!mesh || (s->whole && (st = tell_of_rim(actor, job)) != VV_OK)) {
        vvi_cache_release(cached);
        return st;
    }
    caps->cap[caps->n] = (vvi_mesh_cap){.actor = *actor, .owner = owner, .section = cached};
    vv_mesh_actor *cap = &caps->cap[caps->n++].actor;
    cap->mesh = mesh;
    cap->colors = NULL;
    cap->parts = NULL;
    cap->textures = NULL;
    cap->look.planes = NULL;
    st = take_planes(cap, &actor->look, plane, job);
    return st == VV_OK ? color_parts(cap, actor, job) : st;
}

vv_status vvi_mesh_caps_open(vvi_mesh_caps *out, const vv_scene *scene, vv_job *job)
{
    size_t n = 0;
    vv_status st = VV_OK;
    *out = (vvi_mesh_caps){0};
    for (size_t i = 0; i < scene->n_mesh_actors; i++)
        n += scene->mesh_actors[i].look.cap ? scene->mesh_actors[i].look.n_planes : 0;
    if (!n)
        return VV_OK;
    out->cap = vvi_alloc_zeroed(job, n * sizeof *out->cap, VVI_MEM_SCRATCH);
    if (!out->cap)
        return vv_fail_memory(n * sizeof *out->cap);
    for (size_t i = 0; i < scene->n_mesh_actors; i++) {
        const vv_actor *look = &scene->mesh_actors[i].look;
        for (size_t p = 0; look->cap && p < look->n_planes && st == VV_OK; p++)
            st = add_cap(out, scene, i, p, job);
    }
    return st;
}

void vvi_mesh_caps_close(vvi_mesh_caps *caps)
{
    for (size_t i = 0; i < caps->n; i++) {
        vvi_cache_release(caps->cap[i].section);
        vvi_free(caps->cap[i].actor.look.planes);
        vvi_free((void *)caps->cap[i].actor.parts);
    }
    vvi_free(caps->cap);
    *caps = (vvi_mesh_caps){0};
}
