/* A box of samples from where they lie in a chunk to where they lie in a field. */
#include "io/formats/zarr/zarr.h"
#include <string.h>

#define COPY_ROW(T)                                                                                                    \
    for (int64_t i = 0; i < n; i++, from += from_step, to += to_step)                                                  \
    memcpy(to, from, sizeof(T))

/* One value n times: what is there is copied behind itself. */
static void fill_row(uint8_t *to, const uint8_t *value, int64_t n, size_t bytes)
{
    const size_t all = (size_t)n * bytes;
    memcpy(to, value, bytes);
    for (size_t at = bytes; at < all; at *= 2)
        memcpy(to + at, to, at < all - at ? at : all - at);
}

static void copy_row(const vvi_zarr_copying *c, const uint8_t *from, uint8_t *to, int64_t n, int64_t from_step,
                     int64_t to_step)
{
    if (from_step == 0 && to_step == (int64_t)c->bytes) {
        fill_row(to, from, n, c->bytes);
    } else if (c->half) {
        for (int64_t i = 0; i < n; i++, from += from_step, to += to_step) {
            uint16_t half;
            memcpy(&half, from, sizeof half);
            const float value = vvi_half_to_float(half);
            memcpy(to, &value, sizeof value);
        }
    } else if (from_step == (int64_t)c->bytes && to_step == from_step) {
        memcpy(to, from, (size_t)n * c->bytes);
    } else if (c->bytes == 1) {
        COPY_ROW(uint8_t);
    } else if (c->bytes == 2) {
        COPY_ROW(uint16_t);
    } else if (c->bytes == 4) {
        COPY_ROW(uint32_t);
    } else {
        COPY_ROW(uint64_t);
    }
}

static void copy_box(const vvi_zarr_copying *c, int axis, const uint8_t *from, uint8_t *to)
{
    if (axis == c->n_axes - 1) {
        copy_row(c, from, to, c->n[axis], c->from_step[axis], c->to_step[axis]);
        return;
    }
    for (int64_t i = 0; i < c->n[axis]; i++, from += c->from_step[axis], to += c->to_step[axis])
        copy_box(c, axis + 1, from, to);
}

void vvi_zarr_copy_box(const vvi_zarr_copying *c, const uint8_t *from, uint8_t *to)
{
    copy_box(c, 0, from, to);
}
