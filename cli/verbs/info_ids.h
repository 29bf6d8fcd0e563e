/** @file
 * What volumes of several inputs are called in a World that has them all.
 */
#ifndef CLI_INFO_IDS_H
#define CLI_INFO_IDS_H
#include "core/status.h"
#include <stddef.h>
#include <volvis/field.h>

/** Ids that are taken. Zeroed is empty; finish with cli_info_ids_finish. */
typedef struct cli_info_ids {
    char (*id)[64];
    size_t n;
} cli_info_ids;

/** The id of the input's volume, or of its first channel's, as vvi_world_merge() gives it; its ids are taken then. */
vv_status cli_info_ids_take(char out[64], cli_info_ids *ids, const char *path, const vv_field_info *info);
void cli_info_ids_finish(cli_info_ids *ids);
#endif
