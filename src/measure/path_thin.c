#include "measure/path_thin.h"
#include "core/memory.h"
#include "core/status.h"
#include "core/vec.h"
#include <math.h>
#include <stdlib.h>

static double off_line(vv_vec3 p, vv_vec3 from, vv_vec3 to)
{
    const vv_vec3 along = vvi_sub(to, from), to_p = vvi_sub(p, from);
    const double square = vvi_dot(along, along);
    const double t = square > 0 ? fmin(1, fmax(0, vvi_dot(to_p, along) / square)) : 0;
    const vv_vec3 off = vvi_sub(to_p, vvi_scaled(along, t));
    return sqrt(vvi_dot(off, off));
}

/* The point between two that is farthest from their line, more than `far`; 0: there is none. */
static size_t find_farthest(const vv_vec3 *p, size_t from, size_t to, double far)
{
    size_t farthest = 0;
    for (size_t i = from + 1; i < to; i++) {
        const double off = off_line(p[i], p[from], p[to]);
        if (off > far) {
            far = off;
            farthest = i;
        }
    }
    return farthest;
}

/* `end` is a stack of points that the lines from `from` on must reach: each point comes on it once at most. What stays
 * moves over what went, which nobody looks at again. */
vv_status vvi_path_thin(size_t *n_out, vv_vec3 *p, size_t n, double far)
{
    size_t *end = vvi_calloc(n + 1, sizeof *end);
    size_t from = 0, waiting = 0, kept = n > 0;
    if (!end)
        return vv_fail_memory((n + 1) * sizeof *end);
    if (n > 1)
        end[waiting++] = n - 1;
    while (waiting) {
        const size_t to = end[waiting - 1], farthest = find_farthest(p, from, to, far);
        if (farthest) {
            end[waiting++] = farthest;
        } else {
            p[kept++] = p[to];
            from = to;
            waiting--;
        }
    }
    free(end);
    *n_out = kept;
    return VV_OK;
}
