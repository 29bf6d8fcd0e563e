#include "io/format.h"
#include "core/text.h"
#include "io/coding.h"
#include <string.h>
#include <strings.h>
#include <volvis/property.h>

#define NAMES_MOST 256

vvi_coding vvi_path_coding(const char *path, size_t *n_out)
{
    static const struct {
        const char *suffix;
        vvi_coding coding;
    } codings[] = {{".gz", VVI_CODING_GZIP}, {".bz2", VVI_CODING_BZIP2}, {".zst", VVI_CODING_ZSTD}};
    const size_t n = strlen(path);
    *n_out = n;
    for (size_t i = 0; i < sizeof codings / sizeof *codings; i++) {
        const size_t m = strlen(codings[i].suffix);
        if (n > m && strcasecmp(path + n - m, codings[i].suffix) == 0) {
            *n_out = n - m;
            return codings[i].coding;
        }
    }
    return VVI_CODING_NONE;
}

bool vvi_format_has_suffix(const vv_format *format, const char *path, size_t n)
{
    for (const char *const *s = format->suffixes; s && *s; s++) {
        const size_t m = strlen(*s);
        if (n > m && strncasecmp(path + n - m, *s, m) == 0)
            return true;
    }
    return false;
}

/* Names or suffixes of all rows, for the nearest one. */
static size_t collect(const char **names, const vv_registry *registry, bool suffixes, bool writable)
{
    size_t n = 0;
    for (const vv_format *const *f = registry->formats; *f; f++) {
        if (writable && !(*f)->write)
            continue;
        if (!suffixes && n < NAMES_MOST)
            names[n++] = (*f)->name;
        for (const char *const *s = (*f)->suffixes; suffixes && s && *s && n < NAMES_MOST; s++)
            names[n++] = *s;
    }
    return n;
}

static void add_list(vvi_text *text, const char *const *names, size_t n)
{
    for (size_t i = 0; i < n; i++)
        vvi_text_printf(text, "%s%s", i ? ", " : "", names[i]);
}

static const char *nearest_suffix(const char *path, size_t n, const char *const *names, size_t n_names)
{
    char typed[32];
    size_t dot = n;
    while (dot > 0 && path[dot - 1] != '.' && path[dot - 1] != '/')
        dot--;
    if (dot == 0 || path[dot - 1] != '.' || n - dot + 1 >= sizeof typed)
        return NULL;
    memcpy(typed, path + dot - 1, n - dot + 1);
    typed[n - dot + 1] = 0;
    return vv_nearest_name(typed, names, n_names);
}

vv_status vvi_format_named(const vv_format **out, const char *name, const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    *out = NULL;
    for (const vv_format *const *f = registry->formats; *f; f++)
        if (strcmp((*f)->name, name) == 0) {
            *out = *f;
            return VV_OK;
        }
    const size_t n = collect(names, registry, false, false);
    const char *near = vv_nearest_name(name, names, n);
    if (near)
        return vv_fail(VV_E_ARGUMENT, "there is no format '%.60s'; did you mean '%s'?", name, near);
    vvi_text list = {0};
    add_list(&list, names, n);
    vv_status st = vv_fail(VV_E_ARGUMENT, "there is no format '%.60s'; there are %s", name, list.s ? list.s : "none");
    vvi_text_free(&list);
    return st;
}

static vv_status fail_unknown(const uint8_t *head, size_t n_head, const char *path, size_t n_path,
                              const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    vvi_text text = {0};
    if (n_head == 0)
        return vv_fail_at(VV_E_FORMAT, path, NULL, "is empty");
    vvi_text_add(&text, "is of no known format (tried ");
    add_list(&text, names, collect(names, registry, false, false));
    vvi_text_add(&text, " by content and suffix)");
    const char *near = nearest_suffix(path, n_path, names, collect(names, registry, true, false));
    if (near)
        vvi_text_printf(&text, "; the nearest suffix is %s", near);
    vvi_text_add(&text, "; samples without a header need --raw, for example --raw 256x256x128,u8");
    vv_status st = vv_fail_at(VV_E_FORMAT, path, NULL, "%s", text.s && !text.bad ? text.s : "is of no known format");
    vvi_text_free(&text);
    return st;
}

vv_status vvi_format_of_file(const vv_format **out, const uint8_t *head, size_t n, const char *path,
                             const vv_registry *registry)
{
    size_t n_path;
    int best = 0;
    bool best_suffix = false;
    *out = NULL;
    vvi_path_coding(path, &n_path);
    for (const vv_format *const *f = registry->formats; *f; f++) {
        const int sure = (*f)->probe ? (*f)->probe(head, n, path) : 0;
        const bool suffix = vvi_format_has_suffix(*f, path, n_path);
        if (sure > best || (sure == best && suffix && !best_suffix)) {
            best = sure;
            best_suffix = suffix;
            *out = *f;
        }
    }
    return *out && n > 0 ? VV_OK : fail_unknown(head, n, path, n_path, registry);
}

vv_status vvi_format_of_output(const vv_format **out, const char *path, const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    size_t n_path;
    *out = NULL;
    vvi_path_coding(path, &n_path);
    for (const vv_format *const *f = registry->formats; *f; f++)
        if ((*f)->write && vvi_format_has_suffix(*f, path, n_path)) {
            *out = *f;
            return VV_OK;
        }
    const size_t n = collect(names, registry, true, true);
    const char *near = nearest_suffix(path, n_path, names, n);
    if (near)
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "has a suffix that no format writes; did you mean %s?", near);
    vvi_text list = {0};
    add_list(&list, names, n);
    vv_status st = vv_fail_at(VV_E_ARGUMENT, path, NULL, "has no suffix that a format writes; there are %s",
                              list.s ? list.s : "none");
    vvi_text_free(&list);
    return st;
}

vv_status vvi_format_check_encoding(const vv_format *format, const char *encoding)
{
    size_t n = 0;
    if (!encoding)
        return VV_OK;
    for (; format->encodings && format->encodings[n]; n++)
        if (strcmp(format->encodings[n], encoding) == 0)
            return VV_OK;
    const char *near = n > 0 ? vv_nearest_name(encoding, format->encodings, n) : NULL;
    if (near)
        return vv_fail(VV_E_ARGUMENT, "the format %s has no encoding '%.60s'; did you mean '%s'?", format->name,
                       encoding, near);
    return vv_fail(VV_E_ARGUMENT, "the format %s has no encoding '%.60s'; its default is '%s'", format->name, encoding,
                   n > 0 ? format->encodings[0] : "raw");
}
