/** @file
 * What a model has forgotten of its history, for those who tell people.
 */
#ifndef VVI_MODEL_HISTORY_H
#define VVI_MODEL_HISTORY_H
#include <volvis/model.h>

/** How many of the oldest steps can be undone no more, since the history has a limit in bytes. Of the thread that
 * edits. */
uint64_t vvi_model_forgotten(vv_model *model, uint64_t *bytes_out);
#endif
