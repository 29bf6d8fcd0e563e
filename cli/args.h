/** @file
 * The words of a command line, matched with the property rows of a verb.
 */
#ifndef CLI_ARGS_H
#define CLI_ARGS_H
#include "verb.h"

/** One option that was given. The text lives in argv, or in the file of defaults. */
typedef struct cli_given {
    const vv_class *cls;
    const vv_property *row;
    const char *text;
    size_t n_before;   /**< words that stand before it */
    bool skip;         /**< it is for another input */
    bool refused;      /**< it does not fit, and is left out: of the file of defaults alone */
    const char *place; /**< "FILE:LINE" of the file of defaults; NULL: the command line */
} cli_given;

enum { CLI_PLACES_MOST = 16 };

typedef struct cli_args {
    cli_given *given;
    size_t n_given;
    const char **words; /**< what stands without dashes */
    size_t n_words;
    bool placed;                   /**< some words are for inputs that they say, and others before them are left out */
    size_t place[CLI_PLACES_MOST]; /**< by word, where they are placed: the number of the input */
    bool named[CLI_PLACES_MOST];   /**< by word: it is named as a further input, the same for each of the first */
    char *names;                   /**< of the inputs, as given for an option; what is behind one of `given` */
} cli_args;

/** Errors: VV_E_ARGUMENT, with the nearest real name for an unknown option. */
vv_status cli_args_parse(cli_args *out, const cli_verb *verb, int argc, char **argv);
void cli_args_free(cli_args *args);
/** An object of one of the verb's classes with what was given for it. */
vv_status cli_args_object(vv_object **out, const cli_args *args, const vv_class *cls,
                          const vv_property_context *context);
/** Overwrites what was given for an option, which everybody sees in the list of programs, once its object is made. */
void cli_args_hide(const cli_args *args, const char *name);
/** "dry_run" as it is typed: "dry-run". */
void cli_option_name(char out[64], const vv_property *row);
/** Whether help and completions list it; what is no option at all they do not. */
bool cli_option_is_listed(const vv_property *row);
/** Whether each time that it is given adds a row to a table. */
bool cli_option_adds_row(const vv_property *row);
/** Whether it takes labels or channels, which the input has names for. */
bool cli_option_is_named(const vv_property *row);
/** Whether an option may stand without a value: an enumeration that begins with "none" and "auto". Alone it says auto;
 * a value stands behind "=". */
bool cli_option_alone(const vv_property *row);
#endif
