/** @file
 * The runner, for those who tell what it will do.
 */
#ifndef VVI_RUN_RUN_H
#define VVI_RUN_RUN_H
#include <volvis/run.h>

/** Whether all samples are looked at for the type of what is written, before it is. */
bool vvi_run_looks_for_type(const vv_field_info *info, const char *path, const vv_write_options *options, vv_job *job);
#endif
