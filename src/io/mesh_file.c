/* Mesh files: by the registry's mesh formats. */
#include "io/mesh_file.h"
#include "core/allowed_places.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/names.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/mesh.h"
#include "import/import_mesh.h"
#include "io/coding.h"
#include "io/foreign_files.h"
#include "io/format.h"
#include "io/mesh_part.h"
#include "io/meshes/mesh_builder.h"
#include "io/sink.h"
#include "io/source.h"
#include "io/store_impl.h"

#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

enum { NAMES_MOST = 64 };

void vv_mesh_read_options_init(vv_mesh_read_options *options, size_t size)
{
    const vv_mesh_read_options defaults = {.size = size};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

void vv_mesh_write_options_init(vv_mesh_write_options *options, size_t size)
{
    const vv_mesh_write_options defaults = {.size = size};
    memset(options, 0, size);
    memcpy(options, &defaults, size < sizeof defaults ? size : sizeof defaults);
}

/* Choosing a format ----------------------------------------------------------------------------------------------- */

static bool has_suffix(const vv_mesh_format *format, const char *path, size_t n)
{
    for (const char *const *s = format->suffixes; *s; s++) {
        const size_t m = strlen(*s);
        if (n > m && strncasecmp(path + n - m, *s, m) == 0)
            return true;
    }
    return false;
}

/* Names or suffixes of all rows. */
static size_t collect(const char *names[NAMES_MOST], const vv_registry *registry, bool suffixes)
{
    size_t n = 0;
    for (const vv_mesh_format *const *f = registry->mesh_formats; *f; f++) {
        if (!suffixes && n < NAMES_MOST)
            names[n++] = (*f)->name;
        for (const char *const *s = (*f)->suffixes; suffixes && *s && n < NAMES_MOST; s++)
            names[n++] = *s;
    }
    return n;
}

/* Makes an error of VV_E_ARGUMENT. */
static void fail_listing(const char *sentence, const char *name, const vv_registry *registry, bool suffixes)
{
    const char *names[NAMES_MOST] = {0};
    const size_t n = collect(names, registry, suffixes);
    char suffix[32];
    vvi_path_suffix(suffix, name, strlen(name));
    vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, suffixes ? suffix : name, &(vvi_known){names, n, NULL, NULL}, "%.200s: %s",
                  name, sentence);
}

const vv_mesh_format *vvi_mesh_format_find(const char *name, const vv_registry *registry)
{
    for (const vv_mesh_format *const *f = registry->mesh_formats; *f; f++)
        if (strcasecmp((*f)->name, name) == 0)
            return *f;
    name += name[0] == '.';
    for (const vv_mesh_format *const *f = registry->mesh_formats; *f; f++)
        for (const char *const *s = (*f)->suffixes; *s; s++)
            if (strcasecmp(*s + 1, name) == 0)
                return *f;
    return NULL;
}

vv_status vvi_mesh_format_named(const vv_mesh_format **out, const char *name, const vv_registry *registry)
{
    *out = vvi_mesh_format_find(name, registry);
    if (*out)
        return VV_OK;
    fail_listing("is not a mesh format", name, registry, false);
    return VV_E_ARGUMENT;
}

const vv_mesh_format *vvi_mesh_format_of_path(const char *path, const vv_registry *registry)
{
    size_t n;
    vvi_path_coding(path, &n);
    for (const vv_mesh_format *const *f = registry->mesh_formats; *f; f++)
        if (has_suffix(*f, path, n))
            return *f;
    return NULL;
}

int vvi_mesh_format_of_head(const vv_mesh_format **out, const uint8_t *head, size_t n, const char *path,
                            const vv_registry *registry)
{
    size_t n_path;
    int best = 0;
    bool best_suffix = false;
    *out = NULL;
    vvi_path_coding(path, &n_path);
    for (const vv_mesh_format *const *f = registry->mesh_formats; *f; f++) {
        const int sure = (*f)->probe ? (*f)->probe(head, n, path) : 0;
        const bool suffix = has_suffix(*f, path, n_path);
        if (sure > best || (sure > 0 && sure == best && suffix && !best_suffix)) {
            best = sure;
            best_suffix = suffix;
            *out = *f;
        }
    }
    return best;
}

bool vvi_format_is_certain(const uint8_t *head, size_t n, const char *path, const vv_registry *registry)
{
    for (const vv_format *const *row = registry->formats; *row; row++)
        if ((*row)->probe && (*row)->probe(head, n, path) == 2)
            return true;
    return false;
}

