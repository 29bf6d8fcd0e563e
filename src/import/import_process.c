/* Nothing that the import program does may hold this process up or confuse it: every wait is bounded and sees cancel,
 * every length is checked before memory is taken, and however it ends, it is waited for, so that none is left behind.
 */
#include "import/import_process.h"
#include "core/installed.h"
#include "core/job.h"
#include "core/limits.h"
#include "core/os.h"
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define POLL_MS 20
#define PIECE_BYTES ((size_t)64 << 10)
#define MESSAGE_SLACK ((uint64_t)64 << 10) /* beside a text of the longest kind */

/* Starting -------------------------------------------------------------------------------------------------------- */

static bool find_program(char *out, size_t room, const vv_job *job)
{
    const char *given = vvi_job_import_program(job);
    if (!given)
        return vvi_installed_find(out, room, "volvis-import", X_OK);
    snprintf(out, room, "%s", given);
    return true;
}

bool vvi_import_is_there(const vv_job *job)
{
    char program[4096];
    return find_program(program, sizeof program, job);
}

/* What a library may need to know; nothing that makes one load or write anything. */
static void keep_environment(char *out[8], char room[8][512])
{
    static const char *const names[] = {"TMPDIR", "ASAN_OPTIONS", "UBSAN_OPTIONS", "TSAN_OPTIONS", "TZ"};
    size_t n = 0;
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        const char *value = getenv(names[i]);
        if (value && snprintf(room[n], sizeof room[n], "%s=%s", names[i], value) < (int)sizeof room[n]) {
            out[n] = room[n];
            n++;
        }
    }
    out[n] = NULL;
}

static int spawn(pid_t *pid_out, const char *program, int socket, const vvi_import_process *p)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none;
    char *const words[] = {(char *)(uintptr_t)program, NULL};
    char *environment[8], room[8][512];
    int failed = posix_spawn_file_actions_init(&files);
    if (failed)
        return failed;
    if ((failed = posix_spawnattr_init(&attributes)) != 0) {
        posix_spawn_file_actions_destroy(&files);
        return failed;
    }
    sigemptyset(&none);
    keep_environment(environment, room);
    if (p->input >= 0)
        failed = posix_spawn_file_actions_adddup2(&files, p->input, STDIN_FILENO);
    else if (!p->endless)
        failed = posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (!failed)
        failed = posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    if (!failed)
        failed = posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    if (!failed)
        failed = posix_spawn_file_actions_adddup2(&files, socket, VVI_IMPORT_SOCKET);
    if (!failed)
        failed = posix_spawnattr_setsigmask(&attributes, &none);
    if (!failed)
        failed = posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
    if (!failed)
        failed = posix_spawn(pid_out, program, &files, &attributes, words, environment);
    posix_spawnattr_destroy(&attributes);
    posix_spawn_file_actions_destroy(&files);
    return failed;
}

vv_status vvi_import_start(vvi_import_process *p, vv_job *job)
{
    char program[4096];
    int ends[2];
    p->pid = 0;
    p->socket = -1;
    if (!find_program(program, sizeof program, job))
        return vv_fail(VV_E_UNSUPPORTED, "--safe needs the import program, and there is none at %s: %s", program,
                       strerror(errno));
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return vv_fail_at(VV_E_READ, p->name, NULL, "cannot connect to the import program: %s", strerror(errno));
    const int failed = spawn(&p->pid, program, ends[1], p);
    close(ends[1]);
    if (failed) {
        p->pid = 0;
        close(ends[0]);
        return vv_fail_at(VV_E_READ, p->name, NULL, "the import program %s cannot be started: %s", program,
                          strerror(failed));
    }
    p->socket = ends[0];
    return VV_OK;
}

/* Ending ---------------------------------------------------------------------------------------------------------- */

