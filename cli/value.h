/** @file
 * What people type beside plain property values: lists of numbers, points, ranges.
 */
#ifndef CLI_VALUE_H
#define CLI_VALUE_H
#include "core/text.h"
#include <string.h>
#include <strings.h>
#include <volvis/property.h>

/** Exactly n numbers between commas (or `x` where by_x), two of them also as LO..HI: VV_E_ARGUMENT says what was
 * expected. */
vv_status cli_value_numbers(double *out, size_t n, const char *typed, bool by_x);

/** "LO..HI" (and "LO,HI", "LO:HI") in its two ends, either of which may be empty, not both; "80" is "80..". */
bool cli_value_split_range(char lo[64], char hi[64], const char *typed);

/** "10mm,2cm,0" as the JSON array that the property engine takes; numbers stay numbers. */
void cli_value_vector(vvi_text *out, const char *typed);
/** The same of a point or direction of --option: X,Y,Z. Errors: VV_E_ARGUMENT, VV_E_MEMORY. */
vv_status cli_value_point(vvi_text *out, const char *option, const char *typed);

/** The word for n things: `one` or `several`, as in "1 triangle", "2 triangles". */
static inline const char *cli_plural(uint64_t n, const char *one, const char *several)
{
    return n == 1 ? one : several;
}

/** Whether a path or a word has that suffix, in whatever letter case, behind something. */
static inline bool cli_ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), n_end = strlen(end);
    return n > n_end && strcasecmp(text + n - n_end, end) == 0;
}

/** A path without its folders. */
static inline const char *cli_base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/** ".nrrd"; "": it has none. */
static inline const char *cli_suffix_of(const char *path)
{
    const char *dot = strrchr(cli_base_of(path), '.');
    return dot ? dot : "";
}

/** "0.05 s", "46 s", "5 min", "77 min", "3.5 h" of a time that is known about. */
void cli_value_duration(char out[32], double seconds);
/** Of one number at least, which it sorts. */
double cli_value_median(double *v, size_t n);
#endif
