/* How chunks are coded: names to codecs, and the chain backwards. */
#include "config.h"
#include "core/memory.h"
#include "io/formats/zarr/zarr.h"
#include <string.h>

static bool same_type(const vvi_zarr_type *a, const vvi_zarr_type *b)
{
    return a->type == b->type && a->half == b->half;
}

/* dtype and astype of a filter; astype defaults to dtype. */
static vv_status read_types(vvi_zarr_codec *c, const char *codec, const json_t *config, const char *name)
{
    const char *plain = vvi_json_text(config, "dtype"), *stored = vvi_json_text(config, "astype");
    stored = stored ? stored : plain;
    if (vvi_zarr_type_v2(&c->plain, plain) && vvi_zarr_type_v2(&c->stored, stored) && !c->plain.half && !c->stored.half)
        return VV_OK;
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "its filter %s goes from type '%.20s' to '%.20s', which is not known", codec, plain ? plain : "",
                      stored ? stored : "");
}

static vv_status read_shuffle(vvi_zarr_codec *c, const json_t *config, const char *name)
{
    int64_t bytes = 4;
    const json_t *said = json_object_get(config, "elementsize");
    if (said && (!vvi_json_whole(&bytes, said) || bytes < 1 || bytes > 256))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "the 'elementsize' of its filter shuffle is not from 1 to 256");
    c->element_bytes = (size_t)bytes;
    return VV_OK;
}

static vv_status read_fixed(vvi_zarr_codec *c, const json_t *config, const char *name)
{
    if (vvi_json_real(&c->scale, json_object_get(config, "scale")) && c->scale != 0 &&
        vvi_json_real(&c->offset, json_object_get(config, "offset")))
        return read_types(c, "fixedscaleoffset", config, name);
    return vv_fail_at(VV_E_FORMAT, name, NULL, "its filter fixedscaleoffset has no 'scale' and 'offset'");
}

/* Filters whose loss happened when they were written: nothing is left to do. */
static vv_status check_rounding(vvi_zarr_codec *c, const char *codec, const json_t *config, const char *name)
{
    vv_status st = json_object_get(config, "dtype") ? read_types(c, codec, config, name) : VV_OK;
    if (st == VV_OK && !same_type(&c->plain, &c->stored))
        st = vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its filter %s changes the type", codec);
    return st;
}

static const struct known {
    const char *name;
    vvi_zarr_code code;
    bool there;
} known[] = {
    {"shuffle", VVI_ZARR_SHUFFLE, true},
    {"delta", VVI_ZARR_DELTA, true},
    {"fixedscaleoffset", VVI_ZARR_FIXED, true},
    {"crc32c", VVI_ZARR_CRC32C, true},
    {"gzip", VVI_ZARR_GZIP, true},
    {"zlib", VVI_ZARR_GZIP, true},
    {"zstd", VVI_ZARR_ZSTD, VV_HAVE_ZSTD},
    {"bz2", VVI_ZARR_BZIP2, VV_HAVE_BZIP2},
    {"lz4", VVI_ZARR_LZ4, VV_HAVE_LZ4},
    {"lzma", VVI_ZARR_LZMA, VV_HAVE_LZMA},
    {"blosc", VVI_ZARR_BLOSC, VV_HAVE_BLOSC},
};

static vv_status find(const struct known **out, const char *codec, const char *name)
{
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(codec, known[i].name) == 0) {
            *out = &known[i];
            return known[i].there
                       ? VV_OK
                       : vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                                    "its chunks are coded by '%s', for which this build has no library", codec);
        }
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "its chunks are coded by '%.40s', which is not known; blosc, zstd, gzip, zlib, bz2, lz4, lzma, "
                      "shuffle, delta, fixedscaleoffset and crc32c are",
                      codec);
}

static vv_status read_config(vvi_zarr_codec *c, const char *codec, const json_t *config, const char *name)
{
    int64_t format = 1;
    const char *location = vvi_json_text(config, "location");
    switch (c->code) {
    case VVI_ZARR_SHUFFLE:
        return read_shuffle(c, config, name);
    case VVI_ZARR_DELTA:
        return read_types(c, codec, config, name);
    case VVI_ZARR_FIXED:
        return read_fixed(c, config, name);
    case VVI_ZARR_CRC32C:
        return !location || strcmp(location, "end") == 0
                   ? VV_OK
                   : vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its checksums crc32c do not stand at the end");
    case VVI_ZARR_LZMA:
        return !vvi_json_whole(&format, json_object_get(config, "format")) || format == 1 || format == 2
                   ? VV_OK
                   : vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its lzma data has no header; formats 1 and 2 are known");
    default:
        return VV_OK;
    }
}

vv_status vvi_zarr_codec_named(vvi_zarr_chain *chain, const char *codec, const json_t *config,
                               const vvi_zarr_array *array, const char *name)
{
    const struct known *row = NULL;
    vvi_zarr_codec c = {.plain = array->type, .stored = array->type};
    if (strncmp(codec, "numcodecs.", 10) == 0)
        codec += 10;
    if (strcmp(codec, "quantize") == 0 || strcmp(codec, "bitround") == 0)
        return check_rounding(&c, codec, config, name);
    vv_status st = find(&row, codec, name);
    if (st != VV_OK)
        return st;
    if (chain->n == VVI_ZARR_CODECS)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has more than %d codecs", VVI_ZARR_CODECS);
    c.code = row->code;
    if ((st = read_config(&c, codec, config, name)) == VV_OK)
        chain->codec[chain->n++] = c;
    return st;
}

