/* Analyze 7.5, the ancestor of NIfTI: the same first 348 bytes without a magic, and without a word on left and right.
 * Sizes, types, SPM's scale and SPM's origin are understood as SPM and nibabel do. */
#include "grid/field.h"
#include "io/formats/nifti/nifti.h"
#include "io/placement.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum { AT_DIM = 40, AT_UNIT = 56, AT_GLMAX = 140, AT_GLMIN = 144, AT_ORIENT = 252, AT_ORIGIN = 253, AT_MAGIC = 344 };

static int32_t whole(const uint8_t *at, size_t n, bool swapped)
{
    uint8_t b[4];
    int16_t i16;
    int32_t i32;
    memcpy(b, at, n);
    if (swapped)
        vvi_swap_bytes(b, n, 1);
    memcpy(&i16, b, sizeof i16);
    memcpy(&i32, b, n == 4 ? sizeof i32 : 0);
    return n == 2 ? i16 : i32;
}

bool vvi_nifti_is_analyze(const uint8_t *head, size_t n, bool *swapped)
{
    if (n < VVI_NIFTI1_BYTES)
        return false;
    for (int swap = 0; swap < 2; swap++) {
        const int32_t rank = whole(head + AT_DIM, 2, swap);
        *swapped = swap;
        if (whole(head, 4, swap) == VVI_NIFTI1_BYTES && rank >= 1 && rank <= 7)
            return !(head[AT_MAGIC] == 'n' && (head[AT_MAGIC + 1] == '+' || head[AT_MAGIC + 1] == 'i'));
    }
    return false;
}

/* Types that SPM added, as NIfTI numbers them. */
static int datatype_of(int code)
{
    return code == 130 ? 256 : code == 132 ? 512 : code == 136 ? 768 : code;
}

/* SPM's factor; without one the range of stored numbers and the values that its ends mean. */
static void find_scale(vvi_nifti *h, const uint8_t *bytes)
{
    const double stored_hi = whole(bytes + AT_GLMAX, 4, h->swapped), stored_lo = whole(bytes + AT_GLMIN, 4, h->swapped);
    const double span = h->cal_max - h->cal_min;
    if (isfinite(h->slope) && h->slope != 0) {
        h->intercept = isfinite(h->intercept) ? h->intercept : 0;
        return;
    }
    h->slope = h->intercept = 0;
    if (stored_hi > stored_lo && isfinite(span) && span != 0) {
        h->slope = span / (stored_hi - stored_lo);
        h->intercept = h->cal_min - h->slope * stored_lo;
    }
}

void vvi_nifti_unpack_analyze(vvi_nifti *h, const uint8_t *bytes)
{
    vvi_nifti_unpack(h, bytes);
    h->datatype = datatype_of(h->datatype);
    for (int i = 3; i < 8; i++)
        h->dim[i] = h->dim[i] == 0 ? 1 : h->dim[i];
    h->toffset = 0;
    h->xyzt_units = h->intent_code = h->qform_code = h->sform_code = 0;
    h->intent_name[0] = 0;
    h->orient = bytes[AT_ORIENT];
    for (int i = 0; i < 3; i++)
        h->origin[i] = whole(bytes + AT_ORIGIN + 2 * i, 2, h->swapped);
    memcpy(h->unit, bytes + AT_UNIT, 4);
    h->unit[4] = 0;
    find_scale(h, bytes);
}

/* Index of the sample at the world's zero: SPM's origin counts from 1; a text or nothing there means the centre. */
static void find_origin(double out[3], const vvi_nifti *h, const int64_t dims[3])
{
    bool given = false, sane = true;
    for (int a = 0; a < 3; a++) {
        const double o = h->origin[a], n = (double)dims[a];
        given |= o != 0;
        sane &= o > -n && o < 2 * n;
    }
    for (int a = 0; a < 3; a++)
        out[a] = given && sane ? h->origin[a] - 1 : (double)(dims[a] - 1) / 2;
}

/* Directions of the axes in right, front, up for the codes 0 .. 5. */
static const int8_t directions[6][3][3] = {
    {{-1, 0, 0}, {0, 1, 0}, {0, 0, 1}},  /* transverse */
    {{-1, 0, 0}, {0, 0, 1}, {0, 1, 0}},  /* coronal */
    {{0, 1, 0}, {0, 0, 1}, {-1, 0, 0}},  /* sagittal */
    {{-1, 0, 0}, {0, -1, 0}, {0, 0, 1}}, /* the same, flipped */
    {{-1, 0, 0}, {0, 0, -1}, {0, 1, 0}}, {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}},
};

vv_status vvi_nifti_place_analyze(vv_grid *grid, const vvi_nifti *h, const char *name, vv_notes *notes)
{
    double origin[3];
    const bool known = h->orient >= 0 && h->orient < 6;
    const int orient = known ? h->orient : 0;
    vv_affine *place = &grid->index_to_world;
    vv_vec3 o = {0, 0, 0};
    find_origin(origin, h, grid->dims);
    for (int a = 0; a < 3; a++) {
        const double step = isfinite(h->pixdim[a + 1]) && h->pixdim[a + 1] != 0 ? fabs(h->pixdim[a + 1]) : 1;
        const int8_t *d = directions[orient][a];
        place->axis[a] = (vv_vec3){d[0] * step, d[1] * step, d[2] * step};
        o.x -= origin[a] * place->axis[a].x;
        o.y -= origin[a] * place->axis[a].y;
        o.z -= origin[a] * place->axis[a].z;
    }
    place->origin = o;
    if (!vvi_affine_finite(place) || !(fabs(vv_affine_determinant(*place)) > 0))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its pixdim are out of range; correct the header");
    grid->space = VV_SPACE_RAS;
    vvi_unit_name(grid->unit, h->unit, strlen(h->unit));
    if (strcmp(grid->unit, "cm") != 0 && strcmp(grid->unit, "um") != 0)
        snprintf(grid->unit, sizeof grid->unit, "mm");
    vv_status st = vvi_notes_add(notes, "header", "Analyze 7.5");
    if (st == VV_OK && !known)
        st = vvi_notes_warn(notes, "its orientation code is %d; 0 to 5 are known; 0 is used", h->orient);
    return st == VV_OK ? vvi_notes_warn(notes, "Analyze does not specify which side is left; its axes are taken as its "
                                               "orientation code says, from right to left, as SPM does")
                       : st;
}
