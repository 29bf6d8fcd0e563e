/* What the import program may open: the file or folder that it was handed, what a header may name beside it, and
 * temporary files that are open before. */
#include "core/job.h"
#include "io/format.h"
#include "lock.h"
#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <volvis/sys/registry.h>

/* The kernel's own numbers (linux/landlock.h), since the headers of a system may be older than what it runs on. */
#ifndef SYS_landlock_create_ruleset
#define SYS_landlock_create_ruleset 444
#define SYS_landlock_add_rule 445
#define SYS_landlock_restrict_self 446
#endif
enum {
    WRITE_FILE = 1 << 1,
    READ_FILE = 1 << 2,
    READ_DIR = 1 << 3,
    TRUNCATE = 1 << 14,
    ASK_VERSION = 1,
    RULE_BENEATH = 1
};
typedef struct rules {
    uint64_t files, net, scoped;
} rules;
typedef struct rule {
    uint64_t allowed;
    int32_t beneath;
} __attribute__((packed)) rule;

/* -1: the kernel has no Landlock, or it is turned off. */
static int landlock_version(void)
{
    return (int)syscall(SYS_landlock_create_ruleset, NULL, 0, ASK_VERSION);
}

/* All that this version of it can restrict. */
static int new_rules(int version)
{
    static const uint64_t files[] = {0x1fff, 0x3fff, 0x7fff, 0x7fff, 0xffff};
    const rules all = {
        .files = files[version < 5 ? version - 1 : 4], .net = version >= 4 ? 3 : 0, .scoped = version >= 6 ? 3 : 0};
    const size_t n = version >= 6 ? sizeof all : version >= 4 ? 2 * sizeof(uint64_t) : sizeof(uint64_t);
    return (int)syscall(SYS_landlock_create_ruleset, &all, n, 0);
}

static void allow(int set, int fd, uint64_t allowed, int version)
{
    struct stat about;
    if (fd < 0 || fstat(fd, &about) != 0)
        return;
    if (!S_ISDIR(about.st_mode))
        allowed &= ~(uint64_t)READ_DIR;
    if (version < 3)
        allowed &= ~(uint64_t)TRUNCATE;
    const rule r = {allowed, fd};
    syscall(SYS_landlock_add_rule, set, RULE_BENEATH, &r, 0); /* what has no place in a tree needs no rule: pipes */
}

/* What is not hidden: keys and settings of people are. Links are no files of the folder. */
static void allow_entries(int set, int folder, uint64_t most, int version)
{
    const int listed = openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    DIR *dir = listed >= 0 ? fdopendir(listed) : NULL;
    const struct dirent *e;
    allow(set, folder, READ_DIR, version);
    for (uint64_t n = 0; dir && n < most && (e = readdir(dir)) != NULL;) {
        const int fd = e->d_name[0] != '.' ? openat(folder, e->d_name, O_PATH | O_NOFOLLOW | O_CLOEXEC) : -1;
        if (fd < 0)
            continue;
        allow(set, fd, READ_FILE | READ_DIR, version);
        close(fd);
        n++;
    }
    if (dir)
        closedir(dir);
}

/* Which may be read -------------------------------------------------------------------------------------------------
 */

static bool has_suffix(const char *const *suffixes, const char *path, size_t n)
{
    for (; suffixes && *suffixes; suffixes++) {
        const size_t m = strlen(*suffixes);
        if (n >= m && strncasecmp(path + n - m, *suffixes, m) == 0)
            return true;
    }
    return false;
}

/* Whether n bytes, the beginning of a text, have a word, in whatever case. */
static bool has_word(const char *text, size_t n, const char *word)
{
    const size_t m = strlen(word);
    for (size_t i = 0; i + m <= n; i++)
        if (strncasecmp(text + i, word, m) == 0)
            return true;
    return false;
}

/* Of two formats whose headers say so within their beginning: the samples are in the file itself, as in most of theirs.
 * What a header hides from this (a word of it that stands elsewhere) leaves the file more, never less. */
static bool names_no_file(const char *head, size_t n)
{
    const char *end = memmem(head, n, "\n\n", 2);
    if (!end)
        end = memmem(head, n, "\r\n\r\n", 4);
    if (n > 4 && memcmp(head, "NRRD", 4) == 0)
        return end && !has_word(head, (size_t)(end - head), "data file") &&
               !has_word(head, (size_t)(end - head), "datafile");
    const char *data = memmem(head, n, "\nElementDataFile = LOCAL", 24);
    return has_word(head, n < 64 ? n : 64, "ObjectType") && data &&
           memchr(data + 24, '\n', n - (size_t)(data + 24 - head));
}

