#include "manipulate/directions.h"
#include <strings.h>

#define ISOMETRIC 35.264389682754654 /* atan(1 / sqrt(2)) */

static const vvi_direction directions[] = {
    {"front", "anterior", NULL, 0, 0, 0},
    {"back", "posterior", NULL, 180, 180, 0},
    {"left", "-x", NULL, -90, 90, 0},
    {"right", "+x", NULL, 90, -90, 0},
    {"top", "superior", "+z", 0, 0, 90},
    {"bottom", "inferior", "-z", 0, 0, -90},
    {"iso", "isometric", NULL, 45, -45, ISOMETRIC},
    {NULL, "+y", NULL, 180, 0, 0},
    {NULL, "-y", NULL, 0, 180, 0},
};

const vvi_direction *vvi_direction_nth(size_t index)
{
    return index < sizeof directions / sizeof *directions ? &directions[index] : NULL;
}

const vvi_direction *vvi_direction_find(const char *name)
{
    const vvi_direction *d;
    for (size_t i = 0; (d = vvi_direction_nth(i)) != NULL; i++) {
        const char *const names[] = {d->name, d->alias, d->alias_too};
        for (size_t a = 0; a < sizeof names / sizeof *names; a++)
            if (names[a] && strcasecmp(names[a], name) == 0)
                return d;
    }
    return NULL;
}
