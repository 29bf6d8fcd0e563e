/** @file
 * Formulas: text such as "a - 0.5*b" made into a small program that is run over rows of numbers.
 *
 * Numbers, names, + - * / % ^, < <= > >= == !=, && || !, ?: and functions (core/expression_functions.c), with the
 * precedence of C and ^ (to the power of, from the right) above the sign. Everything is reckoned in doubles; what is
 * not 0 is true, and what compares or negates gives 1 or 0. A text is safe to take from anybody: its length, depth and
 * program are bounded, and nothing in it has an effect.
 */
#ifndef VVI_CORE_EXPRESSION_H
#define VVI_CORE_EXPRESSION_H
#include "core/job.h"

enum {
    VVI_EXPRESSION_ROW = 512,   /**< numbers that are worked on at once */
    VVI_EXPRESSION_BYTES = 4000 /**< of a text, at most */
};

typedef struct vvi_expression vvi_expression;

/** `names` are what the text may name beside constants and functions, at most 64. VV_E_ARGUMENT tells the column, what
 * was expected and what was found. */
vv_status vvi_expression_new(vvi_expression **out, const char *text, const char *const *names, size_t n_names);
void vvi_expression_free(vvi_expression *expression); /* NULL is fine */
/** Whether the value depends on the name, as far as the text goes: "0*a" does. */
bool vvi_expression_uses(const vvi_expression *expression, size_t name);
/** Whether a text that names something may call it so: a letter or _, then letters, digits and _, and the name of no
 * constant or function. VV_E_ARGUMENT says why not. */
vv_status vvi_expression_check_name(const char *name);

/** A worker's rows. The expression outlives them. */
typedef struct vvi_expression_rows vvi_expression_rows;
vv_status vvi_expression_rows_new(vvi_expression_rows **out, const vvi_expression *expression, vv_job *job);
void vvi_expression_rows_free(vvi_expression_rows *rows);
/** The VVI_EXPRESSION_ROW values of a name that the expression uses, to be written before each run; 0 at first. NULL:
 * it does not use it. */
double *vvi_expression_row(vvi_expression_rows *rows, size_t name);
/** The value at each of the first n places of the rows; stays until the next run. The same numbers with any instruction
 * set. */
const double *vvi_expression_run(vvi_expression_rows *rows, size_t n);

/** A constant or a function that every text may name; NULL past the end. *doc_out: what it is, in a few words. */
const char *vvi_expression_constant(size_t index, double *value_out);
const char *vvi_expression_function(size_t index, const char **doc_out);
#endif
