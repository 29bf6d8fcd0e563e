#include "manipulate/navigate.h"

#define HIGHEST (89.9 / 180 * M_PI)
#define NEAREST 1e-12 /* distances to the pivot and heights stay above */

vv_vec3 vvi_pose_right(const vvi_pose *pose)
{
    return vvi_turned(pose->turn, vvi_vec(1, 0, 0));
}

vv_vec3 vvi_pose_up(const vvi_pose *pose)
{
    return vvi_turned(pose->turn, vvi_vec(0, 1, 0));
}

vv_vec3 vvi_pose_forward(const vvi_pose *pose)
{
    return vvi_turned(pose->turn, vvi_vec(0, 0, -1));
}

double vvi_pose_distance(const vvi_pose *pose)
{
    return vvi_length(vvi_sub(pose->pivot, pose->eye));
}

double vvi_pose_extent(const vvi_pose *pose)
{
    return pose->parallel ? pose->height : 2 * tan(pose->fov / 2) * vvi_pose_distance(pose);
}

static bool equal(vv_vec3 a, vv_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

bool vvi_pose_equal(const vvi_pose *a, const vvi_pose *b)
{
    return equal(a->eye, b->eye) && equal(a->pivot, b->pivot) && a->turn.w == b->turn.w && a->turn.x == b->turn.x &&
           a->turn.y == b->turn.y && a->turn.z == b->turn.z && a->parallel == b->parallel && a->fov == b->fov &&
           a->height == b->height;
}

vvi_pose vvi_pose_turned(const vvi_pose *pose, vvi_quaternion world_turn)
{
    const vvi_quaternion back = vvi_turn_back(world_turn);
    vvi_pose p = *pose;
    p.turn = vvi_turn_unit(vvi_turn_after(back, pose->turn));
    p.eye = vvi_add(pose->pivot, vvi_turned(back, vvi_sub(pose->eye, pose->pivot)));
    return p;
}

vvi_pose vvi_orbit(const vvi_pose *pose, double dx, double dy, vv_vec3 up)
{
    const double sine = -vvi_dot(vvi_pose_forward(pose), up);
    const double elevation = asin(fmin(fmax(sine, -1), 1));
    const double wanted = fmin(fmax(elevation - M_PI * dy, -HIGHEST), HIGHEST);
    vv_vec3 across = vvi_cross(vvi_pose_forward(pose), up);
    if (!vvi_unit(&across)) /* straight from above or below */
        across = vvi_pose_right(pose);
    const vvi_pose lifted = vvi_pose_turned(pose, vvi_turn_about(across, wanted - elevation));
    return vvi_pose_turned(&lifted, vvi_turn_about(up, 2 * M_PI * dx));
}

/* In camera axes. */
static vv_vec3 on_sphere(const double at[2])
{
    const double square = at[0] * at[0] + at[1] * at[1];
    if (square <= 1)
        return vvi_vec(at[0], at[1], sqrt(1 - square));
    return vvi_vec(at[0] / sqrt(square), at[1] / sqrt(square), 0);
}

static vv_vec3 on_sheet(const double at[2])
{
    const double square = at[0] * at[0] + at[1] * at[1];
    vv_vec3 v = vvi_vec(at[0], at[1], square < 0.5 ? sqrt(1 - square) : 0.5 / sqrt(square));
    vvi_unit(&v);
    return v;
}

/* A turn in camera axes as one in the World's. */
static vvi_quaternion to_world(const vvi_pose *pose, vvi_quaternion turn)
{
    return vvi_turn_after(vvi_turn_after(pose->turn, turn), vvi_turn_back(pose->turn));
}

vvi_pose vvi_arcball(const vvi_pose *pose, const double from[2], const double to[2])
{
    const vv_vec3 a = on_sphere(from), b = on_sphere(to), u = vvi_cross(a, b);
    const vvi_quaternion twice = {vvi_dot(a, b), u.x, u.y, u.z}; /* b a*: by double the angle between */
    return vvi_pose_turned(pose, to_world(pose, vvi_turn_unit(twice)));
}

vvi_pose vvi_trackball(const vvi_pose *pose, const double from[2], const double to[2])
{
    return vvi_pose_turned(pose, to_world(pose, vvi_turn_between(on_sheet(from), on_sheet(to))));
}

static vvi_pose shifted(const vvi_pose *pose, vv_vec3 by)
{
    vvi_pose p = *pose;
    p.eye = vvi_add(pose->eye, by);
    p.pivot = vvi_add(pose->pivot, by);
    return p;
}

vvi_pose vvi_pan(const vvi_pose *pose, double dx, double dy)
{
    const double extent = vvi_pose_extent(pose);
    return shifted(
        pose, vvi_add(vvi_scaled(vvi_pose_right(pose), -dx * extent), vvi_scaled(vvi_pose_up(pose), -dy * extent)));
}

vvi_pose vvi_zoom(const vvi_pose *pose, double amount, const double at[2])
{
    const double factor = exp(-2 * amount);
    const double size = pose->parallel ? pose->height : vvi_pose_distance(pose);
    if (!isfinite(factor) || !(size * factor > NEAREST) || !isfinite(size * factor))
        return *pose;
    vvi_pose p = *pose;
    if (pose->parallel)
        p.height *= factor;
    else
        p.eye = vvi_add(pose->pivot, vvi_scaled(vvi_sub(pose->eye, pose->pivot), factor));
    if (!at)
        return p;
    return vvi_pan(&p, at[0] / 2 * (1 - 1 / factor), at[1] / 2 * (1 - 1 / factor));
}

vvi_pose vvi_roll(const vvi_pose *pose, double angle)
{
    vvi_pose p = *pose;
    p.turn = vvi_turn_unit(vvi_turn_after(pose->turn, vvi_turn_about(vvi_vec(0, 0, 1), -angle)));
    return p;
}

/* Where steady speed v and spin w, both in axes that turn along, lead in time t: the left Jacobian of the group of
 * turns (Rodrigues). */
static vv_vec3 flown(vv_vec3 v, vv_vec3 w, double t)
{
    const double rate = vvi_length(w), angle = rate * t;
    const vv_vec3 once = vvi_cross(w, v), twice = vvi_cross(w, once);
    const double a = angle > 1e-4 ? (1 - cos(angle)) / (rate * rate) : t * t / 2 * (1 - angle * angle / 12);
    const double b =
        angle > 1e-3 ? (angle - sin(angle)) / (rate * rate * rate) : t * t * t / 6 * (1 - angle * angle / 20);
    return vvi_add(vvi_scaled(v, t), vvi_add(vvi_scaled(once, a), vvi_scaled(twice, b)));
}

vvi_pose vvi_fly(const vvi_pose *pose, vv_vec3 speed, vv_vec3 spin, double seconds)
{
    const vv_vec3 ahead = vvi_turned(vvi_turn_back(pose->turn), vvi_sub(pose->pivot, pose->eye));
    vvi_pose p = *pose;
    p.eye = vvi_add(pose->eye, vvi_turned(pose->turn, flown(speed, spin, seconds)));
    p.turn = vvi_turn_unit(vvi_turn_after(pose->turn, vvi_turn_by(vvi_scaled(spin, seconds))));
    p.pivot = vvi_add(p.eye, vvi_turned(p.turn, ahead));
    return p;
}

double vvi_stick(double u, double dead_zone)
{
    if (!(fabs(u) > dead_zone))
        return 0;
    const double s = (fmin(fabs(u), 1) - dead_zone) / (1 - dead_zone);
    return copysign(s * s * s, u);
}

static double ratio(double a, double b, double t)
{
    return a > 0 && b > 0 ? a * pow(b / a, t) : a + (b - a) * t;
}

vvi_pose vvi_pose_between(const vvi_pose *a, const vvi_pose *b, double t)
{
    if (t <= 0 || t >= 1)
        return t <= 0 ? *a : *b;
    vvi_pose p = *b;
    p.turn = vvi_slerp(a->turn, b->turn, t);
    p.pivot = vvi_add(a->pivot, vvi_scaled(vvi_sub(b->pivot, a->pivot), t));
    p.height = ratio(a->height, b->height, t);
    p.fov = 2 * atan(ratio(tan(a->fov / 2), tan(b->fov / 2), t));
    p.eye = vvi_sub(p.pivot, vvi_scaled(vvi_pose_forward(&p), ratio(vvi_pose_distance(a), vvi_pose_distance(b), t)));
    return p;
}
