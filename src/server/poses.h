/** @file
 * Where one has stood: views that came to rest, gone through backwards and forwards, as a browser does with pages.
 */
#ifndef VVI_SERVER_POSES_H
#define VVI_SERVER_POSES_H
#include "core/status.h"
#include "manipulate/navigate.h"
#include <stddef.h>

/** Zeroed is fine. */
typedef struct vvi_poses {
    vvi_pose *pose; /**< the oldest first */
    size_t n, room, at;
} vvi_poses;

enum { VVI_POSES_MOST = 1000 };

/** One stands there now: what came after the last one is forgotten, and what is older than VVI_POSES_MOST. The same
 * pose again is none. Without memory it is not kept. */
void vvi_poses_note(vvi_poses *poses, const vvi_pose *pose);
/** The one before (by -1) or behind (1) where one stands, which becomes that; false: there is none. */
bool vvi_poses_step(vvi_pose *out, vvi_poses *poses, int by);
void vvi_poses_free(vvi_poses *poses);
#endif