/* How it ended, when it is given `ms` to do so by itself; -1 when that is not known or it had to be killed. */
static int end(vvi_import_process *p, int ms)
{
    int how = -1;
    pid_t ended = 0;
    if (p->socket >= 0)
        close(p->socket);
    p->socket = -1;
    if (p->pid <= 0)
        return -1;
    for (; ended == 0 && ms > 0; ms--) {
        ended = waitpid(p->pid, &how, WNOHANG);
        if (ended == 0)
            nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    if (ended == 0) {
        kill(p->pid, SIGKILL);
        while ((ended = waitpid(p->pid, &how, 0)) < 0 && errno == EINTR) {
        }
        how = -1;
    }
    p->pid = 0;
    return ended < 0 ? -1 : how; /* a program that waits for any child may have taken ours */
}

void vvi_import_stop(vvi_import_process *p)
{
    end(p, 0);
    vvi_text_free(&p->body);
}

vv_status vvi_import_nonsense(vvi_import_process *p, const char *what)
{
    end(p, 0);
    return vv_fail_at(VV_E_READ, p->name, NULL,
                      "the import program gave an invalid answer (%s); the file is damaged or hostile", what);
}

static vv_status fail_dead(vvi_import_process *p)
{
    const int how = end(p, 500);
    if (how != -1 && WIFSIGNALED(how) && WTERMSIG(how) == SIGSYS)
        return vv_fail_at(VV_E_READ, p->name, NULL,
                          "the import program was stopped because it tried what no reader does; the file is hostile");
    if (how != -1 && WIFSIGNALED(how) && WTERMSIG(how) == SIGXCPU)
        return vv_fail_at(VV_E_READ, p->name, NULL,
                          "the import program used up its processor time; the file is damaged or hostile, or --limit "
                          "import_seconds=N allows more");
    if (how != -1 && WIFSIGNALED(how))
        return vv_fail_at(VV_E_READ, p->name, NULL,
                          "the import program crashed (signal %d, %s); the file is damaged or hostile", WTERMSIG(how),
                          strsignal(WTERMSIG(how)));
    return vv_fail_at(VV_E_READ, p->name, NULL,
                      "the import program ended too early (exit %d); the file is damaged or hostile",
                      how != -1 && WIFEXITED(how) ? WEXITSTATUS(how) : -1);
}

/* Listening ------------------------------------------------------------------------------------------------------- */

/* Processor seconds of all its threads, as the kernel counts them: it cannot lie about these. */
static double busy_seconds(const vvi_import_process *p)
{
    clockid_t clock;
    struct timespec used = {0};
    if (clock_getcpuclockid(p->pid, &clock) != 0 || clock_gettime(clock, &used) != 0)
        return 0;
    return (double)used.tv_sec + 1e-9 * (double)used.tv_nsec;
}

vv_status vvi_import_ask(vvi_import_process *p, vvi_wire_kind kind, const vvi_text *body, int descriptor)
{
    if (body->bad)
        return vv_fail_memory(body->n);
    p->asked_s = vvi_os_seconds();
    p->busy_s = busy_seconds(p);
    p->messages = 0;
    return vvi_wire_send(p->socket, kind, body, descriptor) ? VV_OK : fail_dead(p);
}

static vv_status check_time(vvi_import_process *p, vv_job *job)
{
    const double most = (double)vvi_job_limits(job)->import_seconds;
    const double busy_s = busy_seconds(p) - p->busy_s;
    if (busy_s <= most && (p->endless || vvi_os_seconds() - p->asked_s < most))
        return VV_OK;
    end(p, 0);
    return vv_fail_at(VV_E_READ, p->name, NULL,
                      "the import program %s %g seconds and was stopped; the file is damaged or hostile, or --limit "
                      "import_seconds=N allows more",
                      busy_s > most / 2 ? "did not respond for" : "gave no sign of life for", most);
}

static vv_status wait_for_more(vvi_import_process *p, vv_job *job)
{
    struct pollfd what = {.fd = p->socket, .events = POLLIN};
    for (;;) {
        const int ready = poll(&what, 1, POLL_MS);
        vv_status st = vvi_job_poll(job);
        if (st != VV_OK)
            end(p, 0);
        if (st != VV_OK || (st = check_time(p, job)) != VV_OK)
            return st;
        if (ready > 0)
            return VV_OK;
    }
}

/* Exactly n bytes to the end of the text, which grows as they come. */
static vv_status receive_bytes(vvi_import_process *p, vvi_text *to, uint64_t n, vv_job *job)
{
    char piece[PIECE_BYTES];
    while (n > 0) {
        vv_status st = wait_for_more(p, job);
        if (st != VV_OK)
            return st;
        const ssize_t got = recv(p->socket, piece, n < sizeof piece ? (size_t)n : sizeof piece, MSG_DONTWAIT);
        if (got < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (got <= 0)
            return fail_dead(p);
        vvi_text_add_n(to, piece, (size_t)got);
        n -= (uint64_t)got;
        if (to->bad) {
            end(p, 0);
            return vv_fail_memory(to->n);
        }
    }
    return VV_OK;
}

vv_status vvi_import_receive(vvi_import_process *p, vvi_wire_kind *kind_out, vvi_wire_in *out, vv_job *job)
{
    const vv_limits *limits = vvi_job_limits(job);
    vvi_wire_head head;
    vvi_text *body = &p->body;
    body->n = 0;
    vv_status st = receive_bytes(p, body, sizeof head, job);
    if (st != VV_OK)
        return st;
    memcpy(&head, body->s, sizeof head);
    body->n = 0;
    if (head.magic != VVI_WIRE_MAGIC || head.kind < VVI_WIRE_LOG || head.kind > VVI_WIRE_FAILED)
        return vvi_import_nonsense(p, "no message");
    if (head.n_bytes > limits->header_bytes + MESSAGE_SLACK)
        return vvi_import_nonsense(p, "a message that is too long");
    /* as many as there may be notes of every kind, and log lines; reports of progress come at most 20 a second */
    if (head.kind != VVI_WIRE_PROGRESS && p->messages++ > 6 * limits->metadata_keys + 4096)
        return vvi_import_nonsense(p, "messages without end");
    if ((st = receive_bytes(p, body, head.n_bytes, job)) != VV_OK)
        return st;
    p->asked_s = vvi_os_seconds();
    *kind_out = (vvi_wire_kind)head.kind;
    *out = (vvi_wire_in){.bytes = body->s ? body->s : "", .n = body->n};
    return VV_OK;
}
