/* From a depth to what is there. */
#include "render/pixel_value.h"
#include "core/job.h"
#include "core/memory.h"
#include "render/common/shade_ref.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include "scene/transfer.h"

/* Depths are floats: what lies on a face may seem to lie this far beyond it. Voxels, and shares of the depth. */
#define SLACK_VOXELS 1e-3
#define SLACK_DEPTH 2.4e-7
/* How far beyond a depth a surface is surely in what it is the surface of; voxels. */
#define BEHIND 0.01

static vv_status open_volume(vvi_sight_volume *v, const vv_actor *actor, vv_job *job)
{
    v->actor = actor;
    v->voxel = vvi_actor_voxel(actor);
    if (!vv_affine_invert(&v->world_to_index, actor->index_to_world))
        return vv_fail(VV_E_UNSUPPORTED, "volume '%s' has no thickness, so its visible part cannot be determined",
                       actor->id);
    const int64_t *dims = vv_field_get_info(actor->field)->grid.dims;
    const double reach = actor->nearest ? 0.5 : 0;
    for (int a = 0; a < 3; a++) {
        v->lo[a] = -reach;
        v->hi[a] = (double)(dims[a] - 1) + reach;
    }
    const vv_status st = vvi_probe_open(&v->probe, actor->field, actor->component, actor->nearest, job);
    v->probe.labels = actor->classes.kind == VV_SEGMENT_LABELS;
    return st;
}

vv_status vvi_sight_open(vvi_sight *out, const vv_scene *scene, vv_job *job)
{
    vv_status st = VV_OK;
    *out = (vvi_sight){.scene = scene};
    out->volumes = vvi_alloc_zeroed(job, (scene->n_actors + 1) * sizeof *out->volumes, VVI_MEM_SCRATCH);
    if (!out->volumes)
        return vv_fail_memory((scene->n_actors + 1) * sizeof *out->volumes);
    for (; out->n_volumes < scene->n_actors && st == VV_OK; out->n_volumes += st == VV_OK)
        st = open_volume(&out->volumes[out->n_volumes], &scene->actors[out->n_volumes], job);
    for (size_t i = 0; i < out->n_volumes; i++)
        out->volumes[i].layer = vvi_actor_projects(scene, &scene->actors[i]);
    if (st != VV_OK)
        vvi_sight_close(out);
    return st;
}

void vvi_sight_close(vvi_sight *sight)
{
    for (size_t i = 0; i < sight->n_volumes; i++)
        vvi_probe_close(&sight->volumes[i].probe);
    vvi_free(sight->volumes);
    sight->volumes = NULL;
}

typedef struct ray {
    vv_vec3 origin, direction; /* direction: length 1 */
    double depth, slack;       /* slack: of the depth, world */
} ray;

static vv_vec3 point_at(const ray *r, double t)
{
    return vvi_add(r->origin, vvi_scaled(r->direction, t));
}

static void index_of(double out[3], const vvi_sight_volume *v, vv_vec3 world)
{
    const vv_vec3 p = vv_affine_point(v->world_to_index, world);
    out[0] = p.x;
    out[1] = p.y;
    out[2] = p.z;
}

/* Within the samples and what no plane cuts away. */
static bool contains(const vvi_sight_volume *v, const ray *r)
{
    const vv_vec3 world = point_at(r, r->depth);
    const double slack = SLACK_VOXELS + r->slack / v->voxel;
    double p[3];
    index_of(p, v, world);
    for (int a = 0; a < 3; a++)
        if (!(p[a] >= v->lo[a] - slack && p[a] <= v->hi[a] + slack))
            return false;
    for (size_t i = 0; i < v->actor->n_planes; i++)
        if (vvi_dot(v->actor->planes[i].normal, world) < v->actor->planes[i].offset - slack * v->voxel)
            return false;
    return true;
}

