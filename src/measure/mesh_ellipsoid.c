#include "measure/mesh_ellipsoid.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include <math.h>

enum { BLOCK = 4096 };

typedef struct run {
    const vv_mesh_info *mesh;
    vv_affine to_world, to_ball; /* of positions */
    vvi_mesh_inside *found;      /* one a block of triangles; volumes in the ball's unit */
} run;

typedef struct flat {
    double x, y;
} flat;

static double flat_cross(flat p, flat q)
{
    return p.x * q.y - p.y * q.x;
}

static double flat_dot(flat p, flat q)
{
    return p.x * q.x + p.y * q.y;
}

static flat along(flat p, flat q, double t)
{
    return (flat){p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
}

/* What a triangle and the ball's circle in its plane have in common: area, and solid angle from the ball's middle. */
typedef struct common {
    double area, angle;
    double high, square; /* of the plane above the middle, of the circle's radius */
} common;

static void add_triangle(common *c, flat p, flat q)
{
    const double cross = flat_cross(p, q), h = c->high;
    const double a = sqrt(h * h + flat_dot(p, p)), b = sqrt(h * h + flat_dot(q, q));
    c->area += cross / 2;
    c->angle += 2 * atan2(cross, a * b + h * (a + b) + h * h + flat_dot(p, q));
}

static void add_sector(common *c, flat p, flat q)
{
    const double turn = atan2(flat_cross(p, q), flat_dot(p, q));
    c->area += c->square * turn / 2;
    c->angle += (1 - c->high) * turn;
}

/* A side of the triangle, from the circle's middle: in the circle a triangle, outside a sector. */
static void add_side(common *c, flat p, flat q)
{
    const flat d = {q.x - p.x, q.y - p.y};
    const double dd = flat_dot(d, d), pd = flat_dot(p, d), root = pd * pd - dd * (flat_dot(p, p) - c->square);
    if (!(root > 0)) {
        add_sector(c, p, q);
        return;
    }
    const double t = fmin(1, fmax(0, (-pd - sqrt(root)) / dd)), u = fmin(1, fmax(0, (-pd + sqrt(root)) / dd));
    const flat in = along(p, q, t), out = along(p, q, u);
    if (t > 0)
        add_sector(c, p, in);
    add_triangle(c, in, out);
    if (u < 1)
        add_sector(c, out, q);
}

/* Of a triangle in the ball's space: the volume between its middle and the triangle within the ball. Which share of
 * its area is inside goes to *share. */
static double add_up(double *share, const vv_vec3 p[3])
{
    const vv_vec3 across = vvi_cross(vvi_sub(p[1], p[0]), vvi_sub(p[2], p[0]));
    const double twice = vvi_length(across), volume = vvi_dot(p[0], vvi_cross(p[1], p[2]));
    vv_vec3 n = across, right = vvi_sub(p[1], p[0]);
    flat q[3];
    double length[3];
    *share = 0;
    if (!(twice > 0))
        return 0;
    for (int i = 0; i < 3; i++)
        length[i] = vvi_length(p[i]);
    if (length[0] <= 1 && length[1] <= 1 && length[2] <= 1) {
        *share = 1;
        return volume / 6;
    }
    vvi_unit(&n);
    vvi_unit(&right);
    const vv_vec3 up = vvi_cross(n, right);
    const double high = vvi_dot(n, p[0]);
    common c = {.high = fabs(high), .square = 1 - high * high};
    for (int i = 0; i < 3; i++)
        q[i] = (flat){vvi_dot(p[i], right), vvi_dot(p[i], up)};
    for (int i = 0; c.square > 0 && i < 3; i++)
        add_side(&c, q[i], q[(i + 1) % 3]);
    *share = fmin(1, fmax(0, 2 * c.area / twice));
    if (high == 0) /* the middle is in its plane, which it sees from neither side */
        return 0;
    const double whole = 2 * atan2(fabs(volume), length[0] * length[1] * length[2] + vvi_dot(p[0], p[1]) * length[2] +
                                                     vvi_dot(p[1], p[2]) * length[0] + vvi_dot(p[2], p[0]) * length[1]);
    return (high * c.area + copysign(whole - c.angle, high)) / 3;
}

static vv_status sum_item(void *scratch, void *shared, size_t item)
{
    const run *r = shared;
    const size_t n = r->mesh->n_triangles, end = n - BLOCK * item < BLOCK ? n : BLOCK * (item + 1);
    vvi_mesh_inside *out = &r->found[item];
    *out = (vvi_mesh_inside){0};
    for (size_t t = BLOCK * item; t < end; t++) {
        vv_vec3 world[3], ball[3];
        double share;
        for (int i = 0; i < 3; i++) {
            const float *at = r->mesh->positions + 3 * (size_t)r->mesh->triangles[3 * t + (size_t)i];
            const vv_vec3 p = {(double)at[0], (double)at[1], (double)at[2]};
            world[i] = vv_affine_point(r->to_world, p);
            ball[i] = vv_affine_point(r->to_ball, p);
        }
        out->volume += add_up(&share, ball);
        out->area += share / 2 * vvi_length(vvi_cross(vvi_sub(world[1], world[0]), vvi_sub(world[2], world[0])));
        out->n_triangles += share > 0;
    }
    return VV_OK;
}

vv_status vvi_mesh_in_ellipsoid(vvi_mesh_inside *out, const vv_mesh *mesh, const vv_affine *to_world,
                                const vv_region_shape *ellipsoid, vv_job *job)
{
    const vvi_work work = {.stage = "measure", .item = sum_item};
    const vv_mesh_info *info = vv_mesh_get_info(mesh);
    const size_t n = (info->n_triangles + BLOCK - 1) / BLOCK;
    const vv_affine placed = {.axis = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .origin = info->origin};
    run r = {.mesh = info, .to_world = vv_affine_compose(*to_world, placed)};
    vv_affine ball = ellipsoid->frame, inverse;
    *out = (vvi_mesh_inside){0};
    for (int a = 0; a < 3; a++)
        ball.axis[a] = vvi_scaled(ball.axis[a], ellipsoid->half[a]);
    if (!vv_affine_invert(&inverse, ball))
        return vv_fail(VV_E_ARGUMENT, "the ellipsoid has no extent");
    r.to_ball = vv_affine_compose(inverse, r.to_world);
    r.found = vvi_alloc(job, (n + 1) * sizeof *r.found, VVI_MEM_SCRATCH);
    if (!r.found)
        return vv_fail_memory((n + 1) * sizeof *r.found);
    const vv_status st = vvi_parallel_for(job, &work, &r, n);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        out->n_triangles += r.found[i].n_triangles;
        out->area += r.found[i].area;
        out->volume += r.found[i].volume;
    }
    /* triangles that a mirror turns over turn back */
    out->volume *= fabs(vv_affine_determinant(ball)) * (vv_affine_determinant(r.to_ball) < 0 ? -1 : 1);
    vvi_free(r.found);
    return st;
}
