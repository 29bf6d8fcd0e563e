/** @file
 * How many triangles a surface will have, from a few layers of cells: for --dry-run.
 */
#ifndef CLI_MESH_ESTIMATE_H
#define CLI_MESH_ESTIMATE_H
#include "input.h"

typedef struct cli_mesh_estimate {
    const char *unknown;         /**< why nothing is known; NULL: it is */
    double triangles;            /**< of all pieces, without caps, to two digits */
    size_t n_layers, n_examined; /**< of cells between two slices */
    bool found;                  /**< the value is an estimate too: it is that of the samples that were read */
    uint64_t bytes;              /**< of the mesh and of what finds its triangles */
} cli_mesh_estimate;

/** Reads up to 64 slices of the command's first input, evenly spread in pairs, and marches through the layers between
 * them. `params` are those of the verb's operation, which makes a surface, in which the value is set where none was.
 * Nothing is known of labels, scenes and pipes. Errors: those of vv_file_read() and of its settle(). */
vv_status cli_mesh_estimate_make(cli_mesh_estimate *out, cli_command *command, const cli_input *input,
                                 vv_object **params);
/** "out.ply: a mesh of about 12000 triangles, ...": the lines and the JSON of a dry run. samples_bytes: of what is
 * read. */
void cli_mesh_estimate_report(cli_command *command, const cli_mesh_estimate *estimate, const vv_object *params,
                              const char *value_unit, uint64_t samples_bytes);
#endif
