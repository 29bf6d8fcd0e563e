/** @file
 * The process of an import program: started, listened to within limits, and ended, whatever it does.
 */
#ifndef VVI_IMPORT_PROCESS_H
#define VVI_IMPORT_PROCESS_H
#include "core/status.h"
#include "import/import_wire.h"
#include <sys/types.h>

typedef struct vvi_import_process {
    pid_t pid;         /* 0: none */
    int socket;        /* -1: none */
    const char *name;  /* of what it reads, for errors; borrowed */
    bool endless;      /* what it reads may be slow without end: standard input */
    int input;         /* what its standard input is instead; -1: nothing else */
    vvi_text body;     /* of the message that came last */
    double asked_s;    /* when it was asked, or last gave a sign of life */
    double busy_s;     /* processor seconds that it had used by then */
    uint64_t messages; /* since it was asked */
} vvi_import_process;

/** Whether there is a program to start. */
bool vvi_import_is_there(const vv_job *job);
/** Starts the program; it waits for VVI_WIRE_OPEN. name, endless and input are set. */
vv_status vvi_import_start(vvi_import_process *process, vv_job *job);
/** Asks; the answers are then received. */
vv_status vvi_import_ask(vvi_import_process *process, vvi_wire_kind kind, const vvi_text *body, int descriptor);
/** One message, valid until the next call. On failure the process is gone and the sentence says why: it died, it used
 * up a limit, it talks nonsense, the job was cancelled. */
vv_status vvi_import_receive(vvi_import_process *process, vvi_wire_kind *kind_out, vvi_wire_in *out, vv_job *job);
/** The sentence for an answer that makes no sense; ends the process. */
vv_status vvi_import_nonsense(vvi_import_process *process, const char *what);
/** Kills it, waits for it, closes. Nothing to do when there is none. */
void vvi_import_stop(vvi_import_process *process);
#endif
