/** @file
 * What the parts of bindings share.
 */
#ifndef VVI_INPUT_BINDINGS_IMPL_H
#define VVI_INPUT_BINDINGS_IMPL_H
#include "input/bindings.h"

/** Whether a key, without modifiers, is one that a page can send: VV_E_ARGUMENT with the nearest name, at "when". */
vv_status vvi_key_check(const char *id);
/** Whether what an action names behind "operation-", "renderer-" or "preset-" is there; other actions are not looked
 * at. VV_E_ARGUMENT with the nearest name, at "action". */
vv_status vvi_action_check_name(const char *action, const vv_registry *registry);
/** Whether two bindings of a device, which have been checked, would do something at the same time; a button that drags
 * and clicks does one or the other. */
bool vvi_binding_meets(const char *when, const char *method, const char *other_when, const char *other_method);
#endif
