#include "core/job.h"
#include "core/text.h"
#include "core/units.h"
#include "io/coding.h"
#include "io/formats/nifti/nifti.h"
#include "io/formats/nrrd/nrrd.h"
#include "io/numbers.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Samples of an attached file begin at a multiple of this, so that they can be mapped whatever their type. */
#define ALIGNMENT 64

static const char *type_name(vv_type type)
{
    static const char *const names[VV_TYPE_COUNT] = {"uint8", "int8",   "uint16", "int16", "uint32",
                                                     "int32", "uint64", "int64",  "float", "double"};
    return names[type];
}

static const char *component_kind(const vv_field_info *info)
{
    switch (info->meaning) {
    case VV_MEANING_RGB:
        return "RGB-color";
    case VV_MEANING_RGBA:
        return "RGBA-color";
    case VV_MEANING_VECTOR:
        return info->components == 3 ? "3-vector" : "vector";
    case VV_MEANING_SCALAR:
    case VV_MEANING_LABEL:
        break;
    }
    return "list";
}

static bool has_component_axis(const vv_field_info *info)
{
    return info->components > 1 || info->meaning == VV_MEANING_RGB || info->meaning == VV_MEANING_RGBA ||
           info->meaning == VV_MEANING_VECTOR;
}

static void add_vector(vvi_text *t, vv_vec3 v)
{
    char x[32], y[32], z[32];
    vvi_print_unsigned_zero(x, v.x);
    vvi_print_unsigned_zero(y, v.y);
    vvi_print_unsigned_zero(z, v.z);
    vvi_text_printf(t, "(%s,%s,%s)", x, y, z);
}

/* One line. Line ends would end the field, and a quote the quoted word. */
static void add_clean(vvi_text *t, const char *s)
{
    for (; *s; s++) {
        const char c = *s == '\n' || *s == '\r' ? ' ' : *s == '"' ? '\'' : *s;
        vvi_text_add_n(t, &c, 1);
    }
}

bool vvi_nrrd_is_placed(const vv_grid *grid)
{
    return grid->space != VV_SPACE_PLAIN || strcmp(grid->unit, "voxels") != 0 ||
           !vvi_is_identity(&grid->index_to_world);
}

static void add_space(vvi_text *t, const vv_grid *grid, bool component, bool time)
{
    vvi_text_add(t, grid->space == VV_SPACE_RAS ? "space: right-anterior-superior\n" : "space dimension: 3\n");
    vvi_text_add(t, "space directions:");
    if (component)
        vvi_text_add(t, " none");
    for (int a = 0; a < 3; a++) {
        vvi_text_add(t, " ");
        add_vector(t, grid->index_to_world.axis[a]);
    }
    vvi_text_add(t, time ? " none\nspace origin: " : "\nspace origin: ");
    add_vector(t, grid->index_to_world.origin);
    vvi_text_add(t, "\nspace units:");
    for (int a = 0; a < 3; a++) {
        vvi_text_add(t, " \"");
        add_clean(t, grid->unit);
        vvi_text_add(t, "\"");
    }
    vvi_text_add(t, "\n");
}

static void add_time(vvi_text *t, const vv_field_info *info, bool component)
{
    char step[32];
    if (info->frame_step != 0 && isfinite(info->frame_step)) {
        vvi_print_number(step, info->frame_step);
        vvi_text_printf(t, "spacings:%s nan nan nan %s\n", component ? " nan" : "", step);
    }
    if (info->frame_unit[0]) {
        vvi_text_printf(t, "units:%s \"\" \"\" \"\" \"", component ? " \"\"" : "");
        add_clean(t, info->frame_unit);
        vvi_text_add(t, "\"\n");
    }
}

static void add_key_number(vvi_text *t, const char *key, double value)
{
    char number[32];
    vvi_print_unsigned_zero(number, value);
    vvi_text_printf(t, "%s:=%s\n", key, number);
}

/* A volume of a series has no axis that could say it. */
static void add_time_of_one(vvi_text *t, const vv_field_info *info)
{
    if (info->frame_step == 0 || !isfinite(info->frame_step) || (info->frame_step == 1 && !info->frame_unit[0]))
        return;
    add_key_number(t, "volvis frame step", info->frame_step);
    if (info->frame_unit[0]) {
        vvi_text_add(t, "volvis frame unit:=");
        add_clean(t, info->frame_unit);
        vvi_text_add(t, "\n");
    }
}

/* A text that was longer than it is kept here stays what it was. */
static const char *whole_text(const char *now, const char *then)
{
    const size_t n = strlen(now), quoted = then[0] == '"';
    return n > 0 && strncmp(then + quoted, now, n) == 0 && n >= 15 ? then : NULL;
}

