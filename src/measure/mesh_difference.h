/** @file
 * How two meshes differ: what each is, and how far their surfaces lie from each other.
 */
#ifndef VVI_MEASURE_MESH_DIFFERENCE_H
#define VVI_MEASURE_MESH_DIFFERENCE_H
#include <volvis/measure_distance.h>

typedef struct vvi_mesh_about {
    vv_mesh_topology topology;
    vv_mesh_measures measures;
} vvi_mesh_about;

typedef struct vvi_mesh_difference {
    vvi_mesh_about about[2];
    vv_mesh *b;                 /**< the second, in the unit of the first where both have real ones; to be released */
    char unit[2][16];           /**< as the meshes have them */
    bool same_world;            /**< in one unit and space, before anything is scaled */
    bool same_topology;         /**< as many vertices, and the same triangles of them, in the same order */
    bool same_places;           /**< as many vertices, each at the same place */
    bool same_data;             /**< the same normals, values and colours, of vertices in the same order */
    double bounds_difference;   /**< largest distance of the same corner of both boxes; NaN: one has none */
    bool apart;                 /**< only one has triangles: there are no distances */
    vv_figure least;            /**< of one surface from the other */
    vv_mesh_distances distance; /**< with what the places are rounded by */
    double rounding;            /**< lengths below it are none */
} vvi_mesh_difference;

/** Distances are 0, without a search, where nothing differs. out->b is for vv_mesh_release(), also after a failure. */
vv_status vvi_mesh_compare(vvi_mesh_difference *out, const vv_mesh *a, const vv_mesh *b, vv_job *job);
/** Whether neither surface has a place farther than the limit from the other, but for rounding of places: looked at
 * once more where the measured distance and its error leave it open. */
vv_status vvi_mesh_within(bool *out, const vvi_mesh_difference *d, const vv_mesh *a, double limit, vv_job *job);
#endif
