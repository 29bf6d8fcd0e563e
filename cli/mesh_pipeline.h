/** @file
 * Operations that make meshes: inputs read, the operation run, the mesh written and reported.
 */
#ifndef CLI_MESH_PIPELINE_H
#define CLI_MESH_PIPELINE_H
#include "input.h"

/** Runs the verb's operation, whose row makes a mesh of fields or of meshes, on the command's words, and writes -o.
 * With --dry-run nothing is written, and nothing read but headers and, for an estimate of triangles, a few slices. */
vv_status cli_mesh_pipeline_run(cli_command *command);
#endif
