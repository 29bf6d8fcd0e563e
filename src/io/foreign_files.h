/** @file
 * Files that are no volumes, told by their first bytes: people name them by mistake, and want to know what to do.
 */
#ifndef VVI_IO_FOREIGN_FILES_H
#define VVI_IO_FOREIGN_FILES_H
#include <stddef.h>
#include <stdint.h>

/** "a ZIP archive: unpack it and name what is inside"; NULL: nothing that is certain, whatever the file's name. */
const char *vvi_foreign_mark(const uint8_t *head, size_t n);
/** The same, and texts, of a file that no reader knows. */
const char *vvi_foreign_kind(const uint8_t *head, size_t n);
#endif
