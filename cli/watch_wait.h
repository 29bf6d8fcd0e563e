/** @file
 * Waiting until files have changed, and whoever writes them has done so.
 */
#ifndef CLI_WATCH_WAIT_H
#define CLI_WATCH_WAIT_H
#include "watch.h"

/** Returns the number of one whose files are others than they were when they were read, and are still by now. inotify
 * wakes it; a look each second finds what inotify does not tell, on network file systems and where it is not to be
 * had. A signal ends the program. */
size_t cli_watch_wait(cli_watch *watches, size_t n);
#endif
