/** @file
 * What a model has forgotten of its history, for those who tell people.
 */
#ifndef VVI_MODEL_HISTORY_H
#define VVI_MODEL_HISTORY_H
#include <volvis/model.h>

/** How many of the oldest steps can be undone no more, since the history has a limit in bytes. Of the thread that
 * edits. */
uint64_t vvi_model_forgotten(vv_model *model, uint64_t *bytes_out);
/** The World and all that undo and redo can bring back, until see() says false. Of the thread that edits. */
void vvi_model_each_world(const vv_model *model, bool (*see)(void *user, const vv_object *world), void *user);
#endif