/* Where the ray enters and through what, looking inwards; the ray's own direction where it begins inside. */
static double entry_of(vv_vec3 *inwards_out, const vvi_sight_volume *v, const ray *r)
{
    const vv_vec3 o = vv_affine_point(v->world_to_index, r->origin),
                  d = vv_affine_vector(v->world_to_index, r->direction);
    const double from[3] = {o.x, o.y, o.z}, step[3] = {d.x, d.y, d.z};
    const vv_vec3 *axis = v->world_to_index.axis;
    const vv_vec3 rows[3] = {
        {axis[0].x, axis[1].x, axis[2].x}, {axis[0].y, axis[1].y, axis[2].y}, {axis[0].z, axis[1].z, axis[2].z}};
    double entry = 0;
    *inwards_out = r->direction;
    for (int a = 0; a < 3; a++) {
        const double t = ((step[a] > 0 ? v->lo[a] : v->hi[a]) - from[a]) / step[a];
        if (step[a] != 0 && t >= entry) {
            entry = t;
            *inwards_out = vvi_scaled(rows[a], step[a] > 0 ? 1 : -1);
        }
    }
    for (size_t i = 0; i < v->actor->n_planes; i++) {
        const vv_plane *p = &v->actor->planes[i];
        const double along = vvi_dot(p->normal, r->direction), t = (p->offset - vvi_dot(p->normal, r->origin)) / along;
        if (along > 0 && t >= entry) {
            entry = t;
            *inwards_out = p->normal;
        }
    }
    vvi_unit(inwards_out);
    return entry;
}

/* Also a little behind, since a surface has values on both its sides. */
static double extinction(const vvi_sight_volume *v, const ray *r)
{
    double largest = 0;
    for (int i = 0; i < 2; i++) {
        double p[3], rgbk[4];
        index_of(p, v, point_at(r, r->depth + i * BEHIND * v->voxel));
        vvi_transfer_evaluate(rgbk, &v->actor->classes, vvi_probe_value(&v->probe, p));
        largest = fmax(largest, rgbk[3]);
    }
    return largest;
}

/* Whether a layer has found its value here, if that hides half of what is below. */
static bool hides(const vvi_sight_volume *v, const ray *r)
{
    const vv_actor *actor = v->actor;
    double p[3], rgbk[4];
    if (!v->layer || actor->layer.blend == VV_SLICE_ADD || !contains(v, r))
        return false;
    index_of(p, v, point_at(r, r->depth));
    vvi_transfer_evaluate(rgbk, &actor->classes, vvi_probe_value(&v->probe, p));
    return -expm1(-rgbk[3] * actor->classes.opacity_length) * actor->layer.opacity >= 0.5 - 1e-6;
}

static const vvi_sight_volume *choose(const vvi_sight *sight, const ray *r)
{
    for (size_t i = sight->n_volumes; i-- > 0;)
        if (hides(&sight->volumes[i], r))
            return &sight->volumes[i];
    const vvi_sight_volume *best = NULL;
    double most = -1;
    for (size_t i = 0; i < sight->n_volumes; i++) {
        const vvi_sight_volume *v = &sight->volumes[i];
        const double k = !contains(v, r) ? -1 : sight->n_volumes == 1 || v->layer ? 0 : extinction(v, r);
        if (k > most) {
            most = k;
            best = v;
        }
    }
    return best;
}

/* Inverse transpose of index -> world. */
static vv_vec3 to_world(const vvi_sight_volume *v, vv_vec3 g)
{
    const vv_vec3 *m = v->world_to_index.axis; /* columns: m[a] is what world axis a is in index space */
    return vvi_vec(vvi_dot(m[0], g), vvi_dot(m[1], g), vvi_dot(m[2], g));
}

static vv_vec3 normal_of(const vvi_sight_volume *v, const ray *r, vv_vec3 gradient)
{
    vv_vec3 inwards, n = vvi_scaled(gradient, -1);
    if (fabs(r->depth - entry_of(&inwards, v, r)) <= r->slack)
        return vvi_scaled(inwards, -1);
    if (!(vvi_length(gradient) >= vvi_shade_flat(v->actor)) || !vvi_unit(&n))
        return vvi_vec(0, 0, 0);
    return vvi_dot(n, r->direction) > 0 ? vvi_scaled(n, -1) : n;
}

