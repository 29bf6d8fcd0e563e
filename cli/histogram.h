/** @file
 * A histogram for people, in text.
 */
#ifndef CLI_HISTOGRAM_H
#define CLI_HISTOGRAM_H
#include "core/text.h"
#include <volvis/field.h>

/** Sixteen bars, as long as their count, or as its logarithm; the share stands beside. */
void cli_histogram_text(vvi_text *out, const vv_statistics *statistics, bool logarithmic);
#endif
