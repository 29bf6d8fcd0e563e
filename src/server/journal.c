#include "server/journal.h"
#include "core/json_text.h"
#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#define READ_MOST ((off_t)1 << 30)      /* of one that an older version wrote */
#define LONG_BYTES ((off_t)16 << 20)    /* then the World as it is takes the place of the lines */
#define LINE_BYTES ((size_t)2048 << 10) /* of the longest line, twice: so much is free for them at least */
enum { KEPT_MOST = 1000 };

struct vvi_journal {
    int fd;
    char *folder, *path, *kept;
    off_t whole, before; /* bytes of whole lines, and before the last of them was added */
    off_t begun;         /* of the World that the lines begin with, when it took the place of others */
    bool unsynced, misses, cut;
    bool torn; /* there may be part of a line behind the whole ones */
    uint64_t lost;
};

static int open_locked(const char *path, int more)
{
    const int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | more, 0600);
    if (fd >= 0 && flock(fd, LOCK_EX | LOCK_NB) != 0) {
        close(fd);
        errno = EWOULDBLOCK;
        return -1;
    }
    return fd;
}

static void free_journal(vvi_journal *j)
{
    if (j->fd >= 0)
        close(j->fd);
    free(j->folder);
    free(j->path);
    free(j->kept);
    free(j);
}

vv_status vvi_journal_open(vvi_journal **out, const char *folder)
{
    *out = NULL;
    vvi_journal *j = vvi_calloc(1, sizeof *j);
    if (!j)
        return vv_fail_memory(sizeof *j);
    j->fd = -1;
    j->folder = vvi_strdup(folder);
    j->path = vvi_asprintf("%s/journal.jsonl", folder);
    if (!j->folder || !j->path) {
        free_journal(j);
        return vv_fail_memory(strlen(folder));
    }
    j->fd = open_locked(j->path, 0);
    if (j->fd >= 0) {
        *out = j;
        return VV_OK;
    }
    const int error = errno;
    free_journal(j);
    return error == EWOULDBLOCK
               ? vv_fail_at(VV_E_ARGUMENT, folder, NULL, "another server uses this folder for its session")
               : vv_fail_at(VV_E_WRITE, folder, NULL, "the journal cannot be opened: %s", strerror(error));
}

/* Whether something else has its name: another server's, which began after the folder was removed. */
static bool is_replaced(const vvi_journal *j)
{
    struct stat ours, there;
    return fstat(j->fd, &ours) == 0 && lstat(j->path, &there) == 0 &&
           (ours.st_ino != there.st_ino || ours.st_dev != there.st_dev);
}

void vvi_journal_close(vvi_journal *j, bool keep)
{
    if (!j)
        return;
    if (keep)
        vvi_journal_sync(j);
    else if (!is_replaced(j))
        unlink(j->path);
    free_journal(j);
}

/* Writing --------------------------------------------------------------------------------------------------------- */

static bool write_all(int fd, const char *text, size_t n, off_t at)
{
    while (n > 0) {
        const ssize_t done = pwrite(fd, text, n, at);
        if (done < 0 && errno != EINTR)
            return false;
        text += done > 0 ? done : 0;
        at += done > 0 ? done : 0;
        n -= done > 0 ? (size_t)done : 0;
    }
    return true;
}

static vv_status fail_full(const vvi_journal *j, int error)
{
    return vv_fail_at(VV_E_WRITE, j->path, NULL,
                      "a change that cannot be kept for the case of a crash is not made: %s; %s and do it again",
                      strerror(error),
                      error == EFBIG ? "raise the limit on the size of files (ulimit -f, prlimit --fsize)"
                                     : "make room on that disk");
}

static vv_status fail_replaced(const vvi_journal *j)
{
    return vv_fail_at(VV_E_WRITE, j->path, NULL,
                      "a change that cannot be kept for the case of a crash is not made: another journal has taken the "
                      "place of this one; save the scene, and start this server again");
}

/* Whole lines take the place of all, in one step: a crash leaves the old ones or these. */
static vv_status put_instead(vvi_journal *j, const char *text, size_t n)
{
    if (is_replaced(j))
        return fail_replaced(j);
    char *fresh = vvi_asprintf("%s/journal.new", j->folder);
    if (!fresh)
        return vv_fail_memory(strlen(j->folder));
    const int fd = open_locked(fresh, O_TRUNC);
    const bool fine = fd >= 0 && write_all(fd, text, n, 0) && fsync(fd) == 0 && rename(fresh, j->path) == 0;
    const int error = errno;
    if (!fine && fd >= 0) {
        unlink(fresh);
        close(fd);
    }
    free(fresh);
    if (!fine)
        return fail_full(j, error);
    close(j->fd);
    j->fd = fd;
    j->whole = j->before = (off_t)n;
    j->torn = j->unsynced = false;
    return VV_OK;
}

