/** @file
 * Verbs: the descriptor, and the table of those that exist. A hand-written verb is one file in cli/verbs with one
 * descriptor and one line in cli/verbs.c; every operation of the registry is a verb by itself.
 */
#ifndef CLI_VERB_H
#define CLI_VERB_H
#include <volvis/sys/registry.h>

struct cli_command;

/** Option classes of one verb at most: its own, reading, writing, timing, watching. */
enum { CLI_VERB_CLASSES = 5 };

typedef struct cli_verb {
    const char *name;
    const char *doc;     /**< one line, lower case, no full stop */
    const char *about;   /**< paragraphs for the help, or NULL */
    const char *words;   /**< what stands without dashes, as the usage line shows it: "INPUT" */
    const char *choices; /**< what those words are chosen from, for completion: "files", "verbs", "renderers", ... */
    bool files_too;      /**< or files, where `choices` is something else */
    size_t min_words, max_words;
    const vv_class *options[CLI_VERB_CLASSES]; /**< NULL where there are fewer; cli_common_class comes by itself */
    const vv_class *own; /**< the one of them that run() makes itself, with units and names of its input; or NULL */
    const char *const *examples; /**< command lines; run by the tests; ends with NULL */
    bool makes_file;             /**< -o is a file that run() writes; else the result's text goes there */
    const char *draws;           /**< how -o becomes a picture, which run() sees to; NULL: it never does */
    bool each_input;             /**< -o '{stem}.png' makes one of each input */
    bool in_out;                 /**< IN OUT will do instead of IN -o OUT */
    bool safe;                   /**< files are read as with --safe, unless --no-safe is given */
    bool world;                  /**< works on a World: --set has something to set */
    bool plain;                  /**< the file of defaults is not read */
    bool hidden;
    vv_status (*run)(struct cli_command *command);
    const vv_operation *operation; /**< where the verb is one */
} cli_verb;

/** Hand-written verbs and operations in the order of the help, by number: false past the end. */
bool cli_verb_nth(cli_verb *out, const vv_registry *registry, size_t index);
/** By name; an error with the nearest real name when there is none. */
vv_status cli_verb_find(cli_verb *out, const vv_registry *registry, const char *name);
#endif