static void add_values(vvi_text *t, const vv_field_info *info, const vv_write_options *options)
{
    vvi_nrrd_kept k = {0};
    const bool known = vvi_nrrd_get_kept(&k, options);
    const char *content = known ? whole_text(info->name, k.content) : NULL;
    const char *unit = known ? whole_text(info->value_unit, k.sample_units) : NULL;
    if (content) {
        vvi_text_printf(t, "content: %s\n", content);
    } else if (info->name[0]) {
        vvi_text_add(t, "content: ");
        add_clean(t, info->name);
        vvi_text_add(t, "\n");
    }
    if (unit) {
        vvi_text_printf(t, "sample units: %s\n", unit);
    } else if (info->value_unit[0]) {
        vvi_text_add(t, "sample units: \"");
        add_clean(t, info->value_unit);
        vvi_text_add(t, "\"\n");
    }
    if (info->value_scale != 1)
        add_key_number(t, "volvis value scale", info->value_scale);
    if (info->value_offset != 0)
        add_key_number(t, "volvis value offset", info->value_offset);
    if (info->meaning == VV_MEANING_LABEL)
        vvi_text_add(t, "volvis meaning:=label\n");
    else if (info->meaning == VV_MEANING_VECTOR && info->components != 3)
        vvi_text_add(t, "volvis meaning:=vector\n");
}

/* The roles of the axes that are written, and how many there are. */
static int list_roles(int roles[VVI_ROLES], bool component, bool time)
{
    int n = 0;
    if (component)
        roles[n++] = VVI_ROLE_COMPONENT;
    for (int r = VVI_ROLE_X; r <= VVI_ROLE_Z; r++)
        roles[n++] = r;
    if (time)
        roles[n++] = VVI_ROLE_FRAME;
    return n;
}

static vv_status build_header(vvi_text *t, const vv_field_info *info, size_t n_frames, const char *encoding,
                              const vv_write_options *options, const vvi_nrrd_segmentation *seg)
{
    int roles[VVI_ROLES];
    vvi_nrrd_kept k;
    const bool component = has_component_axis(info), time = n_frames > 1;
    const int64_t *n = info->grid.dims;
    const char *kind = vvi_nrrd_take_kind(&k, info, options);
    const int n_axes = list_roles(roles, component, time);
    vvi_text_add(t, "NRRD0005\n# written by VolVis\n");
    vvi_nrrd_take_lines(t, VVI_NRRD_KEPT_COMMENT, info, options);
    vvi_text_printf(t, "type: %s\ndimension: %d\n", type_name(info->type), n_axes);
    if (vvi_nrrd_is_placed(&info->grid))
        add_space(t, &info->grid, component, time);
    vvi_text_add(t, "sizes:");
    if (component)
        vvi_text_printf(t, " %d", info->components);
    vvi_text_printf(t, " %" PRId64 " %" PRId64 " %" PRId64, n[0], n[1], n[2]);
    if (time)
        vvi_text_printf(t, " %zu", n_frames);
    vvi_text_printf(t, "\nkinds:%s%s domain domain domain%s\n", component ? " " : "",
                    !component ? ""
                    : kind     ? kind
                               : component_kind(info),
                    time ? " time" : "");
    if (time)
        add_time(t, info, component);
    if (vv_type_bytes(info->type) > 1 && strcmp(encoding, "ascii") != 0)
        vvi_text_printf(t, "endian: %s\n", options->big_endian ? "big" : "little");
    vvi_text_printf(t, "encoding: %s\n", encoding);
    vvi_nrrd_take_fields(t, info, options, roles, n_axes);
    add_values(t, info, options);
    if (!time)
        add_time_of_one(t, info);
    vvi_nrrd_take_lines(t, VVI_NRRD_KEPT_KEY, info, options);
    vvi_nifti_add_words(t, VVI_NRRD_NIFTI, ":=", info, n_frames, options);
    if (info->meaning == VV_MEANING_LABEL || seg)
        return vvi_nrrd_add_segments(t, info, options, seg);
    vvi_nrrd_add_channels(t, info, options);
    return VV_OK;
}

/* The header ends so that raw samples lie well: a comment fills it up. */
static void pad_header(vvi_text *t)
{
    const size_t bare = t->n + 1; /* with the empty line */
    const size_t over = bare % ALIGNMENT;
    if (over == 0)
        return;
    size_t fill = ALIGNMENT - over;
    if (fill < 3)
        fill += ALIGNMENT;
    vvi_text_add(t, "# ");
    for (size_t i = 3; i < fill; i++)
        vvi_text_add(t, ".");
    vvi_text_add(t, "\n");
}

/* Text ------------------------------------------------------------------------------------------------------------- */

typedef struct texting {
    vv_sink *sink;
    vv_type type;
    int column;
    bool hex, swap;
} texting;

