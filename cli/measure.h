/** @file
 * What the files behind `measure` share: its options, inputs that are open, answers for people and in tables.
 */
#ifndef CLI_MEASURE_H
#define CLI_MEASURE_H
#include "edits.h"
#include "input.h"
#include "measuring/figure_changes.h"
#include "measuring/measuring.h"
#include "run/measured.h"

/** What is asked: the kind, and one file or two. */
typedef struct cli_question {
    const vv_measure_kind *kind; /**< NULL: what is stored */
    const char *file[2];         /**< the second file, of distances between surfaces, is NULL mostly */
    const char *edited;          /**< the input that --set edits; NULL: none */
    vv_measurement *asked;       /**< its properties */
    bool typed;                  /**< labels, channels and cut planes are not among them: they need the files */
} cli_question;

/** Options beside the properties of vv_measurement, which are the others. */
typedef struct cli_measure_options {
    vv_object base;
    vv_collection *cut_planes; /**< of cli_word, as typed */
    char *store;
    bool log, csv, update;
} cli_measure_options;
extern const vv_class cli_measure_class;

/* Words ----------------------------------------------------------------------------------------------------------- */

/** "stored": the word for what is no kind. */
#define CLI_MEASURE_STORED "stored"
/** The kind that a word names, unless a file has that name; NULL: none. */
const vv_measure_kind *cli_measure_kind(const char *word);
bool cli_measure_is_stored(const char *word);
/** Of which no kind is said. */
const vv_measure_kind *cli_measure_default_kind(void);
/** How many files it takes. */
size_t cli_measure_most_files(const vv_measure_kind *kind);
/** What may stand for WHAT, by number; NULL past the last. */
const char *cli_measure_word_nth(size_t index);
vv_status cli_measure_fail_kind(const char *word);
/** What was given for a property of vv_measurement, by its name; NULL: nothing. */
const char *cli_measure_typed(const cli_command *command, const char *property);
/** What is typed, as a measurement, yours to release: all that can be told without the files. kind NULL: none. */
vv_status cli_measure_take(vv_measurement **out, const cli_command *command, const vv_measure_kind *kind);

/* Inputs ---------------------------------------------------------------------------------------------------------- */

/** All of a question, open. Zeroed is valid to close. */
typedef struct cli_measured {
    cli_input file[2]; /**< of the first and the second, where these are volumes */
    cli_input mask, values;
    vv_world *world; /**< of the meshes that it shows */
    char *planes;    /**< of --clip, as JSON; NULL: none */
    vvi_measured_all of;
} cli_measured;

/** Opens the files of a question, and masks and values beside them. Close it also when it fails. */
vv_status cli_measured_open(cli_measured *out, cli_command *command, const cli_question *question);
/** What stands beside the first file. */
vv_status cli_measured_open_beside(cli_measured *out, cli_command *command, const vv_measurement *asked);
void cli_measured_close(cli_measured *inputs);
/** The World of a scene, or of what a scene on data would be, into `model`; edited: with every --set. */
vv_status cli_measure_world(vv_model *model, vvi_recipe *recipe_out, cli_command *command, const char *word,
                            bool edited);
/** The World of a scene, or of a picture with one, whose first visible volume is a mesh; NULL: `file` is none. With
 * every --set where it is `edited`. Yours to release. */
vv_world *cli_measure_mesh_world(cli_command *command, const cli_question *question);

/* Before anything is measured ------------------------------------------------------------------------------------- */

/** VV_E_ARGUMENT: an option that says nothing about what is asked. */
vv_status cli_measure_check(cli_command *command, const cli_question *question);
/** What -o makes, by its suffix: a plot, a table, JSON or text; VV_E_ARGUMENT: none of them. To be asked first. */
vv_status cli_measure_output(cli_command *command, const vv_measure_kind *kind);
/** --dry-run: what would be read and measured. */
vv_status cli_measure_plan(cli_command *command, const cli_question *question);
/** The rest of what is typed: labels and channels by the names that the inputs have, and --clip. */
vv_status cli_measure_names(vv_measurement **asked, cli_command *command, cli_measured *inputs);

/* Answers --------------------------------------------------------------------------------------------------------- */

/** One question, answered. *asked_out: what was asked, labels and all, and its figures. Both are yours to release, also
 * when this fails; notes are told. */
vv_status cli_measure_ask(vv_answer **out, vv_measurement **asked_out, cli_command *command,
                          const cli_question *question);
/** As text or as a table, and in JSON. */
void cli_answer_print(cli_command *command, const vv_answer *answer, bool csv, bool logarithmic);

/** Whether -o names a picture and no text. */
bool cli_plot_wanted(const cli_command *command);
/** To be asked before the work: from then on -o is the plot, and the text goes to standard output. */
vv_status cli_plot_check(cli_command *command);
/** Draws and writes -o, where it is a picture: SVG, or an image by its suffix. */
vv_status cli_plot_write(cli_command *command, const vv_answer *answer, const char *file, bool logarithmic);

/* Kept in scenes --------------------------------------------------------------------------------------------------- */

/** --store: whether it can be, before anything is measured. */
vv_status cli_measure_store_check(cli_command *command, const char *input);
/** --store: what was asked, with its figures, into a scene. */
vv_status cli_measure_store(cli_command *command, const cli_question *question, const vv_measurement *asked);
/** Whether `file` is a scene that has measurements. */
bool cli_measure_has_stored(cli_command *command, const char *file);
/** Those of a scene once more: all, or those of n names. */
vv_status cli_measure_stored(cli_command *command, const char *file, const char *const *names, size_t n);
/** Figures that changed, as "changes" and "changed". */
void cli_changes_json(vvi_result *json, const vvi_changes *changes);
/** All figures, and what became of those of before; csv: as rows of a table. id: the measurement's. */
void cli_changes_put(vvi_text *out, bool csv, const char *id, const vvi_changes *changes);
#endif
