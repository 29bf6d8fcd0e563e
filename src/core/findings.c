#include "core/findings.h"
#include "core/memory.h"
#include "core/result.h"
#include "core/runtime.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void drop(vv_finding *f)
{
    free((char *)(uintptr_t)f->name);
    free((char *)(uintptr_t)f->json);
    free((char *)(uintptr_t)f->phrase);
    free((char *)(uintptr_t)f->note);
}

void vv_job_forget_findings(vv_job *job)
{
    if (!job)
        return;
    for (size_t i = 0; i < job->n_findings; i++)
        drop(&job->findings[i]);
    free(job->findings);
    job->findings = NULL;
    job->n_findings = 0;
}

bool vv_job_finding(vv_finding *out, const vv_job *job, size_t index)
{
    if (!job || index >= job->n_findings)
        return false;
    *out = job->findings[index];
    return true;
}

static vv_finding *place_of(vv_job *job, const char *name)
{
    for (size_t i = 0; name && i < job->n_findings; i++)
        if (job->findings[i].name && strcmp(job->findings[i].name, name) == 0) {
            drop(&job->findings[i]);
            return &job->findings[i];
        }
    vv_finding *more = vvi_realloc_plain(job->findings, (job->n_findings + 1) * sizeof *more);
    if (!more)
        return NULL;
    job->findings = more;
    return &more[job->n_findings++];
}

/* What it points to is given. */
static void find(vv_job *job, vv_finding finding)
{
    vv_finding *at = finding.json || finding.phrase || finding.note ? place_of(job, finding.name) : NULL;
    if (at)
        *at = finding;
    else
        drop(&finding);
}

static void find_json(vv_job *job, const char *name, vvi_result *json)
{
    const vv_finding finding = {.name = vvi_strdup(name), .json = vvi_text_take(&json->text)};
    find(job, finding.name ? finding : (vv_finding){.json = NULL});
    if (!finding.name)
        free((char *)(uintptr_t)finding.json);
}

void vvi_find_number(vv_job *job, const char *name, double value)
{
    vvi_result json = {.compact = true};
    if (!job)
        return;
    vvi_result_number(&json, NULL, value);
    find_json(job, name, &json);
}

void vvi_find_numbers(vv_job *job, const char *name, const double *values, size_t n)
{
    vvi_result json = {.compact = true};
    if (!job)
        return;
    vvi_result_numbers(&json, NULL, values, n);
    find_json(job, name, &json);
}

void vvi_find_count(vv_job *job, const char *name, uint64_t value)
{
    vvi_result json = {.compact = true};
    if (!job)
        return;
    vvi_result_unsigned(&json, NULL, value);
    find_json(job, name, &json);
}

void vvi_find_bool(vv_job *job, const char *name, bool value)
{
    vvi_result json = {.compact = true};
    if (!job)
        return;
    vvi_result_bool(&json, NULL, value);
    find_json(job, name, &json);
}

void vvi_find_string(vv_job *job, const char *name, const char *value)
{
    vvi_result json = {.compact = true};
    if (!job)
        return;
    vvi_result_string(&json, NULL, value);
    find_json(job, name, &json);
}

static char *print(const char *format, va_list arguments)
{
    char *text = NULL;
    return vasprintf(&text, format, arguments) < 0 ? NULL : text;
}

void vvi_find_phrase(vv_job *job, const char *format, ...)
{
    va_list arguments;
    if (!job)
        return;
    va_start(arguments, format);
    find(job, (vv_finding){.phrase = print(format, arguments)});
    va_end(arguments);
}

void vvi_find_note(vv_job *job, const char *format, ...)
{
    va_list arguments;
    if (!job)
        return;
    va_start(arguments, format);
    find(job, (vv_finding){.note = print(format, arguments)});
    va_end(arguments);
}

/* Kept ------------------------------------------------------------------------------------------------------------- */

static vv_finding copy_of(const vv_finding *f)
{
    return (vv_finding){.name = f->name ? vvi_strdup(f->name) : NULL,
                        .json = f->json ? vvi_strdup(f->json) : NULL,
                        .phrase = f->phrase ? vvi_strdup(f->phrase) : NULL,
                        .note = f->note ? vvi_strdup(f->note) : NULL};
}

void vvi_findings_keep(vvi_findings *out, const vv_job *job)
{
    *out = (vvi_findings){.n = job ? job->n_findings : 0};
    out->all = out->n ? vvi_calloc(out->n, sizeof *out->all) : NULL;
    if (!out->all)
        out->n = 0;
    for (size_t i = 0; i < out->n; i++)
        out->all[i] = copy_of(&job->findings[i]);
}

void vvi_findings_tell(vv_job *job, const vvi_findings *kept)
{
    for (size_t i = 0; job && i < kept->n; i++)
        find(job, copy_of(&kept->all[i]));
}

void vvi_findings_free(vvi_findings *kept)
{
    for (size_t i = 0; i < kept->n; i++)
        drop(&kept->all[i]);
    free(kept->all);
    *kept = (vvi_findings){.n = 0};
}
