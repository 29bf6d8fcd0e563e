/** @file
 * The recipe of a picture, by the program's names for it.
 */
#ifndef CLI_RECIPE_H
#define CLI_RECIPE_H
#include "render/recipe.h"

#define CLI_KEY_SCENE VVI_KEY_SCENE
#define CLI_KEY_VIEW VVI_KEY_VIEW
#define CLI_KEY_BITS VVI_KEY_BITS
#define CLI_KEY_VERSION VVI_KEY_VERSION
#define CLI_KEY_SEED VVI_KEY_SEED
#define CLI_KEY_DATA VVI_KEY_DATA
#define CLI_KEY_RAYS VVI_KEY_RAYS
typedef vvi_recipe cli_recipe;
#define cli_recipe_is_missing vvi_recipe_is_missing
#define cli_recipe_read vvi_recipe_read
#define cli_recipe_fix vvi_recipe_fix
#define cli_recipe_text vvi_recipe_text
#endif
