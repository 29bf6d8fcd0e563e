/** @file
 * How two meshes differ: what each is, and how far their surfaces lie from each other.
 */
#ifndef CLI_MESH_DIFFERENCE_H
#define CLI_MESH_DIFFERENCE_H
#include "command.h"
#include <volvis/measure_distance.h>

typedef struct cli_mesh_about {
    vv_mesh_topology topology;
    vv_mesh_measures measures;
} cli_mesh_about;

typedef struct cli_mesh_difference {
    cli_mesh_about about[2];
    char unit[2][16];           /**< as the files have them */
    bool same_world;            /**< in one unit and space, before anything is scaled */
    bool same_topology;         /**< as many vertices, and the same triangles of them, in the same order */
    bool same_places;           /**< as many vertices, each at the same place */
    bool same_data;             /**< the same normals, values and colours, of vertices in the same order */
    double bounds_difference;   /**< largest distance of the same corner of both boxes; NaN: one has none */
    bool apart;                 /**< only one has triangles: there are no distances */
    vv_figure least;            /**< of one surface from the other */
    vv_mesh_distances distance; /**< with what the places are rounded by */
    double rounding;            /**< lengths below it are none */
} cli_mesh_difference;

/** Where both have real units, *b is swapped for one in the unit of a. Distances are 0, without a search, where nothing
 * differs. */
vv_status cli_mesh_compare(cli_mesh_difference *out, const vv_mesh *a, vv_mesh **b, vv_job *job);
/** Whether neither surface has a place farther than the limit from the other, but for rounding of places: looked at
 * once more where the measured distance and its error leave it open. */
vv_status cli_mesh_within(bool *out, const cli_mesh_difference *d, const vv_mesh *a, const vv_mesh *b, double limit,
                          vv_job *job);
/** Lines and JSON. */
void cli_mesh_difference_report(cli_command *command, const cli_mesh_difference *d, const vv_mesh *a, const vv_mesh *b);
#endif
