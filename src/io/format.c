#include "io/format.h"
#include "core/names.h"
#include "core/text.h"
#include "io/coding.h"
#include "io/foreign_files.h"
#include "io/formats/slices/slices.h"
#include "io/formats/slices/slices_write.h"
#include "io/mesh_file.h"
#include "registry.h"
#include <string.h>
#include <strings.h>
#include <volvis/property.h>

#define NAMES_MOST 256
#define MESHES "'volvis isosurface' makes meshes of volumes"
#define PICTURES "'volvis render' makes pictures of volumes"

void vvi_options_over(void *known, size_t room, const void *options)
{
    size_t size = 0;
    if (options)
        memcpy(&size, options, sizeof size);
    size = size < room ? size : room;
    if (size >= sizeof size) {
        memcpy(known, options, size);
        memcpy(known, &room, sizeof room);
    }
}

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

static void add_once(const char **names, size_t *n, const char *name)
{
    for (size_t i = 0; i < *n; i++)
        if (strcmp(names[i], name) == 0)
            return;
    if (*n < NAMES_MOST)
        names[(*n)++] = name;
}

/* Names or suffixes of all rows, for the nearest one. */
static size_t collect(const char **names, const vv_registry *registry, bool suffixes, bool writable)
{
    size_t n = 0;
    for (const vv_format *const *f = registry->formats; *f; f++) {
        if (writable && !(*f)->write)
            continue;
        if (!suffixes)
            add_once(names, &n, (*f)->name);
        for (const char *const *s = (*f)->suffixes; suffixes && s && *s; s++)
            add_once(names, &n, strcmp(*s, "/") == 0 ? "FOLDER/" : *s);
    }
    return n;
}

void vvi_path_suffix(char typed[32], const char *path, size_t n)
{
    *typed = 0;
    size_t dot = n;
    while (dot > 0 && path[dot - 1] != '.' && path[dot - 1] != '/')
        dot--;
    if (dot == 0 || path[dot - 1] != '.' || n - dot + 1 >= 32)
        return;
    memcpy(typed, path + dot - 1, n - dot + 1);
    typed[n - dot + 1] = 0;
}

/* People say nii for nifti: one of its suffixes, with or without the dot. The first row that has it. */
static const vv_format *find_by_suffix(const char *name, const vv_registry *registry)
{
    name += name[0] == '.';
    for (const vv_format *const *f = registry->formats; *f && *name; f++)
        for (const char *const *s = (*f)->suffixes; s && *s; s++)
            if (strcasecmp(*s + 1, name) == 0)
                return *f;
    return NULL;
}

static bool is_image(const char *name, const vv_registry *registry)
{
    for (const vv_image_format *const *f = registry->image_formats; *f; f++)
        for (const char *const *s = (*f)->suffixes; *s; s++)
            if (strcasecmp(*s + (name[0] != '.'), name) == 0)
                return true;
    return false;
}

/* A suffix, with or without its dot, or a name. */
static bool is_mesh(const char *name, const vv_registry *registry)
{
    return vvi_mesh_format_find(name, registry) != NULL;
}

static vv_status fail_unnamed(const char *name, const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    const size_t n = collect(names, registry, false, false);
    if (is_mesh(name, registry))
        return vv_fail(VV_E_ARGUMENT, "%.60s is a mesh format, not a volume format; " MESHES, name);
    if (is_image(name, registry) && !vv_nearest_name(name, names, n))
        return vv_fail(VV_E_ARGUMENT, "%.60s is a picture format, not a volume format; " PICTURES, name);
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, name, &(vvi_known){names, n, "volvis formats", NULL},
                         "there is no format '%.60s'", name);
}

vv_status vvi_format_named(const vv_format **out, const char *name, const vv_registry *registry)
{
    *out = NULL;
    for (const vv_format *const *f = registry->formats; *f && !*out; f++)
        if (strcasecmp((*f)->name, name) == 0)
            *out = *f;
    if (!*out)
        *out = find_by_suffix(name, registry);
    return *out ? VV_OK : fail_unnamed(name, registry);
}

