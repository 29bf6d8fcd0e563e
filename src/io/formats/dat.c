/* The .dat headers of Voreen, Ultravis and the volume renderers around them: "Key: value" lines that name a raw file.
 */
#include "io/data_files.h"
#include "io/sample_writer.h"
#include "registry.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    char text[513];
    const size_t m = n < sizeof text - 1 ? n : sizeof text - 1;
    memcpy(text, head, m);
    text[m] = 0;
    const bool file = strcasestr(text, "ObjectFileName"), resolution = strcasestr(text, "Resolution");
    return file && resolution ? 2 : 0;
}

/* Lines ------------------------------------------------------------------------------------------------------------ */

static vv_status collect(vvi_keys *keys, vv_source *source)
{
    const char *line, *value;
    bool end = false;
    size_t n_name;
    vv_status st = VV_OK;
    for (int number = 1; st == VV_OK; number++) {
        st = vvi_source_line(source, &line, (size_t)vvi_source_limits(source)->string_bytes, &end);
        if (st != VV_OK || end)
            return st;
        line += strspn(line, " \t");
        if (line[0] == 0 || line[0] == '#')
            continue;
        if (vvi_keys_split(line, ":=", &n_name, &value)) {
            st = vvi_keys_add(keys, line, n_name, value, strlen(value), number);
        } else {
            char where[16];
            snprintf(where, sizeof where, "%d", number);
            st = vv_fail_at(VV_E_FORMAT, keys->file, where, "'%.40s' is not 'Key: value'", line);
        }
    }
    return st;
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

/* "USHORT", "UCHAR3", "FLOAT"; USHORT_12 keeps 12 bits in 16. */
static bool parse_format(vv_field_info *info, const char *text)
{
    static const struct {
        const char *name;
        vv_type type;
    } types[] = {{"UCHAR", VV_TYPE_U8},     {"CHAR", VV_TYPE_I8},   {"USHORT", VV_TYPE_U16},  {"SHORT", VV_TYPE_I16},
                 {"UINT", VV_TYPE_U32},     {"INT", VV_TYPE_I32},   {"FLOAT", VV_TYPE_F32},   {"DOUBLE", VV_TYPE_F64},
                 {"UINT8", VV_TYPE_U8},     {"INT8", VV_TYPE_I8},   {"UINT16", VV_TYPE_U16},  {"INT16", VV_TYPE_I16},
                 {"UINT32", VV_TYPE_U32},   {"INT32", VV_TYPE_I32}, {"FLOAT32", VV_TYPE_F32}, {"FLOAT64", VV_TYPE_F64},
                 {"USHORT_12", VV_TYPE_U16}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        const size_t n = strlen(types[i].name);
        if (strncasecmp(text, types[i].name, n) != 0 ||
            (text[n] != 0 && (text[n] < '2' || text[n] > '4' || text[n + 1])))
            continue;
        info->type = types[i].type;
        info->components = text[n] ? text[n] - '0' : 1;
        return true;
    }
    return false;
}

/* OpenQVis wants "ObjectModel: RGBA" in every header, also of scalars; the length of the data tells. */
static vv_status read_model(vv_field_info *info, vvi_keys *keys, vv_source *source, vv_job *job)
{
    const char *model = vvi_keys_get(keys, "ObjectModel"), *name = vvi_keys_get(keys, "ObjectFileName");
    const int said = model && strcasecmp(model, "RGB") == 0 ? 3 : model && strcasecmp(model, "RGBA") == 0 ? 4 : 1;
    const int64_t *dims = info->grid.dims;
    if (info->components == 1 && said > 1) {
        vv_source *data;
        bool exact;
        vv_status st = vvi_source_open_beside(&data, source, name, job);
        if (st != VV_OK)
            return st;
        const double wanted = (double)dims[0] * (double)dims[1] * (double)dims[2] * (double)vv_type_bytes(info->type);
        if ((double)vvi_source_left(data, &exact) == wanted * said && exact)
            info->components = said;
        vvi_source_close(data);
    }
    if (info->type == VV_TYPE_U8 && (info->components == 3 || info->components == 4))
        info->meaning = info->components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    return VV_OK;
}

static vv_status read_samples_kind(vv_field_info *info, bool *big, vvi_keys *keys)
{
    const char *format = vvi_keys_get(keys, "Format"), *order = vvi_keys_get(keys, "ByteOrder");
    vv_status st = vvi_keys_need(keys, "Format");
    if (st != VV_OK)
        return st;
    if (!parse_format(info, format))
        return vvi_keys_fail(keys, "Format", "is '%.40s'; UCHAR, USHORT, FLOAT and the like are known", format);
    order = order ? order : vvi_keys_get(keys, "Endianness");
    *big = order && strncasecmp(order, "big", 3) == 0;
    return VV_OK;
}

static vv_status place(vv_field_info *info, vvi_keys *keys)
{
    double step[3] = {1, 1, 1};
    const char *text = vvi_keys_get(keys, "SliceThickness");
    vv_status st = vvi_keys_reals(step, 3, keys, "SliceThickness");
    if (st != VV_OK)
        return st;
    for (int a = 0; a < 3; a++)
        if (!(step[a] > 0))
            return vvi_keys_fail(keys, "SliceThickness", "is '%.60s'; each of the three must be more than 0", text);
    info->grid.index_to_world = (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {0, 0, 0}};
    snprintf(info->grid.unit, sizeof info->grid.unit, "%s", text ? "units" : "voxels");
    return VV_OK;
}

static vv_status understand(vv_field_info *info, vvi_data_files *d, vvi_keys *keys, vv_source *source, vv_notes *notes,
                            vv_job *job)
{
    bool big = false;
    int64_t *dims = info->grid.dims;
    vv_status st = collect(keys, source);
    if (st == VV_OK)
        st = vvi_keys_need(keys, "Resolution");
    if (st != VV_OK || (st = vvi_keys_dims(dims, 3, keys, "Resolution", d->limits)) != VV_OK ||
        (st = read_samples_kind(info, &big, keys)) != VV_OK || (st = place(info, keys)) != VV_OK ||
        (st = vvi_keys_need(keys, "ObjectFileName")) != VV_OK || (st = read_model(info, keys, source, job)) != VV_OK)
        return st;
    d->layout = (vvi_layout){.n_axes = 4,
                             .axis = {{info->components, VVI_ROLE_COMPONENT},
                                      {dims[0], VVI_ROLE_X},
                                      {dims[1], VVI_ROLE_Y},
                                      {dims[2], VVI_ROLE_Z}},
                             .type = info->type,
                             .swap = vv_type_bytes(info->type) > 1 && vvi_order_swapped(big)};
    const char *name = vvi_keys_get(keys, "ObjectFileName");
    if (!name[0])
        return vvi_keys_fail(keys, "ObjectFileName", "names no file");
    st = vvi_data_files_add(d, name);
    return st == VV_OK ? vvi_keys_note_rest(keys, notes) : st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_data_files_open(info, plan_out, source, understand, notes, job);
}

static const char *const suffixes[] = {".dat", NULL};

const vv_format vvi_format_dat = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "dat",
    .doc = "raw samples with a .dat header of Voreen or Ultravis",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_data_files_free_plan,
    .read = vvi_data_files_read_plan,
    .mappable = vvi_data_files_mappable,
};
