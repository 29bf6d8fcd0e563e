#include "filter/diffuse_file.h"
#include "core/memory.h"
#include "filter/real_samples.h"
#include "grid/lazy.h"
#include "io/scratch_file.h"

#define SHARE 4 /* of the memory, for steps under way */

struct vvi_diffuse_file {
    vvi_scratch_file *scratch; /* numbers, one component after the other */
    vv_field_info info;        /* of the input, and so of the result */
    vv_field_info numbers;     /* of one component in the file */
    uint64_t slice_bytes;      /* of it */
    int64_t component;         /* that is worked on */
    char *slice;               /* of a wave, on its way into the file */
    vv_job *job;
};

uint64_t vvi_diffuse_file_bytes(const vv_field_info *info)
{
    const int64_t *n = info->grid.dims;
    return (uint64_t)(n[0] * n[1] * n[2]) * (uint64_t)info->components * vvi_reals_bytes(vvi_reals_wide(info->type));
}

vv_status vvi_diffuse_file_new(vvi_diffuse_file **out, const vv_field *in, vv_job *job)
{
    vvi_diffuse_file *f = vvi_alloc_zeroed(job, sizeof *f, VVI_MEM_SCRATCH);
    *out = NULL;
    if (!f)
        return vv_fail_memory(sizeof *f);
    const bool wide = vvi_reals_wide(vv_field_get_info(in)->type);
    f->info = f->numbers = *vv_field_get_info(in);
    f->numbers.type = wide ? VV_TYPE_F64 : VV_TYPE_F32;
    f->numbers.components = 1;
    f->numbers.meaning = VV_MEANING_SCALAR;
    f->slice_bytes = (uint64_t)(f->info.grid.dims[0] * f->info.grid.dims[1]) * vvi_reals_bytes(wide);
    f->job = job;
    const vv_status st = vvi_scratch_file_new(&f->scratch, vvi_diffuse_file_bytes(&f->info), "diffuse", job);
    if (st == VV_OK)
        *out = f;
    else
        vvi_diffuse_file_free(f);
    return st;
}

void vvi_diffuse_file_free(vvi_diffuse_file *file)
{
    if (!file)
        return;
    vvi_scratch_file_free(file->scratch);
    vvi_free(file);
}

static uint64_t place_of(const vvi_diffuse_file *f, int64_t component, int64_t k)
{
    return (uint64_t)(component * f->info.grid.dims[2] + k) * f->slice_bytes;
}

/* A wave has read what is in the way of a slice: steps go on in the same file. */
static vv_status take_slice(void *user, int64_t k)
{
    vvi_diffuse_file *f = user;
    return vvi_scratch_file_write(f->scratch, place_of(f, f->component, k), f->slice, f->slice_bytes, f->job);
}

static vv_status read_slices(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const vvi_diffuse_file *f = user;
    vv_field_info info = f->numbers;
    void *data;
    info.grid = vv_grid_crop(&info.grid, box);
    vv_status st = vv_field_new_empty(out, &data, &info, job);
    if (st == VV_OK)
        st = vvi_scratch_file_read(f->scratch, place_of(f, f->component, box->lo[2]), data,
                                   (size_t)box->n[2] * f->slice_bytes, job);
    return st;
}

/* What the file holds of a component, one slice at a time: nothing is read before it is asked for, as what lies behind
 * a wave is written anew. */
static vv_status open_numbers(vv_field **out, vvi_diffuse_file *f)
{
    const vvi_lazy_source source = {.make = read_slices, .user = f};
    vvi_lazy_pool *pool;
    *out = NULL;
    vv_status st = vvi_lazy_pool_new(&pool, 1, 0, f->job);
    if (st == VV_OK)
        st = vvi_field_lazy(out, &f->numbers, &source, pool, f->job);
    vvi_lazy_pool_release(pool);
    return st;
}

/* Steps that go together: their wave has a share of the memory. */
static int64_t steps_at_once(const vvi_diffuse_wave *wave)
{
    vvi_diffuse_wave one = *wave;
    one.iterations = 1;
    const double room = wave->job ? (double)vv_runtime_memory_limit(vv_job_runtime(wave->job)) / SHARE : 1e18;
    const double n = room / vvi_diffuse_wave_bytes(&one);
    return n < 1 ? 1 : n < (double)wave->iterations ? (int64_t)n : wave->iterations;
}

static vv_status run_steps(vvi_diffuse_file *f, const vvi_diffuse_wave *wave)
{
    const int64_t step = steps_at_once(wave), nz = f->info.grid.dims[2], groups = (wave->iterations - 1) / step + 1;
    vvi_diffuse_wave w = *wave;
    vv_status st = VV_OK;
    w.out = f->slice;
    w.type = f->numbers.type;
    w.step = (int64_t)vv_type_bytes(w.type);
    w.take = take_slice;
    w.user = f;
    w.all = (uint64_t)(groups * nz + wave->iterations) * (uint64_t)f->info.components;
    w.before = (uint64_t)(groups * nz + wave->iterations) * (uint64_t)wave->component;
    for (int64_t done = 0; done < wave->iterations && st == VV_OK; done += step) {
        vv_field *numbers = NULL;
        w.iterations = wave->iterations - done < step ? wave->iterations - done : step;
        if (done > 0 && (st = open_numbers(&numbers, f)) == VV_OK) {
            w.in = numbers;
            w.component = 0;
        }
        if (st == VV_OK)
            st = vvi_diffuse_wave_run(&w);
        vv_field_release(numbers);
        w.before += (uint64_t)(nz + w.iterations);
    }
    return st;
}

vv_status vvi_diffuse_file_run(vvi_diffuse_file *file, const vvi_diffuse_wave *wave)
{
    file->component = wave->component;
    file->slice = vvi_alloc(file->job, (size_t)file->slice_bytes, VVI_MEM_SCRATCH);
    const vv_status st = file->slice ? run_steps(file, wave) : vv_fail_memory((size_t)file->slice_bytes);
    vvi_free(file->slice);
    file->slice = NULL;
    return st;
}

vv_status vvi_diffuse_file_slices(vv_field **out, vvi_diffuse_file *file, const vv_box *box, vv_job *job)
{
    const int64_t n = box->n[0] * box->n[1], components = file->info.components;
    const int64_t type = (int64_t)vv_type_bytes(file->info.type), each = type * components;
    vv_field_info info = file->info;
    void *data;
    *out = NULL;
    info.grid = vv_grid_crop(&info.grid, box);
    char *numbers = vvi_alloc(job, (size_t)file->slice_bytes, VVI_MEM_SCRATCH);
    vv_field *made = NULL;
    vv_status st = numbers ? vv_field_new_empty(&made, &data, &info, job) : vv_fail_memory((size_t)file->slice_bytes);
    for (int64_t k = 0; k < box->n[2] && st == VV_OK; k++)
        for (int64_t c = 0; c < components && st == VV_OK; c++) {
            st = vvi_scratch_file_read(file->scratch, place_of(file, c, box->lo[2] + k), numbers,
                                       (size_t)file->slice_bytes, job);
            if (st == VV_OK)
                vvi_samples_of_reals((char *)data + k * n * each + c * type, each, info.type, numbers,
                                     file->numbers.type == VV_TYPE_F64, n);
        }
    vvi_free(numbers);
    if (st == VV_OK)
        *out = made;
    else
        vv_field_release(made);
    return st;
}
