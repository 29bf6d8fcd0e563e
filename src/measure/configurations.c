/* Areas from counts of 2 x 2 x 2 patterns. */
#include "measure/configurations.h"

#include "core/vec.h"

#include <math.h>

const int vvi_directions[VVI_DIRECTIONS][3] = {{1, 0, 0},  {0, 1, 0},  {0, 0, 1}, {1, 1, 0},  {1, -1, 0},
                                               {1, 0, 1},  {1, 0, -1}, {0, 1, 1}, {0, 1, -1}, {1, 1, 1},
                                               {1, 1, -1}, {1, -1, 1}, {-1, 1, 1}};

/* Directions ------------------------------------------------------------------------------------------------------ */

static vv_vec3 world_step(const vv_affine *m, const int d[3])
{
    return vv_affine_vector(*m, vvi_vec(d[0], d[1], d[2]));
}

/* Solid angle of a triangle seen from the origin (Van Oosterom & Strackee 1983). */
static double solid_angle(vv_vec3 a, vv_vec3 b, vv_vec3 c)
{
    const double la = vvi_length(a), lb = vvi_length(b), lc = vvi_length(c);
    const double volume = vvi_dot(a, vvi_cross(b, c));
    return 2 * atan2(fabs(volume), la * lb * lc + vvi_dot(a, b) * lc + vvi_dot(a, c) * lb + vvi_dot(b, c) * la);
}

enum { CORNERS = 64 };

/* Keeps of a convex polygon what is on the positive side of a plane through the origin. */
static int clip(vv_vec3 *p, int n, vv_vec3 normal)
{
    vv_vec3 kept[CORNERS];
    int m = 0;
    for (int i = 0; i < n; i++) {
        const vv_vec3 a = p[i], b = p[(i + 1) % n];
        const double da = vvi_dot(a, normal), db = vvi_dot(b, normal);
        if (da >= 0)
            kept[m++] = a;
        if ((da >= 0) != (db >= 0))
            kept[m++] = vvi_add(a, vvi_scaled(vvi_sub(b, a), da / (da - db)));
    }
    for (int i = 0; i < m; i++)
        p[i] = kept[i];
    return m;
}

/* The cell of a unit direction on the sphere is cut out of a large square in the plane that touches there. */
static double voronoi_cell(const vv_vec3 *unit, int which)
{
    const double large = 1e4;
    const vv_vec3 d = unit[which], other = fabs(d.x) < 0.6 ? vvi_vec(1, 0, 0) : vvi_vec(0, 1, 0);
    vv_vec3 u = vvi_cross(d, other), p[CORNERS];
    vvi_unit(&u);
    const vv_vec3 v = vvi_cross(d, u);
    int n = 4;
    for (int i = 0; i < 4; i++)
        p[i] = vvi_add(
            d, vvi_add(vvi_scaled(u, i == 0 || i == 3 ? large : -large), vvi_scaled(v, i < 2 ? large : -large)));
    for (int o = 0; o < VVI_DIRECTIONS; o++)
        for (int sign = -1; sign <= 1 && o != which; sign += 2)
            n = clip(p, n, vvi_sub(d, vvi_scaled(unit[o], sign)));
    double angle = 0;
    for (int i = 1; i + 1 < n; i++)
        angle += solid_angle(p[0], p[i], p[i + 1]);
    return angle;
}

void vvi_direction_weights(double weight[VVI_DIRECTIONS], const vv_affine *index_to_world)
{
    vv_vec3 unit[VVI_DIRECTIONS];
    double sum = 0;
    for (int d = 0; d < VVI_DIRECTIONS; d++) {
        unit[d] = world_step(index_to_world, vvi_directions[d]);
        vvi_unit(&unit[d]);
    }
    for (int d = 0; d < VVI_DIRECTIONS; d++)
        sum += weight[d] = voronoi_cell(unit, d);
    for (int d = 0; d < VVI_DIRECTIONS; d++)
        weight[d] /= sum;
}

/* Patterns -------------------------------------------------------------------------------------------------------- */

/* Crossings along a direction in one pattern, times how often the pair is met in other cells: 4 cells share an edge, 2
 * the diagonal of a face. */
