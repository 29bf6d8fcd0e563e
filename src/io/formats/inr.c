/* Inrimage: a header of text, padded to a multiple of 256 bytes, and plain samples behind it. Read only. */
#include "io/data_files.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define MAGIC "#INRIMAGE-4#{"
#define BLOCK 256

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n >= strlen(MAGIC) && memcmp(head, MAGIC, strlen(MAGIC)) == 0 ? 2 : 0;
}

/* Lines up to the one that ends the header, whose end is at a multiple of 256 bytes. */
static vv_status collect(vvi_keys *keys, int64_t *offset, vv_source *source)
{
    const char *line, *value;
    bool end = false;
    size_t n_name;
    vv_status st = VV_OK;
    for (int number = 1; st == VV_OK; number++) {
        const vv_limits *limits = vvi_source_limits(source);
        st = vvi_source_line(source, &line, (size_t)limits->string_bytes, &end);
        if (st == VV_OK && !end && vvi_source_tell(source) > limits->header_bytes)
            return vv_fail_at(VV_E_FORMAT, keys->file, NULL,
                              "its header has more than %llu bytes; --limit header_bytes=N allows more",
                              (unsigned long long)limits->header_bytes);
        if (st == VV_OK && end)
            return vv_fail_at(VV_E_FORMAT, keys->file, NULL, "its header does not end: the line '##}' is missing");
        if (st != VV_OK)
            return st;
        if (number == 1 && strncmp(line, MAGIC, strlen(MAGIC)) != 0)
            return vv_fail_at(VV_E_FORMAT, keys->file, NULL, "does not begin with " MAGIC ", so it is not an Inrimage");
        if (strncmp(line, "##}", 3) == 0)
            break;
        if (line[0] != '#' && vvi_keys_split(line, "=", &n_name, &value))
            st = vvi_keys_add(keys, line, n_name, value, strlen(value), number);
    }
    *offset = (int64_t)((vvi_source_tell(source) + BLOCK - 1) / BLOCK * BLOCK);
    return st;
}

static vv_status read_type(vv_type *out, vvi_keys *keys)
{
    static const struct {
        const char *name;
        int bits;
        vv_type type;
    } types[] = {
        {"unsigned fixed", 8, VV_TYPE_U8},   {"unsigned fixed", 16, VV_TYPE_U16}, {"unsigned fixed", 32, VV_TYPE_U32},
        {"unsigned fixed", 64, VV_TYPE_U64}, {"signed fixed", 8, VV_TYPE_I8},     {"signed fixed", 16, VV_TYPE_I16},
        {"signed fixed", 32, VV_TYPE_I32},   {"signed fixed", 64, VV_TYPE_I64},   {"float", 32, VV_TYPE_F32},
        {"float", 64, VV_TYPE_F64},          {"double", 64, VV_TYPE_F64}};
    const char *type = vvi_keys_get(keys, "TYPE"), *size = vvi_keys_get(keys, "PIXSIZE"), *end;
    int64_t bits = 0;
    vv_status st = vvi_keys_need(keys, "TYPE");
    if (st != VV_OK || (st = vvi_keys_need(keys, "PIXSIZE")) != VV_OK)
        return st;
    if (!vvi_scan_int(&bits, size, &end) ||
        (end[strspn(end, " \t")] && strcasecmp(end + strspn(end, " \t"), "bits") != 0))
        return vvi_keys_fail(keys, "PIXSIZE", "is '%.40s'; it is a number of bits, as in '16 bits'", size);
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcasecmp(type, types[i].name) == 0 && bits == types[i].bits) {
            *out = types[i].type;
            return VV_OK;
        }
    return vvi_keys_fail(keys, "TYPE",
                         "is '%.40s' of %lld bits; fixed of 8, 16, 32 and 64 bits, signed and unsigned, and "
                         "float of 32 and 64 are known",
                         type, (long long)bits);
}

