/** @file
 * Meshes in a folder, and folders that are volumes: they are no parts of what is read as a volume.
 */
#ifndef CLI_INFO_FOLDER_H
#define CLI_INFO_FOLDER_H
#include "command.h"

/** Lists those of a folder; of a file, and of a part of a folder, nothing. alone: it holds nothing else, and has
 * no block yet. Whether there are any. */
bool cli_info_folder(cli_command *command, const char *word, bool alone);
#endif
