/** @file
 * Text of mesh files: words and numbers in order, with the line that they stand on; and numbers to text.
 */
#ifndef VVI_IO_MESH_WORDS_H
#define VVI_IO_MESH_WORDS_H
#include "core/status.h"
#include "io/source.h"

typedef struct vvi_words {
    vv_source *source;
    const char *at; /* of the line, what comes next; NULL before the first line */
    uint64_t line;  /* from 1 */
    bool ended;
    char comment; /* what it begins goes as far as its line; 0: nothing does */
    vv_job *job;
} vvi_words;

void vvi_words_begin(vvi_words *out, vv_source *source, char comment, vv_job *job);
/** The next line, its blanks at the front passed; NULL at the end of the file. */
vv_status vvi_words_line(vvi_words *words, const char **line_out);
/** The next word, on this line or a later one; *n_out is 0 at the end of the file. Valid until the next call. */
vv_status vvi_words_next(vvi_words *words, const char **word_out, size_t *n_out);
/** The next word of this line; NULL and 0 at its end. */
const char *vvi_words_here(vvi_words *words, size_t *n_out);
/** How many words this line still has, at most `most`. */
size_t vvi_words_left(const vvi_words *words, size_t most);
/** The next word as a number; "nan" and "inf" are some. VV_E_FORMAT names `what` and the line. */
vv_status vvi_words_real(vvi_words *words, double *out, const char *what);
/** The next word as a whole number in lo .. hi. */
vv_status vvi_words_int(vvi_words *words, int64_t *out, int64_t lo, int64_t hi, const char *what);
/** VV_E_FORMAT at the line. */
vv_status vvi_words_fail(const vvi_words *words, const char *format, ...) VV_PRINTF(2, 3);
/** A number at `text`, exact; false where there is none. */
bool vvi_words_number(double *out, const char *text, const char **end);

/** The fewest digits that read back as the same float; how many letters, no 0 at the end. What is not finite is "nan",
 * "inf" or "-inf". */
size_t vvi_print_float(char out[32], float value);
/** A whole number, as above. */
size_t vvi_print_uint(char out[32], uint64_t value);
#endif
