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

typedef struct kept {
    int32_t code;
    size_t n;
    void *bytes;
} kept;

struct vv_notes {
    vv_job *job; /* only while the header is read; nothing is added later */
    list keys, values, warnings, part_names, part_abouts;
    size_t chosen; /* of the parts; SIZE_MAX: none yet */
    vv_channel *channels;
    vv_label *labels;
    kept *kept;
    size_t n_channels, n_labels, n_kept;
    uint64_t bytes;
    bool full, dropped, hushed;
};

vv_status vvi_notes_new(vv_notes **out, vv_job *job)
{
    *out = vvi_alloc_zeroed(job, sizeof **out, VVI_MEM_MODEL);
    if (!*out)
        return vv_fail_memory(sizeof **out);
    (*out)->job = job;
    (*out)->chosen = SIZE_MAX;
    return VV_OK;
}

void vvi_notes_hush(vv_notes *notes)
{
    notes->hushed = true;
}

bool vvi_notes_are_hushed(const vv_notes *notes)
{
    return notes->hushed;
}

static void list_free(list *l)
{
    for (size_t i = 0; i < l->n; i++)
        vvi_free(l->item[i]);
    vvi_free(l->item);
    *l = (list){0};
}

void vvi_notes_free(vv_notes *notes)
{
    if (!notes)
        return;
    list_free(&notes->keys);
    list_free(&notes->values);
    list_free(&notes->warnings);
    list_free(&notes->part_names);
    list_free(&notes->part_abouts);
    vvi_free(notes->channels);
    for (size_t i = 0; i < notes->n_labels; i++)
        vvi_free((void *)(uintptr_t)notes->labels[i].codes);
    vvi_free(notes->labels);
    for (size_t i = 0; i < notes->n_kept; i++)
        vvi_free(notes->kept[i].bytes);
    vvi_free(notes->kept);
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
    const vv_limits *limits = vvi_job_limits(notes->job);
    const bool many = notes->keys.n >= limits->metadata_keys;
    if (many || notes->bytes + bytes > limits->header_bytes) {
        notes->full = true;
        return vvi_notes_warn(
            notes, "has more metadata than is kept; '%.60s' and what follows are left out (--limit %s=N allows more)",
            key, many ? "metadata_keys" : "header_bytes");
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

/* Whether so much more may be kept. */
static bool has_room(vv_notes *notes, size_t n_entries, uint64_t bytes)
{
    if (n_entries >= vvi_job_limits(notes->job)->metadata_keys ||
        notes->bytes + bytes > vvi_job_limits(notes->job)->header_bytes)
        return false;
    notes->bytes += bytes;
    return true;
}

void vvi_notes_forget_parts(vv_notes *notes)
{
    list_free(&notes->part_names);
    list_free(&notes->part_abouts);
    notes->chosen = SIZE_MAX;
}

vv_status vvi_notes_part(vv_notes *notes, const char *name, const char *about, bool chosen)
{
    if (!has_room(notes, notes->part_names.n, strlen(name) + strlen(about) + 2))
        return VV_OK;
    if (chosen)
        notes->chosen = notes->part_names.n;
    vv_status st = list_add(&notes->part_names, name, notes->job);
    return st == VV_OK ? list_add(&notes->part_abouts, about, notes->job) : st;
}

/* Room for one more in an array that doubles at powers of two. */
static vv_status grow(void **items, size_t n, size_t bytes, vv_job *job)
{
    if (n > 0 && (n & (n - 1)) != 0)
        return VV_OK;
    void *grown = vvi_realloc(job, *items, (n ? n * 2 : 1) * bytes, VVI_MEM_MODEL);
    if (!grown)
        return vv_fail_memory((n ? n * 2 : 1) * bytes);
    *items = grown;
    return VV_OK;
}

vv_status vvi_notes_channel(vv_notes *notes, const vv_channel *channel)
{
    if (!has_room(notes, notes->n_channels, sizeof *channel))
        return VV_OK;
    vv_status st = grow((void **)&notes->channels, notes->n_channels, sizeof *channel, notes->job);
    if (st == VV_OK)
        notes->channels[notes->n_channels++] = *channel;
    return st;
}

/* NULL where there is no room, or nothing in them. */
static vv_status copy_codes(vv_code **out, vv_notes *notes, const vv_code *codes)
{
    const size_t bytes = VV_LABEL_CODES * sizeof *codes;
    bool any = false;
    for (int c = 0; c < VV_LABEL_CODES; c++)
        any |= codes[c].value[0] || codes[c].meaning[0];
    if (!any || !has_room(notes, notes->n_labels, bytes))
        return VV_OK;
    *out = vvi_alloc(notes->job, bytes, VVI_MEM_MODEL);
    if (!*out)
        return vv_fail_memory(bytes);
    memcpy(*out, codes, bytes);
    return VV_OK;
}

vv_status vvi_notes_label(vv_notes *notes, const vv_label *label)
{
    if (!has_room(notes, notes->n_labels, sizeof *label))
        return VV_OK;
    vv_status st = grow((void **)&notes->labels, notes->n_labels, sizeof *label, notes->job);
    vv_code *codes = NULL;
    if (st == VV_OK && label->codes)
        st = copy_codes(&codes, notes, label->codes);
    if (st != VV_OK)
        return st;
    notes->labels[notes->n_labels] = *label;
    notes->labels[notes->n_labels++].codes = codes;
    return VV_OK;
}

vv_status vvi_notes_keep(vv_notes *notes, int32_t code, const void *bytes, size_t n)
{
    if (notes->dropped)
        return VV_OK;
    if (!has_room(notes, notes->n_kept, n)) {
        notes->dropped = true;
        return vvi_notes_warn(
            notes,
            "has more in its header than is kept for a file in the same format (--limit header_bytes=N allows more)");
    }
    vv_status st = grow((void **)&notes->kept, notes->n_kept, sizeof *notes->kept, notes->job);
    if (st != VV_OK)
        return st;
    kept *k = &notes->kept[notes->n_kept];
    *k = (kept){code, n, vvi_alloc(notes->job, n + 1, VVI_MEM_MODEL)};
    if (!k->bytes)
        return vv_fail_memory(n);
    memcpy(k->bytes, bytes, n);
    ((char *)k->bytes)[n] = 0;
    notes->n_kept++;
    return VV_OK;
}

const void *vvi_notes_kept(const vv_notes *notes, size_t index, int32_t *code_out, size_t *n_out)
{
    if (index >= notes->n_kept)
        return NULL;
    *code_out = notes->kept[index].code;
    *n_out = notes->kept[index].n;
    return notes->kept[index].bytes;
}

bool vvi_notes_get_part(const vv_notes *notes, size_t index, vv_part *out)
{
    if (index >= notes->part_names.n || index >= notes->part_abouts.n)
        return false;
    *out = (vv_part){notes->part_names.item[index], notes->part_abouts.item[index], index == notes->chosen};
    return true;
}

const vv_channel *vvi_notes_channels(const vv_notes *notes, size_t *n_out)
{
    *n_out = notes->n_channels;
    return notes->channels;
}

const vv_label *vvi_notes_labels(const vv_notes *notes, size_t *n_out)
{
    *n_out = notes->n_labels;
    return notes->labels;
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
