/* What is said of parts: that one of several was taken, and that there is none of a name. */
#include "core/job.h"
#include "core/memory.h"
#include "core/names.h"
#include "core/text.h"
#include "io/notes.h"

static size_t count(const vv_notes *notes)
{
    vv_part part;
    size_t n = 0;
    while (vvi_notes_get_part(notes, n, &part))
        n++;
    return n;
}

/* "b, c and 4 more": those that were not chosen. *n_out: all of them. */
static void add_others(vvi_text *out, size_t n, const vv_notes *notes)
{
    enum { SHOWN = 6 };
    vv_part part;
    size_t others = 0;
    for (size_t i = 0; vvi_notes_get_part(notes, i, &part); i++) {
        if (part.chosen || others++ >= SHOWN)
            continue;
        vvi_text_printf(out, "%s%.80s", others == 1 ? "" : others == n ? " and " : ", ", part.name);
    }
    if (n > SHOWN)
        vvi_text_printf(out, " and %zu more", n - SHOWN);
}

vv_status vvi_notes_warn_unnamed(vv_notes *notes, const char *file, const char *kind)
{
    const char *chosen = NULL, *other = NULL;
    const size_t n = count(notes);
    vvi_text others = {0};
    vv_part part;
    for (size_t i = 0; vvi_notes_get_part(notes, i, &part); i++)
        if (part.chosen)
            chosen = part.name;
        else
            other = other ? other : part.name;
    if (!chosen || !other || vvi_notes_are_hushed(notes)) /* one of many files: it is told of all together */
        return VV_OK;
    add_others(&others, n - 1, notes);
    const vv_status st =
        others.bad
            ? vv_fail_memory(others.n)
            : vvi_notes_warn(notes,
                             "holds %zu %s, and none is named; this is %.80s. There %s %s too, named as %s:%.80s", n,
                             kind, chosen, n > 2 ? "are" : "is", others.s, file, other);
    vvi_text_free(&others);
    return st;
}

vv_status vvi_notes_fail_part(const vv_notes *notes, vv_status status, const char *file, const char *kind,
                              const char *typed)
{
    const size_t n = count(notes);
    if (n == 0)
        return vv_fail_at(status, file, NULL, "has no %s '%.60s'", kind, typed);
    const char **names = vvi_alloc(NULL, (n + 1) * sizeof *names, VVI_MEM_SCRATCH);
    vv_part part;
    if (!names)
        return vv_fail_memory((n + 1) * sizeof *names);
    for (size_t i = 0; i < n && vvi_notes_get_part(notes, i, &part); i++)
        names[i] = part.name;
    const vv_status st = vvi_fail_name(status, file, NULL, typed, &(vvi_known){names, n, "volvis info"},
                                       "has no %s '%.60s'", kind, typed);
    vvi_free(names);
    return st;
}
