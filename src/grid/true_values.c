#include "grid/true_values.h"
#include "core/memory.h"
#include "grid/lazy.h"
#include "grid/sample_map.h"
#include <math.h>

/* Two of them are kept, and what is written may be made slab by slab for want of memory. */
static uint64_t slab_bytes(const vv_job *job)
{
    const uint64_t most = (uint64_t)32 << 20;
    const vv_runtime *runtime = job ? vv_job_runtime(job) : NULL;
    const uint64_t share = runtime ? vv_runtime_memory_limit(runtime) / 64 : most;
    return share < most ? share : most;
}

bool vvi_has_scale(const vv_field_info *info)
{
    return info->value_scale != 1 || info->value_offset != 0;
}

/* Whole multiples of whole numbers, which doubles hold exactly. */
static bool are_whole(const vv_field_info *info)
{
    const double most = 9007199254740992.0; /* 2^53 */
    return !vv_type_is_float(info->type) && floor(info->value_scale) == info->value_scale &&
           floor(info->value_offset) == info->value_offset && fabs(info->value_scale) < most &&
           fabs(info->value_offset) < most;
}

/* Of the numbers up to there. */
static double f32_spacing(double most)
{
    const float a = (float)fabs(most);
    return (double)a - (double)nextafterf(a, 0);
}

static bool tells_steps_apart_in_f32(const vv_field_info *info, double lo, double hi)
{
    const double most = fmax(fabs(lo), fabs(hi));
    const double stored = fmax(fabs(lo - info->value_offset), fabs(hi - info->value_offset)) / fabs(info->value_scale);
    if (!isfinite((float)most))
        return false;
    if (info->type == VV_TYPE_F32) /* as well as f32 did before, to half a step */
        return f32_spacing(most) <= 2 * f32_spacing(stored) * fabs(info->value_scale);
    return f32_spacing(most) <= fabs(info->value_scale);
}

vv_type vvi_true_values_type(const vv_field_info *info, double lo, double hi, unsigned types)
{
    static const vv_type whole[] = {VV_TYPE_U8,  VV_TYPE_I8,  VV_TYPE_U16, VV_TYPE_I16,
                                    VV_TYPE_U32, VV_TYPE_I32, VV_TYPE_U64, VV_TYPE_I64};
    if (info->type == VV_TYPE_F64)
        return VV_TYPE_F64;
    if (lo > hi)
        lo = hi = info->value_offset;
    for (size_t i = 0; are_whole(info) && i < sizeof whole / sizeof *whole; i++)
        if ((!types || types & 1u << whole[i]) && lo >= vvi_type_min(whole[i]) && hi <= vvi_type_max(whole[i]))
            return whole[i];
    return tells_steps_apart_in_f32(info, lo, hi) ? VV_TYPE_F32 : VV_TYPE_F64;
}

typedef struct scaled {
    vv_field *field;
    vv_field_info info; /* of the result */
    vvi_sample_map map;
} scaled;

static vv_status make(vv_field **out, void *user, const vv_box *box, vv_job *job)
{
    const scaled *s = user;
    return vvi_sample_map_run(out, s->field, &s->info, box, &s->map, NULL, job);
}

static void drop(void *user)
{
    scaled *s = user;
    vv_field_release(s->field);
    vvi_free(s);
}

static vv_status make_lazy(vv_field **out, const vv_field *field, vv_type type, vvi_lazy_pool *pool, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(field);
    scaled *s = vvi_alloc(job, sizeof *s, VVI_MEM_MODEL);
    if (!s)
        return vv_fail_memory(sizeof *s);
    *s = (scaled){.field = vv_field_retain(field),
                  .info = *info,
                  .map = {info->value_scale, info->value_offset, -INFINITY, INFINITY}};
    s->info.type = type;
    s->info.value_scale = 1;
    s->info.value_offset = 0;
    if (s->info.meaning == VV_MEANING_LABEL && vv_type_is_float(type))
        s->info.meaning = VV_MEANING_SCALAR; /* labels are whole */
    return vvi_field_lazy(out, &s->info, &(vvi_lazy_source){make, drop, s}, pool, job);
}

vv_status vvi_true_values(vv_field **out, const vv_field *const *fields, size_t n, unsigned types, vv_job *job)
{
    double lo = INFINITY, hi = -INFINITY;
    vvi_lazy_pool *pool = NULL;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n; i++)
        out[i] = NULL;
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st = vvi_field_widen_range(&lo, &hi, fields[i], job);
    if (st == VV_OK)
        st = vvi_lazy_pool_new(&pool, slab_bytes(job), 0, job);
    for (size_t i = 0; i < n && st == VV_OK; i++)
        st =
            make_lazy(&out[i], fields[i], vvi_true_values_type(vv_field_get_info(fields[0]), lo, hi, types), pool, job);
    vvi_lazy_pool_release(pool);
    for (size_t i = 0; i < n && st != VV_OK; i++) {
        vv_field_release(out[i]);
        out[i] = NULL;
    }
    return st;
}
