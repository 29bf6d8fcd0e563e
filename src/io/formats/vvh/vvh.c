/* Raw samples with a header that people write by hand: one "key: value" a line. docs/formats.md says what there is. */
#include "io/formats/vvh/vvh.h"
#include "core/names.h"
#include "io/coding.h"
#include "io/data_files.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

static const char *const known[] = {
    "dims",       "type",  "byte order", "spacing", "origin", "directions", "space",  "unit",
    "components", "order", "meaning",    "scale",   "offset", "value unit", "frames", "frame step",
    "frame unit", "name",  "comment",    "coding",  "skip",   "data",
};
#define N_KNOWN (sizeof known / sizeof *known)

static bool line_has(const uint8_t *head, size_t n, const char *key)
{
    const size_t m = strlen(key);
    for (const uint8_t *at = head; at + m < head + n; at++) {
        if (strncasecmp((const char *)at, key, m) == 0)
            return true;
        if (!(at = memchr(at, '\n', n - (size_t)(at - head))))
            return false;
    }
    return false;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    const size_t n_path = strlen(path);
    const bool named = n_path > 4 && strcasecmp(path + n_path - 4, ".vvh") == 0;
    const bool looks = line_has(head, n, "dims:") && line_has(head, n, "type:") && line_has(head, n, "data:");
    return named && looks ? 2 : named || looks;
}

/* Lines ------------------------------------------------------------------------------------------------------------ */

static vv_status fail_line(const vvi_keys *keys, int number, const char *line)
{
    char where[16];
    snprintf(where, sizeof where, "%d", number);
    return vv_fail_at(VV_E_FORMAT, keys->file, where, "'%.40s' is neither 'key: value' nor a # comment", line);
}

static vv_status check_name(const vvi_keys *keys)
{
    char where[16];
    const vvi_key *key = &keys->key[keys->n - 1];
    for (size_t i = 0; i < N_KNOWN; i++)
        if (strcasecmp(key->name, known[i]) == 0)
            return VV_OK;
    snprintf(where, sizeof where, "%d", key->line);
    return vvi_fail_name(VV_E_FORMAT, keys->file, where, key->name, &(vvi_known){known, N_KNOWN, NULL, NULL},
                         "there is no key '%.40s'", key->name);
}

