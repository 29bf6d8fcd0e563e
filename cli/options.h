/** @file
 * Options that several verbs share, as property rows.
 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H
#include <volvis/property.h>

/** One value of an option that may be repeated: rows of kind LIST with this class. */
typedef struct cli_word {
    vv_object base;
    char *text;
} cli_word;
extern const vv_class cli_word_class;
/** Value by number; NULL past the end. */
const char *cli_word_nth(const vv_collection *words, size_t index);

typedef enum cli_progress_kind {
    CLI_PROGRESS_AUTO,
    CLI_PROGRESS_BAR,
    CLI_PROGRESS_JSON,
    CLI_PROGRESS_NONE
} cli_progress_kind;

/** Every verb has these. */
typedef struct cli_common {
    vv_object base;
    char *output;
    vv_collection *set;   /**< of cli_word */
    vv_collection *limit; /**< of cli_word: NAME=VALUE */
    bool json;
    int64_t threads; /**< 0: not given */
    double memory;   /**< bytes; 0: not given */
    int progress;
    bool dry_run, quiet, verbose, overwrite, allow_outside, safe, defaults, help;
} cli_common;
extern const vv_class cli_common_class;
/** Those that are shown of verbs that work on no World: without --set. */
extern const vv_class cli_common_plain_class;

/** Verbs that read data. */
typedef struct cli_reading {
    vv_object base;
    char *missing; /**< cli_missing_read() tells what it says */
    int64_t frame;
    char *part;
    char *raw;
    char *input_format;
} cli_reading;
extern const vv_class cli_reading_class;
/** The same without --missing: of operations that have their own. cli_command_options() gives it as the other. */
extern const vv_class cli_reading_rest_class;
bool cli_is_reading(const vv_class *cls);

/** Verbs that write data. */
typedef struct cli_writing {
    vv_object base;
    char *output_format;
    char *encoding;
    int64_t level;
    bool big_endian, stored;
} cli_writing;
extern const vv_class cli_writing_class;

/** Verbs whose work can be timed by itself. */
typedef struct cli_timing {
    vv_object base;
    int64_t repeat; /**< 0: not timed */
} cli_timing;
extern const vv_class cli_timing_class;
#endif
