/** @file
 * The libraries that the program is built with, and what each is for.
 */
#ifndef CLI_LIBRARIES_H
#define CLI_LIBRARIES_H
#include <stdbool.h>
#include <volvis/base.h>

typedef struct cli_library {
    const char *name, *purpose;
    char version[24]; /**< "": built without it */
    /** Of what is loaded when a file needs it: why that fails, NULL when it does not. load: really; otherwise only
     * whether it is there. NULL: the program is linked with the library. */
    const char *(*problem)(bool load);
} cli_library;

/** By number; false past the end. */
bool cli_library_nth(cli_library *out, size_t index);
/** "gcc 12.2.0" */
const char *cli_compiler(void);
/** Instruction sets by number that kernels were built for, and whether this CPU (and VOLVIS_CPU) can use them. */
bool cli_isa_nth(const char **name_out, bool *usable_out, size_t index);
#endif
