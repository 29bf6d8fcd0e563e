/** @file
 * Measurements as rows of a table: what `volvis measure` asks, scenes keep and the page shows.
 *
 * A question is a vv_measurement: its kind names a row, and its other properties say of what; those that are not set
 * are left to the row. The answer is a list of items in the order in which they are told: figures with their units and
 * errors, texts, rows of numbers, tables, and remarks. Each says who it is for.
 */
#ifndef VOLVIS_MEASURING_H
#define VOLVIS_MEASURING_H
#include <volvis/file.h>
#include <volvis/mesh.h>
#include <volvis/model.h>
VV_BEGIN_DECLS

/* Inputs ---------------------------------------------------------------------------------------------------------- */

/** What data is measured; bits of a set. */
typedef enum vv_measured_is {
    VV_MEASURED_VOLUME = 1,
    VV_MEASURED_MESH = 2,
    VV_MEASURED_SHOWN = 4 /**< meshes where a scene places them */
} vv_measured_is;

/** A volume or a mesh, with what a scene or a file says of it. All of it borrowed. */
typedef struct vv_measured_data {
    const char *name;      /**< for people: the file */
    const char *given;     /**< what whoever asks has named: that, or a scene of it; NULL: the name */
    const vv_field *field; /**< where it lies in the world; NULL: a mesh */
    const vv_mesh *mesh;
    vv_affine place;        /**< to the world: of a mesh, and of masks and values, which lie where the volume does */
    const vv_plane *planes; /**< n_planes in the world: what is kept has normal . p >= offset */
    size_t n_planes;
    const vv_label *labels; /**< what labels are called */
    size_t n_labels;
    int component;      /**< which of the samples' numbers the scene shows */
    bool ranged;        /**< the scene shows values from lo to hi: they are the object unless another is asked for */
    double lo, hi;      /**< INFINITY: no limit */
    const char *shown;  /**< id of a scene's mesh; NULL: it is not of a scene */
    const char *unit;   /**< of its lengths in the scene */
    const char *called; /**< the label that is asked for, as whoever asks calls it; NULL: by its number */
    int says_labels;    /**< what the scene says of the samples: 1: labels, -1: amounts; 0: neither */
    int64_t frame, n_frames; /**< of a series: which time step, from 0, and how many there are; n_frames 0 or 1: none */
} vv_measured_data;

/** What a question is about. Fill with zeros, then set what there is. All of it borrowed. */
typedef struct vv_measured_inputs {
    size_t size;                   /**< sizeof the struct */
    const vv_measured_data *input; /**< a volume, a mesh, or n_inputs meshes of a scene, one at least */
    size_t n_inputs;
    const vv_measured_data *other;  /**< the second of two surfaces; NULL: none */
    const vv_measured_data *mask;   /**< where vv_measurement.mask is set */
    const vv_measured_data *values; /**< where vv_measurement.values is set */
} vv_measured_inputs;

/* Answers --------------------------------------------------------------------------------------------------------- */

/** Who an item is for; bits of a set. */
typedef enum vv_answer_for {
    VV_FOR_PEOPLE = 1,   /**< lines of text */
    VV_FOR_PROGRAMS = 2, /**< JSON */
    VV_FOR_TABLES = 4,   /**< rows of a table: quantity, value, error, unit */
    VV_FOR_SCENES = 8,   /**< kept, to be compared with later ones */
    VV_FOR_ALL = 15
} vv_answer_for;

typedef enum vv_answer_kind {
    VV_ANSWER_FIGURE,  /**< `value` with `error`, `unit`, `chance` */
    VV_ANSWER_NUMBER,  /**< `value` */
    VV_ANSWER_COUNT,   /**< `count` */
    VV_ANSWER_BOOL,    /**< `count`, 0 or 1 */
    VV_ANSWER_TEXT,    /**< `text`; NULL: there is none */
    VV_ANSWER_NUMBERS, /**< `n` of `numbers`, together */
    VV_ANSWER_ROWS,    /**< `n` rows of `columns` of `numbers` each */
    VV_ANSWER_COUNTS,  /**< `n` of `counts`, together */
    VV_ANSWER_OPEN,    /**< what follows belongs together, as a list or under names: `text` is "[" or "{" */
    VV_ANSWER_CLOSE,
    VV_ANSWER_LINE,  /**< `text` for people, after `label` */
    VV_ANSWER_BLOCK, /**< `text` for people, of whole lines */
    VV_ANSWER_BARS,  /**< a histogram for people: `bars` */
    VV_ANSWER_TABLE, /**< `table` */
    VV_ANSWER_JSON   /**< `text` is JSON, as it is: whole numbers of any size, and free objects */
} vv_answer_kind;

typedef enum vv_cell_kind {
    VV_CELL_NUMBER,
    VV_CELL_COUNT,
    VV_CELL_LABEL,          /**< the bits of int64_t */
    VV_CELL_UNSIGNED_LABEL, /**< the bits of uint64_t */
    VV_CELL_TEXT,
    VV_CELL_NAME /**< a text from outside; "": there is none */
} vv_cell_kind;

