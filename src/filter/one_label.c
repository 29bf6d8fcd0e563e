#include "filter/one_label.h"
#include "grid/label_id.h"
#include "grid/slabs.h"

#include <stdatomic.h>
#include <string.h>

#define ITEM_SAMPLES (1 << 18)

typedef struct shared {
    vv_brick brick;
    vvi_slabs slabs;
    _Atomic vv_label_id id; /* the first that anybody sees */
    _Atomic bool many;
} shared;

/* Bits are compared, of which `other` is what may be there beside 0. */
#define ONE_TYPE(ctype)                                                                                                \
    {                                                                                                                  \
        ctype odd = 0, v, other;                                                                                       \
        memcpy(&other, label, sizeof other);                                                                           \
        for (int64_t i = 0; i < n; i++) {                                                                              \
            memcpy(&v, row + i * (int64_t)sizeof v, sizeof v);                                                         \
            odd |= (ctype)((v != 0) & (v != other));                                                                   \
        }                                                                                                              \
        return odd == 0;                                                                                               \
    }

static bool has_no_other(const char *row, const char *label, size_t bytes, int64_t n)
{
    switch (bytes) {
    case 1:
        ONE_TYPE(uint8_t)
    case 2:
        ONE_TYPE(uint16_t)
    case 4:
        ONE_TYPE(uint32_t)
    default:
        ONE_TYPE(uint64_t)
    }
}

/* The first sample that is not 0; NULL: there is none. */
static const char *first_of(const char *row, size_t bytes, int64_t n)
{
    static const char none[8] = {0};
    if (has_no_other(row, none, bytes, n))
        return NULL;
    for (int64_t i = 0; i < n; i++)
        if (memcmp(row + (size_t)i * bytes, none, bytes) != 0)
            return row + (size_t)i * bytes;
    return NULL;
}

static vv_status item(void *scratch, void *user, size_t index)
{
    shared *s = user;
    const vv_box box = vvi_slabs_item(&s->slabs, index);
    const vv_brick b = vvi_brick_part(&s->brick, &box);
    const size_t bytes = vv_type_bytes(b.type);
    const char *label = NULL;
    for (int64_t k = 0; k < box.n[2] && !atomic_load_explicit(&s->many, memory_order_relaxed); k++)
        for (int64_t j = 0; j < box.n[1]; j++) {
            const char *row = (const char *)b.data + j * b.stride[1] + k * b.stride[2];
            if (!label && (label = first_of(row, bytes, box.n[0])) != NULL) {
                const vv_label_id id = vvi_label_of(label, b.type);
                vv_label_id known = 0;
                if (!atomic_compare_exchange_strong(&s->id, &known, id) && known != id)
                    atomic_store(&s->many, true);
            }
            if (label && !has_no_other(row, label, bytes, box.n[0]))
                atomic_store(&s->many, true);
        }
    return VV_OK;
}

vv_status vvi_one_label(bool *out, vv_label_id *id_out, const vv_field *field, const vv_box *box, vv_job *job)
{
    static const vvi_work work = {.item = item};
    shared s = {.slabs = vvi_slabs_of(box, ITEM_SAMPLES)};
    vv_status st = vv_field_brick(&s.brick, field, box, job);
    if (st == VV_OK)
        st = vvi_parallel_for(job, &work, &s, s.slabs.n);
    vv_brick_release(&s.brick);
    *out = st == VV_OK && !atomic_load(&s.many);
    *id_out = atomic_load(&s.id);
    return st;
}
