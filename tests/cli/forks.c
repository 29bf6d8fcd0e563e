/* The program, started once and run many times: loading its libraries takes ten times as long as reading a small file.
 *
 * Preloaded into the program (LD_PRELOAD), this takes the place of its main(): it waits for runs on the socket that
 * LIBFORKS_SOCKET names, and for each forks a child that calls the program's own main(). Until then nothing of the
 * program has run but what the loader runs, so that a child is as a program that was just started. tests/cli/harness.py
 * is the other end.
 *
 * A run is asked for with the length of what follows and three descriptors (input, output, errors), then the folder,
 * the number of words, the words, and the environment, each with a NUL behind it. Answered are the child's number, at
 * once, and at its end what wait4() says: status, microseconds of the processor.
 */
#include <dlfcn.h>
#include <errno.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

typedef int main_function(int, char **, char **);
typedef int start_function(main_function *, int, char **, void (*)(void), void (*)(void), void (*)(void), void *);

static main_function *program_main;
static int runs_socket;

struct answer {
    int64_t pid, status;
};

static bool read_all(void *out, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t got = read(runs_socket, (char *)out + at, n - at);
        if (got <= 0 && !(got < 0 && errno == EINTR))
            return false;
        at += got > 0 ? (size_t)got : 0;
    }
    return true;
}

/* The length of a request, and the descriptors that come with it. */
static bool receive(uint32_t *length_out, int fds_out[3])
{
    union {
        struct cmsghdr head;
        char room[CMSG_SPACE(3 * sizeof(int))];
    } control;
    struct iovec into = {length_out, sizeof *length_out};
    struct msghdr message = {
        .msg_iov = &into, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    const ssize_t got = recvmsg(runs_socket, &message, MSG_CMSG_CLOEXEC | MSG_WAITALL);
    const struct cmsghdr *head = CMSG_FIRSTHDR(&message);
    if (got != (ssize_t)sizeof *length_out || !head || head->cmsg_len != CMSG_LEN(3 * sizeof(int)))
        return false;
    memcpy(fds_out, CMSG_DATA(head), 3 * sizeof(int));
    return true;
}

/* In the child: everything as a shell would leave it, then the program. */
static _Noreturn void run(char *request, size_t length, const int fds[3])
{
    size_t n = 0;
    for (size_t i = 0; i < length; i++)
        n += request[i] == 0;
    char **texts = calloc(n + 1, sizeof *texts); /* folder, number of words, words, environment */
    if (!texts || n < 2)
        _exit(126);
    for (size_t i = 0; i < n; i++) {
        texts[i] = request;
        request += strlen(request) + 1;
    }
    const size_t n_words = strtoul(texts[1], NULL, 10);
    if (n < 2 + n_words || chdir(texts[0]) != 0)
        _exit(126);
    environ = texts + 2 + n_words;
    char **words = calloc(n_words + 1, sizeof *words);
    if (!words)
        _exit(126);
    memcpy(words, texts + 2, n_words * sizeof *words);
    for (int i = 0; i < 3; i++) {
        if (dup2(fds[i], i) < 0)
            _exit(126);
    }
    close(runs_socket);
    const int code = program_main((int)n_words, words, environ);
    if (dlsym(RTLD_DEFAULT, "__asan_init") || dlsym(RTLD_DEFAULT, "__tsan_init"))
        exit(code); /* they look for leaks then */
    fflush(NULL);
    _exit(
        code); /* destructors of libraries would touch, and so copy, the whole heap: half of the time of a short run */
}

static bool serve_one(void)
{
    uint32_t length;
    int fds[3];
    if (!receive(&length, fds))
        return false;
    char *request = malloc(length ? length : 1);
    if (!request || !read_all(request, length))
        return false;
    const pid_t pid = fork();
    if (pid == 0)
        run(request, length, fds);
    free(request);
    for (int i = 0; i < 3; i++)
        close(fds[i]);
    struct answer answer = {.pid = pid};
    if (pid < 0 || write(runs_socket, &answer, sizeof answer) != (ssize_t)sizeof answer)
        return false;
    int status;
    while (waitpid(pid, &status, 0) < 0) {
        if (errno != EINTR)
            return false;
    }
    answer.status = status;
    return write(runs_socket, &answer, sizeof answer) == (ssize_t)sizeof answer;
}

static int serve(int argc, char **argv, char **env)
{
    (void)argc, (void)argv, (void)env;
    const char *named = getenv("LIBFORKS_SOCKET");
    runs_socket = named ? atoi(named) : -1;
    while (serve_one())
        ;
    _exit(0);
}

int __libc_start_main(main_function *main, int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*loader_fini)(void), void *stack);
int __libc_start_main(main_function *main, int argc, char **argv, void (*init)(void), void (*fini)(void),
                      void (*loader_fini)(void), void *stack)
{
    start_function *start = (start_function *)(intptr_t)dlsym(RTLD_NEXT, "__libc_start_main");
    program_main = main;
    return start(serve, argc, argv, init, fini, loader_fini, stack);
}
