/* Names: which are allowed, which known one a misspelt one is nearest to, and where in a document one stands. */
#include "core/property_impl.h"
#include <ctype.h>
#include <string.h>

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

bool vvi_id_valid(const char *id)
{
    const size_t n = strlen(id);
    if (n < 1 || n > VVI_ID_MOST || (id[0] >= '0' && id[0] <= '9') || id[0] == '-')
        return false;
    return strspn(id, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-") == n;
}

static void place_add(vvi_text *text, const vvi_place *place)
{
    if (!place)
        return;
    place_add(text, place->up);
    if (place->name && !*place->name)
        return;
    if (text->n)
        vvi_text_add(text, ".");
    if (place->name)
        vvi_text_add(text, place->name);
    else
        vvi_text_printf(text, "%zu", place->index);
}

char *vvi_place_text(const vvi_place *place)
{
    vvi_text text = {0};
    place_add(&text, place);
    if (!text.n && !text.bad)
        return vvi_strdup("");
    return vvi_text_take(&text);
}

vv_status vvi_fail_place(const vvi_place *place, vv_status status, const char *format, ...)
{
    char message[1024];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    char *where = vvi_place_text(place);
    status = vv_fail_at(status, NULL, where && *where ? where : NULL, "%s", message);
    free(where);
    return status;
}

/* Names for an error, up to what a person reads. */
static void list_names(vvi_text *text, const char *const *names, size_t n)
{
    enum { MOST = 24 };
    for (size_t i = 0; i < n && i < MOST; i++)
        vvi_text_printf(text, "%s%s", i ? ", " : "", names[i]);
    if (n > MOST)
        vvi_text_printf(text, " and %zu more", n - MOST);
}

vv_status vvi_fail_unknown(const vvi_place *place, vv_status status, const char *what, const char *typed,
                           const char *const *names, size_t n)
{
    const char *near = vv_nearest_name(typed, names, n);
    if (near)
        return vvi_fail_place(place, status, "unknown %s '%.64s'; did you mean '%s'?", what, typed, near);
    if (!n)
        return vvi_fail_place(place, status, "unknown %s '%.64s'; none exists yet", what, typed);
    vvi_text known = {0};
    list_names(&known, names, n);
    status = vvi_fail_place(place, status, "unknown %s '%.64s'; known: %s", what, typed, known.s ? known.s : "");
    vvi_text_free(&known);
    return status;
}

static size_t count_names(const vv_object *object)
{
    size_t n = 0;
    for (const vv_property *p = object->cls->properties; p->name; p++)
        n += p->kind == VV_KIND_VARIANTS ? vvi_collection_of(object, p)->n : 1;
    return n;
}

vv_status vvi_fail_unknown_property(const vvi_place *place, const vv_object *object, const char *typed)
{
    const size_t most = count_names(object);
    const char **names = vvi_alloc(NULL, (most + 1) * sizeof *names, VVI_MEM_SCRATCH);
    if (!names)
        return vv_fail_memory((most + 1) * sizeof *names);
    size_t n = 0;
    for (const vv_property *p = object->cls->properties; p->name; p++) {
        if (p->kind != VV_KIND_VARIANTS) {
            names[n++] = p->name;
            continue;
        }
        const vv_collection *variants = vvi_collection_of(object, p);
        for (size_t i = 0; i < variants->n; i++)
            names[n++] = variants->entry[i].id;
    }
    const vv_status st = vvi_fail_unknown(place, VV_E_ARGUMENT, "property", typed, names, n);
    vvi_free(names);
    return st;
}

vv_status vvi_fail_unknown_entry(const vvi_place *place, const vv_collection *collection, const char *typed)
{
    const char **names = vvi_alloc(NULL, (collection->n + 1) * sizeof *names, VVI_MEM_SCRATCH);
    if (!names)
        return vv_fail_memory((collection->n + 1) * sizeof *names);
    size_t n = 0;
    for (size_t i = 0; i < collection->n; i++) {
        if (collection->entry[i].id)
            names[n++] = collection->entry[i].id;
    }
    const vv_status st = vvi_fail_unknown(place, VV_E_NOT_FOUND, "name", typed, names, n);
    vvi_free(names);
    return st;
}
