/** @file
 * Samples written as decimal numbers, with white space or commas between them.
 */
#ifndef VVI_IO_NUMBERS_H
#define VVI_IO_NUMBERS_H
#include "grid/field.h"
#include "io/source.h"

typedef struct vvi_numbers {
    vv_source *source;
    vv_type type;
    uint64_t at, expected; /* the number that comes next; how many there are: for errors */
    vv_job *job;           /* told of a last number that may be cut; NULL: something else ends the text, so none is */
    char *text;
    size_t text_at, text_end;
} vvi_numbers;

/** From where the source stands. */
vv_status vvi_numbers_begin(vvi_numbers *out, vv_source *source, vv_type type, uint64_t expected, vv_job *job);
/** n numbers; VV_E_FORMAT when one is none of its type, or there are too few. */
vv_status vvi_numbers_read(vvi_numbers *numbers, void *out, size_t n);
/** The same, less where the text ends. */
vv_status vvi_numbers_read_some(vvi_numbers *numbers, void *out, size_t n, size_t *n_read);
/** So many fewer. */
vv_status vvi_numbers_skip(vvi_numbers *numbers, uint64_t n);
void vvi_numbers_end(vvi_numbers *numbers); /* a zeroed one is fine */
/** The shortest text that reads as the same sample; what is not finite is "nan", "inf", "-inf". */
void vvi_sample_print(char out[32], vv_type type, const void *sample);
#endif