bool vvi_mesh_is_head(const uint8_t *head, size_t n, const char *path, const vv_registry *registry)
{
    const vv_mesh_format *format;
    const int sure = n > 0 ? vvi_mesh_format_of_head(&format, head, n, path, registry) : 0;
    if (sure == 2)
        return true;
    return vvi_mesh_format_of_path(path, registry) && !vvi_format_is_certain(head, n, path, registry);
}

bool vvi_mesh_is_file(const char *path, const vv_job *job)
{
    uint8_t head[4096];
    struct stat about;
    if (stat(path, &about) != 0 || !S_ISREG(about.st_mode))
        return false; /* what a stream gives is gone once it is read */
    const int fd = vvi_open_place(path, O_RDONLY, false, job);
    const ssize_t n = fd >= 0 ? pread(fd, head, sizeof head, 0) : -1;
    if (fd >= 0)
        close(fd);
    return n >= 0 && vvi_mesh_is_head(head, (size_t)n, path, vvi_job_registry(job));
}

/* Reading --------------------------------------------------------------------------------------------------------- */

/* What begins like nothing that is known is believed its suffix: the reader says what is wrong with it. */
static vv_status choose_reader(const vv_mesh_format **out, vv_source *source, const char *path, const char *format,
                               const vv_registry *registry)
{
    size_t n;
    *out = NULL;
    if (format)
        return vvi_mesh_format_named(out, format, registry);
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    if (!head) {
        const vv_status st = vv_error_last()->status;
        return st != VV_OK ? st : VV_E_INTERNAL;
    }
    if (n == 0) { /* or coded data of which nothing could be read */
        const vv_status st = vvi_source_check_end(source);
        return st != VV_OK
                   ? st
                   : vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "is empty; copy or download it again");
    }
    const int sure = vvi_mesh_format_of_head(out, head, n, path, registry);
    const char *kind = sure < 2 ? vvi_foreign_mark(head, n) : NULL;
    if (kind) /* a download that went wrong has the right name */
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "is %s", kind);
    if (sure == 0)
        *out = vvi_mesh_format_of_path(path, registry);
    return *out ? VV_OK
                : vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                             "is not a mesh in a known format ('volvis formats' lists them)");
}

/* Readers compare what a header says with what can still arrive. Of a pipe nobody knows: it goes to a file first. */
static vv_status know_size(vv_source *source, vv_job *job)
{
    bool exact;
    return vvi_source_left(source, &exact) == UINT64_MAX ? vvi_source_spool(source, job) : VV_OK;
}

static vv_status read_source(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, vv_source *source,
                             const char *path, const vv_mesh_read_options *options, vv_job *job)
{
    vv_status st = choose_reader(format_out, source, path, options->format, vvi_job_registry(job));
    if (st != VV_OK)
        return st;
    if (!(*format_out)->read)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL, "meshes of format %s can only be written",
                          (*format_out)->name);
    if ((st = know_size(source, job)) != VV_OK)
        return st;
    return (*format_out)->read(out, source, options, notes, job);
}

/* Voxels and bare units of a file are no lengths: what the caller knows of them counts. */
static vv_status apply_unit(vv_mesh *mesh, const char *unit, vv_notes *notes)
{
    const char *own = vv_mesh_get_info(mesh)->unit;
    if (!unit || strcmp(own, unit) == 0)
        return VV_OK;
    if (vvi_length_unit_metres(own) > 0)
        return vvi_notes_warn(notes, "the file says that its lengths are in %s; that is kept, and %s is not used", own,
                              unit);
    vvi_mesh_set_unit(mesh, unit);
    return VV_OK;
}

static vv_status read_here(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, const char *path,
                           const vv_mesh_read_options *options, vv_job *job)
{
    vv_source *source;
    vv_mesh_read_options known = *options;
    known.unit = options->unit ? options->unit : "units";
    vv_status st = vvi_source_open(&source, path, job);
    if (st != VV_OK)
        return st;
    st = read_source(out, format_out, notes, source, path, &known, job);
    if (st == VV_OK)
        st = vvi_source_check_end(source);
    vvi_source_close(source);
    return st == VV_OK ? apply_unit(*out, options->unit, notes) : st;
}

