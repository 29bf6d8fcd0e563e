/** @file
 * Numbers of any type that lie one by one in records, as doubles.
 */
#ifndef VVI_IO_MESH_COLUMN_H
#define VVI_IO_MESH_COLUMN_H
#include <volvis/field.h>

typedef struct vvi_column {
    vv_type type;
    bool swapped; /**< the other byte order than the machine's */
    size_t offset, stride;
} vvi_column;

/** Whether this machine keeps the high byte first. */
bool vvi_machine_is_big(void);
/** Of n records, at most VVI_COLUMN_MOST. */
void vvi_column_load(double *out, const vvi_column *column, const void *records, size_t n);
enum { VVI_COLUMN_MOST = 1024 };
/** The other way round: rounded and clamped as vvi_samples_from_f64() does. */
void vvi_column_store(void *records, const vvi_column *column, const double *in, size_t n);
#endif
