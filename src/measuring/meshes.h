/** @file
 * Measuring mesh files, and the meshes of scenes.
 */
#ifndef CLI_MEASURE_MESHES_H
#define CLI_MEASURE_MESHES_H
#include "measure.h"
#include <volvis/measure_mesh.h>
#include <volvis/model.h>

/** What: "summary", "area", "volume" or "box". */
vv_status cli_measure_mesh(cli_result *result, const char *what, const char *path);
/** The figures of a mesh, or of several together, in the form that was asked for. */
void cli_mesh_measures_put(cli_result *result, const char *what, const vv_mesh_measures *measures, const char *unit);

/** The World of a scene, or of a picture with one, whose first visible volume is a mesh; NULL: `file` is none. With
 * every --set where it is `edited`. Yours to release. */
vv_world *cli_measure_mesh_world(cli_command *command, const char *edited, const char *file);
/** VV_E_ARGUMENT: a kind that meshes of a scene do not have. */
vv_status cli_measure_mesh_scene_check(const char *kind, const char *file);
/** Its visible meshes where it places them, each and together. file: its name, for errors. */
vv_status cli_measure_mesh_scene(cli_result *result, const char *what, const char *file, const vv_world *world);
#endif
