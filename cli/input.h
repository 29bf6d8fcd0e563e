/** @file
 * Inputs of a command line: FILE, FILE@N, "-", scenes, and pictures that VolVis made.
 */
#ifndef CLI_INPUT_H
#define CLI_INPUT_H
#include "command.h"
#include "model/contents.h"
#include "render/recipe.h"
#include <volvis/file.h>

typedef enum cli_input_kind { CLI_INPUT_DATA, CLI_INPUT_SCENE, CLI_INPUT_PICTURE } cli_input_kind;

/** A data file that is open. Zeroed is valid to close. */
typedef struct cli_input {
    char *path;
    int64_t frame; /**< -1: none was chosen */
    vv_file *file;
    char *part; /**< that was named; NULL: none */
} cli_input;

/** What FILE[:PART][@N] names. */
typedef struct cli_input_name {
    char *path;
    char *part;    /**< NULL: none was given */
    int64_t frame; /**< -1: none was given */
} cli_input_name;

/** FILE[:PART][@N]; where a file of the whole name exists, that is meant. Free with cli_input_name_free. */
vv_status cli_input_split(cli_input_name *out, const char *word);
void cli_input_name_free(cli_input_name *name);
/** By suffix (.vv.json) and by the first bytes (image formats; of standard input a scene's brace too). What --raw or
 * --input-format speak of is data. */
cli_input_kind cli_input_guess(const cli_command *command, const char *path);
/** The same where a World or data are wanted: a PNG or JPEG without a scene in it is data, a volume of one slice. */
cli_input_kind cli_input_contents(const cli_command *command, const char *path);
/** The format of volumes that takes a picture's pixels for a slice: it knows PNG and JPEG; NULL: none does. */
const char *cli_input_pixels(const cli_command *command, const char *path);
/** Opens a data file, or the data of the first visible volume of a scene or picture, with the command's reading
 * options; the log says its warnings. */
vv_status cli_input_open(cli_input *out, cli_command *command, const char *word);
/** What was said of reading, where a file is open already: its time step is there, values that stand for what is
 * missing are left out. volume: of a World, which may say these too; NULL: there is none. */
vv_status cli_input_take(cli_input *input, cli_command *command, const vv_volume *volume);
/** The same data as a World has them by now: `word` is the input that it came from. */
vv_status cli_input_open_in(cli_input *out, cli_command *command, const vv_world *world, const char *word);
/** The first bytes of a regular file, or of standard input ("-"), which stay there to be read; 0 of what cannot be
 * looked into. */
size_t cli_input_peek(unsigned char *out, size_t n, const char *path);
void cli_input_close(cli_input *input);
/** The property engine's context for lengths along an input's grid. */
vv_property_context cli_input_context(const vv_field_info *info, const vv_registry *registry);

/** The time step in every volume of the World; negative: none was chosen, and all stay as they are. */
vv_status cli_world_set_frame(vv_world **world, int64_t frame);
/** A World on a data file, from a scene, or from a picture's text; the frame of FILE@N is set in its volumes.
 * recipe_out: what else a picture says of itself, zero for other inputs. */
vv_status cli_input_world(vv_world **out, vvi_recipe *recipe_out, cli_command *command, const char *word);
/** Folder that a file lies in, as paths of scenes are relative to it; yours to free(), NULL without memory. */
char *cli_folder_of(const char *path);
#endif
