/* Samples without a header. What they are stands in a layout, "256x256x128,u8[,spacing=1x1x1.4][,big][,skip=N]", or in
 * the file's name, "engine_256x256x128_uint8.raw". */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "io/layout.h"
#include "io/notes.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

typedef struct raw {
    int64_t dims[4]; /* x y z and frames */
    vv_type type;
    int components;
    double spacing[3]; /* 0: not given */
    bool big_endian;
    uint64_t skip;
    vvi_layout layout;
    bool mappable;
    bool endless; /* its length is not known before it is read */
} raw;

#define EXAMPLE "write it as 256x256x128,u8[,spacing=1x1x1.4][,big][,skip=N]"

/* "256x256x128" with 3 or 4 numbers; *end after it. */
static bool scan_dims(int64_t dims[4], const char *text, const char **end)
{
    int n = 0;
    dims[3] = 1;
    for (const char *at = text; n < 4 && isdigit((unsigned char)*at); n++) {
        if (!vvi_scan_int(&dims[n], at, end))
            return false;
        at = *end + 1;
        if ((**end != 'x' && **end != 'X') || !isdigit((unsigned char)*at)) {
            n++;
            break;
        }
    }
    return n >= 3;
}

/* "u8", "uint16", "float"; "u8x3" has three components. */
static bool parse_sample(raw *r, const char *word, size_t n)
{
    char text[32];
    if (n == 0 || n >= sizeof text)
        return false;
    memcpy(text, word, n);
    text[n] = 0;
    r->components = 1;
    char *times = strrchr(text, 'x');
    if (times && times > text && isdigit((unsigned char)times[1]) && !times[2]) {
        r->components = times[1] - '0';
        *times = 0;
    }
    return r->components >= 1 && vv_type_parse(&r->type, text);
}

static bool parse_spacing(raw *r, const char *text, size_t n)
{
    const char *at = text;
    for (int a = 0; a < 3; a++) {
        if (!vvi_scan_real(&r->spacing[a], at, &at) || !isfinite(r->spacing[a]) || r->spacing[a] <= 0)
            return false;
        if (a < 2 && *at++ != 'x')
            return false;
    }
    return at == text + n;
}

static bool parse_word(raw *r, const char *word, size_t n)
{
    const char *end;
    if (n > 8 && strncmp(word, "spacing=", 8) == 0)
        return parse_spacing(r, word + 8, n - 8);
    if (n > 5 && strncmp(word, "skip=", 5) == 0)
        return vvi_scan_uint(&r->skip, word + 5, &end) && end == word + n && r->skip <= INT64_MAX;
    r->big_endian = n == 3 && strncmp(word, "big", 3) == 0;
    return r->big_endian || (n == 6 && strncmp(word, "little", 6) == 0);
}

static vv_status parse_layout(raw *r, const char *text, const char *name)
{
    const char *at;
    if (!scan_dims(r->dims, text, &at) || (*at && *at != ','))
        return vv_fail_at(VV_E_ARGUMENT, name, NULL,
                          "the layout '%.60s' does not begin with dims, the samples along x, y and z; " EXAMPLE, text);
    if (!*at)
        return vv_fail_at(VV_E_ARGUMENT, name, NULL, "the layout '%.60s' has no type after its dims; " EXAMPLE, text);
    size_t n = strcspn(++at, ",");
    if (!parse_sample(r, at, n))
        return vv_fail_at(VV_E_ARGUMENT, name, NULL, "the layout has '%.*s' where a type was expected; " EXAMPLE,
                          n < 40 ? (int)n : 40, at);
    for (at += n; *at == ','; at += n) {
        n = strcspn(++at, ",");
        if (!parse_word(r, at, n))
            return vv_fail_at(VV_E_ARGUMENT, name, NULL, "the layout has '%.*s', which is not understood; " EXAMPLE,
                              n < 40 ? (int)n : 40, at);
    }
    return VV_OK;
}

