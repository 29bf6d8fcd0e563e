#include "gfx/lighting.h"
#include "gfx/mesh_look.h"
#include <volvis/image.h>

/* Places nearer to the eye's plane than this share of the mesh's reach are cut off. */
#define NEAREST 1e-6

double vvi_gfx_nearest(const vvi_gfx_draw *draw)
{
    return NEAREST * draw->reach;
}

static void store(float out[3], vv_vec3 v)
{
    out[0] = (float)v.x, out[1] = (float)v.y, out[2] = (float)v.z;
}

static void store_row(float out[4], const vv_affine *a, vv_vec3 direction)
{
    for (int k = 0; k < 3; k++)
        out[k] = (float)vvi_dot(direction, a->axis[k]);
    out[3] = (float)vvi_dot(direction, a->origin);
}

static vv_status prepare_projection(vvi_gfx_projection *p, vvi_gfx *gfx, const vvi_gfx_draw *draw)
{
    const vvi_gfx_view *view = draw->state.view;
    const vvi_gfx_cut_set *cuts = draw->state.cuts;
    const size_t bytes = (cuts->n_planes + 1) * sizeof *p->cuts;
    float(*planes)[4] = vvi_gfx_keep(gfx, bytes);
    if (!planes)
        return vv_fail_memory(bytes);
    *p = (vvi_gfx_projection){
        .scale = {(float)(view->scale_x * VVI_GFX_STEPS), (float)(view->scale_y * VVI_GFX_STEPS)},
        .middle = {(float)(view->middle_x * VVI_GFX_STEPS), (float)(view->middle_y * VVI_GFX_STEPS)},
        .nearest = (float)vvi_gfx_nearest(draw),
        .parallel = view->lens.parallel,
        .cuts = (const float(*)[4])planes,
        .n_cuts = cuts->n_planes};
    store_row(p->row[0], &draw->to_eye, view->lens.right);
    store_row(p->row[1], &draw->to_eye, view->lens.up);
    store_row(p->row[2], &draw->to_eye, view->lens.forward);
    for (size_t i = 0; i < cuts->n_planes; i++) {
        const vv_plane *plane = &cuts->planes[i];
        store_row(planes[i], &draw->to_eye, plane->normal);
        planes[i][3] = (float)(plane->offset - vvi_dot(plane->normal, view->lens.eye) -
                               vvi_dot(plane->normal, draw->to_eye.origin));
    }
    return VV_OK;
}

/* The cofactors of a map turn normals as it turns planes, but for a factor. */
static void store_normals(float out[3][3], const vv_affine *a, double side)
{
    const vv_vec3 column[3] = {vvi_cross(a->axis[1], a->axis[2]), vvi_cross(a->axis[2], a->axis[0]),
                               vvi_cross(a->axis[0], a->axis[1])};
    double most = 0;
    for (int k = 0; k < 3; k++)
        most = fmax(most, vvi_length(column[k]));
    for (int k = 0; k < 3; k++) {
        const vv_vec3 c = vvi_scaled(column[k], side / most);
        out[0][k] = (float)c.x, out[1][k] = (float)c.y, out[2][k] = (float)c.z;
    }
}

static void prepare_camera(vvi_gfx_lighting *g, const vvi_gfx_view *view)
{
    store(g->right, vvi_scaled(view->lens.right, 1 / view->scale_x));
    store(g->up, vvi_scaled(view->lens.up, 1 / view->scale_y));
    store(g->forward, view->lens.forward);
    g->middle[0] = (float)view->middle_x;
    g->middle[1] = (float)view->middle_y;
    g->parallel = view->lens.parallel;
}

static vv_status prepare_lamps(vvi_gfx_lighting *g, vvi_gfx *gfx, const vvi_gfx_draw *draw)
{
    const vvi_gfx_light_set *set = draw->state.lights;
    vvi_lamp *lamps = vvi_gfx_keep(gfx, (set->n_lamps + 1) * sizeof *lamps);
    if (!lamps)
        return vv_fail_memory((set->n_lamps + 1) * sizeof *lamps);
    for (size_t i = 0; i < set->n_lamps; i++)
        lamps[i] = vvi_lamp_from(&set->lamps[i], draw->state.view->lens.eye);
    g->lamps = lamps;
    g->n_lamps = set->n_lamps;
    return VV_OK;
}

/* The ramp at evenly spaced values between its ends. */
static vv_status prepare_ramp(vvi_gfx_lighting *g, vvi_gfx *gfx, const vvi_gfx_surface *surface)
{
    const size_t bytes = (size_t)3 * (VVI_GFX_RAMP + 1) * sizeof(float);
    float *ramp = surface->ramp ? vvi_gfx_keep(gfx, bytes) : NULL;
    if (!surface->ramp)
        return VV_OK;
    if (!ramp)
        return vv_fail_memory(bytes);
    const double lo = surface->ramp[0], hi = surface->ramp[4 * (surface->n_ramp - 1)],
                 step = (hi > lo ? hi - lo : 1) / (VVI_GFX_RAMP - 1);
    for (size_t i = 0; i <= VVI_GFX_RAMP; i++) {
        double rgb[3];
        vvi_gfx_ramp_color(rgb, surface, lo + step * (double)i);
        for (size_t c = 0; c < 3; c++)
            ramp[3 * i + c] = (float)rgb[c];
    }
    g->values = surface->mesh->values;
    g->ramp = ramp;
    g->ramp_scale = (float)(1 / step);
    g->ramp_lo = (float)lo;
    return VV_OK;
}

vv_status vvi_gfx_prepare(vvi_gfx_prepared **out, vvi_gfx *gfx, const vvi_gfx_draw *draw)
{
    const vv_mesh_info *mesh = draw->surface.mesh;
    const vvi_gfx_material *m = &draw->state.material;
    const vv_vec3 axis[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vvi_gfx_prepared *p = vvi_gfx_keep(gfx, sizeof *p);
    if (!p)
        return vv_fail_memory(sizeof *p);
    p->lighting = (vvi_gfx_lighting){.positions = mesh->positions,
                                     .normals = m->flat ? NULL : mesh->normals,
                                     .colors = draw->surface.one_color || draw->surface.textures ? NULL : mesh->colors,
                                     .triangles = mesh->triangles,
                                     .decode = p->decode,
                                     .opacity = (float)draw->surface.color.a,
                                     .nearest = (float)vvi_gfx_nearest(draw),
                                     .side = draw->mirrored ? -1 : 1,
                                     .model = m->model,
                                     .sides = m->sides,
                                     .gloss = vvi_gloss_of(m->model, m->ambient, m->diffuse, m->specular, m->shininess,
                                                           draw->state.lights->ambient)};
    for (int c = 0; c < 3; c++)
        store_row(p->lighting.to_eye[c], &draw->to_eye, axis[c]);
    store_normals(p->lighting.normal_to_world, &draw->to_eye, draw->mirrored ? -1 : 1);
    prepare_camera(&p->lighting, draw->state.view);
    for (int i = 0; i < 256; i++)
        p->decode[i] = (float)vv_srgb_decode(i / 255.0);
    vv_status st = prepare_projection(&p->projection, gfx, draw);
    *out = p;
    if (st == VV_OK)
        st = prepare_ramp(&p->lighting, gfx, &draw->surface);
    return st == VV_OK ? prepare_lamps(&p->lighting, gfx, draw) : st;
}
