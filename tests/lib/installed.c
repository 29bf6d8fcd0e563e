/* Says before main() where the modules of this build are. */
#include "core/installed.h"
#include "built_modules.h"

__attribute__((constructor)) static void begin_in_the_build_folder(void)
{
    vvi_installed_begin_at(BUILT_MODULES);
}
