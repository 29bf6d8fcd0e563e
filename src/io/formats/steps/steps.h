/** @file
 * Files that are time steps of one data set: volumes in a folder whose names differ in one number, or those that a
 * collection of ParaView's names. Each is read by whatever format it has.
 */
#ifndef VVI_IO_FORMATS_STEPS_H
#define VVI_IO_FORMATS_STEPS_H
#include "io/file_beside.h"
#include "io/notes.h"

/** A file that may be a time step. */
typedef struct vvi_steps_entry {
    size_t name;     /* of the folder's list */
    uint64_t number; /* in it, that counts */
} vvi_steps_entry;

/** Whether files are time steps. */
typedef enum vvi_steps_sure {
    VVI_STEPS_ALONE,   /* one file, or names without a number that changes */
    VVI_STEPS_UNCLEAR, /* several numbers change, or the word before the one says that it counts something else */
    VVI_STEPS_SURE
} vvi_steps_sure;

/** Files whose names differ in numbers alone. */
typedef struct vvi_steps_group {
    char *key;       /* a pattern of their names; a proposal where it is unclear; the name of one alone */
    size_t first, n; /* of the entries, by number */
    vvi_steps_sure sure;
} vvi_steps_group;

typedef struct vvi_steps_groups {
    vvi_names names;
    vvi_steps_entry *entry;
    size_t n;
    vvi_steps_group *group;
    size_t n_groups;
} vvi_steps_groups;

/** A time step. */
typedef struct vvi_steps_file {
    char *name;
    uint64_t number;
    double time;
    bool timed; /* the file, or the collection, says its time */
} vvi_steps_file;

/** The plan of a reader. */
typedef struct vvi_steps {
    vvi_steps_file *file;
    size_t n;
    char *key;                 /* how the files are called together */
    char *format, *raw, *part; /* how each is opened */
    bool finest;
    vv_field_info info; /* of each */
    char time_unit[16];
    bool mappable;
    bool values;   /* files have scales of their own: samples are values, f32 or f64 */
    vv_file *open; /* the one that was read last, or NULL */
    size_t open_at;
} vvi_steps;

/* steps_names.c */
/** Volumes of a folder whose names fit `pattern` (vvi_slices_match; NULL: all), by how they are called. Pictures, and
 * data files that have a header of the same name, are none. Free with vvi_steps_groups_free, also when it fails. */
vv_status vvi_steps_find(vvi_steps_groups *out, const vv_source *folder, const char *pattern, vv_job *job);
void vvi_steps_groups_free(vvi_steps_groups *groups);
/** Whether the files of the folder, in the order of strcmp(), have a header of that name but for its suffix: then the
 * header is the volume, and these are its samples. */
bool vvi_steps_has_header(const char *name, const vvi_names *sorted);
/** Splits a part into a pattern of names, *n_out letters, and what follows behind its colon (NULL: nothing). False: it
 * is no pattern that fits volumes of the folder, but a part of each file. */
bool vvi_steps_split(size_t *n_out, const char **inner_out, const vv_source *folder, const char *part, vv_job *job);

/** Whether the files that are steps are of a format that is read by the import program: then all of them are, by one.
 */
bool vvi_steps_are_contained(const vv_source *folder, const vv_read_options *options, vv_job *job);

/* steps_check.c */
/** Files of a folder and one that is no step of the same data: VV_E_FORMAT with what differs. */
vv_status vvi_steps_check(const vv_field_info *info, const char *name, const vv_field_info *first,
                          const char *first_name, const vv_source *folder);

/* steps_open.c */
/** Looks at all files of the plan, the first fully; the info and notes of all together. */
vv_status vvi_steps_open(vv_field_info *info, vvi_steps *steps, vv_source *source, vv_notes *notes, vv_job *job);
/** Opens a file as the plan says. */
vv_status vvi_steps_open_file(vv_file **out, const vvi_steps *steps, size_t at, const vv_source *source, vv_job *job);

/* steps.c */
vv_status vvi_steps_new(vvi_steps **out, const vv_read_options *options, const char *part, vv_job *job);
/** One more file. */
vv_status vvi_steps_add(vvi_steps *steps, const char *name, const vvi_steps_file *file, vv_job *job);
void vvi_steps_free(void *steps);
vv_status vvi_steps_read(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source, int64_t frame,
                         const vv_box *region, vv_job *job);
bool vvi_steps_mappable(const vv_field_info *info, const void *plan);
#endif
