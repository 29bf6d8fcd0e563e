/* Names of properties: which are allowed, which are unknown, and where in a document one stands. */
#include "core/names.h"
#include "core/property_impl.h"
#include <stdlib.h>
#include <string.h>

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

vv_status vvi_fail_unknown(const vvi_place *place, vv_status status, const char *what, const char *typed,
                           const vvi_known *names)
{
    if (!names->n)
        return vvi_fail_place(place, status, "unknown %s '%.64s'; none exists yet", what, typed);
    char *where = vvi_place_text(place);
    status =
        vvi_fail_name(status, NULL, where && *where ? where : NULL, typed, names, "unknown %s '%.64s'", what, typed);
    free(where);
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
    const vv_status st = vvi_fail_unknown(place, VV_E_ARGUMENT, "property", typed, &(vvi_known){.name = names, .n = n});
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
    const bool is_number = *typed && strspn(typed, "0123456789") == strlen(typed) && strlen(typed) < 10;
    const size_t number = is_number ? strtoul(typed, NULL, 10) : n;
    const vv_status st =
        number < n ? vvi_fail_place(place, VV_E_NOT_FOUND,
                                    "entries have names and no numbers; did you mean '%s'? It is number %s of %zu",
                                    names[number], typed, n)
                   : vvi_fail_unknown(place, VV_E_NOT_FOUND, "name", typed, &(vvi_known){.name = names, .n = n});
    vvi_free(names);
    return st;
}

/* What `when` says before and behind its "=" ----------------------------------------------------------------------- */

bool vvi_property_acts_with(const vv_property *row, const char *word)
{
    const char *at = row->when ? strchr(row->when, '=') : NULL;
    if (!at)
        return true;
    const size_t n = strlen(word);
    for (at++; strncmp(at, word, n) != 0 || (at[n] && at[n] != '|'); at++) {
        at += strcspn(at, "|");
        if (!*at)
            return false;
    }
    return true;
}

const vv_property *vvi_property_choice(const vv_class *cls, const vv_property *row)
{
    char name[64];
    const size_t n = row->when ? strcspn(row->when, "=") : 0;
    if (n == 0 || n >= sizeof name || row->when[n] != '=')
        return NULL;
    memcpy(name, row->when, n);
    name[n] = 0;
    const vv_property *choice = vv_class_find(cls, name);
    return choice && choice->kind == VV_KIND_ENUM ? choice : NULL;
}
