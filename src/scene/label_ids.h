/** @file
 * Labels of any 64-bit id, as numbers from 0 on: for renderers that look labels up in tables.
 */
#ifndef VVI_SCENE_LABEL_IDS_H
#define VVI_SCENE_LABEL_IDS_H
#include "core/cache.h"
#include "core/status.h"
#include <volvis/sys/scene.h>

/** As many different ids as can be told apart: each has its row in the tables of every frame. */
#define VVI_LABEL_IDS_MOST (1 << 20)

typedef struct vvi_label_ids {
    size_t n;
    vv_label_id *id; /**< ascending */
    bool is_unsigned;
    vv_field *numbers;        /**< where each id has its number in `id`: u16, or f32 where there are more */
    vv_statistics statistics; /**< of numbers: the ends alone */
} vvi_label_ids;

/** Whether ids are too far apart, or too large for doubles, to be rows of a table themselves. */
bool vvi_label_ids_needed(const vv_field_info *info, const vv_statistics *statistics);

/** A vvi_label_ids, kept in the job's cache; vvi_cache_release(). Integers as they are stored, never by way of a double
 * where their scale is 1 and their offset 0; other samples rounded, those that are no number 0.
 *
 * Errors   VV_E_LIMIT (more than VVI_LABEL_IDS_MOST), VV_E_MEMORY, VV_E_CANCELLED, and those of reading
 * Threads  same numbers for any thread count
 * Cost     two passes over the samples, once */
vv_status vvi_label_ids_get(vvi_cached **out, const vv_field *field, int component, vv_job *job);

/** The actor with the numbers for its labels, and a classification that knows which ids they are. Its field is the
 * caller's: vv_field_release(); all else belongs to `actor` and `ids`. */
void vvi_label_ids_actor(vv_actor *out, const vv_actor *actor, const vvi_label_ids *ids);
#endif
