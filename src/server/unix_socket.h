/** @file
 * A socket that is a file: only its owner reaches the server, whoever else is on the machine.
 */
#ifndef VVI_SERVER_UNIX_SOCKET_H
#define VVI_SERVER_UNIX_SOCKET_H
#include "core/status.h"

/** Whether there is a folder for it in which a file can be made: VV_E_WRITE. Nothing is changed. */
vv_status vvi_unix_socket_check(const char *path);
/** Sees that a socket can be made there; one that a server has left behind is taken away. VV_E_ARGUMENT: something
 * else is there, or a server that listens, or the name is too long; VV_E_WRITE. */
vv_status vvi_unix_socket_prepare(const char *path);
#endif
