/** @file
 * What labels a volume has, and where.
 */
#ifndef VVI_SURFACE_LABEL_MAP_H
#define VVI_SURFACE_LABEL_MAP_H
#include "grid/label_set.h"

typedef struct vvi_label_box {
    int32_t lo[3], hi[3]; /**< the last is in it */
} vvi_label_box;

typedef struct vvi_label_map {
    int64_t n[3];
    uint16_t *index; /**< by voxel: number of its label */
    size_t n_labels;
    vv_label_id *labels; /**< ascending */
    bool is_unsigned;    /**< they are bits of uint64_t */
    vvi_label_set set;   /**< the same labels */
    vvi_label_box *boxes;
    vv_job *job;
} vvi_label_map;

/** Errors: see vvi_label_surfaces(). Owns: vvi_label_map_finish(); zeroed on failure. */
vv_status vvi_label_map_init(vvi_label_map *out, const vv_field *field, int component, vv_job *job);
void vvi_label_map_finish(vvi_label_map *map); /* zeroed is fine */
/** Number of a label; SIZE_MAX: it is not there. */
size_t vvi_label_number(const vvi_label_map *map, vv_label_id label);

static inline const uint16_t *vvi_label_row(const vvi_label_map *m, int64_t j, int64_t k)
{
    return m->index + (k * m->n[1] + j) * m->n[0];
}
#endif
