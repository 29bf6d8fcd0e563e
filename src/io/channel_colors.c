#include "io/channel_colors.h"

bool vvi_has_channels(const vv_field_info *info)
{
    return info->meaning == VV_MEANING_SCALAR && info->components > 1 && info->components <= VVI_CHANNELS_SHOWN;
}

vv_color vvi_channel_color(const vv_channel *channels, size_t n, size_t index)
{
    static const vv_color colors[VVI_CHANNELS_SHOWN] = {
        {0, 1, 0, 1}, {1, 0, 1, 1},   {0, 1, 1, 1},    {1, 1, 0, 1},
        {1, 0, 0, 1}, {0, 0.1, 1, 1}, {1, 0.25, 0, 1}, {1, 1, 1, 1},
    };
    if (index < n && channels[index].has_color)
        return channels[index].color;
    return colors[index % VVI_CHANNELS_SHOWN];
}
