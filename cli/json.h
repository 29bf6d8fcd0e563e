/** @file
 * JSON text written piece by piece: keys in the order given, numbers in the shortest form that reads back equal.
 * A failed allocation makes the text bad; it is found once, when the text is taken.
 */
#ifndef CLI_JSON_H
#define CLI_JSON_H
#include "core/text.h"

typedef struct cli_json {
    vvi_text text;
    int depth;
    bool filled; /**< the innermost object or array has an entry already */
} cli_json;

/** Everywhere: key is NULL inside an array and for the outermost value. */
void cli_json_open(cli_json *json, const char *key, char bracket);        /* '{' or '[' */
void cli_json_close(cli_json *json, char bracket);                        /* '}' or ']' */
void cli_json_string(cli_json *json, const char *key, const char *value); /* NULL: null */
void cli_json_number(cli_json *json, const char *key, double value);      /* not finite: null */
void cli_json_integer(cli_json *json, const char *key, int64_t value);
void cli_json_unsigned(cli_json *json, const char *key, uint64_t value);
void cli_json_bool(cli_json *json, const char *key, bool value);
void cli_json_numbers(cli_json *json, const char *key, const double *values, size_t n); /* an array on one line */
void cli_json_strings(cli_json *json, const char *key, const char *const *values);      /* ends with NULL */
/** Text that is JSON already. */
void cli_json_raw(cli_json *json, const char *key, const char *value);
#endif
