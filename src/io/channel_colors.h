/** @file
 * Colours of channels that have none of their own.
 */
#ifndef VVI_IO_CHANNEL_COLORS_H
#define VVI_IO_CHANNEL_COLORS_H
#include <volvis/file.h>

/** Components that are shown together, each in its colour; of more only one is shown. */
#define VVI_CHANNELS_SHOWN 8

/** Whether samples are independent numbers of so few components that they are channels of one picture. */
bool vvi_has_channels(const vv_field_info *info);
/** The file's, else one of a set that adds to white and is told apart with all kinds of colour vision as far as two
 * or three channels go: green and magenta first. Linear. */
vv_color vvi_channel_color(const vv_channel *channels, size_t n, size_t index);
#endif
