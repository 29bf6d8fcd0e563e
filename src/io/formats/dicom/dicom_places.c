/* Where frames lie along the normal of their planes, and which of them share a place. */
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include <math.h>
#include <stdlib.h>

static const vvi_dicom_values *values(const vvi_dicom_plan *plan, const vvi_dicom_slice *s)
{
    return vvi_dicom_frame_values(&plan->image[s->image], s->frame);
}

bool vvi_dicom_is_placed(const vvi_dicom_values *v)
{
    double sum = 0;
    for (int a = 0; a < 3; a++)
        sum += v->position[a] + v->row[a] + v->column[a];
    return isfinite(sum);
}

/* Order ---------------------------------------------------------------------------------------------------------- */

static int by_key(double a, double b)
{
    if (isnan(a) || isnan(b))
        return isnan(a) - isnan(b);
    return (a > b) - (a < b);
}

/* Comparing functions have no argument of their own: what they compare by stands beside the slice. */
typedef struct sortable {
    vvi_dicom_slice slice;
    double depth, key;
} sortable;

static int by_depth(const void *a, const void *b)
{
    const sortable *p = a, *q = b;
    int sign = by_key(p->depth, q->depth);
    if (sign == 0)
        sign = by_key(p->key, q->key);
    if (sign == 0)
        sign = (p->slice.image > q->slice.image) - (p->slice.image < q->slice.image);
    return sign ? sign : (p->slice.frame > q->slice.frame) - (p->slice.frame < q->slice.frame);
}

vv_status vvi_dicom_sort(const vvi_dicom_plan *plan, vvi_dicom_slice *slice, size_t n, bool depth, int key, vv_job *job)
{
    sortable *items = vvi_alloc(job, n * sizeof *items, VVI_MEM_SCRATCH);
    if (!items)
        return vv_fail_memory(n * sizeof *items);
    for (size_t i = 0; i < n; i++)
        items[i] = (sortable){slice[i], depth ? slice[i].depth : 0, key < 0 ? 0 : values(plan, &slice[i])->key[key]};
    qsort(items, n, sizeof *items, by_depth);
    for (size_t i = 0; i < n; i++)
        slice[i] = items[i].slice;
    vvi_free(items);
    return VV_OK;
}

/* Places --------------------------------------------------------------------------------------------------------- */

/* GridFrameOffsetVector says where frames lie along the normal, from the position on. */
static double offset_of(const vvi_dicom_plan *plan, const vvi_dicom_slice *s)
{
    const vvi_dicom_image *image = &plan->image[s->image];
    if (!image->offset || (size_t)s->frame >= image->n_offset || isnan(image->offset[s->frame]))
        return 0;
    return image->offset[s->frame] - image->offset[0];
}

static void set_depths(const vvi_dicom_plan *plan, vvi_dicom_slice *slice, size_t n)
{
    const vvi_dicom_values *v = values(plan, &slice[0]);
    const double *r = v->row, *c = v->column;
    const double normal[3] = {r[1] * c[2] - r[2] * c[1], r[2] * c[0] - r[0] * c[2], r[0] * c[1] - r[1] * c[0]};
    for (size_t i = 0; i < n; i++) {
        const double *p = values(plan, &slice[i])->position;
        slice[i].depth = p[0] * normal[0] + p[1] * normal[1] + p[2] * normal[2] + offset_of(plan, &slice[i]);
    }
}

vv_status vvi_dicom_find_places(size_t **place_out, size_t *n_places_out, const vvi_dicom_plan *plan,
                                vvi_dicom_slice *slice, size_t n, vv_job *job)
{
    *place_out = NULL;
    *n_places_out = 0;
    set_depths(plan, slice, n);
    vv_status st = vvi_dicom_sort(plan, slice, n, true, VVI_DICOM_KEY_INSTANCE, job);
    if (st != VV_OK)
        return st;
    size_t *place = vvi_alloc(job, (n + 1) * sizeof *place, VVI_MEM_SCRATCH), n_places = 0;
    if (!place)
        return vv_fail_memory((n + 1) * sizeof *place);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || slice[i].depth - slice[place[n_places - 1]].depth > 2e-3)
            place[n_places++] = i;
    place[n_places] = n;
    *place_out = place;
    *n_places_out = n_places;
    return VV_OK;
}
