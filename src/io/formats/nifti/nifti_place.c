/* The three ways in which NIfTI says where voxels are: https://nifti.nimh.nih.gov/nifti-1 (method 1, 2, 3). */
#include "io/formats/nifti/nifti.h"
#include "io/placement.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static double length_of_step(const vvi_nifti *h, int axis)
{
    const double step = fabs(h->pixdim[axis + 1]);
    return isfinite(step) && step > 0 ? step : 1;
}

/* Method 1: lengths only. */
static vv_affine by_pixdim(const vvi_nifti *h)
{
    return (vv_affine){{{length_of_step(h, 0), 0, 0}, {0, length_of_step(h, 1), 0}, {0, 0, length_of_step(h, 2)}},
                       {0, 0, 0}};
}

/* Method 2: a rotation as the last three parts of a unit quaternion, and qfac -1 for a mirrored third axis. */
static vv_affine by_quaternion(const vvi_nifti *h)
{
    double b = h->quatern[0], c = h->quatern[1], d = h->quatern[2];
    double a = 1 - (b * b + c * c + d * d);
    if (a < 1e-7) { /* a half turn; rounding may make b c d longer than 1 */
        const double s = 1 / sqrt(b * b + c * c + d * d);
        b *= s;
        c *= s;
        d *= s;
        a = 0;
    } else {
        a = sqrt(a);
    }
    const double x = length_of_step(h, 0), y = length_of_step(h, 1);
    const double z = length_of_step(h, 2) * (h->pixdim[0] < 0 ? -1 : 1);
    return (vv_affine){{{(a * a + b * b - c * c - d * d) * x, 2 * (b * c + a * d) * x, 2 * (b * d - a * c) * x},
                        {2 * (b * c - a * d) * y, (a * a + c * c - b * b - d * d) * y, 2 * (c * d + a * b) * y},
                        {2 * (b * d + a * c) * z, 2 * (c * d - a * b) * z, (a * a + d * d - c * c - b * b) * z}},
                       {h->qoffset[0], h->qoffset[1], h->qoffset[2]}};
}

/* Method 3: the matrix itself. */
static vv_affine by_matrix(const vvi_nifti *h)
{
    const double(*r)[4] = h->srow;
    return (vv_affine){{{r[0][0], r[1][0], r[2][0]}, {r[0][1], r[1][1], r[2][1]}, {r[0][2], r[1][2], r[2][2]}},
                       {r[0][3], r[1][3], r[2][3]}};
}

static bool usable(const vv_affine *a)
{
    const double d = vv_affine_determinant(*a);
    return vvi_affine_finite(a) && isfinite(d) && d != 0;
}

bool vvi_nifti_qform(vv_affine *out, const vvi_nifti *h)
{
    *out = by_quaternion(h);
    return h->qform_code > 0 && usable(out);
}

bool vvi_nifti_sform(vv_affine *out, const vvi_nifti *h)
{
    *out = by_matrix(h);
    return h->sform_code > 0 && usable(out);
}

/* More than this share of a voxel apart, somewhere in the volume, is more than rounding. */
#define DISAGREEMENT 0.05

static vv_status warn_of_disagreement(const vv_grid *grid, const vv_affine *q, vv_notes *notes)
{
    const double apart = vvi_placement_distance(&grid->index_to_world, q, grid->dims);
    if (apart <= DISAGREEMENT * vv_grid_voxel(grid))
        return VV_OK;
    return vvi_notes_warn(notes, "sform and qform disagree by up to %.3g %s; the sform is used", apart, grid->unit);
}

