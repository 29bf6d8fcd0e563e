#include "server/unix_socket.h"
#include "core/memory.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

static bool somebody_listens(const struct sockaddr_un *address)
{
    const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const bool found = fd >= 0 && connect(fd, (const struct sockaddr *)address, sizeof *address) == 0;
    if (fd >= 0)
        close(fd);
    return found;
}

vv_status vvi_unix_socket_check(const char *path)
{
    const char *slash = strrchr(path, '/');
    char *folder = slash ? vvi_asprintf("%.*s", slash == path ? 1 : (int)(slash - path), path) : vvi_strdup(".");
    if (!folder)
        return vv_fail_memory(strlen(path));
    const vv_status st = access(folder, W_OK | X_OK) == 0
                             ? VV_OK
                             : vv_fail_at(VV_E_WRITE, path, NULL, "cannot make a socket in the folder %.200s: %s",
                                          folder, strerror(errno));
    free(folder);
    return st;
}

vv_status vvi_unix_socket_prepare(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    struct stat there;
    if (strlen(path) >= sizeof address.sun_path)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "the name of a socket is at most %zu bytes, found %zu",
                          sizeof address.sun_path - 1, strlen(path));
    memcpy(address.sun_path, path, strlen(path) + 1);
    if (lstat(path, &there) != 0)
        return errno == ENOENT ? VV_OK
                               : vv_fail_at(VV_E_WRITE, path, NULL, "cannot make a socket: %s", strerror(errno));
    if (!S_ISSOCK(there.st_mode))
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "exists and is not a socket; name one that does not exist");
    if (somebody_listens(&address))
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "another server listens there; name another socket");
    if (unlink(path) != 0)
        return vv_fail_at(VV_E_WRITE, path, NULL, "belongs to a server that has ended, and cannot be removed: %s",
                          strerror(errno));
    return VV_OK;
}
