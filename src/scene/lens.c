#include "scene/lens.h"
#include <math.h>
#include <stdio.h>

/* Of the World, from axes with z up. */
static vv_vec3 upright(vv_vec3 v, vv_up up)
{
    return up == VV_UP_Y ? vvi_vec(v.x, v.z, -v.y) : v;
}

static vv_vec3 turned_about_z(vv_vec3 v, double angle)
{
    const double c = cos(angle), s = sin(angle);
    return vvi_vec(c * v.x - s * v.y, s * v.x + c * v.y, v.z);
}

/* Axes from the angles alone: defined for every elevation, the poles too, because right never looks at up. */
static void axes_from_angles(vv_lens *lens, const vv_camera *camera, const vvi_fit *fit)
{
    const double side = fit->space == VV_SPACE_RAS ? -1 : 1;
    const double c = cos(camera->elevation), s = sin(camera->elevation);
    lens->forward = upright(turned_about_z(vvi_vec(0, side * c, -s), camera->azimuth), fit->up);
    lens->right = upright(turned_about_z(vvi_vec(side, 0, 0), camera->azimuth), fit->up);
    lens->up = vvi_cross(lens->right, lens->forward);
}

static vv_status fail(const char *path, const char *property, const char *text)
{
    char where[512];
    snprintf(where, sizeof where, "%s.%s", path, property);
    return vv_fail_at(VV_E_ARGUMENT, NULL, where, "%s", text);
}

static vv_status axes_from_points(vv_lens *lens, const vv_camera *camera, vv_vec3 at, vv_up up, const char *path)
{
    const vv_vec3 forward = vvi_sub(at, camera->eye);
    vv_vec3 unit = forward;
    if (!vvi_unit(&unit))
        return fail(path, "eye", "is the same point as at; move one of them");
    const vv_vec3 fallback = lens->up; /* of the angles, for a line of sight along up */
    vv_vec3 right = vvi_cross(unit, upright(vvi_vec(0, 0, 1), up));
    if (vvi_length(right) < 1e-9)
        right = vvi_cross(unit, fallback);
    if (!vvi_unit(&right)) /* the angles look along it as well */
        right = lens->right;
    lens->forward = unit;
    lens->right = right;
    lens->up = vvi_cross(right, unit);
    return VV_OK;
}

/* An up given by hand: kept where it is not along the line of sight. */
static vv_status take_up(vv_lens *lens, const vv_camera *camera, const char *path)
{
    vv_vec3 up = camera->up;
    if (!vvi_unit(&up))
        return fail(path, "up", "has no length; give a direction such as [0, 0, 1]");
    vv_vec3 right = vvi_cross(lens->forward, up);
    if (vvi_length(right) < 1e-9 || !vvi_unit(&right))
        return VV_OK; /* degenerate: what we have is as good as any */
    lens->right = right;
    lens->up = vvi_cross(right, lens->forward);
    return VV_OK;
}

static vv_vec3 turntable_up(const vv_lens *lens, vv_up up)
{
    const vv_vec3 world = upright(vvi_vec(0, 0, 1), up);
    const bool level = fabs(vvi_dot(lens->right, world)) < 1e-6 && vvi_dot(lens->up, world) > -1e-6;
    return level ? world : lens->up;
}

static void roll(vv_lens *lens, double angle)
{
    const double c = cos(angle), s = sin(angle);
    const vv_vec3 right = lens->right, up = lens->up;
    lens->up = vvi_add(vvi_scaled(up, c), vvi_scaled(right, s));
    lens->right = vvi_sub(vvi_scaled(right, c), vvi_scaled(up, s));
}

bool vvi_fit_box(vv_vec3 *lo_out, vv_vec3 *hi_out, const vvi_fit *fit)
{
    vv_vec3 lo = vvi_vec(INFINITY, INFINITY, INFINITY), hi = vvi_scaled(lo, -1);
    for (size_t i = 0; i < fit->n_corners; i++) {
        const vv_vec3 p = fit->corner[i];
        lo = vvi_vec(fmin(lo.x, p.x), fmin(lo.y, p.y), fmin(lo.z, p.z));
        hi = vvi_vec(fmax(hi.x, p.x), fmax(hi.y, p.y), fmax(hi.z, p.z));
    }
    *lo_out = lo;
    *hi_out = hi;
    return fit->n_corners > 0;
}

vv_vec3 vvi_fit_middle(const vvi_fit *fit)
{
    vv_vec3 lo, hi;
    return vvi_fit_box(&lo, &hi, fit) ? vvi_scaled(vvi_add(lo, hi), 0.5) : vvi_vec(0, 0, 0);
}

