/** @file
 * A text header of keys with values, kept until all of its lines are there: formats let them stand in any order.
 */
#ifndef VVI_IO_HEADER_KEYS_H
#define VVI_IO_HEADER_KEYS_H
#include "core/text.h"
#include "io/notes.h"

typedef struct vvi_key {
    char *name, *value; /* without blanks around them */
    int line;
    bool used; /* somebody has asked for it */
} vvi_key;

typedef struct vvi_keys {
    const char *file; /* stands in errors */
    vvi_key *key;
    size_t n;
} vvi_keys;

/** One more; n_name and n_value count bytes. A key that is there already is VV_E_FORMAT. */
vv_status vvi_keys_add(vvi_keys *keys, const char *name, size_t n_name, const char *value, size_t n_value, int line);
/** Blanks around the first separator of a line do not matter. False when it has none, or no name before it. */
bool vvi_keys_split(const char *line, const char *separators, size_t *n_name, const char **value);
void vvi_keys_finish(vvi_keys *keys); /* zeroed is fine */

/** The value, NULL when the key is not there; letter case does not matter. */
const char *vvi_keys_get(vvi_keys *keys, const char *name);
/** The first of these names that is there; NULL when none is. Ends with NULL. */
const char *vvi_keys_first(vvi_keys *keys, const char *const *names);
/** VV_E_FORMAT at the key's line: "file:line: 'name' ...". */
vv_status vvi_keys_fail(const vvi_keys *keys, const char *name, const char *format, ...) VV_PRINTF(3, 4);
/** VV_E_FORMAT that says that there is none. */
vv_status vvi_keys_need(vvi_keys *keys, const char *name);

/* Where the key is not there, nothing is touched and nothing is wrong. */
/** A whole number in lo .. hi. */
vv_status vvi_keys_int(int64_t *out, vvi_keys *keys, const char *name, int64_t lo, int64_t hi);
/** n whole numbers in lo .. hi, and no more. */
vv_status vvi_keys_ints(int64_t *out, int n, vvi_keys *keys, const char *name, int64_t lo, int64_t hi);
/** n numbers of samples along axes: 1 to the limit `dim`. */
vv_status vvi_keys_dims(int64_t *out, int n, vvi_keys *keys, const char *name, const vv_limits *limits);
/** n finite numbers, and no more. */
vv_status vvi_keys_reals(double *out, int n, vvi_keys *keys, const char *name);
/** "True" and "False", "yes" and "no", 1 and 0. */
vv_status vvi_keys_flag(bool *out, vvi_keys *keys, const char *name);
/** "scalar", "rgb", "rgba", "vector", "label", where the type and the number of components allow it. */
vv_status vvi_keys_meaning(vv_field_info *info, vvi_keys *keys, const char *name);
const char *vvi_meaning_name(vv_meaning meaning);
/** Text, cut to what there is room for. */
void vvi_keys_text(char *out, size_t room, vvi_keys *keys, const char *name);

/** One line of a header: name, separator, value, whose line ends become blanks; nothing where the value is empty. */
void vvi_keys_print(vvi_text *text, const char *name, const char *separator, const char *value);
/** The same with n numbers, a blank before each. */
void vvi_keys_print_numbers(vvi_text *text, const char *name, const char *separator, const double *v, int n);

/** Keys that nobody has asked for, as metadata. */
vv_status vvi_keys_note_rest(const vvi_keys *keys, vv_notes *notes);
#endif
