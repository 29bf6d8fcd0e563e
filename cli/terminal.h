/** @file
 * The terminal: its width, whether colour is wanted, and text wrapped to a width.
 */
#ifndef CLI_TERMINAL_H
#define CLI_TERMINAL_H
#include "core/text.h"

/** Columns of a stream (COLUMNS, else the terminal, else 80), between 40 and 120. */
int cli_terminal_width(int descriptor);
/** A terminal that is not dumb, and NO_COLOR is not set. */
bool cli_terminal_color(int descriptor);
/** Columns that UTF-8 text takes, one a character. */
size_t cli_text_columns(const char *s);
/**
 * Words of `s` in lines of at most `width` columns.
 *
 * column  where the first line starts now (already written)
 * indent  spaces before every further line
 * A line end in `s` is kept; the text ends with one.
 */
void cli_text_wrap(vvi_text *out, const char *s, size_t column, size_t indent, size_t width);
#endif
