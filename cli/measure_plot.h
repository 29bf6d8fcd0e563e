/** @file
 * Plots of what was measured, as files.
 */
#ifndef CLI_MEASURE_PLOT_H
#define CLI_MEASURE_PLOT_H
#include "measure.h"
#include "measure/plot.h"

/** Whether -o names a picture and no text. */
bool cli_plot_wanted(const cli_command *command);
/** To be asked before the work: from then on -o is the plot, and the text goes to standard output. */
vv_status cli_plot_check(cli_command *command);
/** Which samples a plot is of, for the line under its title; "" of all. object: those of the object alone. Samples that
 * --seed and the region keep are named too. */
enum { CLI_SUBSET_ROOM = 128 };
void cli_plot_subset(char out[CLI_SUBSET_ROOM], const cli_measuring *m, bool object);
/** Draws and writes -o: SVG, or an image by its suffix. */
vv_status cli_plot_write(cli_command *command, const vvi_plot *plot);
#endif
