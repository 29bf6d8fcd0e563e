/** @file
 * Ctrl-C and its like: the job of the program is cancelled, so that nothing is left half-made.
 */
#ifndef CLI_SIGNALS_H
#define CLI_SIGNALS_H
#include <volvis/runtime.h>

/** SIGINT and SIGTERM cancel `job` (NULL: end the program at once, as there is nothing to undo); broken pipes become
 * write errors. */
void cli_signals_watch(vv_job *job);
/** From now on the first one only asks: cli_signals_came() is true, and the work ends where something whole is there. A
 * second one cancels. */
void cli_signals_soften(void);
/** Whether one of them came. */
bool cli_signals_came(void);
#endif
