/* Says before main() where the modules of this build are. */
#include "core/installed.h"
#include "built_modules.h"

__attribute__((constructor)) static void name_the_build_folder(void)
{
    vvi_installed_modules_at(BUILT_MODULES);
}
