#include "segment/simple_points.h"

#define ALL ((1u << VVI_AROUND) - 1)
#define CORNERS (1u << 0 | 1u << 2 | 1u << 6 | 1u << 8 | 1u << 18 | 1u << 20 | 1u << 24 | 1u << 26)
/* Those that are not the first, and not the last, along x and y: a step comes to them from the one before, or behind.
 */
#define X_UP 0x6db6db6u
#define X_DOWN 0x36db6dbu
#define Y_UP 0x7e3f1f8u
#define Y_DOWN 0x0fc7e3fu

static uint32_t beside_x(uint32_t v)
{
    return (v << 1 & X_UP) | (v >> 1 & X_DOWN);
}

static uint32_t beside_y(uint32_t v)
{
    return (v << 3 & Y_UP) | (v >> 3 & Y_DOWN);
}

static uint32_t beside_z(uint32_t v)
{
    return (v << 9 & ALL) | v >> 9;
}

/* What of a set hangs together with its first one, at corners or at faces: all of it takes a step at a time. */
static uint32_t reach_corners(uint32_t set)
{
    uint32_t reached = set & (0u - set), before = 0;
    while (reached != before) {
        before = reached;
        reached |= beside_x(reached);
        reached |= beside_y(reached);
        reached |= beside_z(reached);
        reached &= set;
    }
    return reached;
}

static uint32_t reach_faces(uint32_t seed, uint32_t set)
{
    uint32_t reached = seed, before = 0;
    while (reached != before) {
        before = reached;
        reached |= (beside_x(reached) | beside_y(reached) | beside_z(reached)) & set;
    }
    return reached;
}

bool vvi_is_simple(uint32_t object)
{
    const uint32_t there = object & ALL & ~(1u << VVI_AROUND_OWN);
    const uint32_t empty = ~object & ALL & ~(CORNERS | 1u << VVI_AROUND_OWN), open = empty & VVI_AROUND_BESIDE;
    if (!there || !open)
        return false;
    return reach_corners(there) == there && (reach_faces(open & (0u - open), empty) & open) == open;
}
