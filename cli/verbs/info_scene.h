/** @file
 * What a scene, or a picture with one, holds, as `info` tells it.
 */
#ifndef CLI_INFO_SCENE_H
#define CLI_INFO_SCENE_H
#include "command.h"

vv_status cli_info_scene(cli_command *command, const char *word, const char *format);
#endif
