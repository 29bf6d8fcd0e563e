/** @file
 * How often each label stands in a field.
 */
#ifndef CLI_LABEL_COUNTS_H
#define CLI_LABEL_COUNTS_H
#include "core/status.h"
#include <volvis/field.h>

typedef struct cli_label_count {
    vv_label_id value; /**< as stored */
    uint64_t count;
} cli_label_count;

/** By ascending value, of the first component; *out is yours to free(). VV_E_LIMIT: more labels than any segmentation
 * has. */
vv_status cli_count_labels(cli_label_count **out, size_t *n_out, const vv_field *field, vv_job *job);
#endif
