/** @file
 * Plots of what was measured, as files.
 */
#ifndef CLI_MEASURE_PLOT_H
#define CLI_MEASURE_PLOT_H
#include "command.h"
#include "measure/plot.h"

/** Whether -o names a picture and no text. */
bool cli_plot_wanted(const cli_command *command);
/** To be asked before the work: from then on -o is the plot, and the text goes to standard output. */
vv_status cli_plot_check(cli_command *command);
/** Draws and writes -o: SVG, or an image by its suffix. */
vv_status cli_plot_write(cli_command *command, const vvi_plot *plot);
#endif
