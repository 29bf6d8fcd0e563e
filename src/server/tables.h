/** @file
 * What a page must know before it can draw anything: the tables of the program, as JSON.
 */
#ifndef VVI_SERVER_TABLES_H
#define VVI_SERVER_TABLES_H
#include "core/result.h"
#include <volvis/sys/registry.h>

/** Members "classes", "operations", "renderers", "presets", "colormaps", "methods" (docs/protocol.md). */
void vvi_tables_tell(vvi_result *out, const vv_registry *registry);
#endif
