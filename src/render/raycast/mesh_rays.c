/* Triangles along rays: places and colours as src/gfx has them, lit by the definition of local light. */
#include "render/raycast/mesh_rays.h"
#include "core/memory.h"
#include "core/status.h"
#include "core/vec.h"
#include "render/common/mesh_tree.h"
#include <math.h>
#include <string.h>
#include <volvis/image.h>

/* More than this is opaque: shares of corners add up to 1 but for rounding. */
#define OPAQUE 0.999

/* Opening --------------------------------------------------------------------------------------------------------- */

/* owner: which of the scene's it belongs to, or is. */
static vv_status open_mesh(vvi_ray_mesh *m, const vv_mesh_actor *actor, size_t owner, const vv_scene *scene,
                           vv_job *job)
{
    const vv_actor *look = &actor->look;
    *m = (vvi_ray_mesh){.actor = actor,
                        .id = (uint32_t)(scene->n_actors + owner + 1),
                        .gloss = vvi_gloss_of(look->shading_model, look->ambient, look->diffuse, look->specular,
                                              look->shininess, scene->ambient)};
    m->surface = vvi_gfx_surface_of(&m->shown, actor);
    vv_affine shifted = actor->place; /* of positions without the origin */
    shifted.origin = vv_affine_point(actor->place, m->shown.origin);
    m->to_world = shifted;
    if (!vv_affine_invert(&m->to_mesh, shifted))
        return vv_fail(VV_E_ARGUMENT, "volumes.%s.place: flattens the mesh; give it a scale other than 0", look->id);
    m->translucent = vvi_gfx_is_translucent(&m->surface);
    const vv_status st = vvi_mesh_tree_get(&m->tree, actor->mesh, job);
    if (st != VV_OK)
        return vv_fail_in(st, "volumes.%s", look->id);
    vvi_mesh_tree_box(m->lo, m->hi, m->tree);
    return VV_OK;
}

