/** @file
 * The recipe of a picture: the World that makes it again, written inside the image file.
 */
#ifndef CLI_RECIPE_H
#define CLI_RECIPE_H
#include "command.h"
#include <volvis/image.h>
#include <volvis/model.h>

/** Keys of the text. */
#define CLI_KEY_SCENE "VolVis:Scene"
#define CLI_KEY_VIEW "VolVis:View"
#define CLI_KEY_BITS "VolVis:Bits"
#define CLI_KEY_VERSION "VolVis:Version"
#define CLI_KEY_SEED "VolVis:Seed"
#define CLI_KEY_DATA "VolVis:Data"
#define CLI_KEY_RAYS "VolVis:Rays"

/** What a picture says of itself beside its World. */
typedef struct cli_recipe {
    char view[64]; /**< "" when it does not say */
    int bits;      /**< a channel; 0 when it does not say */
    char rays[96]; /**< how many there were a pixel, and what ended it; for people */
} cli_recipe;

/** Whether a file is a picture that can be read and carries no World. */
bool cli_recipe_is_missing(const char *path, vv_job *job);

/** The World in a picture; VV_E_FORMAT when VolVis did not make it. */
vv_status cli_recipe_read(vv_world **world_out, cli_recipe *recipe_out, const char *path, vv_job *job);

/** The World with everything that was left open written out, and the checksums of its data. */
vv_status cli_recipe_fix(vv_world **out, vv_world *world, const char *view, vv_job *job);

/** Text for an image file at `path` ("-": paths of data stay as they are); free with vv_text_free(). */
vv_status cli_recipe_text(vv_text **out, size_t *n_out, const vv_world *fixed, const cli_recipe *recipe,
                          const char *path);
#endif
