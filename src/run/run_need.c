/* Whether memory holds what streaming takes, before anything is written; and where it does not, how much would. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "core/units.h"
#include "grid/store.h"
#include "run/run_impl.h"
#include <volvis/runtime.h>

enum {
    WRITING = 560 << 10, /* bytes that writing a file holds beside the samples */
    TRIALS = 48          /* of limits, each an eighth above the one before */
};

/* The first slab, which stays for whoever reads or writes it. The others take no more, or get thinner. */
static vv_status make_first(const vv_run *r, bool written, vv_job *job)
{
    const int64_t *n = vv_field_get_info(r->results[0].field)->grid.dims;
    const vv_box slice = {{0, 0, 0}, {n[0], n[1], 1}};
    void *writing = written ? vvi_alloc(job, WRITING, VVI_MEM_SCRATCH) : NULL;
    vv_brick brick;
    vv_status st =
        written && !writing ? vv_fail_memory(WRITING) : vv_field_brick(&brick, r->results[0].field, &slice, job);
    if (st == VV_OK)
        vv_brick_release(&brick);
    vvi_free(writing);
    return st;
}

/* Passes over all samples are too much for a trial, and so is what goes through files. */
static bool has_passes(const vv_run *r)
{
    for (size_t s = 0; s < r->n_steps; s++)
        if (r->steps[s].operation->passes || r->ways[s].spooled)
            return true;
    return false;
}

/* What has passes is rehearsed: the memory that its slabs take is asked for, and nothing is read. */
static vv_status try_in(const vv_run *r, uint64_t limit)
{
    const vvi_run_plan plan = {r->inputs, r->n_inputs, r->steps, r->takes, r->n_steps, r->name, r->settled};
    const vv_runtime *from = vv_job_runtime(r->job);
    vv_runtime_options options;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_run *run = NULL;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = vv_runtime_threads(from);
    options.memory_bytes = limit;
    options.registry = vvi_job_registry(r->job);
    options.limits = vvi_job_limits(r->job);
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK && (st = vv_job_new(&job, runtime, NULL, NULL)) == VV_OK)
        st = vvi_run_new(&run, &plan, &(vv_run_output){.path = NULL}, job);
    if (st == VV_OK && run->about.streamed) { /* what memory holds as a whole is not tried */
        run->stream.rehearses = has_passes(r);
        if ((st = vvi_run_make_all(run)) == VV_OK)
            st = make_first(run, r->path != NULL, job);
    }
    vv_run_release(run);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st;
}

static bool has_looks(const vv_run *r)
{
    for (size_t s = 0; s < r->n_steps; s++)
        if (r->steps[s].operation->looks && r->steps[s].operation->looks(r->steps[s].params))
            return true;
    return false;
}

/* The first limit of more and more with which it is done, as it is with the one after it: as slabs come in whole
 * slices, somewhat more may be too little again. 0: none. */
static uint64_t find_need(const vv_run *r, uint64_t limit)
{
    vv_status st = VV_E_LIMIT;
    int enough = 0;
    for (int i = 0; i < TRIALS && enough < 2 && (st == VV_OK || st == VV_E_LIMIT); i++) {
        limit += limit / 8;
        st = try_in(r, limit);
        enough = st == VV_OK ? enough + 1 : 0;
    }
    return enough < 2 ? 0 : limit;
}

/* Makes of "there is no memory" how much would be enough. */
static vv_status tell_need(const vv_run *r)
{
    const uint64_t limit = vv_runtime_memory_limit(vv_job_runtime(r->job));
    vvi_error_copy before;
    char text[32], text_limit[32];
    vvi_error_take(&before);
    const uint64_t need = find_need(r, limit);
    if (need == 0)
        return vvi_error_put(&before);
    vvi_error_copy_free(&before);
    vvi_print_bytes(text, need);
    vvi_print_bytes(text_limit, limit);
    return vv_fail(VV_E_LIMIT, "%s needs about %s even slab by slab, and the limit is %s; give more with --memory",
                   r->name, text, text_limit);
}

/* Before passes begin: what slabs of zeros cannot tell, they say themselves. */
static vv_status rehearse(const vv_run *r)
{
    const vv_status st = try_in(r, vv_runtime_memory_limit(vv_job_runtime(r->job)));
    return st == VV_E_LIMIT ? tell_need(r) : st == VV_E_CANCELLED ? st : VV_OK;
}

static vv_status make_planned(vv_run *r)
{
    const bool passes = r->about.streamed && has_passes(r);
    vv_status st = passes ? rehearse(r) : VV_OK;
    if (st != VV_OK)
        return st;
    st = vvi_run_make_all(r);
    if (st == VV_OK && r->about.streamed && (st = vvi_field_prepare(r->results[0].field, r->job)) == VV_OK)
        st = make_first(r, r->path != NULL, r->job);
    /* memory is of no file; and what has passed the rehearsal says itself what it lacks */
    return st != VV_E_LIMIT || !r->about.streamed || passes || vv_error_last()->file ? st : tell_need(r);
}

/* What steps hold may hang on the samples: where memory turns out to lack, those that can begin again slab by slab. */
static vv_status stream_instead(vv_run *r)
{
    vvi_error_copy before;
    vvi_error_take(&before);
    vv_job_forget_findings(r->job);
    vv_status st = vvi_run_plan_streamed(r);
    if (st == VV_OK)
        st = make_planned(r);
    if (st == VV_OK || st == VV_E_LIMIT || st == VV_E_CANCELLED || st == VV_E_WRITE) {
        vvi_error_copy_free(&before);
        return st;
    }
    return vvi_error_put(&before); /* what came by a pipe is gone, say */
}

vv_status vvi_run_make(vv_run *r)
{
    const vv_status st = make_planned(r);
    const bool can = r->about.makes == VV_IS_FIELD && !r->whole && r->job && vv_job_runtime(r->job);
    return st == VV_E_LIMIT && can && !r->about.streamed ? stream_instead(r) : st;
}

vv_status vvi_run_try(vv_run *r)
{
    if (!r->about.streamed || has_looks(r))
        return VV_OK;
    return has_passes(r) ? rehearse(r) : vvi_run_make(r);
}
