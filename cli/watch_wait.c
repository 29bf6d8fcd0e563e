#include "watch_wait.h"
#include "value.h"
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#ifdef __linux__
#include <sys/inotify.h>
#endif

/* Seconds that files have to be still: usually; where one was there and is gone, which may be replaced in a moment;
 * where somebody has it open and writes, who may think for a while, and may never close it. */
static const double still_s = 0.2, gone_s = 1, writing_s = 2;
/* Looks at all files; with very many of them no more than a twentieth of the time. */
static const double look_s = 1, look_share = 20;
enum { STILL_LOOK_MS = 50 };

#ifdef __linux__
static void watch_folder_of(int inotify, cli_watched_file *file)
{
    const uint32_t what = IN_MODIFY | IN_CLOSE_WRITE | IN_MOVED_TO | IN_MOVED_FROM | IN_CREATE | IN_DELETE;
    char *folder = cli_folder_of(file->path);
    file->folder = folder ? inotify_add_watch(inotify, folder, what | IN_ONLYDIR) : -1;
    free(folder);
    inotify_add_watch(inotify, file->path, what | IN_ONLYDIR); /* of a folder of slices; of a file it fails */
}

static int start(cli_watch *watches, size_t n)
{
    const int inotify = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
    for (size_t i = 0; i < n && inotify >= 0; i++)
        for (size_t f = 0; f < watches[i].files.n; f++)
            watch_folder_of(inotify, &watches[i].files.file[f]);
    return inotify;
}

static void mark(cli_watch_files *files, const struct inotify_event *event)
{
    for (size_t f = 0; f < files->n; f++) {
        cli_watched_file *file = &files->file[f];
        if (file->folder == event->wd && strcmp(cli_base_of(file->path), event->name) == 0)
            file->writing = (event->mask & IN_MODIFY) != 0;
    }
}

/* All that has happened since. Of very many files nobody asks which. */
static void drain(int inotify, cli_watch *watches, size_t n)
{
    enum { FILES_MOST = 4096 };
    _Alignas(struct inotify_event) char buffer[8192];
    for (ssize_t got; (got = read(inotify, buffer, sizeof buffer)) > 0;)
        for (ssize_t at = 0; at < got;) {
            const struct inotify_event *event = (const struct inotify_event *)(const void *)(buffer + at);
            for (size_t i = 0; i < n && event->len > 0; i++)
                if (watches[i].files.n <= FILES_MOST)
                    mark(&watches[i].files, event);
            at += (ssize_t)(sizeof *event + event->len);
        }
}
#else
static int start(cli_watch *watches, size_t n)
{
    (void)watches;
    (void)n;
    return -1;
}

static void drain(int inotify, cli_watch *watches, size_t n)
{
    (void)inotify;
    (void)watches;
    (void)n;
}
#endif

/* Until something happens or the time is over. */
static void doze(int inotify, cli_watch *watches, size_t n, int ms)
{
    struct pollfd news = {.fd = inotify, .events = POLLIN};
    if (poll(&news, 1, ms) > 0)
        drain(inotify, watches, n);
}

/* The number of one that has changed; n: none. */
static size_t look(const cli_watch *watches, size_t n)
{
    cli_file_state now;
    bool missing, writing;
    for (size_t i = 0; i < n; i++)
        if (cli_watch_files_changed(&watches[i].files, &now, &missing, &writing))
            return i;
    return n;
}

/* Until the files of one are still. False: they are after all what they were. */
static bool settle(int inotify, cli_watch *watches, size_t n, size_t changed)
{
    cli_file_state before = 0;
    double since_s = cli_now_s();
    for (;;) {
        cli_file_state now;
        bool missing, writing;
        const double start_s = cli_now_s();
        const bool differs = cli_watch_files_changed(&watches[changed].files, &now, &missing, &writing);
        if (!differs)
            return false;
        if (now != before)
            since_s = start_s;
        before = now;
        if (start_s - since_s >= (writing ? writing_s : missing ? gone_s : still_s))
            return true;
        poll(NULL, 0, STILL_LOOK_MS); /* events wait until then: one for each piece that is written is too many */
        doze(inotify, watches, n, 0);
    }
}

size_t cli_watch_wait(cli_watch *watches, size_t n)
{
    const int inotify = start(watches, n);
    for (;;) {
        const double start_s = cli_now_s();
        const size_t changed = look(watches, n);
        const double took_s = cli_now_s() - start_s;
        if (changed < n && settle(inotify, watches, n, changed)) {
            if (inotify >= 0)
                close(inotify);
            return changed;
        }
        if (changed == n)
            doze(inotify, watches, n, (int)(1000 * (took_s * look_share > look_s ? took_s * look_share : look_s)));
    }
}
