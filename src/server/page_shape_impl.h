/** @file
 * Inside of shapes, between their files.
 */
#ifndef VVI_SERVER_PAGE_SHAPE_IMPL_H
#define VVI_SERVER_PAGE_SHAPE_IMPL_H
#include "server/page_shape.h"
#include "surface/compact.h"
#include <volvis/sys/scene.h>

/** Its number, name and bytes: written below the folder of the options, or in memory where there is none. */
vv_status vvi_shape_file_write(vvi_page_shape_file *file, const vvi_compact *compact,
                               const vvi_page_shape_options *options);
/** Of the cache: frees it, and the file is gone. */
void vvi_shape_file_drop(void *file);
/** One part. value: of the surface of a volume; NaN: it is of a mesh. */
void vvi_shape_tell_part(vvi_result *out, const vvi_page_shape_file *file, const vv_actor *actor, double value,
                         const vv_affine *place);
void vvi_shape_tell_light(vvi_result *out, const vv_scene *scene);
/** Why not all is there. */
void vvi_shape_tell_left_out(vvi_result *out, const vv_scene *scene);
#endif
