/* Distances and angles of points alone. */
#include "core/vec.h"

#include <math.h>
#include <volvis/measure_distance.h>

double vv_distance(vv_vec3 a, vv_vec3 b)
{
    return vvi_length(vvi_sub(a, b));
}

double vv_polyline_length(const vv_vec3 *points, size_t n)
{
    double sum = 0, rest = 0; /* Neumaier 1974 */
    for (size_t i = 1; i < n; i++) {
        const double x = vv_distance(points[i - 1], points[i]), s = sum + x;
        rest += sum >= x ? (sum - s) + x : (x - s) + sum;
        sum = s;
    }
    return sum + rest;
}

double vv_angle_between(vv_vec3 a, vv_vec3 b)
{
    if (!vvi_unit(&a) || !vvi_unit(&b))
        return NAN;
    return 2 * atan2(vvi_length(vvi_sub(a, b)), vvi_length(vvi_add(a, b)));
}

double vv_angle_at(vv_vec3 a, vv_vec3 apex, vv_vec3 b)
{
    return vv_angle_between(vvi_sub(a, apex), vvi_sub(b, apex));
}
