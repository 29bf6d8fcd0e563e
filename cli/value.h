/** @file
 * What people type beside plain property values: lists of numbers, and property paths.
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

/**
 * The row that a path of the World leads to, by its classes: "lights.ANY.intensity" needs no light of that name.
 *
 * cls_out  the class of the objects there, for objects, lists and maps; else NULL
 * Errors   VV_E_NOT_FOUND with the nearest real name
 */
vv_status cli_path_row(const vv_property **row_out, const vv_class **cls_out, const vv_class *root, const char *path,
                       const vv_property_context *context);

/** One path that another stands for. */
typedef vv_status cli_path_fn(void *user, const char *path);

/**
 * Every path that `path` stands for: a part `*` is each entry of a map or list, a number in a map the entry at that
 * place, from 0. Other paths are told as they are, whether or not they lead anywhere.
 *
 * Errors   VV_E_ARGUMENT for a star elsewhere; VV_E_NOT_FOUND where there are no entries; those of fn, which ends it
 */
vv_status cli_path_each(const vv_object *root, const char *path, cli_path_fn *fn, void *user);

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

/** A value among values from lo to hi with as many digits as tell them apart: 1000000015 where 1000000000 is near.
 * Whole numbers have all their digits. */
void cli_value_print(char out[32], double value, double lo, double hi);

/** Of one number at least, which it sorts. */
double cli_value_median(double *v, size_t n);

/** What makes values of stored numbers, as in "i16 * 0.5 + 3", "stored - 1024". */
void cli_value_scaled(char out[96], const char *stored, double scale, double offset);
#endif