static double crossings(unsigned pattern, const int d[3])
{
    const int spread = (d[0] != 0) + (d[1] != 0) + (d[2] != 0);
    int n = 0;
    for (int c = 0; c < 8; c++) {
        const int to[3] = {(c & 1) + d[0], (c >> 1 & 1) + d[1], (c >> 2) + d[2]};
        if (to[0] < 0 || to[0] > 1 || to[1] < 0 || to[1] > 1 || to[2] < 0 || to[2] > 1)
            continue;
        n += (pattern >> c & 1) != (pattern >> (to[0] + 2 * to[1] + 4 * to[2]) & 1);
    }
    return n / (spread == 1 ? 4.0 : spread == 2 ? 2.0 : 1.0);
}

static double all_crossings(const uint64_t count[VVI_CONFIGURATIONS], const int d[3])
{
    double sum = 0;
    for (unsigned p = 1; p < 255; p++)
        if (count[p])
            sum += (double)count[p] * crossings(p, d);
    return sum;
}

double vvi_area_crofton(const uint64_t count[VVI_CONFIGURATIONS], const vv_affine *index_to_world)
{
    double weight[VVI_DIRECTIONS], area = 0;
    const double voxel = fabs(vv_affine_determinant(*index_to_world));
    vvi_direction_weights(weight, index_to_world);
    for (int d = 0; d < VVI_DIRECTIONS; d++)
        area += 2 * weight[d] * all_crossings(count, vvi_directions[d]) * voxel /
                vvi_length(world_step(index_to_world, vvi_directions[d]));
    return area;
}

double vvi_area_unevenness(const uint64_t count[VVI_CONFIGURATIONS], const vv_affine *index_to_world)
{
    double weight[VVI_DIRECTIONS], sum = 0, squares = 0;
    vvi_direction_weights(weight, index_to_world);
    for (int d = 0; d < VVI_DIRECTIONS; d++) {
        const double seen =
            all_crossings(count, vvi_directions[d]) / vvi_length(world_step(index_to_world, vvi_directions[d]));
        sum += weight[d] * seen;
        squares += weight[d] * seen * seen;
    }
    return sum > 0 ? sqrt(fmax(squares - sum * sum, 0)) / sum : 0;
}

void vvi_raw_faces(double faces[3], const uint64_t count[VVI_CONFIGURATIONS])
{
    for (int a = 0; a < 3; a++)
        faces[a] = all_crossings(count, vvi_directions[a]);
}

/* The nearer half of a cell along each axis. */
static const unsigned nearer_half[3] = {0x55, 0x33, 0x0f};

void vvi_flat_patterns(double all[3], double one_sided[3], const uint64_t count[VVI_CONFIGURATIONS])
{
    for (int a = 0; a < 3; a++) {
        const double nearer = (double)count[nearer_half[a]], farther = (double)count[255 - nearer_half[a]];
        all[a] = nearer + farther;
        one_sided[a] = fabs(nearer - farther);
    }
}

/* How far counts are from the truth, from spheres, ellipsoids, tori, cylinders and boxes, along the axes and turned, of
 * 3 to 20 voxels at random places (docs/measurement.md). */
#define TURNING 0.6         /* times the square root of the area in faces */
#define FLAT 1.1            /* times half of the faces in flat patches */
#define LONE 0.35           /* more for those that have none opposite: what leans on them ends at them too */
#define FLAT_LEAST 0.1      /* share of flat patterns of one axis in the area, which surfaces that turn have */
#define FLAT_MOST 0.2       /* and from which on all of them are taken for flat faces */
#define EXTRUDED_LEAST 0.17 /* the same of patterns that are alike along an axis */

/* Neighbouring voxels alike along an axis: as bits of the nearer half. */
static bool is_extruded(unsigned pattern, int axis)
{
    return ((pattern >> (1 << axis)) & nearer_half[axis]) == (pattern & nearer_half[axis]);
}

