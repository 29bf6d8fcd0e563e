/** @file
 * What is said of files while a job reads them, for the people who look at them.
 */
#ifndef VVI_SERVER_WARNINGS_H
#define VVI_SERVER_WARNINGS_H
#include <volvis/runtime.h>

/** Warnings, each once, with a line break behind each. NULL: there are none. */
typedef char *vvi_warnings;

/** What the job warns of files from now on is added to *warnings, yours to free() when the job is gone. */
void vvi_warnings_gather(vvi_warnings *warnings, vv_job *job);
/** Adds those that are not there yet, and frees `more`. */
void vvi_warnings_add(vvi_warnings *warnings, vvi_warnings more);
#endif
