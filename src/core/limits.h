/** @file
 * Limits on what comes from outside: vv_limits in <volvis/runtime.h>. A reader asks for those of its job.
 */
#ifndef VVI_CORE_LIMITS_H
#define VVI_CORE_LIMITS_H
#include <volvis/runtime.h>

extern const vv_limits vvi_limits_default;
/** Those of the job's runtime; the defaults for NULL. Valid as long as the job. */
const vv_limits *vvi_job_limits(const vv_job *job);
/** What a caller's struct says, as far as this library knows it; the rest are the defaults. NULL: all defaults. */
vv_status vvi_limits_read(vv_limits *out, const vv_limits *limits);
/** Whether the index-th of vv_limits_get() is an amount of bytes. */
bool vvi_limits_of_bytes(size_t index);
#endif
