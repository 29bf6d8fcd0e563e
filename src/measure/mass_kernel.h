/** @file
 * Sums over triangles, built once per instruction set.
 */
#ifndef VVI_MEASURE_MASS_KERNEL_H
#define VVI_MEASURE_MASS_KERNEL_H
#include <stddef.h>
#include <stdint.h>

/** What is summed. The tetrahedron of a triangle has its apex at the center. */
typedef enum vvi_mass_sum {
    VVI_MASS_AREA,        /**< twice the area */
    VVI_MASS_PERIMETER,   /**< at least the perimeter: square root of 3 times the sum of squared edges */
    VVI_MASS_VOLUME,      /**< 6 times the tetrahedron's volume */
    VVI_MASS_FIRST,       /**< x, y, z: times 24, the integral of each over the tetrahedron */
    VVI_MASS_SECOND = 6,  /**< xx, yy, zz, xy, xz, yz: times 120, the same */
    VVI_MASS_CHORD = 12,  /**< the volume between triangle and surface, all of it taken as positive */
    VVI_MASS_CHORD_R,     /**< the same times the distance from the center */
    VVI_MASS_CHORD_RR,    /**< the same times its square */
    VVI_MASS_CHORD_AREA,  /**< area of the surface less that of the triangle */
    VVI_MASS_OFFSET_AREA, /**< change of area when the vertices move by the mean height of the chords */
    VVI_MASS_SUMS
} vvi_mass_sum;

/** Triangles of one block. */
typedef struct vvi_mass_block {
    const float *positions;
    const float *normals; /**< NULL: no sums about chords, which are 0 then */
    const uint32_t *triangles;
    size_t n;
    double center[3];    /**< taken from positions first */
    double matrix[3][3]; /**< then rows of the linear map that is applied */
    double determinant;  /**< its, not negative */
} vvi_mass_block;

typedef struct vvi_mass_kernels {
    uint32_t needs;
    const char *isa;
    /** At most VVI_MASS_BLOCK triangles. Adds their hashed edges, forwards less backwards, to *edges: what is left is 0
     * when each edge goes as often one way as the other, and otherwise by a chance of 2^-64. The order of the
     * additions is the same in every build. */
    void (*sum)(double sums[VVI_MASS_SUMS], uint64_t *edges, const vvi_mass_block *block);
} vvi_mass_kernels;

enum { VVI_MASS_BLOCK = 16384 };

/** The best build for these VVI_CPU_* bits. */
const vvi_mass_kernels *vvi_mass_kernels_for(uint32_t cpu);
/** All builds, best first; NULL after the last. For tests. */
const vvi_mass_kernels *vvi_mass_kernels_nth(size_t index);
#endif
