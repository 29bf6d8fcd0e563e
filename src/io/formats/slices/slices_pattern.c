/* Patterns that choose slices by their names. */
#include "io/formats/slices/slices.h"
#include <string.h>

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* The role of "{z}", "{c}", "{t}"; VVI_SLICE_FIXED of anything else. */
static vvi_slice_role braced(const char *p)
{
    if (p[0] != '{' || !p[1] || p[2] != '}')
        return VVI_SLICE_FIXED;
    return p[1] == 'z' ? VVI_SLICE_Z : p[1] == 'c' ? VVI_SLICE_C : p[1] == 't' ? VVI_SLICE_T : VVI_SLICE_FIXED;
}

bool vvi_slices_counts(const char *pattern)
{
    for (const char *p = pattern; *p; p++)
        if (*p == '#' || braced(p) != VVI_SLICE_FIXED)
            return true;
    return false;
}

/* Letters, digits and what else a channel's name may hold; not the marks between words. */
static size_t word_length(const char *name)
{
    return strcspn(name, "_-. =");
}

#define STEPS_MOST 65536 /* of one name: patterns with many '*' and numbers could take for ever */

typedef struct matching {
    vvi_slice_runs *out;
    const char *whole;
    size_t steps;
} matching;

static bool match(matching *m, const char *pattern, const char *name);

/* A number or word that counts, then the rest. */
static bool match_number(matching *m, const char *pattern, const char *name)
{
    const vvi_slice_role role = braced(pattern);
    const char *rest = pattern + (role == VVI_SLICE_FIXED ? 1 : 3);
    const size_t at = (size_t)(name - m->whole), n_before = m->out->n, digits = strspn(name, "0123456789");
    if (n_before == VVI_SLICE_RUNS || (at > 0 && digits > 0 && is_digit(name[-1])))
        return false;
    vvi_slice_run run = digits > 0 ? vvi_slices_number(m->whole, at) : (vvi_slice_run){.at = at};
    if (role != VVI_SLICE_FIXED)
        run.role = role;
    else if (run.weak || run.role > VVI_SLICE_T)
        run.role = VVI_SLICE_UNKNOWN;
    const size_t ends[2] = {digits, run.role == VVI_SLICE_C ? word_length(name) : digits};
    for (int i = 0; i < 2; i++) {
        run.n = ends[i];
        if (run.n == 0 || (i == 1 && ends[1] == ends[0]))
            continue;
        m->out->run[m->out->n++] = run;
        if (match(m, rest, name + run.n))
            return true;
        m->out->n = n_before;
    }
    return false;
}

/* Of each run of the loop only the last '*' is ever widened: what came before it fits as early as it can, which serves
 * later text best. */
static bool match(matching *m, const char *p, const char *name)
{
    const char *star = NULL, *from = NULL;
    const size_t n = m->out->n;
    while (m->steps++ < STEPS_MOST) {
        if (*p == '#' || braced(p) != VVI_SLICE_FIXED) {
            if (match_number(m, p, name))
                return true;
        } else if (*p == '*') {
            star = ++p;
            from = name;
            continue;
        } else if (*p && *name && (*p == '?' || *p == *name)) {
            p++;
            name++;
            continue;
        } else if (!*p && !*name) {
            return true;
        }
        if (!star || !*from)
            return false;
        p = star;
        name = ++from;
        m->out->n = n;
    }
    return false;
}

bool vvi_slices_match(vvi_slice_runs *out, const char *pattern, const char *name)
{
    matching m = {.out = out, .whole = name};
    out->n = 0;
    if (!vvi_slices_counts(pattern) && !strpbrk(pattern, "*?"))
        return strncmp(name, pattern, strlen(pattern)) == 0;
    return match(&m, pattern, name);
}
