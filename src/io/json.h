/** @file
 * JSON of files, within the limits. Python writes NaN and Infinity, which JSON does not have: they are read as empty
 * text, which is no number.
 */
#ifndef VVI_IO_JSON_H
#define VVI_IO_JSON_H
#include "io/source.h"
#include <jansson.h>
#include <volvis/field.h>

/** An object of JSON in memory, which is written to. */
vv_status vvi_json_read_text(json_t **out, char *text, size_t n, const char *name, const vv_job *job);
/** A file of JSON in the folder; *out is NULL when it is not there. */
vv_status vvi_json_read_beside(json_t **out, const vv_source *folder, const char *name, vv_job *job);
/** A whole number: also one that is written as a real. */
bool vvi_json_whole(int64_t *out, const json_t *value);
/** The id of a label: a whole number, or its digits, which those past 64 bits with a sign become here. */
bool vvi_json_label(vv_label_id *out, const json_t *value);
/** A finite number. */
bool vvi_json_real(double *out, const json_t *value);
/** Text, or NULL. */
const char *vvi_json_text(const json_t *object, const char *key);
/** Copies text to room of `room` bytes, cut and made clean. */
void vvi_json_copy_text(char *out, size_t room, const char *text);

#endif