static ray find_ray(const vvi_sight *sight, double x, double y, double depth)
{
    const vv_scene *scene = sight->scene;
    ray r = {.depth = depth, .slack = SLACK_DEPTH * fabs(depth)};
    vvi_lens_ray(&r.origin, &r.direction, &scene->lens, scene->width, scene->height, x, y);
    return r;
}

/* v NULL: no volume is there. */
static void see(vvi_seen *out, const vvi_sight *sight, const vvi_sight_volume *v, const ray *r)
{
    double p[3];
    *out = (vvi_seen){.world = point_at(r, r->depth), .value = NAN};
    if (!v)
        return;
    index_of(p, v, out->world);
    out->actor = v->actor;
    out->id = (uint32_t)(v - sight->volumes) + 1;
    out->index = vvi_vec(p[0], p[1], p[2]);
    out->value = vvi_probe_value(&v->probe, p);
    const bool labelled = v->probe.labels || vv_field_get_info(v->actor->field)->meaning == VV_MEANING_LABEL;
    if (!labelled || !vvi_probe_label(&out->label, &v->probe, p))
        out->label = 0;
    out->gradient = to_world(v, vvi_probe_gradient(&v->probe, p));
    out->normal = normal_of(v, r, out->gradient);
}

void vvi_sight_at(vvi_seen *out, const vvi_sight *sight, double x, double y, double depth)
{
    const ray r = find_ray(sight, x, y, depth);
    see(out, sight, choose(sight, &r), &r);
}

void vvi_sight_of(vvi_seen *out, const vvi_sight *sight, uint32_t id, double x, double y, double depth)
{
    const ray r = find_ray(sight, x, y, depth);
    see(out, sight, id > 0 && id <= sight->n_volumes ? &sight->volumes[id - 1] : NULL, &r);
}

/* Layers ---------------------------------------------------------------------------------------------------------- */

typedef struct filling {
    vv_image *image;
    const vvi_sight *sight;
    const vv_job *job;
} filling;

static vv_status fill_row(void *scratch, void *user, size_t y)
{
    const filling *f = user;
    const vv_image *image = f->image;
    (void)scratch;
    for (int32_t x = 0; x < image->width; x++) {
        const size_t at = y * (size_t)image->width + (size_t)x;
        vvi_seen seen;
        if (!isfinite(image->depth[at]) || (image->id && image->id[at] > f->sight->scene->n_actors))
            continue; /* nothing, or a mesh: the renderer's */
        vvi_sight_at(&seen, f->sight, x + 0.5, (double)(y + (size_t)f->sight->scene->top) + 0.5,
                     (double)image->depth[at]);
        if (image->normal && !(f->sight->scene->renderer->can & VV_CAN_NORMALS)) {
            image->normal[3 * at] = (float)seen.normal.x;
            image->normal[3 * at + 1] = (float)seen.normal.y;
            image->normal[3 * at + 2] = (float)seen.normal.z;
        }
        if (image->id)
            image->id[at] = seen.id;
        if (image->value)
            image->value[at] = (float)seen.value;
    }
    return vvi_job_poll(f->job);
}

vv_status vvi_layers_fill(vv_image *image, const vv_scene *scene, vv_job *job)
{
    static const vvi_work work = {.item = fill_row};
    vvi_sight sight;
    if (!image->depth || !(image->normal || image->id || image->value) || scene->renderer->can & VV_CAN_LAYERS)
        return VV_OK;
    vv_status st = vvi_sight_open(&sight, scene, job);
    if (st != VV_OK)
        return st;
    st = vvi_parallel_for(job, &work, &(filling){image, &sight, job}, (size_t)image->height);
    vvi_sight_close(&sight);
    return st;
}
