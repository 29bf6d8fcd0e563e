/** @file
 * Which file a font is read from.
 */
#ifndef VVI_GFX_FONT_FILE_H
#define VVI_GFX_FONT_FILE_H
#include "core/status.h"

/** *out: `path` where that is not NULL, else the environment's VOLVIS_FONT, else a sans serif that fontconfig knows.
 * Yours to free(). Errors: VV_E_NOT_FOUND (none is installed), VV_E_MEMORY. */
vv_status vvi_font_find(char **out, const char *path);
#endif
