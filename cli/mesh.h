/** @file
 * Meshes on the command line: which inputs are some, reading, converting, telling.
 */
#ifndef CLI_MESH_H
#define CLI_MESH_H
#include "command.h"
#include "input.h"
#include <volvis/mesh.h>

/** Whether an input, FILE[:PART], is a mesh: --input-format says so, or its first bytes do, or they leave it in doubt
 * and the suffix is a mesh format's. A path that the rows of volumes are sure of is none. */
bool cli_mesh_is_input(const cli_command *command, const char *word);
/** Whether its first bytes are certainly those of a volume. */
bool cli_mesh_is_volume(const cli_command *command, const char *word);
/** Whether an output is to be a mesh: by --output-format, else by its suffix. */
bool cli_mesh_is_output(const cli_command *command, const char *output, const char *format);
/** VV_E_ARGUMENT where a time step is asked for, which no mesh has. */
vv_status cli_mesh_check_frame(const cli_command *command, const cli_input_name *name);
/** A mesh file, or FILE:PART, with the command's reading options; its warnings are told. input_unit: as below. */
vv_status cli_mesh_read(vv_mesh **out, cli_command *command, const char *word, const char *input_unit);
/** What is in a mesh file, as text and as JSON. input_unit: of lengths where the file says none; NULL: "units". */
vv_status cli_mesh_info(cli_command *command, const char *path, const char *input_unit);
/** From one mesh file to another. unit: lengths are written in it; NULL: as they are. */
vv_status cli_mesh_convert(cli_command *command, const char *path, const char *input_unit, const char *unit);
#endif
