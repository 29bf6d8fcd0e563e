/** @file
 * Instruction sets by name, for the runtime.
 */
#ifndef VVI_CORE_CPU_SELECT_H
#define VVI_CORE_CPU_SELECT_H
#include <volvis/status.h>

/** VVI_CPU_* bits of a name; NULL: VOLVIS_CPU, else all that the machine has. Errors name what there is. */
vv_status vvi_cpu_select(uint32_t *bits_out, const char *name);
/** "base", "avx2", ...: the best kernels that these bits allow. */
const char *vvi_cpu_name(uint32_t bits);
#endif
