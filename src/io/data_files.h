/** @file
 * Samples beside or behind a text header: in the header's own source, or in files that it names, one piece of equal
 * length in each. Raw, coded or written as numbers.
 */
#ifndef VVI_IO_DATA_FILES_H
#define VVI_IO_DATA_FILES_H
#include "io/header_keys.h"
#include "io/layout.h"

typedef struct vvi_data_files {
    const char *header; /* name of the header; in errors */
    const vv_limits *limits;
    char **name; /* none: the samples lie in the header's own source */
    size_t n;
    vvi_coding coding;
    bool numbers;    /* decimal numbers instead of bytes */
    int64_t skip;    /* bytes before the samples of each file; -1: the samples end it */
    uint64_t begins; /* with -1: samples begin no sooner, since the header lies before; a file that is cut shows so */
    uint64_t coded_bytes; /* of coded samples; UINT64_MAX: to the end */
    vvi_layout layout;
    /* what vvi_data_files_check() finds */
    uint64_t per_file; /* elements in each */
    bool mappable;
} vvi_data_files;

/** One more name. */
vv_status vvi_data_files_add(vvi_data_files *files, const char *name);
/** Those of a pattern with one %d, "slice%03d.raw", for first, first + step, .. last. NULL, or what is wrong, to follow
 * the pattern in a sentence; *memory: there is none. */
const char *vvi_data_files_expand(vvi_data_files *files, const char *pattern, size_t n, const int64_t range[3],
                                  bool *memory);
/** Whether all samples, or at least half of them, can be there. */
vv_status vvi_data_files_check(vvi_data_files *files, vv_source *header, vv_job *job);
/** Samples of files that are missing or cut short are NaN, or 0 in integers, and the job is damaged. */
vv_status vvi_data_files_read(vv_field **out, const vv_field_info *info, const vvi_data_files *files, vv_source *header,
                              int64_t frame, const vv_box *region, vv_job *job);
void vvi_data_files_finish(vvi_data_files *files); /* zeroed is fine */

/* Formats whose plan is a vvi_data_files -----------------------------------------------------------------------------
 */

/** Fills keys, info and files from a header; what is left to do is done by vvi_data_files_open(). */
typedef vv_status vvi_data_files_header_fn(vv_field_info *info, vvi_data_files *files, vvi_keys *keys,
                                           vv_source *source, vv_notes *notes, vv_job *job);
/** The body of a row's read_header(). */
vv_status vvi_data_files_open(vv_field_info *info, void **plan_out, vv_source *source, vvi_data_files_header_fn *header,
                              vv_notes *notes, vv_job *job);
void vvi_data_files_free_plan(void *plan);
vv_status vvi_data_files_read_plan(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                                   int64_t frame, const vv_box *region, vv_job *job);
bool vvi_data_files_mappable(const vv_field_info *info, const void *plan);
#endif
