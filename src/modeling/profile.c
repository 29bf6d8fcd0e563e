/* Profiles as tables of 1025 densities: between them a straight line is off by less than 1.5e-6. */
#include "modeling/profile.h"

#include <math.h>

static double gaussian(double s)
{
    const double end = 0.5 * erfc(3 / sqrt(2));
    return (0.5 * erfc(3 * s / sqrt(2)) - end) / (1 - 2 * end);
}

double vvi_profile_at(vvi_profile_kind kind, double s)
{
    s = s < -1 ? -1 : s > 1 ? 1 : s;
    switch (kind) {
    case VVI_PROFILE_HYPERCONE:
        return 0.5 - s + s * s * s - fabs(s) * s * s * s / 2;
    case VVI_PROFILE_GAUSSIAN:
        return gaussian(s);
    case VVI_PROFILE_SMOOTHSTEP: {
        const double t = (s + 1) / 2;
        return 1 - t * t * (3 - 2 * t);
    }
    default:
        return 0.5 - s / 2;
    }
}

void vvi_profile_init(vvi_profile *out, vvi_profile_kind kind, double width)
{
    out->width = width;
    for (int i = 0; i <= VVI_PROFILE_STEPS; i++)
        out->table[i] = (float)vvi_profile_at(kind, 2.0 * i / VVI_PROFILE_STEPS - 1);
    out->table[VVI_PROFILE_STEPS + 1] = out->table[VVI_PROFILE_STEPS];
}

double vvi_profile_voxels(vvi_profile_kind kind)
{
    return kind == VVI_PROFILE_LINEAR ? sqrt(6) : 3;
}

void vvi_profile_densities(float *out, const double *distances, size_t n, const vvi_profile *profile)
{
    const double half = VVI_PROFILE_STEPS / 2.0, scale = half / profile->width;
    for (size_t i = 0; i < n; i++) {
        const double at = distances[i] * scale + half;
        const double in = at > 0 ? at < VVI_PROFILE_STEPS ? at : VVI_PROFILE_STEPS : at <= 0 ? 0 : VVI_PROFILE_STEPS;
        const int cell = (int)in;
        const float a = profile->table[cell], b = profile->table[cell + 1];
        out[i] = a + (b - a) * (float)(in - cell);
    }
}
