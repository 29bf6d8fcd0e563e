/** @file
 * Primitives: solids that are known by signed distances, each in its own coordinates, its middle at the origin and its
 * axis along z.
 */
#ifndef VVI_MODELING_PRIMITIVES_H
#define VVI_MODELING_PRIMITIVES_H
#include <stdbool.h>
#include <stddef.h>
#include <volvis/status.h>
#include <volvis/vec.h>

/** What of these a primitive has, its row says. */
typedef struct vvi_lengths {
    double radius;
    double top;      /**< radius at the upper end of a cone */
    double tube;     /**< radius of what a torus is bent from */
    double height;   /**< along z; of a capsule between the middles of its ends */
    double rounding; /**< radius of a box's edges */
    double size[3];  /**< along x, y, z, from end to end */
} vvi_lengths;

/** Places whose distances are asked for at once. */
typedef struct vvi_places {
    const double *x, *y, *z;
    size_t n;
} vvi_places;

enum {
    VVI_HAS_RADIUS = 1,
    VVI_HAS_TOP = 2,
    VVI_HAS_TUBE = 4,
    VVI_HAS_HEIGHT = 8,
    VVI_HAS_ROUNDING = 16,
    VVI_HAS_SIZE = 32
};

typedef struct vvi_primitive {
    const char *name;
    unsigned has; /**< bits of its lengths; what has not to be above 0 (top, rounding) may be 0 */
    /** True euclidean distances, negative inside: they change by no more than the way that is gone. */
    void (*distances)(double *out, const vvi_places *places, const vvi_lengths *lengths);
    /** What is wrong with lengths that are none below 0; NULL: nothing, or there is no such check. */
    const char *(*fault)(const vvi_lengths *lengths);
    /** Its thinnest part, from surface to surface. */
    double (*thickness)(const vvi_lengths *lengths);
} vvi_primitive;

typedef enum vvi_shape {
    VVI_SPHERE,
    VVI_ELLIPSOID,
    VVI_BOX,
    VVI_CYLINDER,
    VVI_CONE,
    VVI_CAPSULE,
    VVI_TORUS,
    VVI_SHAPES
} vvi_shape;

extern const vvi_primitive vvi_primitives[VVI_SHAPES];

/** VV_E_ARGUMENT with a sentence that begins with `what`: a length that is 0, not finite, or does not go with another.
 */
vv_status vvi_primitive_check(const vvi_primitive *primitive, const vvi_lengths *lengths, const char *what);
/** Of primitives.c's table; ellipsoid.c. */
void vvi_ellipsoid_distances(double *out, const vvi_places *places, const vvi_lengths *lengths);
#endif
