/** @file
 * Measuring triangle meshes: area, volume, centroid, inertia, box.
 */
#ifndef VOLVIS_MEASURE_MESH_H
#define VOLVIS_MEASURE_MESH_H
#include <volvis/mesh.h>
#include <volvis/runtime.h>
VV_BEGIN_DECLS

/** A number with its unit, and how far the truth may be from it. */
typedef struct vv_figure {
    double value;  /**< NaN: there is none */
    double error;  /**< the truth is expected within value - error .. value + error; INFINITY: not known */
    char unit[24]; /**< "mm", "mm^2", "mm^3", ...; "" for pure numbers */
} vv_figure;

/** Options of vv_mesh_measure(). Fill with vv_mesh_measure_options_init(), then change what you need. */
typedef struct vv_mesh_measure_options {
    size_t size;        /**< set by init */
    vv_affine to_world; /**< applied to every vertex before anything is measured; default: identity */
    char unit[16];      /**< of lengths after that; default "": the mesh's */
    size_t part;        /**< measure this part alone; default SIZE_MAX: all triangles */
    bool sampled;       /**< the triangles are chords of a smooth surface, as Marching Cubes makes them; default false:
                             they are the thing itself. Decides what `error` means */
    bool open;          /**< an open mesh is not an error: it has no volume, centroid and inertia then; default false */
} vv_mesh_measure_options;

/** What vv_mesh_measure() finds. */
typedef struct vv_mesh_measures {
    size_t n_triangles;
    vv_bounds bounds; /**< of all vertices, or of those of the part; empty when there are none */
    vv_figure area;
    vv_figure volume;      /**< of what is enclosed; hollows whose triangles face into them are left out */
    vv_figure centroid[3]; /**< x, y, z: of the solid, density 1 */
    vv_figure inertia[6];  /**< xx, yy, zz, xy, xz, yz: tensor about the centroid, density 1: xx = integral of
                                  y^2 + z^2, xy = - integral of x y */
    bool closed;           /**< every edge has as many triangles on one side as on the other */
    bool inside_out;       /**< the triangles face inwards; the volume is positive all the same */
    size_t n_open_edges;   /**< that have more triangles on one side than on the other; 0 when closed */
    size_t n_turned_edges; /**< of those: where two triangles run the same way, so that one is turned over */
    vv_vec3 open_at;       /**< the middle of one of them */
} vv_mesh_measures;

VV_API void vv_mesh_measure_options_init(vv_mesh_measure_options *options, size_t size);

/**
 * Area, volume, centroid, inertia and box of a mesh or of one part of it.
 *
 * Volume, centroid and inertia are sums over the tetrahedra between each triangle and the middle of the bounding box
 * (divergence theorem), in double precision, compensated. Vertices at the same place count as one, so that a mesh whose
 * triangles share no vertices can be closed.
 *
 * Units    lengths in options->unit, or the mesh's: area in its square, volume and inertia in its 3rd and 5th power
 * Error    not sampled: the area and volume of all that the vertices' rounding to floats allows (a strict bound).
 *          sampled: besides, an estimate of what chords leave out, which falls with the square of the triangles' size.
 *          Along an edge with normals n and m at its ends, p and q, the surface bends away from the chord as a parabola
 *          with second derivative times squared length (m - n).(q - p); its height over a triangle is integrated, and
 *          the vertices are taken to be as far from the surface as the chords are on average, which holds for linear
 *          interpolation between samples of a distance; the area changes by that times the mean curvature, and by half
 *          the squared slope. It is an estimate, not a bound: for spheres from Marching Cubes it is 1 to 2 times the
 *          true error. It knows nothing of errors in the data: noise, partial volume, the choice of the value; surfaces
 *          of binary data have 8 % too much area whatever the resolution. Normals are the mesh's, else made of the
 *          triangles around each vertex.
 * Errors   VV_E_ARGUMENT (no such part; a vertex that is not a number; an open mesh: how many edges, and where),
 *          VV_E_MEMORY, VV_E_CANCELLED
 * Threads  any; same bytes for any thread count
 * Source   Eberly 2002 (moments); Max 1999 (normals)
 */
VV_API vv_status vv_mesh_measure(vv_mesh_measures *out, const vv_mesh *mesh, const vv_mesh_measure_options *options,
                                 vv_job *job);

VV_END_DECLS
#endif