vv_status vvi_mesh_read_noted(vv_mesh **out, const vv_mesh_format **format_out, vv_notes *notes, const char *path,
                              const vv_mesh_read_options *options, vv_job *job)
{
    vv_mesh_read_options known;
    *out = NULL;
    *format_out = NULL;
    vv_mesh_read_options_init(&known, sizeof known);
    vvi_options_over(&known, sizeof known, options);
    const bool safe = vvi_job_safe(job) || vvi_job_distrusts(job, path);
    vv_status st = safe ? vvi_import_mesh(out, format_out, notes, path, &known, job)
                        : read_here(out, format_out, notes, path, &known, job);
    if (st == VV_OK)
        st = vvi_mesh_pick_part(out, known.part, strcmp(path, "-") == 0 ? "standard input" : path, job);
    if (st != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}

vv_status vv_mesh_read(vv_mesh **out, const char *path, const vv_mesh_read_options *options, vv_job *job)
{
    vv_notes *notes;
    const vv_mesh_format *format;
    const char *text;
    *out = NULL;
    vv_status st = vvi_notes_new(&notes, job);
    if (st != VV_OK)
        return st;
    st = vvi_mesh_read_noted(out, &format, notes, path, options, job);
    for (size_t i = 0; st == VV_OK && (text = vvi_notes_warning(notes, i)) != NULL; i++)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: %s", strcmp(path, "-") == 0 ? "standard input" : path, text);
    if (st == VV_OK)
        vvi_log(job, VV_LOG_INFO, "io", "%s: read as %s", path, format->name);
    vvi_notes_free(notes);
    return st;
}

/* Writing --------------------------------------------------------------------------------------------------------- */

static vv_status check_encoding(vv_mesh_write_options *out, const vv_mesh_format *format)
{
    size_t n = 0;
    vvi_text list = {0};
    if (!out->encoding) {
        out->encoding = format->encodings ? format->encodings[0] : "";
        return VV_OK;
    }
    for (; format->encodings && format->encodings[n]; n++) {
        if (strcmp(format->encodings[n], out->encoding) == 0) {
            vvi_text_free(&list);
            return VV_OK;
        }
        vvi_text_printf(&list, "%s%s", n ? ", " : "", format->encodings[n]);
    }
    const vv_status st = n == 0
                             ? vv_fail(VV_E_ARGUMENT, "the format %s is written in one way only: omit --encoding %.60s",
                                       format->name, out->encoding)
                             : vv_fail(VV_E_ARGUMENT, "the format %s has no encoding '%.60s'; it has %s", format->name,
                                       out->encoding, list.s && !list.bad ? list.s : format->encodings[0]);
    vvi_text_free(&list);
    return st;
}

/* The row, and options with their defaults filled in. */
static vv_status choose_writer(const vv_mesh_format **format_out, vv_mesh_write_options *out, const char *path,
                               const vv_mesh_write_options *given, vv_job *job)
{
    const vv_registry *registry = vvi_job_registry(job);
    vv_status st = VV_OK;
    vv_mesh_write_options_init(out, sizeof *out);
    vvi_options_over(out, sizeof *out, given);
    if (out->format)
        st = vvi_mesh_format_named(format_out, out->format, registry);
    else
        *format_out = vvi_mesh_format_of_path(path, registry);
    if (st != VV_OK)
        return st;
    if (!*format_out) {
        fail_listing("has no suffix that a mesh format writes", path, registry, true);
        return VV_E_ARGUMENT;
    }
    if (!(*format_out)->write)
        return vv_fail_at(VV_E_UNSUPPORTED, path, NULL,
                          "the format %s can only be read; 'volvis formats' shows what can be written",
                          (*format_out)->name);
    if (out->level < 0 || out->level > 9)
        return vv_fail(VV_E_ARGUMENT, "level is %d; expected 1 (fast) to 9 (small), or 0 for the default", out->level);
    if (out->unit && !(vvi_length_unit_metres(out->unit) > 0))
        return vv_fail(VV_E_ARGUMENT,
                       "'%.20s' is not a unit of length; expected m, cm, mm, um, nm, pm, A, km, in or ft", out->unit);
    return check_encoding(out, *format_out);
}

vv_status vv_mesh_check(const char *path, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_format *format;
    vv_mesh_write_options known;
    return choose_writer(&format, &known, path, options, job);
}

static void warn_of_losses(const vv_sink *sink, const vv_mesh *mesh, const vv_mesh_format *format, const vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    bool colored = false, named = m->n_parts > 1;
    for (size_t i = 0; i < m->n_parts; i++) {
        colored = colored || m->parts[i].color.a >= 0;
        named = named || m->parts[i].name[0];
    }
    const struct {
        bool has;
        unsigned holds;
        const char *what;
    } losses[] = {
        {m->values != NULL, VV_MESH_HOLDS_VALUES, "values"},
        {m->colors != NULL, VV_MESH_HOLDS_COLORS, "vertex colours"},
        {named, VV_MESH_HOLDS_PARTS, "parts"},
        {colored, VV_MESH_HOLDS_PART_COLORS, "colours of parts"},
        {m->n_textures > 0, VV_MESH_HOLDS_TEXTURES, "images on triangles"},
    };
    for (size_t i = 0; i < sizeof losses / sizeof *losses; i++)
        if (losses[i].has && !(format->holds & losses[i].holds))
            vvi_log(job, VV_LOG_WARNING, "io", "%s: the format %s cannot hold %s; they are left out",
                    vvi_sink_name(sink), format->name, losses[i].what);
    if (m->normals && !(format->holds & VV_MESH_HOLDS_NORMALS))
        vvi_log(job, VV_LOG_INFO, "io", "%s: the format %s cannot hold vertex normals", vvi_sink_name(sink),
                format->name);
    if (vvi_length_unit_metres(m->unit) > 0 && !(format->holds & VV_MESH_HOLDS_UNIT))
        vvi_log(
            job, VV_LOG_WARNING, "io",
            "%s: the format %s does not store that lengths are in %s; tell whoever reads it, VolVis by --input-unit",
            vvi_sink_name(sink), format->name, m->unit);
    const vv_bounds box = vv_mesh_bounds(mesh);
    if (!(format->holds & VV_MESH_HOLDS_DOUBLES) && vvi_mesh_is_far(&box))
        vvi_log(
            job, VV_LOG_WARNING, "io",
            "%s: the mesh is far from the origin for its size, and the format %s rounds positions to single precision",
            vvi_sink_name(sink), format->name);
}

static vv_status write_sink(vv_sink *sink, const char *path, const vv_mesh *mesh, const vv_mesh_format *format,
                            const vv_mesh_write_options *options, vv_job *job)
{
    size_t n;
    vv_status st = VV_OK;
    const vvi_coding coding = vvi_path_coding(path, &n);
    if (options->spare_inputs)
        vvi_sink_spare_inputs(sink);
    if (coding != VVI_CODING_NONE)
        st = vvi_sink_coding(sink, (int)coding, options->level);
    warn_of_losses(sink, mesh, format, job);
    return st == VV_OK ? format->write(sink, mesh, options, job) : st;
}

static vv_status write_file(const char *path, const vv_mesh *mesh, const vv_mesh_format *format,
                            const vv_mesh_write_options *options, vv_job *job)
{
    vv_sink *sink;
    vv_status st = vvi_sink_open(&sink, path, job);
    if (st != VV_OK)
        return st;
    if ((st = write_sink(sink, path, mesh, format, options, job)) == VV_OK)
        return vvi_sink_commit(sink);
    vvi_sink_abandon(sink);
    return st;
}

/* Lengths in another unit. */
static vv_status in_unit(vv_mesh **out, const vv_mesh *mesh, const char *unit, vv_job *job)
{
    const vv_mesh_info *m = vv_mesh_get_info(mesh);
    const double from = vvi_length_unit_metres(m->unit);
    if (!unit || strcmp(unit, m->unit) == 0) {
        *out = vv_mesh_retain(mesh);
        return VV_OK;
    }
    if (!(from > 0))
        return vv_fail(VV_E_ARGUMENT,
                       "lengths of the mesh are in '%s', and its length in %s is not known; give it with --input-unit, "
                       "as in '--input-unit 0.5mm'",
                       m->unit, unit);
    return vvi_mesh_scaled(out, mesh, from / vvi_length_unit_metres(unit), unit, job);
}

vv_status vv_mesh_write(const char *path, const vv_mesh *mesh, const vv_mesh_write_options *options, vv_job *job)
{
    const vv_mesh_format *format;
    vv_mesh_write_options known;
    vv_mesh *scaled;
    vv_status st = choose_writer(&format, &known, path, options, job);
    if (st != VV_OK || (st = in_unit(&scaled, mesh, known.unit, job)) != VV_OK)
        return st;
    st = write_file(path, scaled, format, &known, job);
    vv_mesh_release(scaled);
    return st;
}
