/** @file
 * Colours by name, as CSS has them.
 */
#ifndef VVI_CORE_COLOR_NAMES_H
#define VVI_CORE_COLOR_NAMES_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** The 148 of CSS, and transparent. */
enum { VVI_COLOR_NAMES = 149 };

/** In the order of the alphabet; NULL at the end. */
const char *vvi_color_name(size_t index);

/** The sRGB bytes 0xrrggbbaa of a name, letter case apart; false: there is none. */
bool vvi_color_of_name(uint32_t *rgba_out, const char *typed);

#endif
