#include "server/warnings.h"
#include "core/memory.h"
#include "core/runtime.h"

#include <stdlib.h>
#include <string.h>

enum { BYTES_MOST = 8192 };

static bool is_there(const char *all, const char *line, size_t n)
{
    for (; all && *all; all += strcspn(all, "\n") + 1)
        if (strcspn(all, "\n") == n && strncmp(all, line, n) == 0)
            return true;
    return false;
}

static void add_line(vvi_warnings *warnings, const char *line, size_t n)
{
    const size_t before = *warnings ? strlen(*warnings) : 0;
    if (n == 0 || before + n > BYTES_MOST || is_there(*warnings, line, n))
        return;
    char *more = vvi_realloc_plain(*warnings, before + n + 2);
    if (!more)
        return;
    memcpy(more + before, line, n);
    memcpy(more + before + n, "\n", 2);
    *warnings = more;
}

static void gather(void *user, vv_log_level level, const char *component, const char *text)
{
    (void)level;
    if (strcmp(component, "io") == 0)
        add_line(user, text, strcspn(text, "\n"));
}

void vvi_warnings_gather(vvi_warnings *warnings, vv_job *job)
{
    if (job)
        vvi_job_listen_warnings(job, gather, warnings);
}

void vvi_warnings_add(vvi_warnings *warnings, vvi_warnings more)
{
    for (const char *at = more; at && *at; at += strcspn(at, "\n") + 1)
        add_line(warnings, at, strcspn(at, "\n"));
    free(more);
}
