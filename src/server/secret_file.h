/** Files with secrets: keys and tokens. */
#ifndef VV_SERVER_SECRET_FILE_H
#define VV_SERVER_SECRET_FILE_H

#include "core/status.h"

#include <sys/stat.h>

/** Whether its owner alone can read it. holds: what is secret in it, for the sentence. What is no regular file (a pipe
 * of a shell) is fine. VV_E_ARGUMENT. */
vv_status vvi_secret_file_check(const struct stat *info, const char *path, const char *holds);
/** The same of a key of TLS, which a group may read too, if it is root's or ours: Debian has them as root:ssl-cert,
 * 0640, for servers that are in that group. */
vv_status vvi_key_file_check(const struct stat *info, const char *path, const char *holds);

#endif