double vvi_count_spread(const uint64_t count[VVI_CONFIGURATIONS])
{
    const unsigned *half = nearer_half;
    double faces[3];
    vvi_raw_faces(faces, count);
    const double area = (faces[0] + faces[1] + faces[2]) / 1.5; /* of surfaces that turn every way */
    double square = TURNING * TURNING * area;
    for (int a = 0; a < 3 && area > 0; a++) {
        const double n = (double)(count[half[a]] + count[255 - half[a]]);
        const double lone = fabs((double)count[half[a]] - (double)count[255 - half[a]]);
        const double flat =
            (n + LONE * lone) / 2 * fmin(fmax((n / area - FLAT_LEAST) / (FLAT_MOST - FLAT_LEAST), 0), 1);
        double extruded = -EXTRUDED_LEAST * area;
        for (unsigned p = 1; p < 255; p++)
            if (is_extruded(p, a) && p != half[0] && p != half[1] && p != half[2] && p != 255 - half[0] &&
                p != 255 - half[1] && p != 255 - half[2])
                extruded += (double)count[p];
        square += FLAT * FLAT * flat * flat + TURNING * TURNING * fmax(extruded, 0) * sqrt(area);
    }
    return sqrt(square);
}

/* Corners that share edges with corner c, itself among them, within a set. */
static unsigned piece(unsigned set, int c)
{
    unsigned got = 1u << c;
    for (int turn = 0; turn < 7; turn++)
        for (int i = 0; i < 8; i++)
            if (got >> i & 1)
                got |= set & (1u << (i ^ 1) | 1u << (i ^ 2) | 1u << (i ^ 4));
    return got;
}

/* Of the corner of the piece that has most neighbours in it: how many. */
static int most_neighbours(unsigned set)
{
    int most = 0;
    for (int c = 0; c < 8; c++) {
        const unsigned around = 1u << (c ^ 1) | 1u << (c ^ 2) | 1u << (c ^ 4);
        const int n = set >> c & 1 ? __builtin_popcount(set & around) : 0;
        most = n > most ? n : most;
    }
    return most;
}

static bool is_face(unsigned set)
{
    static const unsigned faces[6] = {0x55, 0xaa, 0x33, 0xcc, 0x0f, 0xf0};
    for (int f = 0; f < 6; f++)
        if (set == faces[f])
            return true;
    return false;
}

/* Of one piece of at most four corners. A plane never cuts off four in a row that turn twice: theirs is the area of the
 * polygon that Marching Cubes puts there. */
static double piece_weight(unsigned set)
{
    switch (__builtin_popcount(set)) {
    case 1:
        return 0.636;
    case 2:
        return 0.669;
    case 3:
        return 0.554;
    default:
        return is_face(set) ? 0.927 : most_neighbours(set) == 3 ? 0.421 : 1.366;
    }
}

static double lindblad_weight(unsigned pattern)
{
    unsigned rest = __builtin_popcount(pattern) > 4 ? pattern ^ 255 : pattern;
    double sum = 0;
    while (rest) {
        const unsigned one = piece(rest, __builtin_ctz(rest));
        sum += piece_weight(one);
        rest &= ~one;
    }
    return sum;
}

double vvi_area_lindblad(const uint64_t count[VVI_CONFIGURATIONS])
{
    double sum = 0;
    for (unsigned p = 1; p < 255; p++)
        if (count[p])
            sum += (double)count[p] * lindblad_weight(p);
    return sum;
}

/* Voxels - pairs that share a face + fours around an edge - eights around a corner, each divided among the cells that
 * see it. */
int64_t vvi_euler_number(const uint64_t count[VVI_CONFIGURATIONS])
{
    static const unsigned faces[6] = {0x55, 0xaa, 0x33, 0xcc, 0x0f, 0xf0};
    int64_t eighths = 0;
    for (unsigned p = 1; p < 256; p++) {
        int pairs = 0, fours = 0;
        for (int c = 0; c < 8; c++)
            for (int bit = 1; bit < 8; bit *= 2)
                pairs += !(c & bit) && (p >> c & 1) && (p >> (c | bit) & 1);
        for (int f = 0; f < 6; f++)
            fours += (p & faces[f]) == faces[f];
        eighths += (int64_t)count[p] * (__builtin_popcount(p) - 2 * pairs + 4 * fours - 8 * (p == 255));
    }
    return eighths / 8;
}
