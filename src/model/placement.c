#include "model/placement.h"
#include <math.h>

static vv_affine rotation(int axis, double angle)
{
    const double c = cos(angle), s = sin(angle);
    vv_affine a = vv_affine_identity();
    if (axis == 0) {
        a.axis[1] = (vv_vec3){0, c, s};
        a.axis[2] = (vv_vec3){0, -s, c};
    } else if (axis == 1) {
        a.axis[2] = (vv_vec3){s, 0, c};
        a.axis[0] = (vv_vec3){c, 0, -s};
    } else {
        a.axis[0] = (vv_vec3){c, s, 0};
        a.axis[1] = (vv_vec3){-s, c, 0};
    }
    return a;
}

vv_affine vvi_placement_matrix(const vv_placement *frame)
{
    if (frame->matrix && frame->matrix->n == 12) {
        const double *m = frame->matrix->v;
        return (vv_affine){{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}}, {m[3], m[7], m[11]}};
    }
    vv_affine a = vv_affine_identity();
    a.axis[0].x = frame->scale.x;
    a.axis[1].y = frame->scale.y;
    a.axis[2].z = frame->scale.z;
    a = vv_affine_compose(rotation(0, frame->rotation.x), a);
    a = vv_affine_compose(rotation(1, frame->rotation.y), a);
    a = vv_affine_compose(rotation(2, frame->rotation.z), a);
    a.origin = frame->position;
    return a;
}
