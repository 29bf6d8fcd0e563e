/** @file
 * What work finds beside its result, or says of it: figures by name, for programs, and phrases for people. Told by the
 * thread that runs the work, and only by it; without a job, or without memory, it is told to nobody.
 */
#ifndef VVI_CORE_FINDINGS_H
#define VVI_CORE_FINDINGS_H
#include "core/status.h"
#include <volvis/runtime.h>

/** Figures take the place of those of the same name; a number that is not finite is null. */
void vvi_find_number(vv_job *job, const char *name, double value);
void vvi_find_numbers(vv_job *job, const char *name, const double *values, size_t n);
void vvi_find_count(vv_job *job, const char *name, uint64_t value);
void vvi_find_bool(vv_job *job, const char *name, bool value);
void vvi_find_string(vv_job *job, const char *name, const char *value);
/** A phrase without a point at its end, "3 pieces became 2": phrases stand behind each other, between commas. */
void vvi_find_phrase(vv_job *job, const char *format, ...) VV_PRINTF(2, 3);
/** What people should know of the input, and of what was made of it: it stands behind the input's name. */
void vvi_find_note(vv_job *job, const char *format, ...) VV_PRINTF(2, 3);

/** What was found of a result that is kept, for those who get it later. Zeroed is valid to free. */
typedef struct vvi_findings {
    vv_finding *all;
    size_t n;
} vvi_findings;

/** A copy of all that the job was told; without memory of none. */
void vvi_findings_keep(vvi_findings *out, const vv_job *job);
/** All of it is told to the job, as if it had just been found. */
void vvi_findings_tell(vv_job *job, const vvi_findings *kept);
void vvi_findings_free(vvi_findings *kept);
#endif