vv_status vvi_nifti_place(vv_grid *grid, const vvi_nifti *h, const char *name, vv_notes *notes)
{
    static const char *const units[] = {"mm", "m", "mm", "um"};
    vv_status st = VV_OK;
    vv_affine s, q;
    const bool s_good = vvi_nifti_sform(&s, h), q_good = vvi_nifti_qform(&q, h);
    const int unit = h->xyzt_units & 7;
    snprintf(grid->unit, sizeof grid->unit, "%s", unit < 4 ? units[unit] : "mm");
    grid->space = VV_SPACE_RAS;
    grid->index_to_world = s_good ? s : q_good ? q : by_pixdim(h);
    if (!usable(&grid->index_to_world))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its pixdim are out of range; correct the header");
    if (h->sform_code > 0 && !s_good)
        st = vvi_notes_warn(notes, "its sform is singular or not finite; the %s is used",
                            q_good ? "qform" : "voxel size alone");
    if (st == VV_OK && h->qform_code > 0 && !q_good)
        st = vvi_notes_warn(notes, "its qform is not finite and is ignored");
    if (st == VV_OK && !s_good && !q_good)
        st = vvi_notes_warn(notes, "gives no orientation; its axes are taken as right, front and up");
    if (st == VV_OK && s_good && q_good)
        st = warn_of_disagreement(grid, &q, notes);
    return st;
}

/* Writing ---------------------------------------------------------------------------------------------------------- */

/* Of a proper rotation; after the format's own description, with the largest part chosen as the pivot. */
static void to_quaternion(double out[3], double r[3][3])
{
    const double trace = r[0][0] + r[1][1] + r[2][2];
    double a, b, c, d;
    if (trace > 0) {
        a = 0.5 * sqrt(1 + trace);
        b = 0.25 * (r[2][1] - r[1][2]) / a;
        c = 0.25 * (r[0][2] - r[2][0]) / a;
        d = 0.25 * (r[1][0] - r[0][1]) / a;
    } else {
        const double xd = 1 + r[0][0] - r[1][1] - r[2][2], yd = 1 + r[1][1] - r[0][0] - r[2][2];
        const double zd = 1 + r[2][2] - r[0][0] - r[1][1];
        if (xd >= yd && xd >= zd) {
            b = 0.5 * sqrt(xd);
            c = 0.25 * (r[0][1] + r[1][0]) / b;
            d = 0.25 * (r[0][2] + r[2][0]) / b;
            a = 0.25 * (r[2][1] - r[1][2]) / b;
        } else if (yd >= zd) {
            c = 0.5 * sqrt(yd);
            b = 0.25 * (r[0][1] + r[1][0]) / c;
            d = 0.25 * (r[1][2] + r[2][1]) / c;
            a = 0.25 * (r[0][2] - r[2][0]) / c;
        } else {
            d = 0.5 * sqrt(zd);
            b = 0.25 * (r[0][2] + r[2][0]) / d;
            c = 0.25 * (r[1][2] + r[2][1]) / d;
            a = 0.25 * (r[1][0] - r[0][1]) / d;
        }
    }
    const double sign = a < 0 ? -1 : 1; /* the first part is not stored: readers take it as positive */
    out[0] = b * sign;
    out[1] = c * sign;
    out[2] = d * sign;
}

bool vvi_nifti_set_qform(vvi_nifti *h, const vv_affine *p)
{
    double r[3][3];
    for (int a = 0; a < 3; a++) {
        const double n = vvi_length(p->axis[a]);
        h->pixdim[a + 1] = n;
        if (!(n > 0))
            return false;
        r[0][a] = p->axis[a].x / n;
        r[1][a] = p->axis[a].y / n;
        r[2][a] = p->axis[a].z / n;
    }
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3;
        if (fabs(r[0][a] * r[0][b] + r[1][a] * r[1][b] + r[2][a] * r[2][b]) > 1e-6)
            return false;
    }
    const bool mirrored = vv_affine_determinant(*p) < 0;
    h->pixdim[0] = mirrored ? -1 : 1;
    for (int i = 0; mirrored && i < 3; i++)
        r[i][2] = -r[i][2];
    to_quaternion(h->quatern, r);
    h->qoffset[0] = p->origin.x;
    h->qoffset[1] = p->origin.y;
    h->qoffset[2] = p->origin.z;
    return true;
}