static vv_status write_value(texting *w, const uint8_t *at)
{
    char number[32];
    vvi_sample_print(number, w->type, at);
    const char *after = ++w->column % 10 ? " " : "\n";
    return vvi_sink_printf(w->sink, "%s%s", number, after);
}

static vv_status write_text(void *user, void *data, size_t n_bytes)
{
    texting *w = user;
    const uint8_t *at = data;
    const size_t bytes = vv_type_bytes(w->type);
    vv_status st = VV_OK;
    if (!w->hex) {
        for (size_t i = 0; i < n_bytes && st == VV_OK; i += bytes)
            st = write_value(w, at + i);
        return st;
    }
    if (w->swap)
        vvi_swap_bytes(data, bytes, n_bytes / bytes);
    static const char digits[] = "0123456789abcdef";
    for (size_t i = 0; i < n_bytes && st == VV_OK; i++) {
        const char two[3] = {digits[at[i] >> 4], digits[at[i] & 15], '\n'};
        st = vvi_sink_write(w->sink, two, ++w->column % 36 ? 2 : 3);
    }
    return st;
}

/* Where the samples go ----------------------------------------------------------------------------------------------
 */

static vv_status write_samples(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const char *encoding,
                               const vv_write_options *options, vv_job *job)
{
    const bool hex = strcmp(encoding, "hex") == 0, text = hex || strcmp(encoding, "ascii") == 0;
    const vvi_coding coding = strcmp(encoding, "gzip") == 0    ? VVI_CODING_GZIP
                              : strcmp(encoding, "bzip2") == 0 ? VVI_CODING_BZIP2
                              : strcmp(encoding, "zstd") == 0  ? VVI_CODING_ZSTD
                                                               : VVI_CODING_NONE;
    const vv_type type = vv_field_get_info(frames[0])->type;
    texting t = {sink, type, 0, hex, vv_type_bytes(type) > 1 && vvi_order_swapped(options->big_endian)};
    vv_status st = coding != VVI_CODING_NONE ? vvi_sink_coding(sink, (int)coding, options->level) : VV_OK;
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = text ? vvi_samples_each(frames[f], -1, write_text, &t, job)
                  : vvi_samples_write(sink, frames[f], -1, options->big_endian, job);
    if (st == VV_OK && coding != VVI_CODING_NONE)
        st = vvi_sink_coding(sink, VVI_CODING_NONE, 0);
    return st;
}

static bool is_detached(const char *path)
{
    const size_t n = strlen(path);
    return n > 5 && strcasecmp(path + n - 5, ".nhdr") == 0;
}

/* "head.nhdr" keeps its samples in "head.raw", "head.raw.gz", ... */
static vv_status open_data(vv_sink **data, vvi_text *header, vv_sink *sink, const char *encoding)
{
    const char *path = vvi_sink_name(sink), *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    const char *suffix = strcmp(encoding, "gzip") == 0    ? ".raw.gz"
                         : strcmp(encoding, "bzip2") == 0 ? ".raw.bz2"
                         : strcmp(encoding, "zstd") == 0  ? ".raw.zst"
                         : strcmp(encoding, "raw") == 0   ? ".raw"
                                                          : ".txt";
    vvi_text name = {0};
    vvi_text_add_n(&name, base, strlen(base) - 5);
    vvi_text_add(&name, suffix);
    vvi_text_printf(header, "data file: %s\n", name.s ? name.s : "");
    vv_status st = name.bad || !name.s ? vv_fail_memory(strlen(base)) : vvi_sink_beside_on_line(data, sink, name.s);
    vvi_text_free(&name);
    return st;
}

vv_status vvi_nrrd_write_all(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                             const vv_write_options *options, const vvi_nrrd_segmentation *seg, vv_job *job)
{
    const char *encoding = options->encoding ? options->encoding : vvi_nrrd_encodings[0];
    const bool detached = is_detached(vvi_sink_name(sink));
    vv_sink *data = sink;
    vvi_text header = {0};
    vv_status st = build_header(&header, vv_field_get_info(frames[0]), n_frames, encoding, options, seg);
    if (st == VV_OK && detached)
        st = open_data(&data, &header, sink, encoding);
    else
        pad_header(&header);
    if (!detached)
        vvi_text_add(&header, "\n");
    if (st == VV_OK)
        st = header.bad ? vv_fail_memory(header.n) : vvi_sink_write(sink, header.s, header.n);
    vvi_text_free(&header);
    return st == VV_OK ? write_samples(data, frames, n_frames, encoding, options, job) : st;
}

vv_status vvi_nrrd_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames, const vv_write_options *options,
                         vv_job *job)
{
    return vvi_nrrd_write_all(sink, frames, n_frames, options, NULL, job);
}
