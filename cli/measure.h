/** @file
 * What the files behind `measure` share: its options, what is measured, and figures for people and programs.
 */
#ifndef CLI_MEASURE_H
#define CLI_MEASURE_H
#include "edits.h"
#include "grid/label_id.h"
#include "input.h"
#include "run/stream.h"
#include <volvis/measure.h>

/** Where figures go: text or a table, JSON, and the list that a scene keeps. */
typedef struct cli_result {
    cli_command *command;
    bool csv;
    const char *edited;              /**< the input that --set edits; NULL: none */
    const char *part;                /**< of several: tables and scenes name figures after it too; NULL: of all */
    char object[160], region[96];    /**< of what, for people; "" where that says nothing */
    vvi_text figures;                /**< JSON objects of the model's class `figure`, with commas between them */
    vvi_text planes;                 /**< the same of --clip, of the class `cut_plane` */
    int component;                   /**< the number of --channel */
    char label[2][VVI_LABEL_DIGITS]; /**< the numbers of --label and --other-label, where names are given; "": not */
} cli_result;

/** What is asked: the kind, and one file or two. */
typedef struct cli_question {
    const char *kind, *file[2]; /**< the second file, of distances between surfaces, is NULL mostly */
} cli_question;

typedef enum cli_method { CLI_METHOD_AUTO, CLI_METHOD_CUBES, CLI_METHOD_COUNT } cli_method;
typedef enum cli_space { CLI_SPACE_INDEX, CLI_SPACE_WORLD } cli_space;

typedef struct cli_measure_options {
    vv_object base;
    char *iso, *threshold, *label, *mask, *seed, *box, *values, *range, *store, *other_iso, *other_label, *input_unit;
    char *component;             /**< number or name, as typed */
    vv_collection *clip, *point; /**< of cli_word */
    int method, space;
    int64_t bins, samples;
    bool closed, log, csv, update;
} cli_measure_options;
extern const vv_class cli_measure_class;

enum { CLI_PLANES_MOST = 38 }; /* six of a box */

/** One measurement of the command line. */
typedef struct cli_measuring {
    cli_command *command;
    cli_result *result;
    const cli_measure_options *o;
    cli_input input, mask_input, values_input;
    vvi_stream stream, mask_stream, values_stream;
    vv_field *field, *mask;
    vv_affine place; /**< where the scene puts the data */
    vv_plane planes[CLI_PLANES_MOST - 6];
    size_t n_planes;
    vv_measure_options choice;
    bool chosen;       /**< an object was asked for */
    bool automatic;    /**< VolVis chose the value */
    bool of_scene;     /**< it is the one that the scene shows */
    bool took_missing; /**< field is without them */
    bool told_seed;    /**< in JSON, once */
    bool told_empty;   /**< that the object is empty */
    char object[160];  /**< what it is, for people */
    char region[96];
} cli_measuring;

/** Opens `word` with the command's options and makes the choice. Close it also when it fails. */
vv_status cli_measuring_open(cli_measuring *out, cli_result *result, const char *word);
void cli_measuring_close(cli_measuring *m);
/** Without an option that names an object: the values above the one that best splits the histogram, or below it where
 * the larger ones surround the object; of labels all but 0. To be asked before areas and volumes are measured. */
vv_status cli_measuring_choose(cli_measuring *m);
/** Of an object below a value that was chosen so: the surface of that value, which bounds it from outside. */
void cli_measuring_take_surface(cli_measuring *m);
/** Of data that turned out to be steps: counts from now on, where the method was left to VolVis. False: it was not. */
bool cli_measuring_count_steps(cli_measuring *m);
/** The planes of the region in the world, those of the box too, at its outermost samples. How many there are. */
size_t cli_measuring_planes(vv_plane out[CLI_PLANES_MOST], const cli_measuring *m);
/** Of labels: counts, unless --method cubes was typed. */
void cli_measuring_label_method(cli_measuring *m);
/** What --label or --other-label names; in another layer of the file than the one that is read, it is told. */
vv_status cli_measuring_label(vv_label_id *out, const cli_measuring *m, const char *option, const char *typed);
/** A plane of q where its places are p = map q. */
vv_plane cli_plane_mapped(const vv_plane *plane, const vv_affine *map);
/** The World of a scene, or of what a scene on data would be, into `model`; edited: with every --set. */
vv_status cli_measuring_world(vv_model *model, vvi_recipe *recipe_out, cli_command *command, const char *word,
                              bool edited);
/** The first input's samples, with what its scene and --clip say of them. */
vv_status cli_measuring_open_samples(cli_measuring *m, const char *word);
/** Samples of one more input. */
vv_status cli_measuring_read(vv_field **out, cli_input *input, vvi_stream *stream, cli_command *command,
                             const char *word);
/** The same samples elsewhere in the world. */
vv_status cli_measuring_put_at(vv_field **field, const vv_affine *place);
/** The same of a file that is told sample by sample with the volume: it goes where the scene puts the volume, and its
 * samples must lie where the volume's do; in the volume's order then. marks: it is a mask, 0 where it has no samples;
 * else it must have one wherever the volume has. */
