/** @file
 * Inside a sink: what the files that make it share.
 */
#ifndef VVI_IO_SINK_IMPL_H
#define VVI_IO_SINK_IMPL_H
#include "io/coding.h"
#include "io/sink.h"
#include "io/sink_folder.h"
#include <sys/types.h>

#define VVI_SINK_ROOM ((size_t)256 << 10) /* of what is not yet coded, and of what is */

struct vv_sink {
    int fd;
    int held;    /* the folder of the target; -1: it is found by its path */
    int lock;    /* on the file that has a temporary name, until it has its own; -1: none */
    int library; /* what vvi_sink_file() gave out; -1: nothing */
    char *name;  /* as the caller gave it: stands in errors */
    char *path;  /* where it is going to be; links resolved. NULL: a stream that is written straight away */
    char *temporary;
    vv_job *job;    /* outlives the sink */
    uint8_t *plain; /* not yet coded or written */
    size_t n_plain;
    vvi_encoder *encoder;
    uint8_t *coded;
    uint64_t written, counted; /* counted: vvi_job_count_write() */
    bool failed, spares_inputs;
    bool placed; /* it has its name */
    vv_sink *beside, *next;
    vvi_sink_folder *folder; /* NULL: it is a file */
    bool in_memory;
    uint8_t *memory; /* `written` bytes and room for more */
    size_t n_room;
};

/** VV_E_WRITE with what the system says; nothing is committed after it. */
vv_status vvi_sink_fail(vv_sink *sink, const char *doing, int error);
/** One alone, without those beside it. */
void vvi_sink_free(vv_sink *sink);
/** Its file is going to be so long; on failure nothing is committed. */
vv_status vvi_sink_count(vv_sink *sink, uint64_t bytes);
/** Bytes as they are, past the encoder. */
vv_status vvi_sink_out(vv_sink *sink, const uint8_t *data, size_t n);
/** Where files are written in some places alone, the folder that *path lies in is held, and *path becomes one by the
 * number of its descriptor: what takes the folder's place meanwhile is not written to. Not for people: `name` is. */
vv_status vvi_sink_hold_folder(int *held, char **path, const char *name, vv_job *job);
/** A name beside the target that nobody has, for a new file or for one that has none. */
vv_status vvi_sink_name_temporary(vv_sink *sink, mode_t mode);
/** A file or folder becomes `path`; where the job keeps what exists, only if nothing is there. -1 with errno. */
int vvi_sink_rename(const char *temporary, const char *path, const vv_job *job);
/** VV_E_WRITE: it is there, and stays. */
vv_status vvi_sink_fail_existing(const char *name);
/** What a library wrote to a temporary file goes to the stream. */
vv_status vvi_sink_copy_library(vv_sink *sink);
#endif