/* Words of a file name end at _ - . or a blank. */
static size_t word_length(const char *at)
{
    return strcspn(at, "_-. ");
}

/* Dims and type somewhere in the name, as people write them. */
static bool parse_name(raw *r, const char *path)
{
    const char *slash = strrchr(path, '/'), *end;
    bool dims = false, type = false;
    for (const char *at = slash ? slash + 1 : path; *at; at += at[0] != 0) {
        const size_t n = word_length(at);
        int64_t found[4];
        if (!dims && scan_dims(found, at, &end) && end == at + n) {
            memcpy(r->dims, found, sizeof found);
            dims = true;
        } else if (!type && n > 1 && parse_sample(r, at, n)) {
            type = true;
        } else if ((n == 2 && strncasecmp(at, "be", 2) == 0) || (n == 3 && strncasecmp(at, "big", 3) == 0)) {
            r->big_endian = true;
        }
        at += n;
        if (!*at)
            break;
    }
    return dims && type;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    raw r;
    return n > 0 && parse_name(&r, path) ? 1 : 0;
}

static vv_status fill_info(vv_field_info *info, raw *r, const char *name)
{
    vv_grid *grid = &info->grid;
    info->type = r->type;
    info->components = r->components;
    info->n_frames = r->dims[3];
    memcpy(grid->dims, r->dims, sizeof grid->dims);
    if (r->type == VV_TYPE_U8 && (r->components == 3 || r->components == 4))
        info->meaning = r->components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    if (r->spacing[0] > 0) {
        grid->index_to_world.axis[0].x = r->spacing[0];
        grid->index_to_world.axis[1].y = r->spacing[1];
        grid->index_to_world.axis[2].z = r->spacing[2];
        snprintf(grid->unit, sizeof grid->unit, "units");
    }
    r->layout = (vvi_layout){
        .n_axes = 5,
        .axis = {{r->components, VVI_ROLE_COMPONENT},
                 {r->dims[0], VVI_ROLE_X},
                 {r->dims[1], VVI_ROLE_Y},
                 {r->dims[2], VVI_ROLE_Z},
                 {r->dims[3], VVI_ROLE_FRAME}},
        .type = r->type,
        .swap = vv_type_bytes(r->type) > 1 && vvi_order_swapped(r->big_endian),
    };
    return VV_OK;
}

/* By their names: the axes of the layout below have other numbers. */
static vv_status check_dims(const raw *r, const vv_source *source)
{
    static const char *const names[4] = {"samples along x", "samples along y", "samples along z", "time steps"};
    const uint64_t most = vvi_source_limits(source)->dim;
    for (int a = 0; a < 4; a++) {
        if (r->dims[a] < 1)
            return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(source), NULL,
                              "the layout has 0 %s; at least 1 is needed; " EXAMPLE, names[a]);
        if ((uint64_t)r->dims[a] > most && a < 3)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                              "the layout has %" PRId64 " %s; at most %" PRIu64 " are allowed (--limit dim=N allows "
                              "more)",
                              r->dims[a], names[a], most);
    }
    return VV_OK;
}

