#include "server/line_file.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* A file ends again where its last n bytes began, if they are its last. False: it is no file, or others wrote to it. */
static bool cut_off(const vvi_line_file *file, size_t n)
{
    struct stat info;
    const off_t end = lseek(file->fd, 0, SEEK_CUR), start = end - (off_t)n;
    return fstat(file->fd, &info) == 0 && S_ISREG(info.st_mode) && info.st_size == end && start >= 0 &&
           ftruncate(file->fd, start) == 0 && lseek(file->fd, start, SEEK_SET) == start;
}

static bool write_all(vvi_line_file *file, const char *text, size_t n)
{
    for (size_t at = 0; at < n;) {
        const ssize_t done = write(file->fd, text + at, n - at);
        if (done < 0 && errno != EINTR) {
            file->error = errno;
            file->torn = file->torn && !(at > 0 && cut_off(file, at));
            return false;
        }
        at += done > 0 ? (size_t)done : 0;
        file->torn = at > 0 && at < n;
    }
    return true;
}

bool vvi_line_file_put(vvi_line_file *file, char *text)
{
    const size_t n = text ? strlen(text) : 0;
    if (text)
        text[n] = '\n'; /* in the place of its end: one call writes all of it */
    const bool fine = text && (!file->torn || write_all(file, "\n", 1)) && write_all(file, text, n + 1);
    if (!text)
        file->error = ENOMEM;
    free(text);
    return fine;
}
