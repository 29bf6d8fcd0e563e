/** @file
 * Messages of input and of frames, as rows of the table of messages (messages.c) take them.
 */
#ifndef VVI_SERVER_MESSAGE_INPUT_H
#define VVI_SERVER_MESSAGE_INPUT_H
#include "server/session_impl.h"

vv_status vvi_message_events(vvi_client *client, int64_t id, const json_t *message, int64_t now);
vv_status vvi_message_action(vvi_client *client, int64_t id, const json_t *message, int64_t now);
vv_status vvi_message_camera(vvi_client *client, int64_t id, const json_t *message, int64_t now);
vv_status vvi_message_ack(vvi_client *client, int64_t id, const json_t *message, int64_t now);
vv_status vvi_message_frames(vvi_client *client, int64_t id, const json_t *message, int64_t now);

/* messages.c ------------------------------------------------------------------------------------------------------ */

/** A member that is a text; NULL: it is none. */
const char *vvi_message_text(const json_t *message, const char *key);
/** VV_E_FORMAT: what a message of this type needs. */
vv_status vvi_message_fail(const char *type, const char *what);
#endif
