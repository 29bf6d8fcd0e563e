/** @file
 * What pictures this terminal can show.
 */
#ifndef CLI_TERMINAL_PICTURE_H
#define CLI_TERMINAL_PICTURE_H
#include <volvis/image.h>

/** Asks it for sixels (0.3 s at most), and looks at TERM, COLORTERM and NO_COLOR. Shades where standard output is no
 * terminal. */
vv_letters cli_terminal_letters(void);
/** Blocks as good as TERM and COLORTERM say, terminal or not. */
vv_letters cli_terminal_blocks(void);
/** Most pixels that fit: as wide as the terminal, not taller than a screen; height of a pixel by its width. */
void cli_terminal_picture_size(int *width_out, int *height_out, double *aspect_out, vv_letters kind);
#endif