/* The maker of the machine that wrote it says the byte order. */
static vv_status read_order(bool *big, const vv_field_info *info, vvi_keys *keys)
{
    static const char *const little[] = {"decm", "alpha", "pc", NULL}, *const large[] = {"sun", "sgi", NULL};
    const char *cpu = vvi_keys_get(keys, "CPU");
    *big = false;
    if (vv_type_bytes(info->type) == 1)
        return VV_OK;
    for (size_t i = 0; cpu && little[i]; i++)
        if (strcasecmp(cpu, little[i]) == 0)
            return VV_OK;
    *big = true;
    for (size_t i = 0; cpu && large[i]; i++)
        if (strcasecmp(cpu, large[i]) == 0)
            return VV_OK;
    return cpu ? vvi_keys_fail(keys, "CPU", "is '%.40s'; decm, alpha and pc are little-endian, sun and sgi big-endian",
                               cpu)
               : vvi_keys_need(keys, "CPU");
}

/* "2**-3" is what whole numbers are counted in. */
static vv_status read_scale(vv_field_info *info, vvi_keys *keys)
{
    const char *text = vvi_keys_get(keys, "SCALE"), *end;
    int64_t power = 0;
    if (!text)
        return VV_OK;
    if (strncmp(text, "2**", 3) != 0 || !vvi_scan_int(&power, text + 3, &end) || end[strspn(end, " \t")] != 0 ||
        power < -64 || power > 64)
        return vvi_keys_fail(keys, "SCALE", "is '%.40s'; it is a power of two, 2**-64 to 2**64", text);
    if (!vv_type_is_float(info->type))
        info->value_scale = ldexp(1, (int)power);
    return VV_OK;
}

static vv_status place(vv_field_info *info, vvi_keys *keys)
{
    static const char *const steps[] = {"VX", "VY", "VZ"}, *const starts[] = {"TX", "TY", "TZ"};
    double step[3] = {1, 1, 1}, start[3] = {0};
    bool given = false;
    vv_grid *grid = &info->grid;
    for (int a = 0; a < 3; a++) {
        vv_status st = vvi_keys_reals(&step[a], 1, keys, steps[a]);
        if (st == VV_OK)
            st = vvi_keys_reals(&start[a], 1, keys, starts[a]);
        if (st == VV_OK && !(step[a] > 0))
            st = vvi_keys_fail(keys, steps[a], "is %g; a voxel is longer than 0", step[a]);
        if (st != VV_OK)
            return st;
        given |= vvi_keys_get(keys, steps[a]) != NULL;
    }
    grid->index_to_world =
        (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {start[0], start[1], start[2]}};
    snprintf(grid->unit, sizeof grid->unit, "%s",
             given || !vvi_is_identity(&grid->index_to_world) ? "units" : "voxels");
    return VV_OK;
}

static vv_status understand(vv_field_info *info, vvi_data_files *d, vvi_keys *keys, vv_source *source, vv_notes *notes,
                            vv_job *job)
{
    static const char *const sizes[] = {"XDIM", "YDIM", "ZDIM"};
    int64_t *dims = info->grid.dims, components = 1;
    bool big;
    vv_status st = collect(keys, &d->skip, source);
    if (st == VV_OK)
        st = vvi_keys_need(keys, "XDIM");
    for (int a = 0; a < 3 && st == VV_OK; a++)
        st = vvi_keys_dims(&dims[a], 1, keys, sizes[a], d->limits);
    if (st != VV_OK || (st = vvi_keys_int(&components, keys, "VDIM", 1, 65535)) != VV_OK ||
        (st = read_type(&info->type, keys)) != VV_OK || (st = read_order(&big, info, keys)) != VV_OK ||
        (st = read_scale(info, keys)) != VV_OK || (st = place(info, keys)) != VV_OK)
        return st;
    info->components = (int)components;
    if (info->type == VV_TYPE_U8 && (components == 3 || components == 4))
        info->meaning = components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    d->layout = (vvi_layout){
        .n_axes = 4,
        .axis = {{components, VVI_ROLE_COMPONENT}, {dims[0], VVI_ROLE_X}, {dims[1], VVI_ROLE_Y}, {dims[2], VVI_ROLE_Z}},
        .type = info->type,
        .swap = vv_type_bytes(info->type) > 1 && vvi_order_swapped(big)};
    return vvi_keys_note_rest(keys, notes);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    return vvi_data_files_open(info, plan_out, source, understand, notes, job);
}

static const char *const suffixes[] = {".inr", NULL};

const vv_format vvi_format_inr = {
    .api = VV_FORMAT_API,
    .name = "inr",
    .doc = "Inrimage-4",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_data_files_free_plan,
    .read = vvi_data_files_read_plan,
    .mappable = vvi_data_files_mappable,
};