vv_status cli_measuring_beside(vv_field **out, const cli_measuring *m, cli_input *input, vvi_stream *stream, bool marks,
                               const char *word);
/** The seed in JSON, once, where there is one. */
void cli_measuring_put_seed(cli_measuring *m);
/** A note that the object is empty, once, though values and the object may both be asked for. */
void cli_measuring_note_empty(cli_measuring *m);
/** How well a place is known along one direction: it is picked from samples, to half a step along each axis. */
double cli_place_error(const cli_measuring *m);
/** --point by number as index coordinates; VV_E_ARGUMENT says how many `what` needs. */
vv_status cli_measuring_points(vv_vec3 *out, size_t n, const cli_measuring *m, const char *what);

/* Figures --------------------------------------------------------------------------------------------------------- */

/** A number with its unit: a line of text, `key`, `key`_error and an entry of "units" in JSON, a row of the CSV table.
 */
typedef struct cli_figure {
    const char *key, *label;
    double value, error; /**< error NaN: none is known */
    char unit[32];
    double chance; /**< of one without an error: how far chance may put it, which its digits follow; 0: not known */
} cli_figure;

enum { CLI_FIGURE_TEXT = 160 };
/** "12.34 ± 0.05 mm^2": as many digits as the error allows; to 6 digits where nothing says how many mean something. */
void cli_figure_print(char out[CLI_FIGURE_TEXT], const cli_figure *figure);
/** "12.34" and "0.05": both to the second digit of the error, with an exponent where that would be many zeros or
 * nothing else; to 6 digits without one. */
void cli_figure_digits(char out[48], char error_out[48], double value, double error);
/** "12.3, 4.57, 8.9": each to the second digit of its error. error NULL: none is known. */
void cli_place_print(char out[CLI_FIGURE_TEXT], const double v[3], const double error[3]);
void cli_figure_put(cli_result *result, const cli_figure *figure);
/** As a row of the table. */
void cli_figure_row(vvi_text *out, const cli_figure *figure);
/** Appends `, "name": value` to the JSON of a scene; nothing where the value is not finite. */
void cli_figure_add_number(vvi_text *out, const char *name, double value);
/** One that is shown in another way: only kept. */
void cli_figure_keep(cli_result *result, const cli_figure *figure);
/** Three numbers of a place: JSON (without errors), rows `key`_x to `key`_z of a table, kept; no text. error: NULL:
 * none is known. */
void cli_vector_put(cli_result *result, const char *key, const double v[3], const double error[3], const char *unit);
void cli_result_free(cli_result *result);
/** "mm^2"; of "voxels" "voxels^2". */
void cli_power_unit(char out[32], const char *unit, int power);

/* Before anything is measured ------------------------------------------------------------------------------------- */

/** VV_E_ARGUMENT: an option that says nothing about what is asked. */
vv_status cli_measure_check(cli_command *command, const cli_question *question);
/** Whether a kind can be plotted. */
bool cli_measure_has_plot(const char *kind);
/** What -o makes, by its suffix: a plot, a table, JSON or text; VV_E_ARGUMENT: none of them. To be asked first. */
vv_status cli_measure_output(cli_command *command, const char *kind);
/** --dry-run: what would be read and measured. */
vv_status cli_measure_plan(cli_command *command, const cli_question *question);

/* Kept in scenes --------------------------------------------------------------------------------------------------- */

/** The kind that a word names, unless a file has that name; NULL: none. */
const char *cli_measure_kind(const char *word);
/** By number; NULL past the last. */
const char *cli_measure_kind_nth(size_t index);
vv_status cli_measure_fail_kind(const char *word);
/** --store: whether it can be, before anything is measured. */
vv_status cli_measure_store_check(cli_command *command, const char *input);
/** LO,HI; what is left out is infinite. */
vv_status cli_threshold_parse(double *lo, double *hi, const char *typed);
/** Two numbers, for --range. */
vv_status cli_range_parse(double *lo, double *hi, const char *typed);
/** A whole number. */
vv_status cli_label_parse(vv_label_id *out, const char *option, const char *typed, vv_type type);
/** One question, answered into `result` with the command's options. */
vv_status cli_measure_ask(cli_result *result, const cli_question *question);
/** --store: the question and its figures, into a scene. */
vv_status cli_measure_store(cli_result *result, const cli_question *question);
/** Whether `file` is a scene that has measurements. */
bool cli_measure_has_stored(cli_command *command, const char *file);
/** Those of a scene once more: all, or those of n names. */
vv_status cli_measure_stored(cli_command *command, const char *file, const char *const *names, size_t n);

/* What is measured ------------------------------------------------------------------------------------------------ */

vv_status cli_measure_object(cli_measuring *m, const char *what);
vv_status cli_measure_values(cli_measuring *m, bool histogram);
vv_status cli_measure_profile(cli_measuring *m);
vv_status cli_measure_points(cli_measuring *m, bool angle);
vv_status cli_measure_labels(cli_measuring *m);
vv_status cli_measure_joint(cli_measuring *m);
#endif
