/** @file
 * JSON text of results, for programs and for the page, written piece by piece: keys in the order given, numbers in the
 * shortest form that reads back equal. A failed allocation makes the text bad; it is found once, when the text is
 * taken.
 */
#ifndef VVI_CORE_RESULT_H
#define VVI_CORE_RESULT_H
#include "core/text.h"
#include <volvis/field.h>
#include <volvis/property.h>

typedef struct vvi_result {
    vvi_text text;
    int depth;
    bool filled;  /**< the innermost object or array has an entry already */
    bool compact; /**< all on one line */
} vvi_result;

/** Everywhere: key is NULL inside an array and for the outermost value. */
void vvi_result_open(vvi_result *json, const char *key, char bracket);        /* '{' or '[' */
void vvi_result_close(vvi_result *json, char bracket);                        /* '}' or ']' */
void vvi_result_string(vvi_result *json, const char *key, const char *value); /* NULL: null */
void vvi_result_number(vvi_result *json, const char *key, double value);      /* not finite: null */
void vvi_result_integer(vvi_result *json, const char *key, int64_t value);
void vvi_result_unsigned(vvi_result *json, const char *key, uint64_t value);
/** All digits of a label's id: a number, which readers that have only doubles round. */
void vvi_result_label(vvi_result *json, const char *key, vv_label_id id, bool is_unsigned);
void vvi_result_bool(vvi_result *json, const char *key, bool value);
void vvi_result_numbers(vvi_result *json, const char *key, const double *values, size_t n); /* an array on one line */
void vvi_result_strings(vvi_result *json, const char *key, const char *const *values);      /* ends with NULL */
/** Text that is JSON already. */
void vvi_result_raw(vvi_result *json, const char *key, const char *value);
/** What everybody is told of a row (property_tell.c): its name, kind, line of documentation, quantity, unit and range.
 */
void vvi_property_tell(vvi_result *json, const vv_property *row);
/** "default", where that is no text; false: it is, or there is none. */
bool vvi_property_tell_default(vvi_result *json, const vv_property *row);
#endif