vv_status vvi_ray_meshes_open(vvi_ray_meshes *out, const vv_scene *scene, vv_job *job)
{
    *out = (vvi_ray_meshes){.scene = scene};
    if (!scene->n_mesh_actors)
        return VV_OK;
    vv_status st = vvi_mesh_caps_open(&out->caps, scene, job);
    const size_t n_own = scene->n_mesh_actors, n = n_own + out->caps.n, bytes = n * sizeof *out->mesh;
    if (st != VV_OK)
        return st;
    if (!(out->mesh = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    vvi_gfx_decode_init(&out->decode);
    out->view = vvi_gfx_view_of(&scene->lens, scene->width, scene->height);
    for (size_t i = 0; i < n; i++) {
        const bool own = i < n_own;
        const vv_mesh_actor *actor = own ? &scene->mesh_actors[i] : &out->caps.cap[i - n_own].actor;
        if (!vv_mesh_get_info(actor->mesh)->n_triangles)
            continue;
        if ((st = open_mesh(&out->mesh[out->n++], actor, own ? i : out->caps.cap[i - n_own].owner, scene, job)) !=
            VV_OK)
            return st;
        out->translucent |= out->mesh[out->n - 1].translucent;
    }
    return VV_OK;
}

void vvi_ray_meshes_close(vvi_ray_meshes *meshes)
{
    for (size_t i = 0; i < meshes->n; i++)
        vvi_cache_release(meshes->mesh[i].tree);
    vvi_free(meshes->mesh);
    vvi_mesh_caps_close(&meshes->caps);
    *meshes = (vvi_ray_meshes){0};
}

/* Hits ------------------------------------------------------------------------------------------------------------ */

/* A ray of a batch through one mesh. Floats begin where it enters the mesh's box, so that they lose nothing on the way
 * there. */
typedef struct passage {
    const vvi_ray_meshes *meshes;
    const vvi_ray_mesh *mesh;
    vv_vec3 origin, direction; /* world */
    double start;              /* distance that the tree's distances begin at */
    bool translucent;          /* which are looked for */
} passage;

static vv_vec3 point_at(const passage *p, double distance)
{
    return vvi_add(p->origin, vvi_scaled(p->direction, distance));
}

static void shares_of(double out[3], const vvi_mesh_hit *hit)
{
    out[0] = 1 - (double)hit->u - (double)hit->v;
    out[1] = (double)hit->u;
    out[2] = (double)hit->v;
}

/* Before light, with textures as a pixel sees them. */
static void color_at(double rgba[4], const passage *p, const vvi_mesh_hit *hit, const double share[3])
{
    const vvi_ray_mesh *m = p->mesh;
    const vv_mesh_info *info = m->surface.mesh;
    double slope[2][3];
    if (m->surface.textures) {
        vv_vec3 corner[3];
        for (size_t k = 0; k < 3; k++) {
            const float *at = info->positions + 3 * (size_t)info->triangles[3 * (size_t)hit->triangle + k];
            corner[k] = vv_affine_point(m->to_world, vvi_vec((double)at[0], (double)at[1], (double)at[2]));
        }
        vvi_gfx_share_slopes(slope, &p->meshes->view, p->origin, p->direction, corner);
    }
    vvi_gfx_color_at(rgba, &m->surface, &p->meshes->decode, hit->triangle, share,
                     m->surface.textures ? (const double(*)[3])slope : NULL);
}

static bool take(void *user, const vvi_mesh_hit *hit)
{
    const passage *p = user;
    const vv_actor *look = &p->mesh->actor->look;
    const vv_vec3 at = point_at(p, p->start + (double)hit->distance);
    for (size_t i = 0; i < look->n_planes; i++)
        if (vvi_dot(look->planes[i].normal, at) < look->planes[i].offset)
            return false;
    if (!p->mesh->translucent)
        return true;
    double rgba[4], share[3];
    shares_of(share, hit);
    color_at(rgba, p, hit, share);
    return p->translucent ? rgba[3] < OPAQUE && rgba[3] > 0 : rgba[3] >= OPAQUE;
}

/* The mesh's part of a ray; false: it passes beside its box. */
static bool enter(vvi_mesh_ray *out, passage *p, double near, double far)
{
    const vvi_ray_mesh *m = p->mesh;
    const vv_vec3 o = vv_affine_point(m->to_mesh, p->origin), d = vv_affine_vector(m->to_mesh, p->direction);
    const double origin[3] = {o.x, o.y, o.z}, direction[3] = {d.x, d.y, d.z};
    for (int a = 0; a < 3; a++) {
        const double lo = m->lo[a], hi = m->hi[a];
        if (direction[a] == 0) {
            if (origin[a] < lo || origin[a] > hi)
                return false;
            continue;
        }
        const double s = (lo - origin[a]) / direction[a], t = (hi - origin[a]) / direction[a];
        near = fmax(near, fmin(s, t));
        far = fmin(far, fmax(s, t));
    }
    if (!(far > near))
        return false;
    p->start = near;
    out->near = 0;
    out->far = (float)(far - near);
    for (int a = 0; a < 3; a++) {
        out->origin[a] = (float)(origin[a] + near * direction[a]);
        out->direction[a] = (float)direction[a];
    }
    return true;
}

/* Light ----------------------------------------------------------------------------------------------------------- */

static void shade(vvi_mesh_sink *out, size_t i, const passage *p, const vvi_mesh_hit *hit)
{
    const vv_scene *scene = p->meshes->scene;
    const double distance = p->start + (double)hit->distance;
    const vvi_gfx_surface *surface = &p->mesh->surface;
    const vv_vec3 to_eye = vvi_scaled(p->direction, -1);
    double rgba[4], share[3];
    vv_vec3 normal;
    shares_of(share, hit);
    color_at(rgba, p, hit, share);
    const bool known = vvi_gfx_normal_at(&normal, surface->mesh, &surface->place, hit->triangle, share, false);
    normal = !known ? vvi_vec(0, 0, 0) : vvi_dot(normal, to_eye) < 0 ? vvi_scaled(normal, -1) : normal;
    const vvi_light_volume *light = p->meshes->light;
    double arrives[VVI_LIGHT_SHARES];
    const vvi_lit_point point = {.position = point_at(p, distance),
                                 .normal = known ? normal : to_eye,
                                 .to_eye = to_eye,
                                 .surface = known,
                                 .arrives = light ? arrives : NULL,
                                 .n_arrive = VVI_LIGHT_SHARES};
    const bool unlit = p->mesh->actor->look.shading_model == VV_SHADING_NONE;
    if (light && !unlit)
        vvi_light_volume_at(arrives, light, point.position, normal);
    if (!unlit)
        vvi_light_ref(rgba, &point, &p->mesh->gloss, scene->lamps, scene->n_lamps);
    const double left = light && unlit ? vvi_light_scattered(light, point.position, normal) : 1;
    for (int c = 0; c < 3; c++)
        rgba[c] *= left;
    const double opacity = rgba[3] >= OPAQUE ? 1 : rgba[3];
    for (int c = 0; c < 3; c++)
        out->sink.rgb[c][i] = (float)(opacity * rgba[c]);
    out->sink.through[i] = (float)(1 - opacity);
    out->sink.depth[i] = (float)distance;
    out->id[i] = p->mesh->id;
    out->normal[0][i] = (float)normal.x, out->normal[1][i] = (float)normal.y, out->normal[2][i] = (float)normal.z;
}

/* Batches --------------------------------------------------------------------------------------------------------- */

/* The nearest hit of all meshes along one ray, and which mesh it is on. */
static bool find_nearest(passage *out, vvi_mesh_hit *hit_out, const vvi_ray_meshes *meshes, const vvi_rays *rays,
                         size_t i, bool translucent, double far)
{
    bool found = false;
    for (size_t m = 0; m < meshes->n; m++) {
        const vvi_ray_mesh *mesh = &meshes->mesh[m];
        passage p = {.meshes = meshes,
                     .mesh = mesh,
                     .origin = {rays->origin[0][i], rays->origin[1][i], rays->origin[2][i]},
                     .direction = {rays->direction[0][i], rays->direction[1][i], rays->direction[2][i]},
                     .translucent = translucent};
        vvi_mesh_ray ray;
        vvi_mesh_hit hit;
        const bool all = !mesh->translucent && !mesh->actor->look.n_planes;
        if ((translucent && !mesh->translucent) || !enter(&ray, &p, rays->near[i], far) ||
            !vvi_mesh_tree_hit(&hit, mesh->tree, &ray, all ? NULL : take, &p))
            continue;
        far = p.start + (double)hit.distance;
        *out = p;
        *hit_out = hit;
        found = true;
    }
    return found;
}

void vvi_ray_meshes_opaque(vvi_mesh_sink *inout, const vvi_ray_meshes *meshes, const vvi_rays *rays)
{
    for (size_t i = 0; i < rays->n; i++) {
        passage p;
        vvi_mesh_hit hit;
        const double far = fmin(rays->far[i], (double)inout->sink.depth[i]);
        if (rays->pixel[i] >= 0 && find_nearest(&p, &hit, meshes, rays, i, false, far))
            shade(inout, i, &p, &hit);
    }
}

size_t vvi_ray_meshes_translucent(vvi_mesh_sink *out, const vvi_ray_meshes *meshes, const vvi_rays *rays)
{
    size_t n = 0;
    for (size_t i = 0; i < rays->n; i++) {
        passage p;
        vvi_mesh_hit hit;
        out->sink.depth[i] = INFINITY;
        if (rays->pixel[i] < 0 || !find_nearest(&p, &hit, meshes, rays, i, true, rays->far[i]))
            continue;
        shade(out, i, &p, &hit);
        n++;
    }
    return n;
}
