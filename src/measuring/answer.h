/** @file
 * How rows fill an answer. A failed allocation makes it bad, which vv_measure_run() finds at the end.
 */
#ifndef VVI_MEASURING_ANSWER_H
#define VVI_MEASURING_ANSWER_H
#include "core/result.h"
#include "core/text.h"
#include "measure/plot.h"
#include <volvis/measuring.h>

/** A number as a row has it. */
typedef struct vvi_figure {
    const char *key, *label;
    double value, error; /**< error NaN: none is known */
    char unit[32];
    double chance; /**< of one without an error: how far chance may put it, which its digits follow; 0: not known */
} vvi_figure;

struct vv_answer {
    vv_answer_item *item;
    size_t n, room;
    char **note;
    size_t n_notes;
    void **kept; /**< what items point to */
    size_t n_kept, kept_room;
    const char *part;             /**< of several: tables and scenes name figures after it too; NULL: of all */
    char object[160], region[96]; /**< of what, for people; "" where that says nothing */
    const vvi_plot *plot;         /**< NULL: there is none */
    const char *no_plot;          /**< why there is nothing to plot */
    vv_answer_item lost;          /**< where an item goes that there is no memory for */
    bool bad;
};

/** So much memory, zeroed, that lives as long as the answer; NULL: it is bad. */
void *vvi_answer_room(vv_answer *a, size_t n, size_t bytes);
/** A copy of a text. Never NULL. */
const char *vvi_answer_copy(vv_answer *a, const char *text);

/** For everybody. */
void vvi_tell_figure(vv_answer *a, const vvi_figure *figure);
/** The same of one without chance. */
void vvi_tell(vv_answer *a, const char *key, const char *label, double value, double error, const char *unit);
/** For some of vv_answer_for. */
void vvi_tell_figure_for(vv_answer *a, const vvi_figure *figure, unsigned whom);
/** The path of a figure that was told: rows of 3 in the measurement's space. */
void vvi_tell_path(vv_answer *a, const char *key, const double *v, size_t n);
/** A count that is told to people only where it is not 0. */
void vvi_tell_rare(vv_answer *a, const char *key, const char *label, uint64_t count);
/** Three numbers of a place: together for programs (without errors), `key`_x to `key`_z in tables and scenes. error:
 * NULL: none is known. */
void vvi_tell_place(vv_answer *a, const char *key, const double v[3], const double error[3], const char *unit);
/* For programs. */
void vvi_tell_text(vv_answer *a, const char *key, const char *text); /* NULL: there is none */
void vvi_tell_json(vv_answer *a, const char *key, const char *json); /* as it is */
void vvi_tell_number(vv_answer *a, const char *key, double value);
void vvi_tell_count(vv_answer *a, const char *key, uint64_t count);
void vvi_tell_bool(vv_answer *a, const char *key, bool value);
void vvi_tell_numbers(vv_answer *a, const char *key, const double *v, size_t n);
void vvi_tell_rows(vv_answer *a, const char *key, const double *v, size_t n, size_t columns);
void vvi_tell_counts(vv_answer *a, const char *key, const uint64_t *v, size_t n);
void vvi_tell_open(vv_answer *a, const char *key, const char *bracket); /* "[" or "{" */
void vvi_tell_close(vv_answer *a, const char *bracket);                 /* "]" or "}" */
/* For people. */
void vvi_tell_line(vv_answer *a, const char *label, const char *format, ...) VV_PRINTF(3, 4);
void vvi_tell_block(vv_answer *a, vvi_text *text); /* takes the text */
void vvi_tell_note(vv_answer *a, const char *format, ...) VV_PRINTF(2, 3);
void vvi_tell_bars(vv_answer *a, const vv_statistics *bars); /* room of the answer */
/** For tables, and for programs where key is not NULL. All are room of the answer, or constants. */
void vvi_tell_table(vv_answer *a, const char *key, const vv_answer_column *columns, size_t n_columns,
                    const vv_cell *cells, size_t n_rows);

/** Keys of a JSON object that is open. */
void vvi_answer_add_json(vvi_result *json, const vv_answer *answer);

/** The table that it has, or else its figures, as comma-separated values. */
void vvi_answer_add_csv(vvi_text *out, const vv_answer *answer);

/* Digits ---------------------------------------------------------------------------------------------------------- */

enum { VVI_FIGURE_TEXT = 160 };
/** "12.34 ± 0.05 mm^2": as many digits as the error allows; to 6 digits where nothing says how many mean something. */
void vvi_figure_print(char out[VVI_FIGURE_TEXT], double value, double error, double chance, const char *unit);
/** "12.34" and "0.05": both to the second digit of the error, with an exponent where that would be many zeros or
 * nothing else; to 6 digits without one. */
void vvi_figure_digits(char out[48], char error_out[48], double value, double error);
/** "12.3, 4.57, 8.9": each to the second digit of its error. error NULL: none is known. */
void vvi_place_print(char out[VVI_FIGURE_TEXT], const double v[3], const double error[3]);
/** "mm^2"; of "voxels" "voxels^2". */
void vvi_power_unit(char out[32], const char *unit, int power);

/** The word for n things. */
static inline const char *vvi_plural(uint64_t n, const char *one, const char *several)
{
    return n == 1 ? one : several;
}
#endif
