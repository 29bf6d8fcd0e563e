/** @file
 * Raw events in, a virtual device out: what is bound to what is data that can be read, saved and changed while a
 * program runs, and no application knows it.
 *
 * A binding says which device, button, key or axis (with which of Shift, Control, Alt and Meta) drives which method,
 * and which slot of the virtual device that method moves or which action it asks for.
 */
#ifndef VVI_INPUT_INPUT_H
#define VVI_INPUT_INPUT_H
#include "input/device.h"
#include "input/method.h"
#include <volvis/property.h>

/** "Control+Shift+Z", "W+left": the modifiers, VVI_WITH_*, and letters that are held, and what is left of it, a part of
 * the text; "+" is a key too. */
const char *vvi_take_modifiers(unsigned *out, const char *when);

typedef struct vvi_input vvi_input;

/** With no bindings yet. NULL, and the thread's error: no memory. Used by one thread at a time. */
vvi_input *vvi_input_new(void);
void vvi_input_free(vvi_input *input); /* NULL is fine */
/** Replaces all bindings; nothing is held any more. JSON: NULL for the default. On failure nothing changes:
 * VV_E_FORMAT, VV_E_ARGUMENT with the binding's path. */
vv_status vvi_input_bind(vvi_input *input, const char *json, size_t length);
/** The virtual device, the caller's to read, to place and to take actions from. */
vvi_virtual_device *vvi_input_device(vvi_input *input);
/** Takes one event. VV_E_ARGUMENT: it is none; VV_E_LIMIT: actions have not been taken; then nothing has changed. */
vv_status vvi_input_feed(vvi_input *input, const vvi_input_event *event);
/** Whether a button or finger is held that moves something. */
bool vvi_input_moving(const vvi_input *input);
#endif