/* Whether a format that may mean the file looks for others beside it. */
static bool looks_beside(int fd, const char *path, const char *format, const vv_registry *registry)
{
    uint8_t head[4096];
    size_t n_path;
    const ssize_t n = pread(fd, head, sizeof head, 0);
    vvi_path_coding(path, &n_path);
    if (n > 0 && names_no_file((const char *)head, (size_t)n))
        return false;
    for (size_t i = 0; registry->formats[i]; i++) {
        const vv_format *f = registry->formats[i];
        if (f->beside && ((format && strcmp(f->name, format) == 0) || has_suffix(f->suffixes, path, n_path) ||
                          (n > 0 && f->probe && f->probe(head, (size_t)n, path))))
            return true;
    }
    for (size_t i = 0; registry->mesh_formats[i]; i++) {
        const vv_mesh_format *f = registry->mesh_formats[i];
        if (f->beside && ((format && strcmp(f->name, format) == 0) || has_suffix(f->suffixes, path, n_path) ||
                          (n > 0 && f->probe && f->probe(head, (size_t)n, path))))
            return true;
    }
    return false;
}

/* The folder in which the file lies by its name, if it does: either may have been exchanged since it was opened. */
static int folder_of(const char *path, int file, bool confined)
{
    struct stat a, b;
    const char *slash = strrchr(path, '/'), *name = slash ? slash + 1 : path;
    char *folder = slash ? strndup(path, (size_t)(slash - path) + 1) : strdup(".");
    const int fd = folder ? open(folder, O_PATH | O_DIRECTORY | O_CLOEXEC) : -1;
    free(folder);
    if (fd >= 0 && fstat(file, &a) == 0 && fstatat(fd, name, &b, confined ? AT_SYMLINK_NOFOLLOW : 0) == 0 &&
        a.st_dev == b.st_dev && a.st_ino == b.st_ino)
        return fd;
    if (fd >= 0)
        close(fd);
    return -1;
}

static void open_spares(int spares[VVI_SPARES])
{
    const char *folder = getenv("TMPDIR");
    folder = folder && *folder ? folder : "/tmp";
    for (int i = 0; i < VVI_SPARES; i++)
        spares[i] = open(folder, O_TMPFILE | O_RDWR | O_CLOEXEC, 0600);
}

bool import_lock_files(const import_file *file, vv_job *job, uint64_t files_most)
{
    const vv_registry *registry = vvi_job_registry(job);
    int fd = file->descriptor, folder = -1, spares[VVI_SPARES];
    struct stat about = {0};
    if (fd < 0 && strcmp(file->path, "-") != 0)
        fd = open(file->path, O_RDONLY | O_CLOEXEC | O_NOCTTY);
    const bool regular = fd >= 0 && fstat(fd, &about) == 0 && S_ISREG(about.st_mode);
    if (regular)
        folder = folder_of(file->path, fd, file->confined);
    if (fd >= 0)
        vvi_job_lend_file(job, file->path, fd, folder);
    import_load_modules(file, fd, registry);
    open_spares(spares);
    vvi_job_lend_spares(job, spares);
    const int version = import_locks_nothing() ? 0 : landlock_version(), set = version > 0 ? new_rules(version) : -1;
    if (set < 0)
        return import_locks_nothing();
    allow(set, fd, READ_FILE | READ_DIR, version);
    allow(set, STDIN_FILENO, READ_FILE, version);
    for (int i = 0; i < VVI_SPARES; i++)
        allow(set, spares[i], READ_FILE | WRITE_FILE | TRUNCATE, version);
    if (folder >= 0 && looks_beside(fd, file->path, file->format, registry))
        allow_entries(set, folder, files_most, version);
    if (vvi_job_allow_outside(job)) {
        const int all = open("/", O_PATH | O_DIRECTORY | O_CLOEXEC);
        allow(set, all, READ_FILE | READ_DIR, version);
        close(all);
    }
    const bool locked = syscall(SYS_landlock_restrict_self, set, 0) == 0;
    close(set);
    return locked;
}
