#include "core/memory.h"
#include "grid/store.h"
#include <string.h>

typedef struct lent {
    vvi_brick_owner head;
    vv_field *field;
    atomic_bool *damaged;
    vv_brick brick;
} lent;

static void give_back(vvi_brick_owner *owner)
{
    lent *l = (lent *)owner;
    vv_brick_release(&l->brick);
    if (l->damaged && vvi_field_is_damaged(l->field))
        atomic_store(l->damaged, true);
    vv_field_release(l->field);
    vvi_free(l);
}

vv_status vvi_field_lend(vv_brick *out, vv_field *field, const vv_box *part, atomic_bool *damaged, vv_job *job)
{
    lent *l = vvi_alloc_zeroed(job, sizeof *l, VVI_MEM_SCRATCH);
    if (!l) {
        vv_field_release(field);
        return vv_fail_memory(sizeof *l);
    }
    *l = (lent){.head = {.release = give_back}, .field = field, .damaged = damaged};
    const vv_status st = vv_field_brick(&l->brick, field, part, job);
    if (st != VV_OK) {
        give_back(&l->head);
        return st;
    }
    out->data = l->brick.data;
    memcpy(out->stride, l->brick.stride, sizeof out->stride);
    out->guard_bytes = l->brick.guard_bytes;
    out->owner = &l->head;
    return VV_OK;
}