typedef union vv_cell {
    double number;
    uint64_t count;
    vv_label_id label;
    const char *text;
} vv_cell;

typedef struct vv_answer_column {
    const char *name; /**< in a table; NULL: only in JSON */
    const char *key;  /**< in JSON, columns of one key together; NULL: only in a table */
    vv_cell_kind kind;
} vv_answer_column;

typedef struct vv_answer_table {
    const vv_answer_column *columns;
    size_t n_columns, n_rows;
    const vv_cell *cells; /**< row by row */
} vv_answer_table;

typedef struct vv_answer_item {
    vv_answer_kind kind;
    unsigned whom;     /**< any of vv_answer_for */
    const char *key;   /**< in JSON; NULL: inside a list */
    const char *name;  /**< of a figure in tables and scenes */
    const char *label; /**< for people; "": it belongs to the line before */
    const char *text;
    const char *unit;    /**< "": none */
    double value, error; /**< NaN: there is none, none is known */
    double chance;       /**< of one without an error: how far chance may put it; 0: not known */
    uint64_t count;
    const double *numbers; /**< of a figure: its path, in the space of what was asked */
    const uint64_t *counts;
    size_t n, columns;
    const vv_statistics *bars;
    const vv_answer_table *table;
} vv_answer_item;

typedef struct vv_answer vv_answer;

/** By number; NULL past the last. Borrowed. */
VV_API const vv_answer_item *vv_answer_nth(const vv_answer *answer, size_t index);
/** Remarks for people, by number; NULL past the last. Borrowed. */
VV_API const char *vv_answer_note(const vv_answer *answer, size_t index);
/** What was measured, and of which part: "values of 90 or more", "box of samples ..". "": there is nothing to say. */
VV_API const char *vv_answer_object(const vv_answer *answer);
VV_API const char *vv_answer_region(const vv_answer *answer);
/** All of it for programs, as one JSON object. Yours to free(). */
VV_API vv_status vv_answer_json(char **json_out, const vv_answer *answer);
/** What scenes keep: the value of vv_measurement's `figures`, as JSON. Yours to free(). */
VV_API vv_status vv_answer_figures(char **json_out, const vv_answer *answer);
VV_API void vv_answer_release(vv_answer *answer); /* NULL is fine */

/* Rows ------------------------------------------------------------------------------------------------------------ */

struct vvi_measuring;

/** One way in which a kind is asked. */
typedef struct vv_measure_form {
    unsigned input, other; /**< any of vv_measured_is; other 0: there is none */
    size_t n_points;       /**< that are given; 0: however many */
    const char *uses;      /**< properties of the measurement that change its answer, with spaces between */
    unsigned what;         /**< for run() */
    vv_status (*run)(struct vvi_measuring *m);
} vv_measure_form;

/** A kind of measurement. */
typedef struct vv_measure_kind {
    const char *name, *doc;
    const char *covers;           /**< what it measures, where that is more than its name says; else NULL */
    const char *also;             /**< other words for it, with spaces between; NULL: none */
    const char *main;             /**< the figure that stands for it in tables and pictures; NULL: the first */
    bool table;                   /**< its result is a table, and not figures */
    bool plot;                    /**< it has a plot */
    bool marks;                   /**< a value or a range is a mark in its plot, and no object */
    bool logarithmic;             /**< and may have a logarithmic scale */
    size_t least_points;          /**< that are given for it, in most of its forms; 0: it is not of points */
    size_t most_points;           /**< SIZE_MAX: any number */
    const vv_measure_form *forms; /**< the first that fits holds; ends with one without run */
} vv_measure_kind;

/** By number, in the order in which they are listed; NULL past the last. */
VV_API const vv_measure_kind *vv_measure_kind_nth(size_t index);
/** By name; NULL: there is none. */
VV_API const vv_measure_kind *vv_measure_kind_find(const char *name);
/** The row of a question. */
VV_API const vv_measure_kind *vv_measure_kind_of(const vv_measurement *question);
/** How it is asked of such data with so many points. other: 0: there is none. NULL: it is not. */
VV_API const vv_measure_form *vv_measure_form_of(const vv_measure_kind *kind, unsigned input, unsigned other,
                                                 size_t n_points);

/**
 * Answer one question.
 *
 * Owns     *out is for vv_answer_release(), also when this fails: it has the remarks until then. It borrows nothing
 * Errors   VV_E_ARGUMENT (data that has no such measure, properties that make no sense for it), VV_E_MEMORY, VV_E_READ,
 *          VV_E_CANCELLED
 * Threads  any; same answer for any thread count
 */
VV_API vv_status vv_measure_run(vv_answer **out, const vv_measurement *question, const vv_measured_inputs *inputs,
                                vv_job *job);

VV_END_DECLS
#endif
