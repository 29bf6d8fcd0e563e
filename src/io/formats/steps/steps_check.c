/* Whether files are steps of the same data: what differs, in the words of whoever has to choose. */
#include "io/formats/steps/steps.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Steps are written by many programs, some with six digits. */
#define SAME_PLACE 1e-4

static bool is_near(double a, double b, double size)
{
    return fabs(a - b) <= SAME_PLACE * size;
}

static bool differ_in_grid(char a[96], char b[96], const vv_grid *p, const vv_grid *q)
{
    const double voxel = vv_grid_voxel(p);
    if (memcmp(p->dims, q->dims, sizeof p->dims) != 0) {
        for (int i = 0; i < 2; i++) {
            const int64_t *n = i ? q->dims : p->dims;
            snprintf(i ? b : a, 96, "%lld x %lld x %lld samples", (long long)n[0], (long long)n[1], (long long)n[2]);
        }
        return true;
    }
    if (strcmp(p->unit, q->unit) != 0) {
        snprintf(a, 96, "lengths in %s", p->unit[0] ? p->unit : "no unit");
        snprintf(b, 96, "lengths in %s", q->unit[0] ? q->unit : "no unit");
        return true;
    }
    for (int i = 0; i < 3; i++)
        if (!is_near(vv_grid_spacing(p, i), vv_grid_spacing(q, i), vv_grid_spacing(p, i))) {
            snprintf(a, 96, "a spacing of %g along %c", vv_grid_spacing(p, i), 'x' + i);
            snprintf(b, 96, "one of %g", vv_grid_spacing(q, i));
            return true;
        }
    for (int i = 0; i < 3; i++) {
        const vv_vec3 v = p->index_to_world.axis[i], w = q->index_to_world.axis[i];
        if (!is_near(v.x, w.x, voxel) || !is_near(v.y, w.y, voxel) || !is_near(v.z, w.z, voxel)) {
            snprintf(a, 96, "other directions");
            snprintf(b, 96, "others");
            return true;
        }
    }
    const vv_vec3 v = p->index_to_world.origin, w = q->index_to_world.origin;
    if (is_near(v.x, w.x, voxel) && is_near(v.y, w.y, voxel) && is_near(v.z, w.z, voxel))
        return false;
    snprintf(a, 96, "its origin at %g, %g, %g", v.x, v.y, v.z);
    snprintf(b, 96, "it at %g, %g, %g", w.x, w.y, w.z);
    return true;
}

static bool differ_in_samples(char a[96], char b[96], const vv_field_info *p, const vv_field_info *q)
{
    if (p->n_frames != q->n_frames || q->n_frames > 1) {
        snprintf(a, 96, "%lld time steps", (long long)p->n_frames);
        snprintf(b, 96, "%lld", (long long)q->n_frames);
    } else if (p->type != q->type) {
        snprintf(a, 96, "samples of %s", vv_type_name(p->type));
        snprintf(b, 96, "samples of %s", vv_type_name(q->type));
    } else if (p->components != q->components || p->meaning != q->meaning) {
        snprintf(a, 96, "%d component%s a sample", p->components, p->components == 1 ? "" : "s");
        snprintf(b, 96, "%d%s", q->components, p->components == q->components ? " of another meaning" : "");
    } else {
        return false;
    }
    return true;
}

vv_status vvi_steps_check(const vv_field_info *info, const char *name, const vv_field_info *first,
                          const char *first_name, const vv_source *folder)
{
    char a[96], b[96];
    if (!differ_in_grid(a, b, &first->grid, &info->grid) && !differ_in_samples(a, b, first, info))
        return VV_OK;
    return vv_fail_at(
        VV_E_FORMAT, vvi_source_name(folder), NULL,
        "'%.80s' and '%.80s' are no time steps of one data set: the first has %s, the second %s; name one "
        "file, as %s:%.80s, or a pattern of those that belong together",
        first_name, name, a, b, vvi_source_name(folder), first_name);
}