/* Farthest corner from `at`; 1 where there is no extent. */
static double radius(const vvi_fit *fit, vv_vec3 at)
{
    double r = 0;
    for (size_t i = 0; i < fit->n_corners; i++)
        r = fmax(r, vvi_length(vvi_sub(fit->corner[i], at)));
    return r > 0 ? r : 1;
}

/* Smallest distance before `at` from which every corner p = at + (x, y, z) in camera axes keeps
 * |x| <= tan_x (distance + z), and the same for y. */
static double fitted_distance(const vvi_fit *fit, const vv_lens *lens, vv_vec3 at)
{
    const double tan_x = lens->half_width * (1 - fit->margin);
    const double tan_y = lens->half_height * (1 - fit->margin);
    double distance = 0;
    for (size_t i = 0; i < fit->n_corners; i++) {
        const vv_vec3 p = vvi_sub(fit->corner[i], at);
        const double z = vvi_dot(p, lens->forward);
        distance = fmax(distance, fabs(vvi_dot(p, lens->right)) / tan_x - z);
        distance = fmax(distance, fabs(vvi_dot(p, lens->up)) / tan_y - z);
    }
    return fmax(distance, 1e-3 * radius(fit, at));
}

/* Where what is seen lies across the picture along one of the camera's axes, opened by a tangent to each side. */
typedef struct extent {
    double middle, half; /* half: of the least picture through `at` that holds all, and whose middle is there */
    double gain;         /* how fast half shrinks with the tangent */
} extent;

/* A place (x, z) beside `at` is inside if |x - middle| <= half + tangent z: the sides nearest to all places touch
 * x - tangent z and x + tangent z. */
static extent extent_at(const vvi_fit *fit, vv_vec3 axis, vv_vec3 forward, double tangent, vv_vec3 at)
{
    double high = -INFINITY, low = INFINITY, z_high = 0, z_low = 0;
    for (size_t i = 0; i < fit->n_corners; i++) {
        const vv_vec3 p = vvi_sub(fit->corner[i], at);
        const double x = vvi_dot(p, axis), z = vvi_dot(p, forward);
        if (x - tangent * z > high) {
            high = x - tangent * z;
            z_high = z;
        }
        if (x + tangent * z < low) {
            low = x + tangent * z;
            z_low = z;
        }
    }
    return (extent){.middle = (high + low) / 2, .half = (high - low) / 2, .gain = (z_high + z_low) / 2};
}

/* The middle of the least picture that holds all, seen from a distance. Its tangent t is where half(t) = t distance;
 * the difference is convex, falls, and has finitely many corners, so Newton's steps from 0 climb to it and end. */
static double middle_from(const vvi_fit *fit, vv_vec3 axis, vv_vec3 forward, double distance, vv_vec3 at)
{
    double tangent = 0;
    extent e = extent_at(fit, axis, forward, 0, at);
    for (int step = 0; step < 64 && e.gain + distance > 0; step++) {
        const double next = tangent + (e.half - tangent * distance) / (e.gain + distance);
        if (!(next > tangent))
            break;
        tangent = next;
        e = extent_at(fit, axis, forward, tangent, at);
    }
    return e.middle;
}

/* Moves `at` in the plane of the picture to where what is seen reaches as near to one side as to the other. The eye is
 * as far away as the axis that needs more room says; the other axis is balanced for that eye, not for a nearer one. */
static vv_vec3 centred(const vvi_fit *fit, const vv_lens *lens, const vv_camera *camera, double aspect, vv_vec3 at)
{
    if (fit->n_corners == 0)
        return at;
    const double tan_y = lens->parallel ? 0 : tan(camera->fov / 2) * (1 - fit->margin), tan_x = tan_y * aspect;
    extent x = extent_at(fit, lens->right, lens->forward, tan_x, at);
    extent y = extent_at(fit, lens->up, lens->forward, tan_y, at);
    if (!lens->parallel) {
        const double distance = fmax(x.half / tan_x, y.half / tan_y);
        x.middle = middle_from(fit, lens->right, lens->forward, distance, at);
        y.middle = middle_from(fit, lens->up, lens->forward, distance, at);
    }
    return vvi_add(at, vvi_add(vvi_scaled(lens->right, x.middle), vvi_scaled(lens->up, y.middle)));
}

