/** @file
 * Measurements in scenes: what options and measurements have alike, and figures then and now.
 */
#ifndef CLI_MEASURE_STORED_H
#define CLI_MEASURE_STORED_H
#include "core/result.h"
#include "core/text.h"
#include <volvis/model.h>

/** Appends to a JSON object, of a measurement or of options, what both write in the same way, as far as it is set. */
void cli_measure_add_same(vvi_text *out, const vv_object *from);
/** The options of class cli_measure_class that the measurement was asked with; yours to release. */
vv_status cli_measure_recall(vv_object **out, const vv_measurement *m);
/** Figures that changed, of class vv_measured_figure, as "changes" and "changed". How many there are. */
size_t cli_changes_json(vvi_result *json, const vv_collection *then, const vv_collection *now);
/** All figures, and what became of those of before; csv: as rows of a table. id: the measurement's. */
void cli_changes_put(vvi_text *out, bool csv, const char *id, const vv_collection *then, const vv_collection *now);
#endif
