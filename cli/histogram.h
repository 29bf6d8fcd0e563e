/** @file
 * A histogram for people, in text, and for programs.
 */
#ifndef CLI_HISTOGRAM_H
#define CLI_HISTOGRAM_H
#include "json.h"
#include <volvis/field.h>

/** Sixteen bars; their length is by the logarithm of the count, the share stands beside. */
void cli_histogram_text(vvi_text *out, const vv_statistics *statistics);
/** "histogram": {"lo", "hi", "counts"} with every bin. */
void cli_histogram_json(cli_json *json, const vv_statistics *statistics);
#endif
