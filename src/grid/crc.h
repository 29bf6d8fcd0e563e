/** @file
 * CRC-32 (the one of zlib, PNG and gzip) at memory speed.
 */
#ifndef VVI_GRID_CRC_H
#define VVI_GRID_CRC_H
#include <volvis/base.h>

/** Whether this machine has carry-less multiplication. */
bool vvi_crc_has_fold(void);
/** `crc` of what came before (0 at first), continued over n bytes. fold: use carry-less multiplication, which must be
 * there; the result is the same. */
uint32_t vvi_crc32(uint32_t crc, const void *data, size_t n, bool fold);
#endif
