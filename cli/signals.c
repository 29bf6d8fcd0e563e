#include "signals.h"
#include <signal.h>
#include <stdatomic.h>
#include <unistd.h>

/* The only mutable globals of the program: a signal handler has no other way to know what to stop. */
static _Atomic(vv_job *) watched;
static volatile sig_atomic_t came, soft;

static void on_signal(int signal_number)
{
    vv_job *job = atomic_load(&watched);
    const bool asks = soft && !came;
    came = 1;
    if (!job)
        _exit(130);
    if (!asks)
        vv_job_cancel(job);
    (void)signal_number;
}

void cli_signals_watch(vv_job *job)
{
    atomic_store(&watched, job);
    if (!job)
        soft = 0;                                        /* of the work that is over */
    struct sigaction action = {.sa_handler = on_signal}; /* no SA_RESTART: a read that waits for input gives up */
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    struct sigaction before; /* the terminal was closed: nothing is left half written, but nohup goes on */
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, NULL);
    action.sa_handler = SIG_IGN;
    sigaction(SIGPIPE, &action, NULL);
    sigaction(SIGXFSZ, &action, NULL); /* past 'ulimit -f' writing fails, with a sentence, as on a full disk */
}

void cli_signals_soften(void)
{
    soft = 1;
}

bool cli_signals_came(void)
{
    return came != 0;
}
