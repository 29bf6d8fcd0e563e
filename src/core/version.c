#include "config.h"
#include <volvis/version.h>

const char *vv_version(void)
{
    return VV_VERSION;
}
