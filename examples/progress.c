/* Long work that tells how far it is, and that a person may stop. */
#include <stdio.h>
#include <volvis/volvis.h>

enum { N = 40 };

typedef struct watcher {
    unsigned calls, patience;
} watcher;

/* At most 20 times a second, by one thread at a time; false ends the work. */
static bool on_progress(void *user, const vv_progress *progress)
{
    watcher *w = user;
    w->calls++;
    fprintf(stderr, "%s: %3.0f %%\n", progress->stage, 100.0 * (double)progress->done / (double)progress->total);
    return w->calls < w->patience;
}

static vv_status smooth(watcher *w, vv_runtime *runtime)
{
    vv_job *job = NULL;
    vv_object *params = NULL;
    vv_field *noise = NULL, *smooth = NULL;
    uint8_t *samples;
    vv_field_info info = vv_field_info_default();
    for (int axis = 0; axis < 3; axis++)
        info.grid.dims[axis] = N;
    vv_status st = vv_job_new(&job, runtime, on_progress, w);
    if (st == VV_OK)
        st = vv_field_new_empty(&noise, (void **)&samples, &info, job);
    for (uint32_t i = 0, x = 1; st == VV_OK && i < N * N * N; i++, x = x * 1664525u + 1013904223u)
        samples[i] = (uint8_t)(x >> 24);
    const vv_operation *denoise = vv_operation_find("denoise", job);
    if (st == VV_OK)
        st = denoise ? vv_operation_new_params(&params, denoise) : vv_error_last()->status;
    if (st == VV_OK)
        st = vv_operation_run(&smooth, denoise, (const vv_field *const[]){noise}, 1, params, job);
    vv_field_release(smooth);
    vv_field_release(noise);
    vv_object_release(params);
    vv_job_release(job);
    return st;
}

int main(void)
{
    vv_runtime *runtime;
    watcher hasty = {.patience = 1}, patient = {.patience = 1000000};
    if (vv_runtime_new(&runtime, NULL) != VV_OK)
        return 1;
    const vv_status stopped = smooth(&hasty, runtime), whole = smooth(&patient, runtime);
    printf("the hasty one: %s; the patient one: %s\n", vv_status_name(stopped), vv_status_name(whole));
    vv_runtime_release(runtime);
    return stopped != VV_E_CANCELLED || whole != VV_OK;
}
