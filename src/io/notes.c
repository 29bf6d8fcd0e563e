#include "io/notes.h"
#include "core/memory.h"
#include "io/source.h"
#include <stdio.h>
#include <string.h>

#define WARNINGS_MOST 64

typedef struct list {
    char **item;
    size_t n, room;
} list;

struct vv_notes {
    vv_job *job; /* only while the header is read; nothing is added later */
    list keys, values, warnings;
    uint64_t bytes;
    bool full;
};

vv_status vvi_notes_new(vv_notes **out, vv_job *job)
{
    *out = vvi_alloc_zeroed(job, sizeof **out, VVI_MEM_MODEL);
    if (!*out)
        return vv_fail_memory(sizeof **out);
    (*out)->job = job;
    return VV_OK;
}

static void list_free(list *l)
{
    for (size_t i = 0; i < l->n; i++)
        vvi_free(l->item[i]);
    vvi_free(l->item);
}

void vvi_notes_free(vv_notes *notes)
{
    if (!notes)
        return;
    list_free(&notes->keys);
    list_free(&notes->values);
    list_free(&notes->warnings);
    vvi_free(notes);
}

static vv_status list_add(list *l, const char *text, vv_job *job)
{
    const size_t n = strlen(text) + 1;
    if (l->n == l->room) {
        const size_t room = l->room ? l->room * 2 : 16;
        char **grown = vvi_realloc(job, l->item, room * sizeof *grown, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        l->item = grown;
        l->room = room;
    }
    char *copy = vvi_alloc(job, n, VVI_MEM_MODEL);
    if (!copy)
        return vv_fail_memory(n);
    memcpy(copy, text, n);
    l->item[l->n++] = copy;
    return VV_OK;
}

vv_status vvi_notes_add(vv_notes *notes, const char *key, const char *value)
{
    const uint64_t bytes = strlen(key) + strlen(value) + 2;
    if (notes->full)
        return VV_OK;
    if (notes->keys.n >= vvi_limits_default.metadata_keys || notes->bytes + bytes > vvi_limits_default.header_bytes) {
        notes->full = true;
        return vvi_notes_warn(notes, "has more metadata than is kept; what follows '%.60s' is left out", key);
    }
    notes->bytes += bytes;
    vv_status st = list_add(&notes->keys, key, notes->job);
    return st == VV_OK ? list_add(&notes->values, value, notes->job) : st;
}

vv_status vvi_notes_warn(vv_notes *notes, const char *format, ...)
{
    char text[512];
    va_list args;
    if (notes->warnings.n >= WARNINGS_MOST)
        return VV_OK;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return list_add(&notes->warnings, text, notes->job);
}

bool vvi_notes_get(const vv_notes *notes, size_t index, const char **key_out, const char **value_out)
{
    if (index >= notes->keys.n || index >= notes->values.n)
        return false;
    *key_out = notes->keys.item[index];
    *value_out = notes->values.item[index];
    return true;
}

const char *vvi_notes_warning(const vv_notes *notes, size_t index)
{
    return index < notes->warnings.n ? notes->warnings.item[index] : NULL;
}
