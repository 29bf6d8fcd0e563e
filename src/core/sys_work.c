/* The public names of what core does for rows of other programs: volvis/sys/work.h. */
#include "core/findings.h"
#include "core/job.h"
#include "core/memory.h"
#include <stdio.h>
#include <volvis/sys/registry.h>
#include <volvis/sys/work.h>

enum { SENTENCE = 1024 };

vv_status vv_parallel_for(vv_job *job, const vv_work *work, void *shared, size_t n_items)
{
    return vvi_parallel_for(job, work, shared, n_items);
}

const vv_registry *vv_job_registry(const vv_job *job)
{
    return vvi_job_registry(job);
}

int vv_job_threads(const vv_job *job)
{
    return vvi_job_threads(job);
}

vv_status vv_job_poll(const vv_job *job)
{
    return vvi_job_poll(job);
}

vv_status vv_job_progress(vv_job *job, const char *stage, uint64_t done, uint64_t total)
{
    return vvi_job_progress(job, stage, done, total);
}

void vv_job_warn(vv_job *job, const char *component, const char *format, ...)
{
    char text[SENTENCE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    vvi_job_warn(job, component, "%s", text);
}

void *vv_alloc(vv_job *job, size_t bytes)
{
    return vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
}

void vv_free(void *memory)
{
    vvi_free(memory);
}

vv_status vv_memory_plan(vv_job *job, uint64_t bytes, const char *what)
{
    return vvi_memory_plan(job, bytes, what);
}

void vv_job_find_number(vv_job *job, const char *name, double value)
{
    vvi_find_number(job, name, value);
}

void vv_job_find_phrase(vv_job *job, const char *format, ...)
{
    char text[SENTENCE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    vvi_find_phrase(job, "%s", text);
}

void vv_job_find_note(vv_job *job, const char *format, ...)
{
    char text[SENTENCE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    vvi_find_note(job, "%s", text);
}
