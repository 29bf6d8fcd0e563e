/** @file
 * JSON text written piece by piece, by the program's names for it.
 */
#ifndef CLI_JSON_H
#define CLI_JSON_H
#include "core/result.h"

typedef vvi_result cli_json;
#define cli_json_open vvi_result_open
#define cli_json_close vvi_result_close
#define cli_json_string vvi_result_string
#define cli_json_number vvi_result_number
#define cli_json_integer vvi_result_integer
#define cli_json_unsigned vvi_result_unsigned
#define cli_json_bool vvi_result_bool
#define cli_json_numbers vvi_result_numbers
#define cli_json_strings vvi_result_strings
#define cli_json_raw vvi_result_raw
#endif