static vv_status check_bytes(raw *r, vv_source *source, vv_notes *notes)
{
    uint64_t n;
    bool exact;
    vv_status st = vvi_layout_count(&n, &r->layout, vvi_source_name(source));
    if (st != VV_OK)
        return st;
    const uint64_t bytes = n * vv_type_bytes(r->type);
    if ((st = vvi_source_expect(source, r->skip, bytes, "these dims and type")) != VV_OK)
        return st;
    const uint64_t all = vvi_source_left(source, &exact) + vvi_source_tell(source);
    if (exact && all > r->skip + bytes)
        st = vvi_notes_warn(notes, "has %" PRIu64 " bytes more than its dims and type need; are they right?",
                            all - r->skip - bytes);
    r->endless = !exact;
    r->mappable = vvi_layout_mappable(&r->layout, r->skip) && vvi_source_mappable(source, r->skip, bytes);
    return st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    const char *name = vvi_source_name(source);
    raw r = {.components = 1};
    vv_status st = VV_OK;
    *plan_out = NULL;
    if (options->raw)
        st = parse_layout(&r, options->raw, name);
    else if (!parse_name(&r, name))
        st = vv_fail_at(VV_E_ARGUMENT, name, NULL,
                        "has no header and no layout in its name (as in engine_256x256x128_uint8.raw); give --raw "
                        "256x256x128,u8");
    if (st != VV_OK || (st = check_dims(&r, source)) != VV_OK || (st = fill_info(info, &r, name)) != VV_OK ||
        (st = check_bytes(&r, source, notes)) != VV_OK)
        return st;
    raw *plan = vvi_alloc(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    *plan = r;
    *plan_out = plan;
    return VV_OK;
}

/* What is packed does not say how long it is before it is read: then a byte behind the samples tells as much. */
static void warn_of_rest(const raw *r, vv_source *source, vv_job *job)
{
    uint64_t n;
    uint8_t byte;
    size_t got = 0;
    if (!r->endless || vvi_layout_count(&n, &r->layout, vvi_source_name(source)) != VV_OK)
        return;
    const uint64_t end = r->skip + n * vv_type_bytes(r->type);
    bool more = vvi_source_tell(source) > end; /* where the checksum was asked for */
    if (!more && vvi_source_seek(source, end) == VV_OK)
        more = vvi_source_read_some(source, &byte, 1, &got) == VV_OK && got == 1;
    if (more)
        vvi_log(job, VV_LOG_WARNING, "io", "%s: has more bytes than its dims and type need; are they right?",
                vvi_source_name(source));
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const raw *r = plan;
    const vv_status st = vvi_layout_read_plain(out, info, &r->layout, source, r->skip, frame, region, job);
    const bool last = !region || region->lo[2] + region->n[2] == info->grid.dims[2];
    if (st == VV_OK && last && frame + 1 == info->n_frames)
        warn_of_rest(r, source, job);
    return st;
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const raw *)plan)->mappable;
}

static void free_plan(void *plan)
{
    vvi_free(plan);
}

/* Writing ---------------------------------------------------------------------------------------------------------- */

static void tell_layout(const vv_sink *sink, const vv_field_info *info, size_t n_frames, bool big, vv_job *job)
{
    vvi_text t = {0};
    const int64_t *n = info->grid.dims;
    vvi_text_printf(&t, "%" PRId64 "x%" PRId64 "x%" PRId64, n[0], n[1], n[2]);
    if (n_frames > 1)
        vvi_text_printf(&t, "x%zu", n_frames);
    vvi_text_printf(&t, ",%s", vv_type_name(info->type));
    if (info->components > 1)
        vvi_text_printf(&t, "x%d", info->components);
    if (big)
        vvi_text_add(&t, ",big");
    if (t.s && !t.bad)
        vvi_log(job, VV_LOG_INFO, "io", "%s: read it again with --raw %s", vvi_sink_name(sink), t.s);
    vvi_text_free(&t);
}

static vv_status write_field(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    vv_status st = VV_OK;
    vvi_log_loss(sink, info, n_frames, "raw", job);
    vvi_log_lost_names(sink, options, 0, "raw", job);
    tell_layout(sink, info, n_frames, options->big_endian, job);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = vvi_samples_write(sink, frames[f], -1, options->big_endian, job);
    return st;
}

static const char *const suffixes[] = {".raw", ".bin", NULL};
static const char *const encodings[] = {"raw", NULL};

const vv_format vvi_format_raw = {
    .api = VV_FORMAT_API,
    .name = "raw",
    .doc = "samples without a header, described by --raw or by the file's name",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
    .write = write_field,
};