/* The line with its end; NULL without memory. */
static char *text_of(json_t *line, size_t *n)
{
    char *text = line ? vvi_json_encode(line, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(line);
    *n = text ? strlen(text) + 1 : 0;
    if (text)
        text[*n - 1] = '\n'; /* no text any more */
    return text;
}

static vv_status append(vvi_journal *j, const char *text, size_t n)
{
    if (j->misses)
        return vv_fail_at(VV_E_WRITE, j->path, NULL, "lacks what was done before");
    if (is_replaced(j))
        return fail_replaced(j);
    if (j->whole + (off_t)n > VVI_JOURNAL_MOST)
        return vv_fail_at(VV_E_LIMIT, j->path, NULL, "would grow beyond %d MiB", VVI_JOURNAL_MOST >> 20);
    if (j->torn && ftruncate(j->fd, j->whole) != 0)
        return vv_fail_at(VV_E_WRITE, j->path, NULL, "cannot be cut off: %s", strerror(errno));
    if (!write_all(j->fd, text, n, j->whole)) {
        const int error = errno;
        j->torn = ftruncate(j->fd, j->whole) != 0;
        return fail_full(j, error);
    }
    j->before = j->whole;
    j->whole += (off_t)n;
    j->torn = false;
    j->unsynced = true;
    return VV_OK;
}

vv_status vvi_journal_add(vvi_journal *j, json_t *line)
{
    size_t n;
    if (!j) {
        json_decref(line);
        return VV_OK;
    }
    char *text = text_of(line, &n);
    const vv_status st = text ? append(j, text, n) : vv_fail_memory(1024);
    free(text);
    return st;
}

void vvi_journal_take_back(vvi_journal *j)
{
    if (!j || j->whole == j->before)
        return;
    j->whole = j->before;
    j->torn = ftruncate(j->fd, j->whole) != 0;
}

void vvi_journal_miss(vvi_journal *j)
{
    if (j)
        j->misses = true;
}

bool vvi_journal_is_gone(const vvi_journal *j)
{
    struct stat info;
    return j && lstat(j->path, &info) != 0 && (errno == ENOENT || errno == ENOTDIR);
}

bool vvi_journal_wants_world(const vvi_journal *j, bool *must)
{
    *must = j && j->misses;
    return *must || (j && j->whole > LONG_BYTES && j->whole > 4 * j->begun);
}

vv_status vvi_journal_begin(vvi_journal *j, json_t *world)
{
    size_t n;
    char *text = text_of(world, &n);
    vv_status st = text ? VV_OK : vv_fail_memory(1024);
    if (st == VV_OK && n > VVI_JOURNAL_MOST - LINE_BYTES)
        st = vv_fail_at(VV_E_LIMIT, j->path, NULL, "the World is too large for a journal of %d MiB",
                        VVI_JOURNAL_MOST >> 20);
    if (st == VV_OK && (st = put_instead(j, text, n)) == VV_OK) {
        j->begun = j->whole;
        j->misses = false;
        j->cut = true;
    }
    free(text);
    return st;
}

bool vvi_journal_is_cut(const vvi_journal *j)
{
    return j && j->cut;
}

vv_status vvi_journal_clear(vvi_journal *j)
{
    if (!j)
        return VV_OK;
    j->torn = ftruncate(j->fd, 0) != 0;
    j->whole = j->before = j->begun = 0;
    j->misses = j->cut = false;
    return VV_OK;
}

vv_status vvi_journal_sync(vvi_journal *j)
{
    if (!j || !j->unsynced)
        return VV_OK;
    j->unsynced = false;
    if (fdatasync(j->fd) == 0 || errno == EINVAL || errno == EROFS)
        return VV_OK;
    const int error = errno;
    j->misses = true; /* which of its lines are there is not known */
    return vv_fail_at(VV_E_WRITE, j->path, NULL, "the last changes may not outlive a crash: %s", strerror(error));
}

/* Playing --------------------------------------------------------------------------------------------------------- */

static vv_status read_all(char **out, size_t *n_out, vvi_journal *j, off_t size)
{
    size_t n = 0;
    char *text = vvi_calloc((size_t)size + 1, 1);
    if (!text)
        return vv_fail_memory((size_t)size + 1);
    while (n < (size_t)size) {
        const ssize_t done = pread(j->fd, text + n, (size_t)size - n, (off_t)n);
        if (done < 0 && errno != EINTR) {
            free(text);
            return vv_fail_at(VV_E_READ, j->path, NULL, "cannot be read: %s", strerror(errno));
        }
        if (done == 0)
            break;
        n += done > 0 ? (size_t)done : 0;
    }
    *out = text;
    *n_out = n;
    return VV_OK;
}

/* The journal goes on with n bytes of text; the old one stays under another name. */
static vv_status keep_old(vvi_journal *j, const char *text, size_t n, const char *why)
{
    char *name = NULL;
    struct stat info;
    for (int i = 1; i <= KEPT_MOST; i++) {
        free(name);
        name = vvi_asprintf("%s/journal-%d.jsonl", j->folder, i);
        if (!name || (lstat(name, &info) != 0 && errno == ENOENT))
            break;
    }
    if (!name)
        return vv_fail_memory(strlen(j->folder));
    /* where there are no second names for a file, a crash right here leaves the old journal under its new one alone */
    vv_status st = link(j->path, name) == 0 || rename(j->path, name) == 0
                       ? VV_OK
                       : vv_fail_at(VV_E_WRITE, j->path, NULL, "cannot be kept as %s: %s", name, strerror(errno));
    if (st == VV_OK)
        st = put_instead(j, text, n);
    if (st == VV_OK) {
        free(j->kept);
        j->kept = vvi_asprintf("%s; it is kept as %s", why, name);
    }
    free(name);
    return st;
}

typedef struct playing {
    const char *text;
    size_t n, at; /* at: of the first line that is not played */
    uint64_t lines;
    char why[1024]; /* empty: no line was refused */
} playing;

static vv_status play_all(playing *p, const vvi_journal *j, vv_status (*play)(void *user, const json_t *line),
                          void *user)
{
    while (p->at < p->n) {
        const char *from = p->text + p->at, *end = memchr(from, '\n', p->n - p->at);
        vvi_json_flaw flaw;
        if (!end)
            return VV_OK;
        json_t *line = vvi_json_decode(from, (size_t)(end - from), 0, &flaw);
        if (!line && flaw.fault == VVI_JSON_MEMORY) /* the line is well */
            return vv_fail_memory((size_t)(end - from));
        const vv_status st = line ? play(user, line) : VV_E_FORMAT;
        const char *reason = line ? vv_error_last()->message : "is damaged";
        json_decref(line);
        if (st == VV_E_MEMORY || st == VV_E_CANCELLED)
            return st;
        if (st != VV_OK) {
            snprintf(p->why, sizeof p->why, "%s: line %llu cannot be played: %s", j->path,
                     (unsigned long long)p->lines + 1, reason);
            return VV_OK;
        }
        p->at = (size_t)(end - p->text) + 1;
        p->lines++;
    }
    return VV_OK;
}

/* What was being written when the session broke off, which nobody was told was done. */
static vv_status cut_off_rest(vvi_journal *j, const playing *p)
{
    if (p->at < p->n && !(j->kept = vvi_asprintf("%s: line %llu was cut off when the session broke off, and is left "
                                                 "out: the last change may be missing",
                                                 j->path, (unsigned long long)p->lines + 1)))
        return vv_fail_memory(strlen(j->path));
    j->torn = ftruncate(j->fd, (off_t)p->at) != 0;
    return VV_OK;
}

static uint64_t lines_from(const playing *p)
{
    uint64_t lines = 0;
    for (size_t i = p->at; i < p->n; i++)
        lines += p->text[i] == '\n';
    return lines;
}

vv_status vvi_journal_replay(uint64_t *n_out, vvi_journal *j, vv_status (*play)(void *user, const json_t *line),
                             void *user)
{
    struct stat info;
    char *text = NULL;
    playing p = {.at = 0};
    *n_out = j->lost = 0;
    free(j->kept);
    j->kept = NULL;
    if (fstat(j->fd, &info) != 0)
        return vv_fail_at(VV_E_READ, j->path, NULL, "cannot be read: %s", strerror(errno));
    if (info.st_size > READ_MOST) {
        snprintf(p.why, sizeof p.why, "%s: is too large for a journal (%lld MiB)", j->path,
                 (long long)(info.st_size >> 20));
        return keep_old(j, "", 0, p.why);
    }
    vv_status st = read_all(&text, &p.n, j, info.st_size);
    p.text = text;
    if (st == VV_OK)
        st = play_all(&p, j, play, user);
    if (st == VV_OK) {
        j->lost = lines_from(&p);
        *n_out = p.lines;
        st = *p.why ? keep_old(j, text, p.at, p.why) : cut_off_rest(j, &p);
    }
    if (st == VV_OK)
        j->whole = j->before = (off_t)p.at;
    free(text);
    return st;
}

uint64_t vvi_journal_lost(const vvi_journal *journal)
{
    return journal->lost;
}

const char *vvi_journal_kept(const vvi_journal *journal)
{
    return journal->kept;
}
