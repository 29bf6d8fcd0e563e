#include "server/poses.h"
#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

void vvi_poses_note(vvi_poses *poses, const vvi_pose *pose)
{
    if (poses->n && vvi_pose_equal(&poses->pose[poses->at], pose))
        return;
    size_t at = poses->n ? poses->at + 1 : 0;
    if (at == VVI_POSES_MOST) {
        memmove(poses->pose, poses->pose + 1, --at * sizeof *poses->pose);
        poses->at--;
    }
    if (at == poses->room) {
        const size_t room = poses->room ? 2 * poses->room : 8;
        vvi_pose *more = vvi_realloc(NULL, poses->pose, room * sizeof *more, VVI_MEM_MODEL);
        if (!more)
            return;
        poses->pose = more;
        poses->room = room;
    }
    poses->pose[at] = *pose;
    poses->at = at;
    poses->n = at + 1;
}

bool vvi_poses_step(vvi_pose *out, vvi_poses *poses, int by)
{
    if (by < 0 ? poses->at == 0 : poses->at + 1 >= poses->n)
        return false;
    poses->at = by < 0 ? poses->at - 1 : poses->at + 1;
    *out = poses->pose[poses->at];
    return true;
}

void vvi_poses_free(vvi_poses *poses)
{
    vvi_free(poses->pose);
    *poses = (vvi_poses){0};
}
