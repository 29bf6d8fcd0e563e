/* Libraries that readers load when a file needs them, loaded before the lock falls: no code is mapped after that. They
 * cost every start 20 ms, so a file that is certainly of another format goes without. */
#include "config.h"
#include "io/coding.h"
#include "io/format.h"
#include "io/formats/dicom/dicom_gdcm.h"
#include "io/formats/steps/steps.h"
#include "lock.h"
#include "registry.h"
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#if VV_HAVE_GDCM
/* DICOM, or a collection whose files may be. */
static bool may_hold_dicom(const vv_format *format)
{
    return format == &vvi_format_dicom || format->free_plan == vvi_steps_free;
}

/* By the same signs as vvi_format_of_file(), each of which is enough here. */
static bool may_be_dicom(const import_file *file, int fd, const vv_registry *registry)
{
    uint8_t head[4096];
    size_t n_path;
    const ssize_t got = fd >= 0 ? pread(fd, head, sizeof head, 0) : -1;
    const size_t n = got > 0 ? (size_t)got : 0;
    const bool coded = n > 0 && vvi_coding_of(head, n) != VVI_CODING_NONE; /* what is in it is not known yet */
    vvi_path_coding(file->path, &n_path);
    for (size_t i = 0; registry->formats[i]; i++) {
        const vv_format *f = registry->formats[i];
        const bool meant = file->format ? strcmp(f->name, file->format) == 0
                                        : vvi_format_has_suffix(f, file->path, n_path) ||
                                              (n > 0 && f->probe && f->probe(head, n, file->path) > 0);
        if (meant && may_hold_dicom(f))
            return true;
    }
    return !file->format && (n == 0 || coded); /* n is 0 of folders and pipes */
}

void import_load_modules(const import_file *file, int fd, const vv_registry *registry)
{
    struct stat about;
    if (fd < 0 && strcmp(file->path, "-") == 0 && fstat(STDIN_FILENO, &about) == 0 && S_ISREG(about.st_mode))
        fd = STDIN_FILENO;
    if (may_be_dicom(file, fd, registry))
        vvi_gdcm_load(); /* where it fails, the reader says so */
}
#else
void import_load_modules(const import_file *file, int fd, const vv_registry *registry)
{
}
#endif
