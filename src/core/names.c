/* Which of the known names was typed, which one a misspelt one is nearest to, and the sentence that says so. */
#include "core/names.h"
#include <ctype.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <volvis/property.h>

enum { LONGEST_NAME = 127 };

/* Optimal string alignment: insert, delete, replace, swap of neighbours cost 1; case costs nothing. */
static size_t edit_distance(const char *a, size_t n_a, const char *b, size_t n_b)
{
    size_t rows[3][LONGEST_NAME + 2];
    size_t *before = rows[0], *last = rows[1], *row = rows[2];
    for (size_t j = 0; j <= n_b; j++)
        last[j] = j;
    for (size_t i = 1; i <= n_a; i++) {
        row[0] = i;
        for (size_t j = 1; j <= n_b; j++) {
            const int ca = tolower((unsigned char)a[i - 1]), cb = tolower((unsigned char)b[j - 1]);
            size_t d = last[j - 1] + (ca != cb);
            d = last[j] + 1 < d ? last[j] + 1 : d;
            d = row[j - 1] + 1 < d ? row[j - 1] + 1 : d;
            if (i > 1 && j > 1 && ca == tolower((unsigned char)b[j - 2]) && cb == tolower((unsigned char)a[i - 2]))
                d = before[j - 2] + 1 < d ? before[j - 2] + 1 : d;
            row[j] = d;
        }
        size_t *oldest = before;
        before = last;
        last = row;
        row = oldest;
    }
    return last[n_b];
}

const char *vv_nearest_name(const char *typed, const char *const *names, size_t n)
{
    const char *best = NULL;
    size_t best_distance = SIZE_MAX;
    const size_t n_typed = strlen(typed);
    if (n_typed > LONGEST_NAME)
        return NULL;
    for (size_t i = 0; i < n; i++) {
        const size_t n_name = strlen(names[i]);
        if (n_name > LONGEST_NAME)
            continue;
        const size_t d = edit_distance(typed, n_typed, names[i], n_name);
        if (d < best_distance && 3 * d <= (n_name > n_typed ? n_name : n_typed)) {
            best_distance = d;
            best = names[i];
        }
    }
    return best;
}

size_t vvi_name_find(const char *typed, const char *const *names, size_t n)
{
    size_t found = n, n_found = 0;
    for (size_t i = 0; i < n; i++) {
        if (strcmp(names[i], typed) == 0)
            return i;
        if (strcasecmp(names[i], typed) == 0) {
            found = i;
            n_found++;
        }
    }
    return n_found == 1 ? found : n;
}

/* " (or mip)" behind "maximum" */
static void add_aliases(vvi_text *out, const char *name, const char *const *aliases)
{
    size_t n = 0;
    for (const char *const *pair = aliases; pair && pair[0]; pair += 2)
        if (strcmp(pair[1], name) == 0)
            vvi_text_printf(out, "%s%s", n++ ? " or " : " (or ", pair[0]);
    vvi_text_add(out, n ? ")" : "");
}

/* The nearest of names and aliases. */
static const char *nearest(const char *typed, const vvi_known *names)
{
    const char *near = vv_nearest_name(typed, names->name, names->n);
    for (const char *const *pair = names->aliases; pair && pair[0]; pair += 2) {
        const char *const both[] = {near, pair[0]};
        near = vv_nearest_name(typed, near ? both : both + 1, near ? 2 : 1);
    }
    return near;
}

static void add_list(vvi_text *out, const vvi_known *names)
{
    enum { BEGUN = 24 };
    const size_t n = names->n <= VVI_KNOWN_LISTED ? names->n : BEGUN;
    for (size_t i = 0; i < n; i++) {
        vvi_text_printf(out, "%s%s", i == 0 ? "" : i + 1 < names->n ? ", " : " and ", names->name[i]);
        add_aliases(out, names->name[i], names->aliases);
    }
    if (n < names->n)
        vvi_text_printf(out, " and %zu more", names->n - n);
}

void vvi_known_add(vvi_text *out, const char *typed, const vvi_known *names)
{
    const char *near = nearest(typed, names);
    const bool listed = names->n > 0 && (names->n <= VVI_KNOWN_LISTED || !names->lister);
    if (near)
        vvi_text_printf(out, "; did you mean '%s'?", near);
    if (listed) {
        vvi_text_printf(out, "%s%s ", near ? " There " : "; there ", names->n == 1 ? "is" : "are");
        add_list(out, names);
    } else if (names->n > 0) {
        vvi_text_printf(out, "%s'%s' lists them", near ? " " : "; ", names->lister);
    } else {
        vvi_text_add(out, "; there are none");
    }
}

vv_status vvi_fail_name(vv_status status, const char *file, const char *where, const char *typed,
                        const vvi_known *names, const char *format, ...)
{
    char sentence[1024];
    vvi_text end = {0};
    va_list args;
    va_start(args, format);
    vsnprintf(sentence, sizeof sentence, format, args);
    va_end(args);
    vvi_known_add(&end, typed, names);
    status = vv_fail_at(status, file, where, "%s%s", sentence, end.s && !end.bad ? end.s : "");
    vvi_text_free(&end);
    return status;
}
