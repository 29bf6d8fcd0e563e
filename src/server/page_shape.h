/** @file
 * What a page can draw of the World by itself: files of triangles or of what they follow from (surface/compact.h), and
 * a text that says where each is placed, in which colour, cut by what, in which light. Files are made once for all
 * pages, by the runtime's cache, and are there as long as that keeps them or somebody has them pinned.
 */
#ifndef VVI_SERVER_PAGE_SHAPE_H
#define VVI_SERVER_PAGE_SHAPE_H
#include "core/cache.h"
#include "core/result.h"
#include <stdatomic.h>
#include <volvis/model.h>

/** A file, as the value of a pinned entry of the cache. */
typedef struct vvi_page_shape_file {
    int64_t number;
    char *path, *name; /**< path: NULL where it is on no disk */
    int fd;            /**< of such a one; 0: it is on the disk */
    size_t n_bytes, n_triangles;
    int32_t step[3]; /**< of records: samples; else 0 */
    bool closed;     /**< of a mesh: it has no open edges */
} vvi_page_shape_file;

typedef struct vvi_page_shape_options {
    bool boxes;         /**< else reduced surfaces */
    size_t bytes;       /**< of all files together */
    const char *folder; /**< where files are written; NULL: nowhere, they are in memory */
    _Atomic int64_t *numbers;
} vvi_page_shape_options;

typedef struct vvi_page_shape {
    vvi_cached **files; /**< vvi_page_shape_file, pinned */
    size_t n;
    vvi_result text; /**< a JSON object: docs/protocol.md, message `shape` */
} vvi_page_shape;

/** What a view of a World shows. VV_E_UNSUPPORTED: none of it can be drawn by a page; VV_E_LIMIT, VV_E_MEMORY,
 * VV_E_READ, VV_E_WRITE, VV_E_CANCELLED. Finish it in any case. */
vv_status vvi_page_shape_make(vvi_page_shape *out, vv_world *world, const char *view,
                              const vvi_page_shape_options *options, vv_job *job);
void vvi_page_shape_finish(vvi_page_shape *shape); /* zeroed is fine */
#endif
