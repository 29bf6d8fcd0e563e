/** @file
 * Where a runtime may read files that are named by paths. At first anywhere; once it is confined, in folders and files
 * that it was given alone.
 *
 * Threads: any.
 */
#ifndef VVI_CORE_ALLOWED_PLACES_H
#define VVI_CORE_ALLOWED_PLACES_H
#include "core/status.h"
#include <pthread.h>
#include <volvis/runtime.h>

typedef struct vvi_allowed_place {
    char *path; /**< real, without a slash at its end */
    size_t n;
    int folder;   /**< its descriptor; -1: that file alone, and what it names beside it */
    bool trusted; /**< vvi_runtime_trust() */
} vvi_allowed_place;

typedef struct vvi_places {
    pthread_mutex_t lock;
    vvi_allowed_place *place;
    size_t n;
    bool confined;
    char *strange; /**< files below are read by the import program; NULL: none */
    bool all_strange;
} vvi_places;

vv_status vvi_places_init(vvi_places *places);
void vvi_places_finish(vvi_places *places);

/** From here on files are read below this folder, a real path, and those that are given later. */
vv_status vvi_runtime_confine(vv_runtime *runtime, const char *folder);
/** This file, a real path, may be read too. */
vv_status vvi_runtime_give(vv_runtime *runtime, const char *file);
/** The same, and by who runs the program: it may be read in this process whatever else is not. */
vv_status vvi_runtime_trust(vv_runtime *runtime, const char *file);
/** Files below this folder, a real path, come from people who are not trusted. */
vv_status vvi_runtime_distrust(vv_runtime *runtime, const char *folder);

/** Nor does anything else that it reads: in the import program. Right after it was made. */
void vvi_runtime_distrust_all(vv_runtime *runtime);

bool vvi_job_confined(const vv_job *job);
/** The descriptor of the folder that a real path lies in, and in *rest the path from there ("." for itself); -1: the
 * path is a file that was given, or (beside) the folder of one; -2: it lies outside of all. */
int vvi_job_place(const vv_job *job, const char *real, bool beside, const char **rest);
/** Whether a real path was given by vvi_runtime_trust(). */
bool vvi_job_trusts(const vv_job *job, const char *real);
/** Whether a file is read by the import program whatever the runtime's options say. */
bool vvi_job_distrusts(const vv_job *job, const char *path);
/** Whether all that is read comes from people who are not trusted: vvi_runtime_distrust_all(). */
bool vvi_job_distrusts_all(const vv_job *job);
#endif
