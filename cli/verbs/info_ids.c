#include "info_ids.h"
#include "io/channel_colors.h"
#include "model/merge.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_taken(const cli_info_ids *ids, const char *id)
{
    for (size_t i = 0; i < ids->n; i++)
        if (strcmp(ids->id[i], id) == 0)
            return true;
    return false;
}

static vv_status take(char out[64], cli_info_ids *ids, const char *id)
{
    char(*grown)[64] = realloc(ids->id, (ids->n + 1) * sizeof *grown);
    if (!grown)
        return vv_fail_memory((ids->n + 1) * sizeof *grown);
    ids->id = grown;
    unsigned n = 1;
    do
        vvi_world_number_id(out, id, n++);
    while (is_taken(ids, out));
    memcpy(ids->id[ids->n++], out, 64);
    return VV_OK;
}

vv_status cli_info_ids_take(char out[64], cli_info_ids *ids, const char *path, const vv_field_info *info)
{
    char id[64], channel[64], given[64];
    vvi_world_id(id, strcmp(path, "-") ? path : "data");
    if (!vvi_has_channels(info))
        return take(out, ids, id);
    vv_status st = VV_OK;
    for (int c = 0; c < info->components && st == VV_OK; c++) {
        snprintf(channel, sizeof channel, "%.*s_%d", 63 - 11, id, c);
        st = take(c == 0 ? out : given, ids, channel);
    }
    return st;
}

void cli_info_ids_finish(cli_info_ids *ids)
{
    free(ids->id);
    *ids = (cli_info_ids){0};
}