/* Decoding ------------------------------------------------------------------------------------------------------- */

static bool is_packer(vvi_zarr_code code)
{
    return code >= VVI_ZARR_GZIP;
}

/* How many bytes there are before each codec was applied; 0 where a compression before it leaves that open. */
static void plan_sizes(size_t *before, const vvi_zarr_chain *chain, size_t expected)
{
    for (int i = 0; i < chain->n; i++) {
        const vvi_zarr_codec *c = &chain->codec[i];
        before[i] = expected;
        if (expected == 0 || is_packer(c->code))
            expected = 0;
        else if (c->code == VVI_ZARR_CRC32C)
            expected += 4;
        else if (c->code == VVI_ZARR_DELTA || c->code == VVI_ZARR_FIXED)
            expected = expected / c->plain.bytes * c->stored.bytes;
    }
}

static vv_status fail_size(const char *name, size_t found, size_t expected)
{
    return vv_fail_at(VV_E_FORMAT, name, NULL, "holds %zu bytes; %zu were expected", found, expected);
}

static vv_status check_crc(vvi_zarr_bytes *b, const char *name)
{
    if (b->n < 4)
        return fail_size(name, b->n, 4);
    b->n -= 4;
    const uint8_t *sum = b->data + b->n;
    const uint32_t said = (uint32_t)sum[0] | (uint32_t)sum[1] << 8 | (uint32_t)sum[2] << 16 | (uint32_t)sum[3] << 24;
    return vvi_crc32c(b->data, b->n) == said ? VV_OK
                                             : vv_fail_at(VV_E_FORMAT, name, NULL, "its checksum crc32c is wrong");
}

/* Filters make a byte of eight at most. */
#define FILTER_MOST 8

vv_status vvi_zarr_check_packed(const vvi_zarr_chain *chain, uint64_t packed, uint64_t expected, const char *name,
                                vv_job *job)
{
    const vv_limits *limits = vvi_job_limits(job);
    bool has_packer = false;
    for (int i = 0; i < chain->n; i++)
        has_packer = has_packer || is_packer(chain->codec[i].code);
    if (expected <= limits->expansion_after || expected / (has_packer ? limits->expansion_zstd : FILTER_MOST) <= packed)
        return VV_OK;
    if (!has_packer)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has %llu bytes for %llu; it is cut short",
                          (unsigned long long)packed, (unsigned long long)expected);
    return vv_fail_at(VV_E_FORMAT, name, NULL,
                      "has %llu bytes for %llu, which no valid data has; --limit expansion_zstd=N allows more",
                      (unsigned long long)packed, (unsigned long long)expected);
}

static vv_status undo(vvi_zarr_bytes *b, const vvi_zarr_codec *c, size_t room, const char *name, vv_job *job)
{
    size_t n = room;
    const char *wrong = NULL;
    if (c->code == VVI_ZARR_CRC32C)
        return check_crc(b, name);
    if (!is_packer(c->code)) {
        n = b->n / c->stored.bytes * c->plain.bytes;
        if (c->code == VVI_ZARR_SHUFFLE)
            n = b->n;
        if (n > room)
            return fail_size(name, n, room);
    }
    const vvi_zarr_chain only = {.n = 1, .codec = {*c}};
    const vv_status st = vvi_zarr_check_packed(&only, b->n, room, name, job);
    if (st != VV_OK)
        return st;
    uint8_t *out = vvi_alloc(job, room ? room : 1, VVI_MEM_SCRATCH);
    if (!out)
        return vv_fail_memory(room);
    if (is_packer(c->code))
        wrong = vvi_zarr_unpack(c->code, b->data, b->n, out, room, &n);
    else
        vvi_zarr_unfilter(c, b->data, b->n, out);
    vvi_free(b->data);
    *b = (vvi_zarr_bytes){out, n};
    return wrong ? vv_fail_at(VV_E_FORMAT, name, NULL, "%s", wrong) : VV_OK;
}

vv_status vvi_zarr_decode(vvi_zarr_bytes *b, const vvi_zarr_chain *chain, size_t expected, const char *name,
                          vv_job *job)
{
    size_t before[VVI_ZARR_CODECS] = {0};
    vv_status st = VV_OK;
    plan_sizes(before, chain, expected);
    for (int i = chain->n - 1; i >= 0 && st == VV_OK; i--) {
        /* what a compression of compressed bytes holds is about as much as the bytes */
        const size_t room = before[i] > 0 ? before[i] : expected + expected / 8 + ((size_t)64 << 10);
        st = undo(b, &chain->codec[i], room, name, job);
        if (st == VV_OK && before[i] > 0 && b->n != before[i])
            st = fail_size(name, b->n, before[i]);
    }
    return st == VV_OK && b->n != expected ? fail_size(name, b->n, expected) : st;
}
