/** @file
 * What surfaces take from a scene or a file beside samples: where they lie, what is cut away, which values and labels
 * are seen, names and colours.
 */
#ifndef CLI_MESH_SCENE_H
#define CLI_MESH_SCENE_H
#include "input.h"
#include "run/label_look.h"
#include "surface/isosurface.h"
#include <volvis/sys/scene.h>

typedef struct cli_mesh_scene {
    vv_scene *scene; /* NULL: there is a file alone */
    const vv_actor *actor;
    vvi_file_labels labels;
    vv_label_look *look; /* of labels, and its user */
    void *look_user;
    double top;
    vvi_isosurface_more more;
    const char *chosen; /* how a value was chosen, for people; NULL: not by the scene */
} cli_mesh_scene;

/** The first visible volume of a scene, or of a picture with one. *field_out: its samples, where the scene puts them;
 * the caller releases it. Zeroed is valid to close. */
vv_status cli_mesh_scene_open(cli_mesh_scene *out, vv_field **field_out, cli_command *command, const char *word);
/** The names that the scene gives labels; yours to free(). */
vv_status cli_mesh_scene_labels(vv_label **out, size_t *n_out, const cli_mesh_scene *scene);
/** Names and colours of labels as the file has them, else the colours of pictures. */
void cli_mesh_scene_of_file(cli_mesh_scene *out, const cli_input *input);
/** The parameters of an operation that makes surfaces from now on make what is seen: nothing that was typed changes.
 * `scene` stays where it is as long as they are used. */
vv_status cli_mesh_scene_apply(cli_mesh_scene *scene, const vvi_surface_row *surface, vv_object **params);
void cli_mesh_scene_close(cli_mesh_scene *scene);
#endif
