/* The import program with one more format, whose reader does what a hostile file might make a reader do. A file of it
 * is "HOSTILE WHEN WHAT": when is "open" or "read". It is 2 x 2 x 2 u8. */
#include "core/job.h"
#include "import/import_wire.h"
#include "io/notes.h"
#include "io/source.h"
#include "lock.h"
#include "serve.h"
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

/* Volatile, so that no compiler is wiser than the hostile file. */
static volatile unsigned sink;
static volatile int never;
static int *volatile nowhere = (int *)8;

static vv_status do_crash(vv_job *job)
{
    (void)job;
    *nowhere = 1;
    return VV_OK;
}

static vv_status do_abort(vv_job *job)
{
    (void)job;
    abort();
}

static vv_status do_loop(vv_job *job)
{
    (void)job;
    while (!never)
        sink++;
    return VV_OK;
}

static vv_status do_sleep(vv_job *job)
{
    (void)job;
    while (!never)
        pause();
    return VV_OK;
}

static int overflow(int n)
{
    volatile char room[4096];
    room[n % 4096] = (char)n;
    return never ? 0 : overflow(n + 1) + room[(n + 1) % 4096];
}

static vv_status do_recurse(vv_job *job)
{
    (void)job;
    sink = overflow(1);
    return VV_OK;
}

/* All that it can get, touched. */
static vv_status do_allocate(vv_job *job)
{
    (void)job;
    size_t n = 0;
    for (char *p; (p = malloc((size_t)16 << 20)) != NULL; n++)
        memset(p, 1, (size_t)16 << 20);
    return vv_fail(VV_E_MEMORY, "got %zu times 16 MiB", n);
}

static vv_status do_exec(vv_job *job)
{
    (void)job;
    execl("/bin/true", "true", (char *)NULL);
    return vv_fail(VV_E_INTERNAL, "exec: %s", strerror(errno));
}

static vv_status do_fork(vv_job *job)
{
    (void)job;
    return fork() < 0 ? vv_fail(VV_E_INTERNAL, "fork: %s", strerror(errno)) : VV_OK;
}

static vv_status do_socket(vv_job *job)
{
    (void)job;
    return socket(AF_INET, SOCK_STREAM, 0) < 0 ? vv_fail(VV_E_INTERNAL, "socket: %s", strerror(errno)) : VV_OK;
}

static vv_status do_kill(vv_job *job)
{
    (void)job;
    return kill(getppid(), SIGTERM) < 0 ? vv_fail(VV_E_INTERNAL, "kill: %s", strerror(errno)) : VV_OK;
}

static vv_status try_open(int flags)
{
    char name[64];
    snprintf(name, sizeof name, "/tmp/volvis-hostile-%d", (int)getpid());
    const int fd = open(name, flags, 0600);
    return fd < 0 ? vv_fail(VV_E_INTERNAL, "open: %s", strerror(errno)) : VV_OK;
}

static vv_status do_create(vv_job *job)
{
    (void)job;
    return try_open(O_CREAT | O_WRONLY);
}

static vv_status do_write(vv_job *job)
{
    (void)job;
    return try_open(O_RDWR);
}

static vv_status do_truncate(vv_job *job)
{
    (void)job;
    return try_open(O_RDONLY | O_TRUNC);
}

static vv_status do_unlink(vv_job *job)
{
    (void)job;
    return unlink("/tmp/volvis-hostile-none") < 0 ? vv_fail(VV_E_INTERNAL, "unlink: %s", strerror(errno)) : VV_OK;
}

/* A name for a file that has none. */
static vv_status do_link(vv_job *job)
{
    char name[64];
    const int fd = vvi_job_take_spare(job);
    if (fd < 0)
        return vv_fail(VV_E_INTERNAL, "tmpfile: %s", strerror(errno));
    snprintf(name, sizeof name, "/proc/self/fd/%d", fd);
    return linkat(AT_FDCWD, name, AT_FDCWD, "/tmp/volvis-hostile-link", AT_SYMLINK_FOLLOW) < 0
               ? vv_fail(VV_E_INTERNAL, "link: %s", strerror(errno))
               : VV_OK;
}

