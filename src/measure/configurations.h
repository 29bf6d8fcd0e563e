/** @file
 * What 2 x 2 x 2 neighbouring voxels tell of the surface between them: from how often each of the 256 patterns occurs
 * follow outer faces, areas and the Euler number. Bit x + 2 y + 4 z of a pattern: that voxel is inside.
 */
#ifndef VVI_MEASURE_CONFIGURATIONS_H
#define VVI_MEASURE_CONFIGURATIONS_H
#include <volvis/field.h>

enum { VVI_CONFIGURATIONS = 256, VVI_DIRECTIONS = 13 };

/** The 13 directions from a voxel to its 26 neighbours, up to their sign, in index steps: 3 axes, 6 diagonals of faces,
 * 4 of space. */
extern const int vvi_directions[VVI_DIRECTIONS][3];
/** Share of the sphere that is nearer to a direction (or its opposite) than to the others, in world space; sums to 1.
 * For cubes 0.0916, 0.0740 and 0.0704 (axes, face diagonals, space diagonals). */
void vvi_direction_weights(double weight[VVI_DIRECTIONS], const vv_affine *index_to_world);

/** Crofton's formula: 2 sum of weight times crossings times area of a line. World area. */
double vvi_area_crofton(const uint64_t count[VVI_CONFIGURATIONS], const vv_affine *index_to_world);
/** How unlike the areas are that the directions see, as a share of their mean: 0 where the surface turns every way, 0.3
 * and more of planes and boxes. */
double vvi_area_unevenness(const uint64_t count[VVI_CONFIGURATIONS], const vv_affine *index_to_world);
/** Lindblad 2005, "Surface area estimation of digitized 3D objects using weighted local configurations"; for voxels
 * that are cubes. In faces of a voxel. */
double vvi_area_lindblad(const uint64_t count[VVI_CONFIGURATIONS]);
/** Of the voxels' outer faces, by index axis: how many. */
void vvi_raw_faces(double faces[3], const uint64_t count[VVI_CONFIGURATIONS]);
/** Patterns whose inside is one face of the cell, by index axis: all, and by how many one side has more of them than
 * the other. Surfaces that turn have some of both sides; flat faces along the axes consist of them. */
void vvi_flat_patterns(double all[3], double one_sided[3], const uint64_t count[VVI_CONFIGURATIONS]);
/** How far the number of voxels may be from the volume, in voxels: in 95 of 100 cases it is nearer. Ends of rows are
 * off by chance on surfaces that turn, all alike on faces along the axes, and alike along an axis on what is extruded
 * along it: patterns tell how much there is of each. */
double vvi_count_spread(const uint64_t count[VVI_CONFIGURATIONS]);
/** Pieces - tunnels + cavities of an object with outside all around; its voxels share faces. */
int64_t vvi_euler_number(const uint64_t count[VVI_CONFIGURATIONS]);
#endif
