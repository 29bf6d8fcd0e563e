/** @file
 * Where things lie that are installed with VolVis and used only when something needs them: the import program, modules.
 *
 * Threads: any.
 */
#ifndef VVI_CORE_INSTALLED_H
#define VVI_CORE_INSTALLED_H
#include <stdbool.h>
#include <stddef.h>

/** The path of the file `name` that may be used in this way (R_OK, X_OK). It lies beside the running program or beside
 * the library that this code is in, in the libexec folder of the tree that either is in, wherever that was copied, or
 * where it was installed; false: nowhere, and out is the last of these. */
bool vvi_installed_find(char *out, size_t room, const char *name, int mode);
/** Where what is read, modules, is looked for first, for tests; they start no programs from there. Borrowed. Before any
 * thread is started. */
void vvi_installed_modules_at(const char *folder);
#endif