static double fitted_half_height(const vvi_fit *fit, const vv_lens *lens, vv_vec3 at, double aspect)
{
    double half = 0;
    for (size_t i = 0; i < fit->n_corners; i++) {
        const vv_vec3 p = vvi_sub(fit->corner[i], at);
        half = fmax(half, fmax(fabs(vvi_dot(p, lens->up)), fabs(vvi_dot(p, lens->right)) / aspect) / (1 - fit->margin));
    }
    return half > 0 ? half : 1 / (1 - fit->margin);
}

static void open_parallel(vvi_aim *aim, const vv_camera *camera, const vvi_fit *fit, double aspect, bool has_eye)
{
    const bool given = vv_object_is_set(&camera->base, "height");
    aim->lens.half_height = given ? camera->height / 2 : fitted_half_height(fit, &aim->lens, aim->at, aspect);
    aim->lens.half_width = aim->lens.half_height * aspect;
    if (!has_eye) /* outside of everything: rays start at the eye's plane */
        aim->lens.eye = vvi_sub(aim->at, vvi_scaled(aim->lens.forward, 2 * radius(fit, aim->at)));
    aim->height = 2 * aim->lens.half_height;
}

static void open_perspective(vvi_aim *aim, const vv_camera *camera, const vvi_fit *fit, double aspect)
{
    aim->lens.half_height = tan(camera->fov / 2);
    aim->lens.half_width = aim->lens.half_height * aspect;
    if (!vv_object_is_set(&camera->base, "eye")) {
        const double distance = fitted_distance(fit, &aim->lens, aim->at);
        aim->lens.eye = vvi_sub(aim->at, vvi_scaled(aim->lens.forward, distance));
    }
    aim->height = 2 * aim->lens.half_height * vvi_dot(vvi_sub(aim->at, aim->lens.eye), aim->lens.forward);
}

/* Numbers near the end of what doubles hold have no directions and distances between them. */
static vv_status check_lens(const vv_lens *lens, const char *path)
{
    const double w = lens->half_width, h = lens->half_height;
    if (vvi_finite(lens->eye) && vvi_finite(lens->forward) && vvi_finite(lens->right) && vvi_finite(lens->up) &&
        w > 0 && h > 0 && isfinite(w) && isfinite(h))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, NULL, path, "eye, at, the angles or the data are too large to compute with");
}

static vv_status zoom(vvi_aim *aim, const vv_camera *camera, const char *path)
{
    aim->lens.half_width /= camera->zoom;
    aim->lens.half_height /= camera->zoom;
    return check_lens(&aim->lens, path);
}

vv_status vvi_aim_camera(vvi_aim *out, const vv_camera *camera, int32_t width, int32_t height, const vvi_fit *fit,
                         const char *path)
{
    vv_status st = VV_OK;
    const double aspect = (double)width / height;
    *out = (vvi_aim){0};
    out->lens.parallel = camera->projection == VV_PARALLEL;
    out->at = vv_object_is_set(&camera->base, "at") ? camera->at : vvi_fit_middle(fit);
    axes_from_angles(&out->lens, camera, fit);
    if (vv_object_is_set(&camera->base, "eye")) {
        out->lens.eye = camera->eye;
        if ((st = axes_from_points(&out->lens, camera, out->at, fit->up, path)) != VV_OK)
            return st;
    }
    if (vv_object_is_set(&camera->base, "up") && (st = take_up(&out->lens, camera, path)) != VV_OK)
        return st;
    out->up = turntable_up(&out->lens, fit->up);
    roll(&out->lens, camera->roll);
    if (fit->centred && !vv_object_is_set(&camera->base, "eye") && !vv_object_is_set(&camera->base, "at"))
        out->at = centred(fit, &out->lens, camera, aspect, out->at);
    if (out->lens.parallel)
        open_parallel(out, camera, fit, aspect, vv_object_is_set(&camera->base, "eye"));
    else
        open_perspective(out, camera, fit, aspect);
    return zoom(out, camera, path);
}

vv_status vvi_aim_plane(vvi_aim *out, const vv_camera *camera, int32_t width, int32_t height, const vvi_fit *fit,
                        vv_vec3 right, vv_vec3 up, vv_vec3 through, const char *path)
{
    *out = (vvi_aim){.lens = {.right = right, .up = up, .forward = vvi_cross(up, right), .parallel = true}, .up = up};
    const vv_vec3 forward = out->lens.forward;
    out->at = vv_object_is_set(&camera->base, "at") ? camera->at : vvi_fit_middle(fit);
    out->at = vvi_add(out->at, vvi_scaled(forward, vvi_dot(vvi_sub(through, out->at), forward)));
    roll(&out->lens, camera->roll);
    open_parallel(out, camera, fit, (double)width / height, false);
    return zoom(out, camera, path);
}
