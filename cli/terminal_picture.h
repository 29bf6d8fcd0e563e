/** @file
 * Pictures in a terminal: sixels, half blocks in colours, or shades of letters.
 */
#ifndef CLI_TERMINAL_PICTURE_H
#define CLI_TERMINAL_PICTURE_H
#include "core/text.h"
#include "preview.h"

typedef enum cli_picture_kind {
    CLI_PICTURE_SIXEL,   /**< pixels */
    CLI_PICTURE_BLOCKS,  /**< two pixels a letter, 16 million colours */
    CLI_PICTURE_BLOCKS8, /**< the same in the 256 colours of xterm */
    CLI_PICTURE_SHADES   /**< one pixel a letter, light or dark */
} cli_picture_kind;

/** What this terminal can show: asks it for sixels (0.3 s at most), and looks at TERM, COLORTERM and NO_COLOR. Shades
 * where standard output is no terminal. */
cli_picture_kind cli_terminal_picture_kind(void);
/** Blocks as good as TERM and COLORTERM say, terminal or not. */
cli_picture_kind cli_terminal_blocks(void);
/** Most pixels that fit: as wide as the terminal, not taller than a screen; height of a pixel by its width. */
void cli_terminal_picture_size(int *width_out, int *height_out, double *aspect_out, cli_picture_kind kind);
void cli_terminal_picture(vvi_text *out, const cli_thumbnail *picture, cli_picture_kind kind);
#endif
