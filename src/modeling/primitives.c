/* Primitives whose distance is a formula. */
#include "modeling/primitives.h"
#include "core/status.h"

#include <math.h>

static double larger(double a, double b)
{
    return a > b ? a : b;
}

static double smaller(double a, double b)
{
    return a < b ? a : b;
}

static double least_size(const vvi_lengths *l)
{
    return smaller(l->size[0], smaller(l->size[1], l->size[2]));
}

/* Of a place from a box, by how far it is beyond each pair of faces. */
static double beyond(double x, double y, double z)
{
    const double a = larger(x, 0), b = larger(y, 0), c = larger(z, 0);
    return sqrt(a * a + b * b + c * c) + smaller(larger(x, larger(y, z)), 0);
}

static void sphere(double *out, const vvi_places *p, const vvi_lengths *l)
{
    for (size_t i = 0; i < p->n; i++)
        out[i] = sqrt(p->x[i] * p->x[i] + p->y[i] * p->y[i] + p->z[i] * p->z[i]) - l->radius;
}

static void box(double *out, const vvi_places *p, const vvi_lengths *l)
{
    const double r = l->rounding, x = l->size[0] / 2 - r, y = l->size[1] / 2 - r, z = l->size[2] / 2 - r;
    for (size_t i = 0; i < p->n; i++)
        out[i] = beyond(fabs(p->x[i]) - x, fabs(p->y[i]) - y, fabs(p->z[i]) - z) - r;
}

static const char *box_fault(const vvi_lengths *l)
{
    return 2 * l->rounding > least_size(l) ? "rounding is more than half of its shortest side" : NULL;
}

static void cylinder(double *out, const vvi_places *p, const vvi_lengths *l)
{
    const double h = l->height / 2;
    for (size_t i = 0; i < p->n; i++)
        out[i] = beyond(sqrt(p->x[i] * p->x[i] + p->y[i] * p->y[i]) - l->radius, fabs(p->z[i]) - h, -INFINITY);
}

/* In the half-plane through the axis the nearest place is on an end or on the slope: the shorter way decides. */
static void cone(double *out, const vvi_places *p, const vvi_lengths *l)
{
    const double h = l->height / 2, lean = l->top - l->radius, along = lean * lean + l->height * l->height;
    for (size_t i = 0; i < p->n; i++) {
        const double rho = sqrt(p->x[i] * p->x[i] + p->y[i] * p->y[i]), z = p->z[i];
        const double end = z < 0 ? l->radius : l->top;
        const double end_x = rho - smaller(rho, end), end_z = fabs(z) - h;
        const double t = ((rho - l->radius) * lean + (z + h) * l->height) / along, on = smaller(larger(t, 0), 1);
        const double side_x = rho - l->radius - lean * on, side_z = z + h - l->height * on;
        const double ways = smaller(end_x * end_x + end_z * end_z, side_x * side_x + side_z * side_z);
        const bool inside = (rho - l->radius) * l->height < lean * (z + h) && end_z < 0;
        out[i] = inside ? -sqrt(ways) : sqrt(ways);
    }
}

static void capsule(double *out, const vvi_places *p, const vvi_lengths *l)
{
    const double h = l->height / 2;
    for (size_t i = 0; i < p->n; i++) {
        const double z = larger(fabs(p->z[i]) - h, 0);
        out[i] = sqrt(p->x[i] * p->x[i] + p->y[i] * p->y[i] + z * z) - l->radius;
    }
}

static void torus(double *out, const vvi_places *p, const vvi_lengths *l)
{
    for (size_t i = 0; i < p->n; i++) {
        const double rho = sqrt(p->x[i] * p->x[i] + p->y[i] * p->y[i]) - l->radius;
        out[i] = sqrt(rho * rho + p->z[i] * p->z[i]) - l->tube;
    }
}

static const char *torus_fault(const vvi_lengths *l)
{
    return l->tube > l->radius ? "tube is more than its radius, and would cross itself" : NULL;
}

static double thick_round(const vvi_lengths *l)
{
    return 2 * l->radius;
}

static double thick_disc(const vvi_lengths *l)
{
    return smaller(2 * l->radius, l->height);
}

static double thick_tube(const vvi_lengths *l)
{
    return 2 * l->tube;
}

const vvi_primitive vvi_primitives[VVI_SHAPES] = {
    [VVI_SPHERE] = {"sphere", VVI_HAS_RADIUS, sphere, NULL, thick_round},
    [VVI_ELLIPSOID] = {"ellipsoid", VVI_HAS_SIZE, vvi_ellipsoid_distances, NULL, least_size},
    [VVI_BOX] = {"box", VVI_HAS_SIZE | VVI_HAS_ROUNDING, box, box_fault, least_size},
    [VVI_CYLINDER] = {"cylinder", VVI_HAS_RADIUS | VVI_HAS_HEIGHT, cylinder, NULL, thick_disc},
    [VVI_CONE] = {"cone", VVI_HAS_RADIUS | VVI_HAS_TOP | VVI_HAS_HEIGHT, cone, NULL, thick_disc},
    [VVI_CAPSULE] = {"capsule", VVI_HAS_RADIUS | VVI_HAS_HEIGHT, capsule, NULL, thick_round},
    [VVI_TORUS] = {"torus", VVI_HAS_RADIUS | VVI_HAS_TUBE, torus, torus_fault, thick_tube},
};

static vv_status check_length(const vvi_primitive *p, const char *what, const char *name, double length, bool zero)
{
    if (isfinite(length) && (length > 0 || (zero && length == 0)))
        return VV_OK;
    return vv_fail(VV_E_ARGUMENT, "%s: %s of a %s is %g, and must be %s", what, name, p->name, length,
                   zero ? "0 or above" : "above 0");
}

vv_status vvi_primitive_check(const vvi_primitive *p, const vvi_lengths *l, const char *what)
{
    const struct {
        unsigned bit;
        const char *name;
        double length;
    } rows[] = {{VVI_HAS_RADIUS, "radius", l->radius},
                {VVI_HAS_TOP, "top", l->top},
                {VVI_HAS_TUBE, "tube", l->tube},
                {VVI_HAS_HEIGHT, "height", l->height},
                {VVI_HAS_ROUNDING, "rounding", l->rounding},
                {VVI_HAS_SIZE, "size", l->size[0]},
                {VVI_HAS_SIZE, "size", l->size[1]},
                {VVI_HAS_SIZE, "size", l->size[2]}};
    vv_status st = VV_OK;
    for (size_t i = 0; i < sizeof rows / sizeof *rows && st == VV_OK; i++)
        if (p->has & rows[i].bit)
            st = check_length(p, what, rows[i].name, rows[i].length,
                              rows[i].bit == VVI_HAS_TOP || rows[i].bit == VVI_HAS_ROUNDING);
    const char *fault = st == VV_OK && p->fault ? p->fault(l) : NULL;
    return fault ? vv_fail(VV_E_ARGUMENT, "%s: a %s's %s", what, p->name, fault) : st;
}
