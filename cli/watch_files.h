/** @file
 * Files as they were when they were read, and whether they are still the same.
 */
#ifndef CLI_WATCH_FILES_H
#define CLI_WATCH_FILES_H
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/** A file, or a folder with the files in it, as one number: another number is another state. 0: it is not there. */
typedef uint64_t cli_file_state;

typedef struct cli_watched_file {
    char *path;
    cli_file_state state; /**< as it was before it was read */
    bool used;            /**< by the run that is going on, or the last one */
    bool writing;         /**< somebody writes into it, and has not closed it yet; inotify tells */
    int folder;           /**< inotify's number of the folder that it is in; -1: none */
} cli_watched_file;

/** Zeroed is valid. Sorted by path. */
typedef struct cli_watch_files {
    cli_watched_file *file;
    size_t n, room;
    char **own; /**< outputs, which are no reason to start again where they lie in a folder that is read */
    size_t n_own;
    bool incomplete; /**< there was no memory for all of them */
} cli_watch_files;

/** An output; ignored in every folder. */
void cli_watch_files_own(cli_watch_files *files, const char *path);
/** A file that is going to be read. */
void cli_watch_files_add(cli_watch_files *files, const char *path);
/** Before a run: every file is as it is now, and none is used. */
void cli_watch_files_begin(cli_watch_files *files);
/** After a run: what it did not use is forgotten, unless it failed before it came to it. */
void cli_watch_files_end(cli_watch_files *files, bool failed);
/** Whether one of them is another by now. `now`: all states in one number; `missing`, `writing`: so is one of them. */
bool cli_watch_files_changed(const cli_watch_files *files, cli_file_state *now, bool *missing, bool *writing);
/** The state of one file or folder. */
cli_file_state cli_file_state_of(const cli_watch_files *files, const char *path);
void cli_watch_files_free(cli_watch_files *files);
#endif