static vv_status do_code(vv_job *job)
{
    (void)job;
    void *p = mmap(NULL, 4096, PROT_READ | PROT_WRITE | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    return p == MAP_FAILED ? vv_fail(VV_E_FORMAT, "no code: %s", strerror(errno)) : VV_OK;
}

static vv_status do_fill(vv_job *job)
{
    static char piece[1 << 20];
    const int fd = vvi_job_take_spare(job);
    for (int i = 0; i < 64; i++) {
        if (write(fd, piece, sizeof piece) < 0)
            return vv_fail(VV_E_FORMAT, "full after %d MiB: %s", i, strerror(errno));
    }
    return VV_OK;
}

/* Nothing of what it was not handed: neither what all may read, nor what lies beside. */
static vv_status do_look(vv_job *job)
{
    static const char *const names[] = {"/etc/passwd", "/proc/self/environ", "/", "."};
    (void)job;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        if (open(names[i], O_RDONLY) >= 0)
            return vv_fail(VV_E_FORMAT, "%s was opened", names[i]);
    return VV_OK;
}

static char beside[4096]; /* a file next to the one that is read */

static vv_status do_beside(vv_job *job)
{
    (void)job;
    return open(beside, O_RDONLY) >= 0 ? VV_OK : vv_fail(VV_E_FORMAT, "%s was not opened", beside);
}

static vv_status do_alone(vv_job *job)
{
    (void)job;
    return open(beside, O_RDONLY) < 0 ? VV_OK : vv_fail(VV_E_FORMAT, "%s was opened", beside);
}

static vv_status do_exit(vv_job *job)
{
    (void)job;
    _exit(3);
}

static vv_status do_progress(vv_job *job)
{
    vv_status st = VV_OK;
    for (uint64_t i = 0; i <= 500 && st == VV_OK; i++) {
        st = vvi_job_progress(job, "read", i, 500);
        usleep(1000);
    }
    return st;
}

static vv_status do_nothing(vv_job *job)
{
    (void)job;
    return VV_OK;
}

static void *twice(void *user)
{
    *(int *)user *= 2;
    return NULL;
}

static vv_status do_thread(vv_job *job)
{
    (void)job;
    pthread_t thread;
    int n = 21;
    if (pthread_create(&thread, NULL, twice, &n) != 0 || pthread_join(thread, NULL) != 0 || n != 42)
        return vv_fail(VV_E_INTERNAL, "no threads");
    return VV_OK;
}

typedef struct deed {
    char what[16];
    bool at_read;
} deed;

static vv_status perform(const char *what, vv_job *job)
{
    static const struct {
        const char *name;
        vv_status (*run)(vv_job *job);
    } deeds[] = {
        {"crash", do_crash},       {"abort", do_abort},       {"loop", do_loop},         {"sleep", do_sleep},
        {"recurse", do_recurse},   {"allocate", do_allocate}, {"exec", do_exec},         {"fork", do_fork},
        {"socket", do_socket},     {"kill", do_kill},         {"create", do_create},     {"write", do_write},
        {"truncate", do_truncate}, {"unlink", do_unlink},     {"link", do_link},         {"code", do_code},
        {"fill", do_fill},         {"exit", do_exit},         {"progress", do_progress}, {"nothing", do_nothing},
        {"thread", do_thread},     {"look", do_look},         {"beside", do_beside},     {"alone", do_alone},
    };
    for (size_t i = 0; i < sizeof deeds / sizeof deeds[0]; i++) {
        if (strcmp(deeds[i].name, what) == 0)
            return deeds[i].run(job);
    }
    return vv_fail(VV_E_ARGUMENT, "there is no deed '%s'", what);
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= 8 && memcmp(head, "HOSTILE ", 8) == 0 ? 2 : 0;
}

/* The same in the header of a format that may name files. */
static int probe_nrrd(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return n >= 8 && memcmp(head, "NRRD0004", 8) == 0 ? 2 : 0;
}

static vv_status read_header(vv_field_info *info_out, void **plan_out, vv_source *source,
                             const vv_read_options *options, vv_notes *notes, vv_job *job)
{
    char text[128], when[16], number[16];
    size_t n;
    (void)options;
    vv_status st = vvi_source_read_some(source, text, sizeof text - 1, &n);
    text[st == VV_OK ? n : 0] = 0;
    deed *d = calloc(1, sizeof *d);
    *plan_out = d;
    const char *name = vvi_source_name(source), *slash = strrchr(name, '/'), *words = strstr(text, "HOSTILE ");
    snprintf(beside, sizeof beside, "%.*s/plain.txt", slash ? (int)(slash - name) : 1, slash ? name : ".");
    if (!d || !words || sscanf(words, "HOSTILE %15s %15s", when, d->what) != 2)
        return vv_fail(VV_E_FORMAT, "no deed");
    snprintf(number, sizeof number, "%d", (int)getpid());
    vvi_notes_add(notes, "pid", number);
    for (int a = 0; a < 3; a++)
        info_out->grid.dims[a] = 2;
    d->at_read = strcmp(when, "read") == 0;
    return d->at_read ? VV_OK : perform(d->what, job);
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    void *data;
    const deed *d = plan;
    (void)source;
    (void)frame;
    (void)region;
    vv_status st = d->at_read ? perform(d->what, job) : VV_OK;
    if (st == VV_OK && (st = vv_field_new_empty(out, &data, info, job)) == VV_OK)
        memcpy(data, "\1\2\3\4\5\6\7\10", 8);
    return st;
}

/* The name is one that the other side knows. */
static const vv_format hostile = {
    .api = VV_FORMAT_API,
    .name = "raw",
    .doc = "does what it should not",
    .probe = probe,
    .read_header = read_header,
    .free_plan = free,
    .read = read_samples,
};

static const vv_format hostile_nrrd = {
    .api = VV_FORMAT_API,
    .name = "nrrd",
    .doc = "the same, and it may name files",
    .beside = true,
    .probe = probe_nrrd,
    .read_header = read_header,
    .free_plan = free,
    .read = read_samples,
};

int main(void)
{
    static const vv_format *const formats[] = {&hostile, &hostile_nrrd, NULL};
    vv_registry registry = *vv_registry_builtin();
    registry.formats = formats;
    /* sanitizers report such signals and exit; here the process has to die of them */
    signal(SIGSEGV, SIG_DFL);
    signal(SIGABRT, SIG_DFL);
    signal(SIGILL, SIG_DFL);
    import_lock_early();
    return import_serve(VVI_IMPORT_SOCKET, &registry);
}
