/** @file
 * The recipe of a picture: the World that makes it again, written inside the image file.
 */
#ifndef VVI_RENDER_RECIPE_H
#define VVI_RENDER_RECIPE_H
#include "core/status.h"
#include <volvis/image.h>
#include <volvis/model.h>

/** Keys of the text. */
#define VVI_KEY_SCENE "VolVis:Scene"
#define VVI_KEY_VIEW "VolVis:View"
#define VVI_KEY_BITS "VolVis:Bits"
#define VVI_KEY_VERSION "VolVis:Version"
#define VVI_KEY_SEED "VolVis:Seed"
#define VVI_KEY_DATA "VolVis:Data"
#define VVI_KEY_RAYS "VolVis:Rays"

/** What a picture says of itself beside its World. */
typedef struct vvi_recipe {
    char view[64]; /**< "" when it does not say */
    int bits;      /**< a channel; 0 when it does not say */
    char rays[96]; /**< how many there were a pixel, and what ended it; for people */
} vvi_recipe;

/** Whether a file is a picture that can be read and carries no World. */
bool vvi_recipe_is_missing(const char *path, vv_job *job);
/** Whether it is one that carries a World. */
bool vvi_recipe_is_there(const char *path, vv_job *job);

/** The World in a picture; VV_E_FORMAT when VolVis did not make it. */
vv_status vvi_recipe_read(vv_world **world_out, vvi_recipe *recipe_out, const char *path, vv_job *job);

/** The World with everything that was left open written out, and the checksums of its data. */
vv_status vvi_recipe_fix(vv_world **out, vv_world *world, const char *view, vv_job *job);

/** Text for an image file at `path` ("-": paths of data stay as they are); free with vv_text_free(). */
vv_status vvi_recipe_text(vv_text **out, size_t *n_out, const vv_world *fixed, const vvi_recipe *recipe,
                          const char *path);
#endif
