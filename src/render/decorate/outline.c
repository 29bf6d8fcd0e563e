/* The edges of volumes, and where cut planes go through them: lines in the World, hidden by what is before them. */
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include "scene/resolve.h"
#include <math.h>
#include <string.h>

#define TOWARDS_EYE 0.75 /* voxels: lines that lie in a surface are seen */
#define OF_MESHES 0.002  /* of the box's diagonal: the same */

size_t vvi_sheet_things(const vvi_sheet *s)
{
    return s->scene->n_actors + s->scene->n_mesh_actors;
}

double vvi_sheet_corners(vv_vec3 out[8], const vvi_sheet *s, size_t i)
{
    if (i < s->scene->n_actors) {
        vvi_actor_corners(out, &s->scene->actors[i]);
        return TOWARDS_EYE * vvi_actor_voxel(&s->scene->actors[i]);
    }
    vvi_shape_corners(out, &s->scene->mesh_actors[i - s->scene->n_actors]);
    return OF_MESHES * vvi_length(vvi_sub(out[7], out[0]));
}

/* A point drawn a little before where it is, on the same pixel. */
static vv_vec3 lifted(const vvi_sheet *s, double lift, vv_vec3 p)
{
    const vv_lens *lens = &s->scene->lens;
    vv_vec3 to_eye = vvi_scaled(lens->forward, -1);
    if (!lens->parallel) {
        to_eye = vvi_sub(lens->eye, p);
        const double distance = vvi_length(to_eye);
        if (!(distance > 2 * lift))
            return p;
        to_eye = vvi_scaled(to_eye, 1 / distance);
    }
    return vvi_add(p, vvi_scaled(to_eye, lift));
}

/* Whether a face of the box looks to the eye: the one that goes through corner `bits` and not along axis `a`. */
static bool faces_eye(const vvi_sheet *s, const vv_vec3 c[8], int a, bool far)
{
    const vv_lens *lens = &s->scene->lens;
    const int u = 1 << (a + 1) % 3, v = 1 << (a + 2) % 3, at = far ? 1 << a : 0;
    vv_vec3 out = vvi_cross(vvi_sub(c[at | u], c[at]), vvi_sub(c[at | v], c[at]));
    if (vvi_dot(out, vvi_sub(c[at], c[at ^ (1 << a)])) < 0)
        out = vvi_scaled(out, -1);
    return vvi_dot(out, lens->parallel ? vvi_scaled(lens->forward, -1) : vvi_sub(lens->eye, c[at])) > 0;
}

void vvi_sheet_edges(vv_vec3 behind[24], size_t *n_behind, vv_vec3 others[24], size_t *n_others, const vvi_sheet *s,
                     size_t thing)
{
    vv_vec3 c[8];
    const double lift = vvi_sheet_corners(c, s, thing);
    *n_behind = *n_others = 0;
    for (int k = 0; k < 12; k++) {
        const int a = k / 4, u = (a + 1) % 3, v = (a + 2) % 3;
        const int from = (k & 1 ? 1 << u : 0) | (k & 2 ? 1 << v : 0);
        const bool hidden = !faces_eye(s, c, u, k & 1) && !faces_eye(s, c, v, k & 2);
        vv_vec3 *to = hidden ? behind + *n_behind : others + *n_others;
        *(hidden ? n_behind : n_others) += 2;
        to[0] = lifted(s, lift, c[from]);
        to[1] = lifted(s, lift, c[from | 1 << a]);
    }
}

/* What projects (a maximum along rays, a mean) has no surface that could hide lines: edges behind the box are then
 * under the picture, and all others over it. */
vv_status vvi_sheet_box(const vvi_sheet *s)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < vvi_sheet_things(s) && st == VV_OK; i++) {
        vv_vec3 behind[24], others[24];
        size_t n_behind, n_others;
        vvi_sheet_edges(behind, &n_behind, others, &n_others, s, i);
        st = vvi_sheet_line(s, behind, n_behind, s->line);
        vvi_gfx_depth(s->gfx, !s->projects);
        if (st == VV_OK)
            st = vvi_sheet_line(s, others, n_others, s->line);
        vvi_gfx_depth(s->gfx, true);
    }
    return st;
}

/* Cut planes ------------------------------------------------------------------------------------------------------ */

