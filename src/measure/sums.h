/** @file
 * What the two methods add up, layer by layer, and what they share in doing so.
 */
#ifndef VVI_MEASURE_SUMS_H
#define VVI_MEASURE_SUMS_H
#include "measure/configurations.h"
#include "measure/object.h"
#include "measure/region.h"

/** Layers of cells in one item of the parallel loops. */
enum { VVI_MEASURE_LAYERS = 8 };

/** Of voxel counting. */
typedef struct vvi_count_sums {
    uint64_t pattern[VVI_CONFIGURATIONS];
    uint64_t voxels;
    int64_t index[3];      /* of the voxels, added up */
    vv_bounds bounds;      /* of their centres */
    bool cut;              /* the object reaches the border of the volume or of the region */
    uint64_t cut_faces[3]; /* of its voxels across x, y, z, where it goes on beyond that; only where it is not closed */
} vvi_count_sums;

/** Of Marching Cubes: areas are world's, volume and moments in index space. */
typedef struct vvi_cubes_sums {
    double area, cut_area, volume;
    double moment[3];
    double inner_area, inner_volume; /* of the cells that the coarse look has as well */
    double sharp_area;               /* in cells that an edge or a corner of the surface passes through */
    vv_bounds bounds;
    vv_bounds surface; /* of its points alone */
    uint64_t unknown;
    uint64_t crossed, stepped; /* crossed edges whose neighbours were looked at, and those that are steps */
    bool between;              /* some sample at a crossed edge is neither the least nor the largest that was met */
    double least, most;
} vvi_cubes_sums;

vv_status vvi_count_object(vvi_count_sums *out, const vvi_object *object, const vvi_region *region, bool closed);
/** Areas and area_error from the patterns of a layer of cells; voxel: its volume. */
void vvi_count_areas(vv_measured *out, const uint64_t pattern[VVI_CONFIGURATIONS], const vv_affine *index_to_world,
                     double voxel);
/** inner: cells along each axis that inner_area and inner_volume are of. */
vv_status vvi_cubes_object(vvi_cubes_sums *out, const vvi_object *object, const vvi_region *region,
                           const int64_t inner[3]);

/** A hair before the middle of a cell, so that a box of n voxels has n cells along an axis and not those at both ends.
 */
#define VVI_CELL_MIDDLE (0.5 - 1e-6)

static inline void vvi_bounds_add(vv_bounds *b, vv_vec3 p)
{
    b->lo.x = p.x < b->lo.x ? p.x : b->lo.x;
    b->lo.y = p.y < b->lo.y ? p.y : b->lo.y;
    b->lo.z = p.z < b->lo.z ? p.z : b->lo.z;
    b->hi.x = p.x > b->hi.x ? p.x : b->hi.x;
    b->hi.y = p.y > b->hi.y ? p.y : b->hi.y;
    b->hi.z = p.z > b->hi.z ? p.z : b->hi.z;
}

static inline vv_bounds vvi_bounds_none(void)
{
    return (vv_bounds){{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
}

static inline void vvi_bounds_join(vv_bounds *b, const vv_bounds *other)
{
    if (other->lo.x > other->hi.x)
        return;
    vvi_bounds_add(b, other->lo);
    vvi_bounds_add(b, other->hi);
}

/** The numbers of the bits that are set, added up. */
static inline int64_t vvi_sum_of_places(uint64_t bits)
{
    static const uint64_t place[6] = {0xaaaaaaaaaaaaaaaa, 0xcccccccccccccccc, 0xf0f0f0f0f0f0f0f0,
                                      0xff00ff00ff00ff00, 0xffff0000ffff0000, 0xffffffff00000000};
    int64_t sum = 0;
    for (int b = 0; b < 6; b++)
        sum += (int64_t)__builtin_popcountll(bits & place[b]) << b;
    return sum;
}

/** Bits lo .. end - 1 of word w. */
static inline uint64_t vvi_interval_bits(vvi_interval row, int64_t w)
{
    const int64_t lo = row.lo - 64 * w, end = row.end - 64 * w;
    const uint64_t from = lo <= 0 ? ~(uint64_t)0 : lo >= 64 ? 0 : ~(uint64_t)0 << lo;
    const uint64_t below = end >= 64 ? ~(uint64_t)0 : end <= 0 ? 0 : ~(~(uint64_t)0 << end);
    return from & below;
}
#endif
