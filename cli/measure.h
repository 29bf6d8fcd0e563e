/** @file
 * What the files behind `measure` share: its options, what is measured, and figures for people and programs.
 */
#ifndef CLI_MEASURE_H
#define CLI_MEASURE_H
#include "edits.h"
#include "input.h"
#include "stream.h"
#include <volvis/measure.h>

typedef enum cli_space { CLI_SPACE_INDEX, CLI_SPACE_WORLD } cli_space;

typedef struct cli_measure_options {
    vv_object base;
    char *iso, *threshold, *label, *mask, *seed, *box, *values, *range, *volume;
    vv_collection *clip, *point; /**< of cli_word */
    int method, space;
    int64_t component, bins, samples;
    bool closed, log, csv;
} cli_measure_options;
extern const vv_class cli_measure_class;

/** One measurement of the command line. */
typedef struct cli_measuring {
    cli_command *command;
    const cli_measure_options *o;
    cli_input input, mask_input, values_input;
    cli_stream stream, mask_stream, values_stream;
    vv_field *field, *mask;
    vv_plane planes[32];
    size_t n_planes;
    vv_measure_options choice;
    bool chosen;      /**< an object was asked for */
    bool told_empty;  /**< that the object is empty */
    char object[160]; /**< what it is, for people */
    char region[96];
} cli_measuring;

/** Opens `word` with the command's options and makes the choice. Close it also when it fails. */
vv_status cli_measuring_open(cli_measuring *out, cli_command *command, const char *word);
void cli_measuring_close(cli_measuring *m);
/** Without an option that names an object: the values above the one that best splits the histogram; of labels all but
 * 0. To be asked before areas and volumes are measured. */
vv_status cli_measuring_choose(cli_measuring *m);
/** Samples of one more input. */
vv_status cli_measuring_read(vv_field **out, cli_input *input, cli_stream *stream, cli_command *command,
                             const char *word);
/** --point by number as index coordinates; VV_E_ARGUMENT says how many `what` needs. */
vv_status cli_measuring_points(vv_vec3 *out, size_t n, const cli_measuring *m, const char *what);

/* Figures --------------------------------------------------------------------------------------------------------- */

/** A number with its unit: a line of text, `key`, `key`_error and an entry of "units" in JSON, a row of the CSV table.
 */
typedef struct cli_figure {
    const char *key, *label;
    double value, error; /**< error NaN: none is known */
    char unit[32];
} cli_figure;

/** "12.34 ± 0.05 mm^2": as many digits as the error allows. */
void cli_figure_print(char out[96], const cli_figure *figure);
void cli_figure_put(cli_command *command, const cli_figure *figure, bool csv);
/** "mm^2"; of "voxels" "voxels^2". */
void cli_power_unit(char out[32], const char *unit, int power);

/* Before anything is measured ------------------------------------------------------------------------------------- */

/** VV_E_ARGUMENT: an option that `kind` of a file does not have. second: the other of two meshes, or NULL. */
vv_status cli_measure_check(const cli_command *command, const char *kind, const char *file, const char *second);
/** What -o makes, by its suffix: a plot, a table, JSON or text; VV_E_ARGUMENT: none of them. To be asked first. */
vv_status cli_measure_output(cli_command *command, const char *kind);
/** --dry-run: what would be read and measured. */
vv_status cli_measure_plan(cli_command *command, const char *kind, const char *file, const char *second);

/* What is measured ------------------------------------------------------------------------------------------------ */

vv_status cli_measure_object(cli_measuring *m, const char *what);
vv_status cli_measure_values(cli_measuring *m, bool histogram);
vv_status cli_measure_profile(cli_measuring *m);
vv_status cli_measure_points(cli_measuring *m, bool angle);
vv_status cli_measure_labels(cli_measuring *m);
#endif
