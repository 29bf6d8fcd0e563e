/** @file
 * What a WebSocket's server says to the key of an upgrade.
 */
#ifndef VVI_SERVER_HANDSHAKE_H
#define VVI_SERVER_HANDSHAKE_H
#include <stddef.h>

/** Letters of a key, and of what is said to it. */
enum { VVI_KEY_LETTERS = 24, VVI_ACCEPT_TEXT = 29 };

/** Sec-WebSocket-Accept for a key of VVI_KEY_LETTERS letters (RFC 6455, 4.2.2). It shows that a WebSocket was meant,
 * and keeps no secret: so SHA-1 will do. */
void vvi_handshake_accept(char out[VVI_ACCEPT_TEXT], const char *key);
#endif
