/* Lists, maps, variants and rows of numbers: immutable once shared, so an edit makes a new one that shares the rest. */
#include "core/property_impl.h"
#include <string.h>

vv_status vvi_collection_new(vv_collection **out, size_t n)
{
    *out = NULL;
    if (n > VVI_COLLECTION_MOST)
        return vv_fail(VV_E_LIMIT, "a list or map of %zu entries is too long: at most %d are allowed", n,
                       VVI_COLLECTION_MOST);
    const size_t bytes = sizeof(vv_collection) + n * sizeof(vv_entry);
    vv_collection *collection = vvi_alloc_zeroed(NULL, bytes, VVI_MEM_MODEL);
    if (!collection)
        return vv_fail_memory(bytes);
    collection->refs = 1;
    collection->n = n;
    *out = collection;
    return VV_OK;
}

vv_collection *vvi_collection_retain(const vv_collection *collection)
{
    vv_collection *shared = (vv_collection *)collection;
    if (shared)
        __atomic_add_fetch(&shared->refs, 1, __ATOMIC_RELAXED);
    return shared;
}

void vvi_collection_release(vv_collection *collection)
{
    if (!collection || __atomic_sub_fetch(&collection->refs, 1, __ATOMIC_ACQ_REL))
        return;
    for (size_t i = 0; i < collection->n; i++) {
        free(collection->entry[i].id);
        vv_object_release(collection->entry[i].object);
    }
    vvi_free(collection);
}

size_t vvi_collection_index(const vv_collection *collection, const char *id)
{
    size_t i = 0;
    while (i < collection->n && (!collection->entry[i].id || strcmp(collection->entry[i].id, id) != 0))
        i++;
    return i;
}

vv_object *vv_collection_find(const vv_collection *collection, const char *id)
{
    if (!collection || !id)
        return NULL;
    const size_t i = vvi_collection_index(collection, id);
    return i < collection->n ? collection->entry[i].object : NULL;
}

static bool ids_equal(const char *a, const char *b)
{
    return a == b || (a && b && !strcmp(a, b));
}

bool vvi_collection_equal(const vv_collection *a, const vv_collection *b)
{
    if (a == b)
        return true;
    if (a->n != b->n)
        return false;
    for (size_t i = 0; i < a->n; i++) {
        if (!ids_equal(a->entry[i].id, b->entry[i].id) || !vv_object_equal(a->entry[i].object, b->entry[i].object))
            return false;
    }
    return true;
}

static vv_status fill_entry(vv_entry *entry, const char *id, const vv_object *object)
{
    if (id && !(entry->id = vvi_strdup(id)))
        return vv_fail_memory(strlen(id) + 1);
    entry->object = vv_object_retain(object);
    return VV_OK;
}

vv_status vvi_collection_splice(vv_collection **out, const vv_collection *from, size_t at, size_t n_gone,
                                const char *id, const vv_object *object)
{
    const size_t n_new = object ? 1 : 0;
    vv_collection *made = NULL;
    const size_t n = from->n - n_gone + n_new;
    vv_status st = vvi_collection_new(&made, n);
    for (size_t i = 0; made && st == VV_OK && i < n; i++) {
        if (object && i == at) {
            st = fill_entry(&made->entry[i], id, object);
            continue;
        }
        const vv_entry *old = &from->entry[i < at ? i : i + n_gone - n_new];
        st = fill_entry(&made->entry[i], old->id, old->object);
    }
    if (st != VV_OK) {
        vvi_collection_release(made);
        made = NULL;
    }
    *out = made;
    return st;
}

static vv_status new_numbers(vv_numbers **out, size_t n, size_t n_labels)
{
    size_t bytes = 0;
    *out = NULL;
    const vv_status st = vvi_mul_size(&bytes, n + n_labels, sizeof(double));
    if (st != VV_OK)
        return st;
    vv_numbers *numbers = vvi_alloc_zeroed(NULL, sizeof *numbers + bytes, VVI_MEM_MODEL);
    if (!numbers)
        return vv_fail_memory(sizeof *numbers + bytes);
    numbers->refs = 1;
    numbers->n = n;
    if (n_labels)
        numbers->labels = (vv_label_id *)(void *)(numbers->v + n);
    *out = numbers;
    return VV_OK;
}

vv_status vvi_numbers_new(vv_numbers **out, size_t n)
{
    return new_numbers(out, n, 0);
}

vv_status vvi_numbers_new_labels(vv_numbers **out, size_t rows, size_t columns)
{
    return new_numbers(out, rows * columns, rows);
}

void vvi_numbers_set_label(vv_numbers *numbers, size_t row, size_t columns, vv_label_id id, double value)
{
    ((vv_label_id *)numbers->labels)[row] = id;
    numbers->v[row * columns] = value;
}

vv_numbers *vvi_numbers_retain(const vv_numbers *numbers)
{
    vv_numbers *shared = (vv_numbers *)numbers;
    if (shared)
        __atomic_add_fetch(&shared->refs, 1, __ATOMIC_RELAXED);
    return shared;
}

void vvi_numbers_release(vv_numbers *numbers)
{
    if (numbers && !__atomic_sub_fetch(&numbers->refs, 1, __ATOMIC_ACQ_REL))
        vvi_free(numbers);
}
