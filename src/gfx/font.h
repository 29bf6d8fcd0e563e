/** @file
 * Letters: from UTF-8 to coverage, lengths and outlines, by FreeType. Where a font comes from: a file that was named,
 * else the environment's VOLVIS_FONT, else what fontconfig knows of Liberation Sans and its like.
 *
 * Letters are not changed to fit pixels, but for their heights, so that a text is as long at every size; kerning is the
 * font's.
 */
#ifndef VVI_GFX_FONT_H
#define VVI_GFX_FONT_H
#include "core/status.h"
#include "gfx/gfx.h"

typedef struct vvi_font vvi_font;

/** path NULL: a font that is found. Errors: VV_E_NOT_FOUND (no such file, no font), VV_E_FORMAT (no font, or none that
 * can be scaled), VV_E_UNSUPPORTED (VolVis was built without FreeType), VV_E_MEMORY. Any thread may use what it gives,
 * several at a time. */
vv_status vvi_font_open(vvi_font **out, const char *path);
void vvi_font_close(void *font); /* NULL is fine */
/** The file. */
const char *vvi_font_path(const vvi_font *font);

/** Shares of an em, above the base line; `below` is below it. */
typedef struct vvi_font_heights {
    double capital, small, above, below;
} vvi_font_heights;
vvi_font_heights vvi_font_get_heights(const vvi_font *font);

/** Length of a line in pixels. size: pixels an em. Characters that the font does not have are an empty box. */
double vvi_font_length(vvi_font *font, const char *utf8, double size);

/** One line of text as coverage: vvi_gfx_font.draw, with the font as its `user`. Errors: VV_E_ARGUMENT (size not within
 * 1 .. 4096, text longer than 16384 pixels), VV_E_MEMORY. */
vv_status vvi_font_draw(void *font, vvi_gfx_coverage *out, const char *utf8, double size, vv_job *job);

/** Closed polygons whose inside, by the rule of odd crossings, is the text: points in ems, x to the right from where it
 * begins, y up from the base line. Of vvi_alloc(). */
typedef struct vvi_font_outline {
    vv_vec3 *points; /**< z is 0 */
    size_t n_points;
    size_t *ends; /**< one past the last point of each polygon */
    size_t n_polygons;
    double advance; /**< ems */
} vvi_font_outline;
/** error_em: how far from curves the polygons may be. */
vv_status vvi_font_trace(vvi_font_outline *out, vvi_font *font, const char *utf8, double error_em, vv_job *job);
void vvi_font_outline_finish(vvi_font_outline *outline);
#endif
