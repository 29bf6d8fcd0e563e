/* Names of data files: one by one, or of a pattern. */
#include "core/memory.h"
#include "io/data_files.h"
#include <ctype.h>
#include <stdlib.h>
#include <string.h>

vv_status vvi_data_files_add(vvi_data_files *d, const char *name)
{
    if (d->n >= d->limits->files)
        return vv_fail_at(VV_E_FORMAT, d->header, NULL, "names more than %llu data files; --limit files=N allows more",
                          (unsigned long long)d->limits->files);
    if ((d->n & (d->n - 1)) == 0) { /* room doubles at powers of two */
        const size_t room = d->n ? d->n * 2 : 1;
        char **grown = vvi_realloc_plain(d->name, room * sizeof *grown);
        if (!grown)
            return vv_fail_memory(room * sizeof *grown);
        d->name = grown;
    }
    char *copy = vvi_strdup(name);
    if (!copy)
        return vv_fail_memory(strlen(name));
    d->name[d->n++] = copy;
    return VV_OK;
}

void vvi_data_files_finish(vvi_data_files *d)
{
    for (size_t i = 0; i < d->n; i++)
        free(d->name[i]);
    free(d->name);
    d->name = NULL;
    d->n = 0;
}

/* printf's own parser is not let near a file's text: one %d with an optional width is all that is allowed. */
const char *vvi_data_files_expand(vvi_data_files *d, const char *pattern, size_t n, const int64_t range[3],
                                  bool *memory)
{
    const char *stop = pattern + n, *percent = memchr(pattern, '%', n), *at = percent ? percent + 1 : stop;
    const bool zeros = at < stop && *at == '0';
    int width = 0;
    *memory = false;
    while (at < stop && isdigit((unsigned char)*at) && width < 100)
        width = width * 10 + (*at++ - '0');
    if (at >= stop || *at != 'd' || width > 20 || memchr(at, '%', (size_t)(stop - at)))
        return "needs one %d, as in slice%03d.raw";
    for (int i = 0; i < 3; i++)
        if (range[i] < -(INT64_C(1) << 40) || range[i] > INT64_C(1) << 40)
            return "has a number that is out of range";
    const int64_t step = range[2];
    if (step == 0 || (step > 0) != (range[1] >= range[0]))
        return "has a step that never leads from its first number to its last";
    for (int64_t i = range[0]; step > 0 ? i <= range[1] : i >= range[1]; i += step) {
        char *name = vvi_asprintf(zeros ? "%.*s%0*lld%.*s" : "%.*s%*lld%.*s", (int)(percent - pattern), pattern, width,
                                  (long long)i, (int)(stop - at - 1), at + 1);
        *memory = !name || d->n >= d->limits->files || vvi_data_files_add(d, name) != VV_OK;
        free(name);
        if (*memory && d->n >= d->limits->files) {
            *memory = false;
            return "makes more names than a header may have; --limit files=N allows more";
        }
        if (*memory)
            return "needs too much memory";
    }
    return NULL;
}
