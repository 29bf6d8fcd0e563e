/** @file
 * The runtime (threads, memory limit, derived-data cache, chosen kernels) and jobs (one piece of long work in it).
 *
 * Nothing is process-wide: a program, a server and a test may each own a runtime. Where a job is asked for, NULL means:
 * this thread alone, default limits, the best kernels, no progress.
 */
#ifndef VOLVIS_RUNTIME_H
#define VOLVIS_RUNTIME_H
#include <volvis/status.h>
VV_BEGIN_DECLS

typedef struct vv_runtime vv_runtime;
typedef struct vv_job vv_job;
struct vv_registry; /* the tables: <volvis/sys/registry.h> */

typedef enum vv_log_level { VV_LOG_ERROR, VV_LOG_WARNING, VV_LOG_INFO, VV_LOG_DEBUG } vv_log_level;

/** One fact a line, without a line end. Called by one thread at a time, any of the runtime's. */
typedef void vv_log_fn(void *user, vv_log_level level, const char *component, const char *text);

/** Limits on what comes from outside: files, folders, standard input. Fill with vv_limits_init(), then change what you
 * need, by member or by name. `volvis doctor --limits` lists them. */
typedef struct vv_limits {
    size_t size;              /**< set by init */
    uint64_t dim;             /**< samples along one axis */
    uint64_t voxels;          /**< samples of one volume */
    uint64_t header_bytes;    /**< of a header, and of the metadata that is kept */
    uint64_t metadata_keys;   /**< entries of metadata */
    uint64_t string_bytes;    /**< of one text */
    uint64_t files;           /**< data files of one header, files of a folder */
    uint64_t nesting;         /**< depth of what lies in each other: elements, groups, sequences */
    uint64_t expansion_gzip;  /**< how many times larger gzip data may become */
    uint64_t expansion_zstd;  /**< the same of zstd, bzip2, blosc, ... */
    uint64_t expansion_after; /**< bytes; data that is no larger than this is never called a bomb */
    uint64_t import_seconds;  /**< of processor time for one file, in the import program (vv_runtime_options.safe) */
    uint64_t import_bytes;    /**< of address space in the import program */
    uint64_t import_spool;    /**< bytes of a temporary file */
    uint64_t undo_bytes;      /**< that a model keeps to undo with; an eighth of the memory limit at most */
    uint64_t session_bytes;   /**< on the disk, of what pages make, bring and write */
    uint64_t
        expansion_mesh; /**< how many times larger a mesh may be than its file, by objects that stand in many places */
} vv_limits;

VV_API void vv_limits_init(vv_limits *limits, size_t size);
/** A limit by its name; value: a whole number, or bytes as in 64M. Errors: VV_E_ARGUMENT with the nearest name, or with
 * what the limit may be. */
VV_API vv_status vv_limits_set(vv_limits *limits, const char *name, const char *value);
/** Name, meaning and value by number; false past the end. */
VV_API bool vv_limits_get(const vv_limits *limits, size_t index, const char **name_out, const char **doc_out,
                          uint64_t *value_out);

/** Options of vv_runtime_new(). Fill with vv_runtime_options_init(), then change what you need. */
typedef struct vv_runtime_options {
    size_t size;           /**< set by init: how much of this struct the caller knows */
    int threads;           /**< 1..256; 0: all cores that the process may use */
    uint64_t memory_bytes; /**< limit on what the library holds; 0: half of the machine's or the cgroup's memory */
    const char *cpu;       /**< "base", "avx2", "avx512", "neon"; NULL: VOLVIS_CPU, else the best that the CPU has.
                                What the CPU lacks is VV_E_UNSUPPORTED */
    vv_log_fn *log;        /**< NULL: silent */
    void *log_user;
    vv_log_level log_level;             /**< the most talkative level passed to log; default VV_LOG_WARNING */
    const struct vv_registry *registry; /**< NULL: everything that is built in */
    bool allow_outside;                 /**< detached data files may lie outside their header's folder */
    const vv_limits *limits;            /**< on what comes from outside; copied. NULL: the defaults */
    bool safe; /**< volume files are read by a program of their own, locked in: a hostile file harms nothing else */
    const char *import_program; /**< its path; NULL: volvis-import beside the running program, or as installed */
    bool contain; /**< default true: formats whose libraries die of damaged files (vv_format.contained) are read by the
                       import program where there is one; false: in this process, unless `safe` */
    const struct vv_registry *more; /**< rows of your own, behind those of `registry`: tables that end with NULL, or are
                                       NULL. The rows outlive the runtime; tables are copied. A name that is there, and
                                       a row for another version of its table, are errors of vv_runtime_new(). The
                                       import program does not know them: they are no formats for `safe`. NULL: none */
} vv_runtime_options;

VV_API void vv_runtime_options_init(vv_runtime_options *options, size_t size);
VV_API vv_status vv_runtime_new(vv_runtime **out, const vv_runtime_options *options);
VV_API vv_runtime *vv_runtime_retain(vv_runtime *runtime);
VV_API void vv_runtime_release(vv_runtime *runtime); /* NULL is fine */

VV_API int vv_runtime_threads(const vv_runtime *runtime);
VV_API uint64_t vv_runtime_memory_limit(const vv_runtime *runtime);
VV_API uint64_t vv_runtime_memory_used(const vv_runtime *runtime);
VV_API uint64_t vv_runtime_memory_peak(const vv_runtime *runtime);
/** The instruction set of the kernels in use: "base", "avx2", "avx512", ... */
VV_API const char *vv_runtime_isa(const vv_runtime *runtime);
VV_API const struct vv_registry *vv_runtime_registry(const vv_runtime *runtime);

/** How far a job is. `done` never falls within a stage. */
typedef struct vv_progress {
    const char *stage; /**< a word or two: "read", "render" */
    uint64_t done, total;
    double elapsed_s; /**< of this stage */
    double eta_s;     /**< of this stage; negative while unknown */
} vv_progress;

/** One thread at a time, any of the runtime's; at most 20 calls a second; false cancels the job. */
typedef bool vv_progress_fn(void *user, const vv_progress *progress);

/** runtime NULL: a job on the calling thread alone. The job keeps the runtime. */
VV_API vv_status vv_job_new(vv_job **out, vv_runtime *runtime, vv_progress_fn *progress, void *user);
VV_API void vv_job_release(vv_job *job); /* NULL is fine */
/** What work has found beside its result, or has to say of it: one of these, the others are NULL. */
typedef struct vv_finding {
    const char *name;   /**< of a figure: "pieces_before" */
    const char *json;   /**< the figure */
    const char *phrase; /**< of the result, for people: "3 pieces became 2" */
    const char *note;   /**< of the input, for people: "looks like labels: a surface of each but 0" */
} vv_finding;

/** What was found since vv_job_forget_findings(), by number, in the order in which it was; false past the end. Of the
 * thread that runs the work; borrowed until more work runs. */
VV_API bool vv_job_finding(vv_finding *out, const vv_job *job, size_t index);
VV_API void vv_job_forget_findings(vv_job *job); /* NULL is fine */
/** May be called from any thread and from a signal handler; work stops within 50 ms with VV_E_CANCELLED. */
VV_API void vv_job_cancel(vv_job *job);
VV_API bool vv_job_cancelled(const vv_job *job);
/** Whether something that the job read was damaged, so that a part of it is missing; the log said what. */
VV_API bool vv_job_damaged(const vv_job *job);
VV_API vv_runtime *vv_job_runtime(const vv_job *job);

VV_END_DECLS
#endif
