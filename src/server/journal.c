#include "server/journal.h"
#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define BYTES_MOST ((off_t)1 << 30)

struct vvi_journal {
    int fd;
    char *path;
    bool unsynced, broken;
    uint64_t lost;
};

vv_status vvi_journal_open(vvi_journal **out, const char *folder)
{
    *out = NULL;
    vvi_journal *j = vvi_calloc(1, sizeof *j);
    if (!j)
        return vv_fail_memory(sizeof *j);
    j->path = vvi_asprintf("%s/journal.jsonl", folder);
    j->fd = j->path ? open(j->path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600) : -1;
    vv_status st = VV_OK;
    if (j->fd < 0)
        st = vv_fail_at(VV_E_WRITE, folder, NULL, "the journal cannot be opened: %s", strerror(errno));
    else if (flock(j->fd, LOCK_EX | LOCK_NB) != 0)
        st = vv_fail_at(VV_E_ARGUMENT, folder, NULL, "another server uses this folder for its session");
    if (st == VV_OK) {
        *out = j;
        return VV_OK;
    }
    if (j->fd >= 0)
        close(j->fd);
    free(j->path);
    free(j);
    return st;
}

void vvi_journal_close(vvi_journal *j, bool keep)
{
    if (!j)
        return;
    if (keep)
        vvi_journal_sync(j);
    else
        unlink(j->path);
    close(j->fd);
    free(j->path);
    free(j);
}

static vv_status read_all(char **out, size_t *n_out, vvi_journal *j)
{
    struct stat info;
    size_t n = 0;
    if (fstat(j->fd, &info) != 0 || info.st_size > BYTES_MOST)
        return vv_fail_at(VV_E_READ, j->path, NULL, "is too large for a journal, or cannot be read");
    char *text = vvi_calloc((size_t)info.st_size + 1, 1);
    if (!text)
        return vv_fail_memory((size_t)info.st_size + 1);
    while (n < (size_t)info.st_size) {
        const ssize_t done = pread(j->fd, text + n, (size_t)info.st_size - n, (off_t)n);
        if (done == 0 || (done < 0 && errno != EINTR))
            break;
        n += done > 0 ? (size_t)done : 0;
    }
    *out = text;
    *n_out = n;
    return VV_OK;
}

vv_status vvi_journal_replay(uint64_t *n_out, vvi_journal *j, vv_status (*play)(void *user, const json_t *line),
                             void *user)
{
    char *text = NULL;
    size_t n = 0, at = 0;
    vv_status st = read_all(&text, &n, j);
    *n_out = 0;
    while (st == VV_OK && at < n) {
        const char *end = memchr(text + at, '\n', n - at);
        json_t *line = end ? json_loadb(text + at, (size_t)(end - text) - at, 0, NULL) : NULL;
        if (!line)
            break;
        st = play(user, line);
        json_decref(line);
        if (st == VV_OK) {
            at = (size_t)(end - text) + 1;
            ++*n_out;
        }
    }
    j->lost = 0;
    for (size_t i = at; st == VV_OK && i < n; i++)
        j->lost += text[i] == '\n';
    free(text);
    if (ftruncate(j->fd, st == VV_OK ? (off_t)at : 0) != 0 || lseek(j->fd, 0, SEEK_END) < 0)
        j->broken = true;
    return st;
}

uint64_t vvi_journal_lost(const vvi_journal *journal)
{
    return journal->lost;
}

static bool write_all(int fd, const char *text, size_t n)
{
    while (n > 0) {
        const ssize_t done = write(fd, text, n);
        if (done < 0 && errno != EINTR)
            return false;
        text += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return true;
}

vv_status vvi_journal_add(vvi_journal *j, json_t *line)
{
    char *text = line && j && !j->broken ? json_dumps(line, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(line);
    if (!j || j->broken)
        return VV_OK;
    const bool fine = text && write_all(j->fd, text, strlen(text)) && write_all(j->fd, "\n", 1);
    free(text);
    j->unsynced = true;
    j->broken = !fine;
    return fine ? VV_OK
                : vv_fail_at(VV_E_WRITE, j->path, NULL, "changes are no longer kept in case of a crash: %s",
                             strerror(errno));
}

vv_status vvi_journal_clear(vvi_journal *j)
{
    if (j && !j->broken && (ftruncate(j->fd, 0) != 0 || lseek(j->fd, 0, SEEK_SET) != 0))
        j->broken = true;
    return VV_OK;
}

void vvi_journal_sync(vvi_journal *j)
{
    if (j && j->unsynced && !j->broken)
        fdatasync(j->fd);
    if (j)
        j->unsynced = false;
}
