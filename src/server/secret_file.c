#include "server/secret_file.h"

#include <unistd.h>

vv_status vvi_secret_file_check(const struct stat *info, const char *path, const char *holds)
{
    if (!S_ISREG(info->st_mode))
        return VV_OK;
    if (info->st_mode & 077)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                          "others may read it (mode %04o), and it holds the %s: chmod 600 %s",
                          (unsigned)info->st_mode & 07777, holds, path);
    if (info->st_uid == geteuid() || info->st_uid == 0)
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                      "it belongs to another user (number %lu), who can read it, and it holds the %s: chown %lu %s",
                      (unsigned long)info->st_uid, holds, (unsigned long)geteuid(), path);
}

vv_status vvi_key_file_check(const struct stat *info, const char *path, const char *holds)
{
    const bool trusted = info->st_uid == 0 || info->st_uid == geteuid(), group_reads = !(info->st_mode & 037);
    return trusted && group_reads ? VV_OK : vvi_secret_file_check(info, path, holds);
}
