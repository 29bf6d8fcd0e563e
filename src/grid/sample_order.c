/* The samples of a field in the order of another grid, whose samples are among its own. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/lazy.h"
#include "grid/same_grid.h"
#include <string.h>

typedef struct fitted {
    vv_field *field;
    vv_grid grid;
    vvi_grid_fit fit;
} fitted;

static int64_t source_index(const vvi_grid_fit *fit, int a, int64_t i)
{
    return fit->first[a] + fit->sign[a] * i;
}

vv_box vvi_grid_covered(const vv_grid *grid, const vv_grid *other, const vvi_grid_fit *fit)
{
    vv_box box;
    for (int a = 0; a < 3; a++) {
        const int64_t last = other->dims[fit->axis[a]] - 1;
        const int64_t p = fit->sign[a] * (0 - fit->first[a]), q = fit->sign[a] * (last - fit->first[a]);
        const int64_t lo = p < q ? p : q, hi = p < q ? q : p;
        box.lo[a] = lo > 0 ? lo : 0;
        const int64_t n = (hi < grid->dims[a] - 1 ? hi : grid->dims[a] - 1) - box.lo[a] + 1;
        box.n[a] = n > 0 ? n : 0;
    }
    return box;
}

/* The part of a box that the field has. */
static vv_box within(const fitted *f, const vv_box *box)
{
    vv_box covered = vvi_grid_covered(&f->grid, &vv_field_get_info(f->field)->grid, &f->fit);
    for (int a = 0; a < 3; a++) {
        const int64_t end = covered.lo[a] + covered.n[a], box_end = box->lo[a] + box->n[a];
        covered.lo[a] = covered.lo[a] > box->lo[a] ? covered.lo[a] : box->lo[a];
        const int64_t n = (end < box_end ? end : box_end) - covered.lo[a];
        covered.n[a] = n > 0 ? n : 0;
    }
    return covered;
}

static void copy_row(char *to, const char *from, int64_t n, int64_t stride, size_t bytes)
{
    if (stride == (int64_t)bytes) {
        memcpy(to, from, (size_t)n * bytes);
        return;
    }
    for (int64_t i = 0; i < n; i++)
        memcpy(to + (size_t)i * bytes, from + i * stride, bytes);
}

/* to: the first sample of the box. part: what is copied of it. */
static vv_status copy_part(char *to, const fitted *f, const vv_box *box, const vv_box *part, vv_job *job)
{
    vv_box from;
    vv_brick brick;
    int64_t stride[3];
    for (int a = 0; a < 3; a++) {
        const int64_t p = source_index(&f->fit, a, part->lo[a]),
                      q = source_index(&f->fit, a, part->lo[a] + part->n[a] - 1);
        from.lo[f->fit.axis[a]] = p < q ? p : q;
        from.n[f->fit.axis[a]] = part->n[a];
    }
    const vv_status st = vv_field_brick(&brick, f->field, &from, job);
    if (st != VV_OK)
        return st;
    const size_t bytes = vv_type_bytes(brick.type) * (size_t)brick.components;
    const char *first = brick.data;
    for (int a = 0; a < 3; a++) {
        stride[a] = f->fit.sign[a] * brick.stride[f->fit.axis[a]];
        first += stride[a] < 0 ? -stride[a] * (part->n[a] - 1) : 0;
    }
    for (int64_t k = 0; k < part->n[2]; k++)
        for (int64_t j = 0; j < part->n[1]; j++) {
            const int64_t at = part->lo[0] - box->lo[0] +
                               box->n[0] * (part->lo[1] - box->lo[1] + j + box->n[1] * (part->lo[2] - box->lo[2] + k));
            copy_row(to + (size_t)at * bytes, first + j * stride[1] + k * stride[2], part->n[0], stride[0], bytes);
        }
    vv_brick_release(&brick);
    return vv_field_health(f->field);
}

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const fitted *f = user;
    vv_field_info info = *vv_field_get_info(f->field);
    const vv_box part = within(f, box);
    const int64_t n = part.n[0] * part.n[1] * part.n[2], n_all = box->n[0] * box->n[1] * box->n[2];
    void *data;
    info.grid = vv_grid_crop(&f->grid, box);
    vv_status st = vv_field_new_empty(out, &data, &info, job);
    if (st != VV_OK)
        return st;
    if (n < n_all)
        memset(data, 0, (size_t)n_all * vv_type_bytes(info.type) * (size_t)info.components);
    if (n > 0 && (st = copy_part(data, f, box, &part, job)) != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    return st;
}

static void drop(void *user)
{
    fitted *f = user;
    vv_field_release(f->field);
    vvi_free(f);
}

vv_status vvi_field_fitted(vv_field **out, const vv_field *field, const vv_grid *grid, const vvi_grid_fit *fit,
                           vv_job *job)
{
    vv_field_info info = *vv_field_get_info(field);
    vvi_lazy_pool *pool = NULL;
    fitted *f = vvi_alloc(job, sizeof *f, VVI_MEM_MODEL);
    *out = NULL;
    if (!f)
        return vv_fail_memory(sizeof *f);
    *f = (fitted){vv_field_retain(field), *grid, *fit};
    info.grid = *grid;
    vv_status st =
        vvi_lazy_pool_new(&pool, job ? vv_runtime_memory_limit(vv_job_runtime(job)) / 8 : UINT64_MAX, 0, job);
    if (st == VV_OK)
        st = vvi_field_lazy(out, &info, &(vvi_lazy_source){make, drop, f}, pool, job);
    else
        drop(f);
    vvi_lazy_pool_release(pool);
    return st;
}
