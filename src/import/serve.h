/** @file
 * The import program's work: one file, opened and read for who asks on a socket.
 */
#ifndef IMPORT_SERVE_H
#define IMPORT_SERVE_H

struct vv_registry;

/** Until the other side hangs up; the exit code. registry NULL: everything that is built in. */
int import_serve(int socket, const struct vv_registry *registry);
#endif
