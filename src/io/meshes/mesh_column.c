#include "io/meshes/mesh_column.h"
#include "grid/field.h"

#include <string.h>

bool vvi_machine_is_big(void)
{
    const uint16_t one = 1;
    uint8_t first;
    memcpy(&first, &one, 1);
    return first == 0;
}

/* Sizes are constants where they are copied: so compilers make moves of it. */
static void gather(uint8_t *out, const uint8_t *in, size_t bytes, size_t stride, size_t n)
{
    for (size_t i = 0; i < n; i++, in += stride, out += bytes)
        switch (bytes) {
        case 1:
            *out = *in;
            break;
        case 2:
            memcpy(out, in, 2);
            break;
        case 4:
            memcpy(out, in, 4);
            break;
        default:
            memcpy(out, in, 8);
            break;
        }
}

void vvi_column_load(double *out, const vvi_column *c, const void *records, size_t n)
{
    uint64_t packed[VVI_COLUMN_MOST];
    const size_t bytes = vv_type_bytes(c->type);
    gather((uint8_t *)packed, (const uint8_t *)records + c->offset, bytes, c->stride, n);
    if (c->swapped)
        vvi_swap_bytes(packed, bytes, n);
    vvi_samples_to_f64(out, packed, c->type, n);
}

void vvi_column_store(void *records, const vvi_column *c, const double *in, size_t n)
{
    uint64_t packed[VVI_COLUMN_MOST];
    const size_t bytes = vv_type_bytes(c->type);
    vvi_samples_from_f64(packed, in, c->type, n);
    if (c->swapped)
        vvi_swap_bytes(packed, bytes, n);
    uint8_t *out = (uint8_t *)records + c->offset;
    for (size_t i = 0; i < n; i++, out += c->stride)
        memcpy(out, (const uint8_t *)packed + i * bytes, bytes);
}