static vv_status fail_unknown(const uint8_t *head, size_t n_head, const char *path, size_t n_path,
                              const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    if (n_head == 0)
        return vv_fail_at(VV_E_FORMAT, path, NULL, "is empty; copy or download it again");
    const vv_mesh_format *mesh;
    if (vvi_mesh_format_of_head(&mesh, head, n_head, path, registry) == 2)
        return vv_fail_at(
            VV_E_FORMAT, path, NULL,
            "is a mesh (%s), not a volume; 'volvis info', 'render', 'view', 'convert', 'simplify', 'smooth', "
            "'measure' and 'compare' take it",
            mesh->name);
    const char *kind = vvi_foreign_kind(head, n_head);
    if (kind)
        return vv_fail_at(VV_E_FORMAT, path, NULL, "is %s", kind);
    char typed[32];
    vvi_path_suffix(typed, path, n_path);
    const char *near = vv_nearest_name(typed, names, collect(names, registry, true, false));
    return vv_fail_at(VV_E_FORMAT, path, NULL,
                      "is of no known format: neither its first bytes nor its suffix say what it is ('volvis formats' "
                      "lists what can be read)%s%s; samples without a header need --raw, for example --raw "
                      "256x256x128,u8",
                      near ? "; the nearest suffix is " : "", near ? near : "");
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
    /* A download that went wrong has the right name: head.nii.gz that is a web page. A name that gives a layout is
     * believed: samples may begin with anything. */
    const char *kind = *out && best < 2 && strcmp((*out)->name, "raw") != 0 ? vvi_foreign_mark(head, n) : NULL;
    if (kind)
        return vv_fail_at(VV_E_FORMAT, path, NULL, "is %s", kind);
    return *out && n > 0 ? VV_OK : fail_unknown(head, n, path, n_path, registry);
}

/* "%d" in a name counts slices where one file may be one of many; of any other format it is two letters. */
static bool is_of_slices(const vv_format *format)
{
    return format == &vvi_format_slices || format == &vvi_format_tiff || format == &vvi_format_ome_tiff;
}

vv_status vvi_format_of_output(const vv_format **out, const char *path, const vv_registry *registry)
{
    const char *names[NAMES_MOST] = {0};
    size_t n_path;
    *out = NULL;
    vvi_path_coding(path, &n_path);
    for (const vv_format *const *f = registry->formats; *f && !*out; f++)
        if ((*f)->write && vvi_format_has_suffix(*f, path, n_path))
            *out = *f;
    if (vvi_slices_pattern(path) && !vvi_mesh_format_of_path(path, registry) && (!*out || is_of_slices(*out)))
        return vvi_format_named(out, vvi_format_slices.name, registry);
    if (*out)
        return VV_OK;
    const size_t n = collect(names, registry, true, true);
    const char *slash = strrchr(path, '/'), *dot = strrchr(slash ? slash : path, '.');
    if (dot && is_image(dot, registry))
        return vv_fail_at(VV_E_ARGUMENT, path, NULL,
                          "has the suffix of a picture, not of a volume; " PICTURES
                          ", and 'volvis convert INPUT -o FOLDER/' one per slice, or -o 'FOLDER/slice_%%03d%s'",
                          dot);
    if (vvi_mesh_format_of_path(path, registry))
        return vv_fail_at(VV_E_ARGUMENT, path, NULL, "has the suffix of a mesh, not of a volume; " MESHES);
    char typed[32];
    vvi_path_suffix(typed, path, n_path);
    return vvi_fail_name(VV_E_ARGUMENT, path, NULL, typed, &(vvi_known){names, n, "volvis formats", NULL},
                         "has no suffix that a format writes");
}

vv_status vvi_format_check_encoding(const vv_format *format, const char *encoding)
{
    size_t n = 0;
    if (!encoding)
        return VV_OK;
    for (; format->encodings && format->encodings[n]; n++)
        if (strcmp(format->encodings[n], encoding) == 0)
            return VV_OK;
    if (n == 0)
        return vv_fail(VV_E_ARGUMENT, "the format %s is written in one way only: omit --encoding %.60s", format->name,
                       encoding);
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, encoding, &(vvi_known){format->encodings, n, NULL, NULL},
                         "the format %s has no encoding '%.60s'", format->name, encoding);
}