/* What of a convex polygon lies in a half-space (Sutherland & Hodgman 1974). */
static size_t clip(vv_vec3 out[VVI_CUT_CORNERS], const vv_vec3 *in, size_t n, const vv_plane *keep)
{
    size_t n_out = 0;
    for (size_t i = 0; i < n && n_out + 2 <= VVI_CUT_CORNERS; i++) {
        const vv_vec3 p = in[i], q = in[(i + 1) % n];
        const double a = vvi_dot(keep->normal, p) - keep->offset, b = vvi_dot(keep->normal, q) - keep->offset;
        if (a >= 0)
            out[n_out++] = p;
        if ((a < 0 && b > 0) || (a > 0 && b < 0))
            out[n_out++] = vvi_add(p, vvi_scaled(vvi_sub(q, p), a / (a - b)));
    }
    return n_out;
}

/* A square in the plane, larger than the box. */
static void square_in(vv_vec3 out[4], const vv_plane *plane, vv_vec3 middle, double reach)
{
    const vv_vec3 n = plane->normal;
    const vv_vec3 other = fabs(n.x) < 0.6 ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    vv_vec3 u = vvi_cross(n, other);
    vvi_unit(&u);
    const vv_vec3 v = vvi_cross(n, u);
    const vv_vec3 foot = vvi_add(middle, vvi_scaled(n, plane->offset - vvi_dot(n, middle)));
    for (int i = 0; i < 4; i++) {
        const double a = i == 0 || i == 3 ? -reach : reach, b = i < 2 ? -reach : reach;
        out[i] = vvi_add(foot, vvi_add(vvi_scaled(u, a), vvi_scaled(v, b)));
    }
}

/* The box's six sides, each looking inwards. */
static void sides_of(vv_plane out[6], const vv_vec3 c[8], vv_vec3 middle)
{
    for (int a = 0; a < 3; a++) {
        const int along = 1 << (a + 1) % 3, across = 1 << (a + 2) % 3;
        for (int far = 0; far < 2; far++) {
            const vv_vec3 p = c[far ? 1 << a : 0];
            vv_vec3 n = vvi_cross(vvi_sub(c[along], c[0]), vvi_sub(c[across], c[0]));
            vvi_unit(&n);
            if (vvi_dot(n, vvi_sub(middle, p)) < 0)
                n = vvi_scaled(n, -1);
            out[2 * a + far] = (vv_plane){n, vvi_dot(n, p)};
        }
    }
}

size_t vvi_cut_outline(vv_vec3 out[VVI_CUT_CORNERS], const vv_vec3 corners[8], const vv_plane *plane,
                       const vv_plane *others, size_t n_others)
{
    vv_vec3 other[VVI_CUT_CORNERS];
    vv_plane sides[6];
    const vv_vec3 middle = vvi_scaled(vvi_add(corners[0], corners[7]), 0.5);
    double reach = 0;
    size_t n = 4;
    for (int i = 0; i < 8; i++)
        reach = fmax(reach, vvi_length(vvi_sub(corners[i], middle)));
    square_in(out, plane, middle, 4 * reach);
    sides_of(sides, corners, middle);
    for (size_t i = 0; i < 6 + n_others && n >= 3; i++) {
        const vv_plane *keep = i < 6 ? &sides[i] : &others[i - 6];
        if (keep == plane)
            continue;
        n = clip(other, out, n, keep);
        memcpy(out, other, n * sizeof *out);
    }
    return n >= 3 ? n : 0;
}

vv_status vvi_sheet_cut_planes(const vvi_sheet *s)
{
    const vv_color color = {0.95, 0.26, 0.05, 1};
    vv_status st = VV_OK;
    vvi_gfx_depth(s->gfx, !s->projects);
    for (size_t i = 0; i < vvi_sheet_things(s); i++) {
        const size_t n_actors = s->scene->n_actors;
        const vv_actor *actor = i < n_actors ? &s->scene->actors[i] : &s->scene->mesh_actors[i - n_actors].look;
        vv_vec3 c[8], outline[VVI_CUT_CORNERS];
        const double lift = vvi_sheet_corners(c, s, i);
        for (size_t p = 0; p < actor->n_planes && st == VV_OK; p++) {
            const size_t n = vvi_cut_outline(outline, c, &actor->planes[p], actor->planes, actor->n_planes);
            for (size_t k = 0; k < n; k++)
                outline[k] = lifted(s, lift, outline[k]);
            const vvi_gfx_stroke stroke = {.color = color, .width = 1.5 * s->line};
            if (n)
                st = vvi_gfx_line(s->gfx, outline, n, VVI_GFX_LOOP, &stroke);
        }
    }
    vvi_gfx_depth(s->gfx, true);
    return st;
}
