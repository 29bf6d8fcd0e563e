/** @file
 * Where one looks from, by name.
 */
#ifndef VVI_MANIPULATE_DIRECTIONS_H
#define VVI_MANIPULATE_DIRECTIONS_H
#include <stdbool.h>
#include <stddef.h>

/** `right` is the side of +x and `front` the side one looks at from the front: the same words for anatomical data,
 * whose front view looks the other way along y. `iso` has all three axes at one angle. Degrees. */
typedef struct vvi_direction {
    const char *name, *alias, *alias_too; /**< NULL: none */
    double azimuth, azimuth_anatomical, elevation;
} vvi_direction;

/** By number; NULL past the last. */
const vvi_direction *vvi_direction_nth(size_t index);
/** By any of its names, letter case apart; NULL: there is none. */
const vvi_direction *vvi_direction_find(const char *name);
/** Its azimuth for such data. */
static inline double vvi_direction_azimuth(const vvi_direction *direction, bool anatomical)
{
    return anatomical ? direction->azimuth_anatomical : direction->azimuth;
}
#endif
