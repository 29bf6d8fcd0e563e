/* MetaImage: .mhd with a data file, .mha with the samples behind the header: https://itk.org/Wiki/MetaIO/Documentation
 */
#include "io/formats/metaimage/metaimage.h"
#include "core/names.h"
#include "io/data_files.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

/* A key at the start of a line, with its '=' or ':'. */
static bool has_key(const uint8_t *head, size_t n, const char *key)
{
    const size_t m = strlen(key);
    for (size_t at = 0; at + m < n;) {
        if (strncasecmp((const char *)head + at, key, m) == 0) {
            size_t i = at + m;
            while (i < n && (head[i] == ' ' || head[i] == '\t'))
                i++;
            if (i < n && (head[i] == '=' || head[i] == ':'))
                return true;
        }
        const uint8_t *end = memchr(head + at, '\n', n - at);
        if (!end)
            break;
        at = (size_t)(end - head) + 1;
    }
    return false;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    const bool dims = has_key(head, n, "NDims");
    if (dims && (has_key(head, n, "DimSize") || has_key(head, n, "ElementDataFile")))
        return 2;
    return dims || has_key(head, n, "ObjectType") ? 1 : 0;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

static vv_status keep_line(vvi_keys *keys, const char *line, int number, bool *last)
{
    char where[16];
    size_t n_name;
    const char *value;
    *last = false;
    if (line[strspn(line, " \t\r")] == 0)
        return VV_OK;
    if (!vvi_keys_split(line, "=", &n_name, &value) && !vvi_keys_split(line, ":", &n_name, &value)) {
        snprintf(where, sizeof where, "%d", number);
        return vv_fail_at(VV_E_FORMAT, keys->file, where, "'%.40s' is not 'Key = value'", line);
    }
    vv_status st = vvi_keys_add(keys, line, n_name, value, strlen(value), number);
    *last = st == VV_OK && strcasecmp(keys->key[keys->n - 1].name, "ElementDataFile") == 0;
    return st;
}

/* Everything up to the key that ends a header. */
static vv_status collect(vvi_keys *keys, vv_source *source)
{
    const char *line;
    bool end = false, last = false;
    vv_status st = VV_OK;
    for (int number = 1; st == VV_OK && !last; number++) {
        st = vvi_source_line(source, &line, (size_t)vvi_source_limits(source)->string_bytes, &end);
        if (st == VV_OK && end)
            return vv_fail_at(
                VV_E_FORMAT, keys->file, NULL,
                "its header has no 'ElementDataFile', which ends it; the file is cut short or no MetaImage");
        if (st == VV_OK)
            st = keep_line(keys, line, number, &last);
    }
    return st;
}

/* Data ------------------------------------------------------------------------------------------------------------- */

/* How many files a list or a pattern must name: the product of the axes that a file does not have. */
static size_t files_wanted(const int64_t *sizes, int n_dims, int per_file)
{
    uint64_t n = 1;
    for (int a = per_file; a < n_dims; a++)
        n *= (uint64_t)sizes[a];
    return (size_t)n;
}

static vv_status read_list(vvi_data_files *d, const vvi_keys *keys, vv_source *source, size_t wanted)
{
    const char *line;
    bool end = false;
    while (d->n < wanted && !end) {
        vv_status st = vvi_source_line(source, &line, (size_t)vvi_source_limits(source)->string_bytes, &end);
        if (st != VV_OK)
            return st;
        const size_t blank = strspn(line, " \t");
        if (!end && line[blank] && (st = vvi_data_files_add(d, line + blank)) != VV_OK)
            return st;
    }
    return d->n == wanted ? VV_OK
                          : vvi_keys_fail(keys, "ElementDataFile",
                                          "is LIST, but %zu names follow; DimSize asks for %zu", d->n, wanted);
}

/* PATTERN first last step; what is left out is 1, as many as there are slices, and 1. */
static vv_status expand(vvi_data_files *d, const vvi_keys *keys, const char *text, size_t wanted)
{
    const char *percent = strchr(text, '%'), *at;
    const size_t n = (size_t)(percent - text) + strcspn(percent, " \t");
    int64_t range[3] = {1, 0, 1};
    bool memory;
    int count = 0;
    for (at = text + n; count < 3 && vvi_scan_int(&range[count], at, &at);)
        count++;
    if (at[strspn(at, " \t")] || range[0] < -(INT64_C(1) << 40) || range[0] > INT64_C(1) << 40)
        return vvi_keys_fail(keys, "ElementDataFile", "is '%.60s'; write name%%03d.raw FIRST LAST STEP", text);
    if (count < 2)
        range[1] = range[0] + (int64_t)wanted - 1;
    const char *wrong = vvi_data_files_expand(d, text, n, range, &memory);
    if (wrong)
        return memory ? vv_fail_memory(n)
                      : vvi_keys_fail(keys, "ElementDataFile", "has the pattern '%.*s', which %s", n < 60 ? (int)n : 60,
                                      text, wrong);
    return d->n == wanted
               ? VV_OK
               : vvi_keys_fail(keys, "ElementDataFile", "makes %zu names; DimSize asks for %zu", d->n, wanted);
}

static vv_status find_files(vvi_data_files *d, vvi_keys *keys, vv_source *source, const int64_t *sizes, int n_dims)
{
    const char *text = vvi_keys_get(keys, "ElementDataFile"), *end;
    int64_t per_file = n_dims - 1;
    if (strcasecmp(text, "LOCAL") == 0)
        return VV_OK;
    if (strncasecmp(text, "LIST", 4) == 0 && (text[4] == 0 || text[4] == ' ')) {
        if (text[4] && (!vvi_scan_int(&per_file, text + 4, &end) || per_file < 1 || per_file > n_dims))
            return vvi_keys_fail(keys, "ElementDataFile",
                                 "is '%.40s'; after LIST comes the number of axes of a file, 1 to %d", text, n_dims);
        const size_t wanted = files_wanted(sizes, n_dims, (int)per_file);
        return read_list(d, keys, source, wanted);
    }
    if (text[0] == 0)
        return vvi_keys_fail(keys, "ElementDataFile", "names no file");
    return strchr(text, '%') ? expand(d, keys, text, files_wanted(sizes, n_dims, n_dims - 1))
                             : vvi_data_files_add(d, text);
}

static vv_status find_coding(vvi_data_files *d, vvi_keys *keys, vv_source *source)
{
    bool compressed = false, binary = true;
    int64_t skip = 0, coded = 0;
    vv_status st = vvi_keys_flag(&compressed, keys, "CompressedData");
    if (st == VV_OK)
        st = vvi_keys_flag(&binary, keys, "BinaryData");
    if (st == VV_OK)
        st = vvi_keys_int(&skip, keys, "HeaderSize", -1, INT64_C(1) << 50);
    if (st == VV_OK)
        st = vvi_keys_int(&coded, keys, "CompressedDataSize", 0, INT64_MAX);
    if (st != VV_OK)
        return st;
    if (skip == -1 && (!binary || (compressed && coded == 0)))
        return vvi_keys_fail(keys, "HeaderSize", "is -1 (the data end the file), but how long %s is not known",
                             binary ? "the compressed data are" : "text is");
    d->numbers = !binary;
    d->coding = compressed ? VVI_CODING_ZLIB : VVI_CODING_NONE;
    /* Otherwise coded data end by themselves, and headers with a wrong size are about. */
    d->coded_bytes = skip == -1 && compressed ? (uint64_t)coded : UINT64_MAX;
    d->skip = skip == 0 && d->n == 0 ? (int64_t)vvi_source_tell(source) : skip;
    d->begins = d->n == 0 ? vvi_source_tell(source) : 0;
    return VV_OK;
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

static const struct {
    const char *name;
    vv_type type;
} types[] = {
    {"MET_CHAR", VV_TYPE_I8},    {"MET_UCHAR", VV_TYPE_U8},   {"MET_SHORT", VV_TYPE_I16},
    {"MET_USHORT", VV_TYPE_U16}, {"MET_INT", VV_TYPE_I32},    {"MET_UINT", VV_TYPE_U32},
    {"MET_LONG", VV_TYPE_I32},   {"MET_ULONG", VV_TYPE_U32},  {"MET_LONG_LONG", VV_TYPE_I64},
    {"MET_FLOAT", VV_TYPE_F32},  {"MET_DOUBLE", VV_TYPE_F64}, {"MET_ULONG_LONG", VV_TYPE_U64},
};
#define N_TYPES (sizeof types / sizeof *types)

static vv_status find_type(vv_type *out, vvi_keys *keys)
{
    const char *known[N_TYPES];
    const char *text = vvi_keys_get(keys, "ElementType");
    vv_status st = vvi_keys_need(keys, "ElementType");
    if (st != VV_OK)
        return st;
    size_t n = strlen(text);
    if (n > 6 && strcasecmp(text + n - 6, "_ARRAY") == 0)
        n -= 6;
    for (size_t i = 0; i < N_TYPES; i++) {
        known[i] = types[i].name;
        if (strlen(types[i].name) == n && strncasecmp(types[i].name, text, n) == 0) {
            *out = types[i].type;
            return VV_OK;
        }
    }
    vvi_text end = {0};
    vvi_known_add(&end, text, &(vvi_known){known, N_TYPES, NULL, NULL});
    st = vvi_keys_fail(keys, "ElementType", "is '%.40s', which is not a type of numbers%s", text,
                       end.s && !end.bad ? end.s : "");
    vvi_text_free(&end);
    return st;
}

static vv_status find_order(bool *big, vvi_keys *keys, vv_notes *notes)
{
    bool data = false;
    *big = false;
    vv_status st = vvi_keys_flag(&data, keys, "BinaryDataByteOrderMSB");
    if (st == VV_OK)
        *big = data;
    if (st == VV_OK)
        st = vvi_keys_flag(big, keys, "ElementByteOrderMSB");
    if (st == VV_OK && *big != data && vvi_keys_get(keys, "BinaryDataByteOrderMSB"))
        st = vvi_notes_warn(notes, "its ElementByteOrderMSB and BinaryDataByteOrderMSB disagree; the first is used");
    return st;
}

static vv_status find_meaning(vv_field_info *info, vvi_keys *keys, vvi_layout *layout)
{
    if (info->type == VV_TYPE_U8 && (info->components == 3 || info->components == 4))
        info->meaning = info->components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    vv_status st = vvi_keys_meaning(info, keys, VVI_METAIMAGE_MEANING);
    if (info->meaning == VV_MEANING_VECTOR && info->components == 3 && info->grid.space == VV_SPACE_RAS &&
        vvi_type_min(info->type) < 0)
        layout->negate = 3; /* left and back to right and front */
    return st;
}

static vv_status find_values(vv_field_info *info, vvi_keys *keys)
{
    vv_status st = vvi_keys_reals(&info->value_scale, 1, keys, "ElementToIntensityFunctionSlope");
    if (st == VV_OK)
        st = vvi_keys_reals(&info->value_offset, 1, keys, "ElementToIntensityFunctionOffset");
    if (st == VV_OK && info->value_scale == 0)
        st = vvi_keys_fail(keys, "ElementToIntensityFunctionSlope", "is 0; write 1 if the samples are the values");
    vvi_keys_text(info->value_unit, sizeof info->value_unit, keys, VVI_METAIMAGE_VALUE_UNIT);
    vvi_keys_text(info->frame_unit, sizeof info->frame_unit, keys, VVI_METAIMAGE_FRAME_UNIT);
    if (info->frame_step == 1 && !info->frame_unit[0])
        info->frame_step = 0; /* what is written where nothing is known: ElementSpacing has a number for every axis */
    vvi_keys_text(info->name, sizeof info->name, keys, "Name");
    return st;
}

static void fill_layout(vv_field_info *info, vvi_layout *layout, const int64_t sizes[VVI_METAIMAGE_AXES], bool swap)
{
    memcpy(info->grid.dims, sizes, sizeof info->grid.dims);
    info->n_frames = sizes[3];
    *layout = (vvi_layout){.n_axes = 5,
                           .axis = {{info->components, VVI_ROLE_COMPONENT},
                                    {sizes[0], VVI_ROLE_X},
                                    {sizes[1], VVI_ROLE_Y},
                                    {sizes[2], VVI_ROLE_Z},
                                    {sizes[3], VVI_ROLE_FRAME}},
                           .type = info->type,
                           .swap = swap && vv_type_bytes(info->type) > 1};
}

static vv_status check_object(vvi_keys *keys)
{
    const char *object = vvi_keys_get(keys, "ObjectType");
    if (object && strcasecmp(object, "Image") != 0) {
        vvi_keys_fail(keys, "ObjectType", "is '%.40s'; only an Image has samples", object);
        return vv_fail_in(VV_E_UNSUPPORTED, "MetaImage");
    }
    return VV_OK;
}

static vv_status find_sizes(int64_t sizes[VVI_METAIMAGE_AXES], int *n_dims, vvi_keys *keys, const vv_limits *limits)
{
    int64_t n = 0;
    vv_status st = check_object(keys);
    if (st != VV_OK || (st = vvi_keys_need(keys, "NDims")) != VV_OK || (st = vvi_keys_need(keys, "DimSize")) != VV_OK ||
        (st = vvi_keys_int(&n, keys, "NDims", 1, VVI_METAIMAGE_AXES)) != VV_OK)
        return st;
    *n_dims = (int)n;
    return vvi_keys_dims(sizes, *n_dims, keys, "DimSize", limits);
}

static vv_status understand(vv_field_info *info, vvi_data_files *d, vvi_keys *keys, vv_source *source, vv_notes *notes,
                            vv_job *job)
{
    int64_t sizes[VVI_METAIMAGE_AXES] = {1, 1, 1, 1}, channels = 1;
    int n_dims = 0;
    bool big;
    vv_status st = collect(keys, source);
    if (st == VV_OK)
        st = find_sizes(sizes, &n_dims, keys, d->limits);
    if (st != VV_OK || (st = find_type(&info->type, keys)) != VV_OK || (st = find_order(&big, keys, notes)) != VV_OK ||
        (st = vvi_keys_int(&channels, keys, "ElementNumberOfChannels", 1, 65535)) != VV_OK)
        return st;
    info->components = (int)channels;
    fill_layout(info, &d->layout, sizes, vvi_order_swapped(big));
    if ((st = vvi_metaimage_place(info, keys, n_dims, notes)) != VV_OK || (st = find_values(info, keys)) != VV_OK ||
        (st = find_files(d, keys, source, sizes, n_dims)) != VV_OK || (st = find_coding(d, keys, source)) != VV_OK)
        return st;
    d->layout.swap &= !d->numbers;
    st = find_meaning(info, keys, &d->layout);
    return st == VV_OK ? vvi_keys_note_rest(keys, notes) : st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_data_files_open(info, plan_out, source, understand, notes, job);
}

static const char *const suffixes[] = {".mhd", ".mha", NULL};

const vv_format vvi_format_metaimage = {
    .beside = true,
    .api = VV_FORMAT_API,
    .name = "metaimage",
    .doc = "MetaImage, data behind the header (.mha) or in other files (.mhd); raw, zlib and text",
    .suffixes = suffixes,
    .encodings = vvi_metaimage_encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_data_files_free_plan,
    .read = vvi_data_files_read_plan,
    .mappable = vvi_data_files_mappable,
    .write = vvi_metaimage_write,
};
