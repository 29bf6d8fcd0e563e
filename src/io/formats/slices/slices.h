/** @file
 * Folders of numbered pictures. Each file is one page of a vvi_tiff, whatever its format: what reads chunks of TIFF
 * reads them, a JPEG or PNG file being a chunk as a whole.
 */
#ifndef VVI_IO_FORMATS_SLICES_H
#define VVI_IO_FORMATS_SLICES_H
#include "io/formats/tiff/tiff.h"

/** What a number in a file's name counts; the first three are the axes of vvi_tiff.planes. */
typedef enum vvi_slice_role {
    VVI_SLICE_C,       /* channels */
    VVI_SLICE_Z,       /* slices */
    VVI_SLICE_T,       /* time steps */
    VVI_SLICE_SERIES,  /* positions, sites: volumes of their own */
    VVI_SLICE_UNKNOWN, /* no word before it says */
    VVI_SLICE_FIXED,   /* nothing: part of the series' name */
    VVI_SLICE_REST     /* nothing, but it changes with another number */
} vvi_slice_role;

/** A number in a name; of the channel, letters that name it may follow ("w2GFP"). */
typedef struct vvi_slice_run {
    size_t at, n;
    uint64_t value;
    vvi_slice_role role;
    size_t n_word; /* letters of the word that says the role */
    bool weak;     /* the word is one letter and stands apart: "a_c_01" */
} vvi_slice_run;

#define VVI_SLICE_RUNS 16

typedef struct vvi_slice_runs {
    vvi_slice_run run[VVI_SLICE_RUNS];
    size_t n;
} vvi_slice_runs;

/** A file of a series. */
typedef struct vvi_slice {
    size_t name;        /* of the folder's list */
    uint32_t series;    /* number of its series */
    uint64_t number[3]; /* in it, by role */
    size_t at, n;       /* what its channel is called, in its name; n = 0: nothing */
} vvi_slice;

typedef struct vvi_series {
    char *key;       /* a pattern of its files' names (vvi_slices_match) */
    size_t first, n; /* of the slices, sorted by time, slice, channel */
    bool counts[3];  /* which roles have a number in the name */
    bool loose;      /* no letter says that the number of slices is one */
    bool unclear;    /* several numbers change and nothing says what they count: the key is a proposal */
} vvi_series;

typedef struct vvi_slices {
    vvi_names names;
    vvi_slice *slice;
    size_t n;
    vvi_series *series;
    size_t n_series;
    size_t n_foreign;  /* files that are no pictures */
    size_t n_pictures; /* before some were chosen */
} vvi_slices;

/* slices_numbers.c */
/** Numbers of a name with what the words before them say. */
vvi_slice_runs vvi_slices_numbers(const char *name);
/** The number at `at`: its digits, value and role. */
vvi_slice_run vvi_slices_number(const char *name, size_t at);

/* slices_pattern.c */
/** Whether a pattern says which numbers count: it has '#', {z}, {c} or {t}. */
bool vvi_slices_counts(const char *pattern);
/** Whether a name fits: '*' any text, '?' any byte, '#' a number that counts what the word before it says, {z} {t} a
 * number of slices or time steps, {c} a number or word of channels. A pattern without any of them is how names begin.
 * *out: the numbers that count. */
bool vvi_slices_match(vvi_slice_runs *out, const char *pattern, const char *name);

/* slices_names.c */
/** Whether a name ends as those of pictures do. */
bool vvi_slices_is_picture(const char *name);
/** Whether a file of a folder is a picture that VolVis made: with a scene inside it is nobody's slice. */
bool vvi_slices_is_made(const vv_source *folder, const char *name, vv_job *job);
enum { VVI_SLICES_LOOKED = 32 }; /* pictures of a folder that are looked into, where there are no more */
/** Pictures among the names of a folder's own files that VolVis has not made; of many, none where the first of them all
 * were made. *any_out: number of one of them. */
size_t vvi_slices_count(size_t *any_out, const vvi_names *names, const vv_source *folder, vv_job *job);
/** Series of the folder, or of those files that fit `pattern` (NULL: all), slices by series and numbers. Free with
 * vvi_slices_free, also when it fails. */
vv_status vvi_slices_find(vvi_slices *slices, vv_source *folder, const char *pattern, vv_job *job);
void vvi_slices_free(vvi_slices *slices);

/* slices_roles.c */
/** What the numbers of names of one shape count: slices [0, n) of it. */
vv_status vvi_slices_roles(vvi_slice_role roles[VVI_SLICE_RUNS], vvi_series *series, const vvi_names *names,
                           const vvi_slice *slice, size_t n, vv_job *job);

/* slices_grid.c */
/** Places along one axis of the files' grid. */
typedef struct vvi_slice_axis {
    uint64_t *value; /* that there are, rising; yours to vvi_free() */
    size_t n_values;
    uint64_t step; /* of numbers from place to place; 0: places are values, one after another */
    size_t n;      /* places */
} vvi_slice_axis;

/** The grid of a series; axes by role. */
vv_status vvi_slices_grid(vvi_slice_axis axes[3], const vvi_slices *slices, const vvi_series *series, vv_source *folder,
                          vv_notes *notes, vv_job *job);
size_t vvi_slices_place(const vvi_slice_axis *axis, uint64_t value);
/** The number of a place. */
uint64_t vvi_slices_value(const vvi_slice_axis *axis, size_t place);

/* slices_stack.c */
/** Whether the file of this name, of those in the folder, is a TIFF of several pages and no other file has its name but
 * for the numbers: a volume by itself, and no slice of one. */
bool vvi_slices_is_stack(const vvi_names *names, const char *name, const vv_source *folder, vv_job *job);

/* slices_pages.c */
/** The page of a PNG or JPEG file; false when it is neither. */
bool vvi_slices_page(vvi_tiff_page *page, const uint8_t *head, size_t n);
/** Pages of one file, appended; NULL where there is nothing that can be read (then the error says why). */
vv_status vvi_slices_add(vvi_tiff *tiff, vv_source *source, uint32_t file, vv_job *job);

/* slices_open.c */
/** The plan of a folder. */
vv_status vvi_slices_open(vv_field_info *info, vvi_tiff *tiff, vv_source *folder, const char *part, vv_notes *notes,
                          vv_job *job);
#endif
