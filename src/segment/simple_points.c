#include "segment/simple_points.h"

#include <stdlib.h>

#define ALL ((1u << VVI_AROUND) - 1)
#define OWN (1u << VVI_AROUND_OWN)

/* By how many axes two of them differ; 3 and more: they do not touch. */
static int distance(int a, int b)
{
    const int x = abs(a % 3 - b % 3), y = abs(a / 3 % 3 - b / 3 % 3), z = abs(a / 9 - b / 9);
    return x > 1 || y > 1 || z > 1 ? 4 : x + y + z;
}

vvi_around_tables vvi_around_tables_make(void)
{
    vvi_around_tables t = {{0}};
    for (int a = 0; a < VVI_AROUND; a++) {
        for (int b = 0; b < VVI_AROUND; b++) {
            const int d = distance(a, b);
            if (d > 0 && d <= 3)
                t.corners[a] |= 1u << b;
            if (d == 1)
                t.faces[a] |= 1u << b;
        }
        const int d = distance(a, VVI_AROUND_OWN);
        if (d == 1 || d == 2)
            t.near |= 1u << a;
        if (d == 1)
            t.beside |= 1u << a;
    }
    return t;
}

/* What of a set hangs together with its first one. */
static uint32_t reach(uint32_t seed, uint32_t set, const uint32_t *touches)
{
    uint32_t reached = seed, waiting = seed;
    while (waiting) {
        const uint32_t more = touches[__builtin_ctz(waiting)] & set & ~reached;
        waiting = (waiting & (waiting - 1)) | more;
        reached |= more;
    }
    return reached;
}

bool vvi_is_simple(uint32_t object, const vvi_around_tables *t)
{
    const uint32_t there = object & ALL & ~OWN, empty = ~object & t->near, open = empty & t->beside;
    if (!there || !open)
        return false;
    if (reach(there & (0u - there), there, t->corners) != there)
        return false;
    return (reach(open & (0u - open), empty, t->faces) & open) == open;
}
