#include "server/secret_file.h"

vv_status vvi_secret_file_check(const struct stat *info, const char *path, const char *holds)
{
    if (!S_ISREG(info->st_mode) || !(info->st_mode & 077))
        return VV_OK;
    return vv_fail_at(VV_E_ARGUMENT, path, NULL, "others may read it (mode %04o), and it holds the %s: chmod 600 %s",
                      (unsigned)info->st_mode & 07777, holds, path);
}