/* Keys, and after a "data:" without a value the names of files. */
static vv_status collect(vvi_keys *keys, vvi_data_files *d, vv_source *source)
{
    const char *line, *value;
    bool end = false, list = false;
    size_t n_name;
    vv_status st = VV_OK;
    for (int number = 1; st == VV_OK; number++) {
        st = vvi_source_line(source, &line, (size_t)vvi_source_limits(source)->string_bytes, &end);
        if (st != VV_OK || end)
            return st;
        line += strspn(line, " \t");
        if (line[0] == 0 || line[0] == '#')
            continue;
        if (list) {
            st = vvi_data_files_add(d, line);
            continue;
        }
        if (!vvi_keys_split(line, ":", &n_name, &value))
            return fail_line(keys, number, line);
        if ((st = vvi_keys_add(keys, line, n_name, value, strlen(value), number)) == VV_OK)
            st = check_name(keys);
        const vvi_key *key = st == VV_OK ? &keys->key[keys->n - 1] : NULL;
        list = key && strcasecmp(key->name, "data") == 0 && key->value[0] == 0;
    }
    return st;
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

static vv_status read_type(vv_field_info *info, bool *big, vvi_keys *keys)
{
    int64_t components = 1, frames = 1;
    const char *type = vvi_keys_get(keys, "type"), *order = vvi_keys_get(keys, "byte order");
    vv_status st = vvi_keys_need(keys, "type");
    if (st != VV_OK)
        return st;
    if (!vv_type_parse(&info->type, type))
        return vvi_keys_fail(keys, "type", "is '%.40s', which is not a type; write for example u8, int16 or float",
                             type);
    *big = order && strcasecmp(order, "big") == 0;
    if (order && !*big && strcasecmp(order, "little") != 0)
        return vvi_keys_fail(keys, "byte order", "is '%.40s'; it is little or big", order);
    if ((st = vvi_keys_int(&components, keys, "components", 1, 65535)) != VV_OK ||
        (st = vvi_keys_int(&frames, keys, "frames", 1, INT64_C(1) << 40)) != VV_OK)
        return st;
    info->components = (int)components;
    info->n_frames = frames;
    if (info->type == VV_TYPE_U8 && (components == 3 || components == 4))
        info->meaning = components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    return vvi_keys_meaning(info, keys, "meaning");
}

static vv_status read_dims(vv_grid *grid, vvi_keys *keys, const vv_limits *limits)
{
    const char *at = vvi_keys_get(keys, "dims");
    vv_status st = vvi_keys_need(keys, "dims");
    int n = 0;
    for (int64_t size; st == VV_OK && n < 3 && vvi_scan_int(&size, at, &at); n++) {
        if (size < 1 || (uint64_t)size > limits->dim)
            return vvi_keys_fail(keys, "dims", "has %lld; 1 to %llu are possible (--limit dim=N allows more)",
                                 (long long)size, (unsigned long long)limits->dim);
        grid->dims[n] = size;
        at += *at == 'x' || *at == ',';
    }
    if (st == VV_OK && (n == 0 || at[strspn(at, " \t")] != 0))
        st = vvi_keys_fail(keys, "dims", "is '%.60s'; expected the samples along x, y and z, as in 256 256 128",
                           vvi_keys_get(keys, "dims"));
    return st;
}

/* "c x y z t": what runs fastest stands first; c and t may be left out where there is one of them. */
static vv_status read_order(vvi_layout *layout, const vv_field_info *info, vvi_keys *keys)
{
    static const char letters[] = "cxyzt";
    const int64_t *dims = info->grid.dims,
                  sizes[VVI_ROLES] = {info->components, dims[0], dims[1], dims[2], info->n_frames};
    const char *text = vvi_keys_get(keys, "order");
    unsigned seen = 0;
    for (const char *at = text ? text : letters; *at; at++) {
        const char *letter = strchr(letters, tolower((unsigned char)*at));
        if (*at == ' ' || *at == '\t')
            continue;
        const unsigned role = letter ? (unsigned)(letter - letters) : VVI_ROLES;
        if (role == VVI_ROLES || (seen >> role & 1))
            return vvi_keys_fail(keys, "order", "is '%.40s'; it has each of x, y, z, c and t once, the fastest first",
                                 text);
        seen |= 1u << role;
        layout->axis[layout->n_axes++] = (vvi_layout_axis){sizes[role], (vvi_role)role};
    }
    for (unsigned role = 0; role < VVI_ROLES; role++)
        if (!(seen >> role & 1) && sizes[role] > 1)
            return vvi_keys_fail(keys, "order", "is '%.40s'; it lacks %c, of which there are %lld", text, letters[role],
                                 (long long)sizes[role]);
    return layout->n_axes > 0 ? VV_OK : vvi_keys_fail(keys, "order", "is empty");
}

/* Placement ---------------------------------------------------------------------------------------------------------
 */

static vv_status read_space(vv_space *out, double flip[2], vvi_keys *keys)
{
    const char *text = vvi_keys_get(keys, "space");
    *out = VV_SPACE_PLAIN;
    flip[0] = flip[1] = 1;
    if (!text || strcasecmp(text, "plain") == 0)
        return VV_OK;
    *out = VV_SPACE_RAS;
    if (strcasecmp(text, "LPS") == 0)
        flip[0] = flip[1] = -1;
    else if (strcasecmp(text, "RAS") != 0)
        return vvi_keys_fail(keys, "space", "is '%.40s'; it is plain, RAS or LPS", text);
    return VV_OK;
}

static vv_status place(vv_field_info *info, vvi_keys *keys)
{
    vv_grid *grid = &info->grid;
    double spacing[3] = {1, 1, 1}, origin[3] = {0}, d[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, flip[2];
    vv_status st = read_space(&grid->space, flip, keys);
    if (st != VV_OK || (st = vvi_keys_reals(spacing, 3, keys, "spacing")) != VV_OK ||
        (st = vvi_keys_reals(origin, 3, keys, "origin")) != VV_OK ||
        (st = vvi_keys_reals(d, 9, keys, "directions")) != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        grid->index_to_world.axis[a] =
            (vv_vec3){d[3 * a] * spacing[a] * flip[0] + 0.0, d[3 * a + 1] * spacing[a] * flip[1] + 0.0,
                      d[3 * a + 2] * spacing[a] + 0.0}; /* no -0 */
    grid->index_to_world.origin = (vv_vec3){origin[0] * flip[0] + 0.0, origin[1] * flip[1] + 0.0, origin[2]};
    if (!vvi_affine_finite(&grid->index_to_world) || vv_affine_determinant(grid->index_to_world) == 0)
        return vv_fail_at(VV_E_FORMAT, keys->file, NULL,
                          "its spacing is 0 or out of range, or its directions lie in one plane");
    const char *unit = vvi_keys_get(keys, "unit");
    const bool placed =
        vvi_keys_get(keys, "spacing") || vvi_keys_get(keys, "origin") || vvi_keys_get(keys, "directions");
    if (unit && unit[0])
        vvi_unit_name(grid->unit, unit, strlen(unit));
    else
        snprintf(grid->unit, sizeof grid->unit, "%s", grid->space == VV_SPACE_RAS ? "mm" : placed ? "units" : "voxels");
    return VV_OK;
}

static vv_status read_values(vv_field_info *info, vvi_keys *keys, vv_notes *notes)
{
    vv_status st = vvi_keys_reals(&info->value_scale, 1, keys, "scale");
    if (st == VV_OK)
        st = vvi_keys_reals(&info->value_offset, 1, keys, "offset");
    if (st == VV_OK)
        st = vvi_keys_reals(&info->frame_step, 1, keys, "frame step");
    if (st == VV_OK && info->value_scale == 0)
        st = vvi_keys_fail(keys, "scale", "is 0; omit it if the samples are the values");
    vvi_keys_text(info->value_unit, sizeof info->value_unit, keys, "value unit");
    vvi_keys_text(info->frame_unit, sizeof info->frame_unit, keys, "frame unit");
    vvi_keys_text(info->name, sizeof info->name, keys, "name");
    const char *comment = vvi_keys_get(keys, "comment");
    return st == VV_OK && comment ? vvi_notes_add(notes, "comment", comment) : st;
}

/* Data ---------------------------------------------------------------------------------------------------------------
 */

static vv_status read_coding(vvi_data_files *d, vvi_keys *keys)
{
    static const vvi_coding codings[] = {VVI_CODING_NONE, VVI_CODING_GZIP, VVI_CODING_BZIP2, VVI_CODING_ZSTD,
                                         VVI_CODING_ZLIB};
    const char *text = vvi_keys_get(keys, "coding");
    vv_status st = vvi_keys_int(&d->skip, keys, "skip", -1, INT64_C(1) << 50);
    if (st != VV_OK || !text)
        return st;
    d->numbers = strcasecmp(text, "text") == 0;
    bool found = d->numbers;
    for (size_t i = 0; i < sizeof codings / sizeof *codings && !found; i++)
        if ((found = strcasecmp(text, vvi_coding_name(codings[i])) == 0))
            d->coding = codings[i];
    if (!found)
        return vvi_keys_fail(keys, "coding", "is '%.40s'; raw, text, gzip, bzip2, zstd and zlib are known", text);
    if (d->skip < 0 && (d->numbers || d->coding != VVI_CODING_NONE))
        return vvi_keys_fail(keys, "skip", "is -1 (the data end the file), which only raw data can be");
    return vvi_coding_available(d->coding);
}

/* A name, or PATTERN first last step. */
static vv_status read_data(vvi_data_files *d, vvi_keys *keys)
{
    const char *text = vvi_keys_get(keys, "data"), *at;
    int64_t range[3] = {0, 0, 1};
    bool memory;
    int count = 0;
    vv_status st = vvi_keys_need(keys, "data");
    if (st != VV_OK || d->n > 0)
        return st;
    if (text[0] == 0)
        return vvi_keys_fail(keys, "data", "names no file");
    const char *percent = strchr(text, '%');
    const size_t n = percent ? (size_t)(percent - text) + strcspn(percent, " \t") : 0;
    for (at = text + n; percent && count < 3 && vvi_scan_int(&range[count], at, &at);)
        count++;
    if (count < 2 && !percent)
        return vvi_data_files_add(d, text);
    if (count < 2 || at[strspn(at, " \t")] != 0)
        return vvi_keys_fail(keys, "data", "is '%.60s'; write slice%%03d.raw FIRST LAST, and a STEP if it is not 1",
                             text);
    const char *wrong = vvi_data_files_expand(d, text, n, range, &memory);
    if (!wrong)
        return VV_OK;
    return memory ? vv_fail_memory(n)
                  : vvi_keys_fail(keys, "data", "has the pattern '%.*s', which %s", n < 60 ? (int)n : 60, text, wrong);
}

static vv_status understand(vv_field_info *info, vvi_data_files *d, vvi_keys *keys, vv_source *source, vv_notes *notes,
                            vv_job *job)
{
    bool big = false;
    vv_status st = collect(keys, d, source);
    if (st == VV_OK)
        st = read_dims(&info->grid, keys, d->limits);
    if (st != VV_OK || (st = read_type(info, &big, keys)) != VV_OK ||
        (st = read_order(&d->layout, info, keys)) != VV_OK || (st = place(info, keys)) != VV_OK ||
        (st = read_values(info, keys, notes)) != VV_OK || (st = read_coding(d, keys)) != VV_OK)
        return st;
    d->layout.type = info->type;
    d->layout.swap = !d->numbers && vv_type_bytes(info->type) > 1 && vvi_order_swapped(big);
    const char *space = vvi_keys_get(keys, "space");
    if (info->meaning == VV_MEANING_VECTOR && info->components == 3 && space && strcasecmp(space, "LPS") == 0 &&
        vvi_type_min(info->type) < 0)
        d->layout.negate = 3;
    return read_data(d, keys);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_data_files_open(info, plan_out, source, understand, notes, job);
}

static const char *const suffixes[] = {".vvh", NULL};

const vv_format vvi_format_vvh = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "vvh",
    .doc = "raw samples in one file or many, and a header to write by hand",
    .suffixes = suffixes,
    .encodings = vvi_vvh_encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_data_files_free_plan,
    .read = vvi_data_files_read_plan,
    .mappable = vvi_data_files_mappable,
    .write = vvi_vvh_write,
};
