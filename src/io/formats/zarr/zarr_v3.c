/* Arrays of Zarr 3: https://zarr-specs.readthedocs.io/en/latest/v3/core/index.html */
#include "io/formats/zarr/zarr.h"
#include "io/sample_writer.h"
#include <string.h>

/* A thing with a name: text, or {"name": ..., "configuration": {...}}. */
static const char *named(const json_t *thing, const json_t **config)
{
    *config = json_object_get(thing, "configuration");
    return json_is_string(thing) ? json_string_value(thing) : vvi_json_text(thing, "name");
}

static vv_status read_type(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    static const struct {
        const char *v3, *v2;
    } types[] = {{"bool", "|b1"},   {"int8", "|i1"},    {"uint8", "|u1"},   {"int16", "=i2"},
                 {"uint16", "=u2"}, {"int32", "=i4"},   {"uint32", "=u4"},  {"int64", "=i8"},
                 {"uint64", "=u8"}, {"float16", "=f2"}, {"float32", "=f4"}, {"float64", "=f8"}};
    const json_t *config;
    const char *type = named(json_object_get(meta, "data_type"), &config);
    if (!type)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has no 'data_type'");
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (strcmp(type, types[i].v3) == 0)
            return vvi_zarr_type_v2(&a->type, types[i].v2) ? VV_OK : vv_fail(VV_E_INTERNAL, "types of Zarr");
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "its elements are of type '%.40s'; bool, integers and floats of 8 to 64 bits can be shown", type);
}

static vv_status read_grid(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    int n;
    const json_t *config;
    const char *grid = named(json_object_get(meta, "chunk_grid"), &config);
    if (!grid || strcmp(grid, "regular") != 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its chunk grid is '%.40s'; 'regular' is known",
                          grid ? grid : "");
    vv_status st = vvi_zarr_sizes(a->chunk, &n, json_object_get(config, "chunk_shape"), "chunk_shape", name);
    if (st == VV_OK && n != a->n_axes)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "its 'shape' has %d axes but its 'chunk_shape' %d", a->n_axes, n);
    return st;
}

static vv_status read_keys(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    const json_t *config;
    const char *keys = named(json_object_get(meta, "chunk_key_encoding"), &config);
    const char *separator = vvi_json_text(config, "separator");
    if (!keys || (strcmp(keys, "default") != 0 && strcmp(keys, "v2") != 0))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "its chunk key encoding is '%.40s'; default and v2 are known",
                          keys ? keys : "");
    a->key_c = strcmp(keys, "default") == 0;
    a->separator = separator ? *separator : a->key_c ? '/' : '.';
    if (separator && strcmp(separator, ".") != 0 && strcmp(separator, "/") != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "the separator of its chunk keys is neither . nor /");
    return VV_OK;
}

/* Codecs --------------------------------------------------------------------------------------------------------- */

static vv_status use_transpose(vvi_zarr_array *a, const json_t *config, const char *name)
{
    const json_t *list = json_object_get(config, "order");
    const char *letter = json_string_value(list); /* of a draft: "C" for as it is, "F" for backwards */
    int order[VVI_ZARR_AXES];
    unsigned seen = 0;
    if (a->chain.n > 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "has a codec transpose after others; it can be read before them");
    for (int i = 0; i < a->n_axes; i++) {
        int64_t axis = -1;
        if (letter && (strcmp(letter, "C") == 0 || strcmp(letter, "F") == 0))
            axis = *letter == 'C' ? i : a->n_axes - 1 - i;
        else if (json_array_size(list) != (size_t)a->n_axes || !vvi_json_whole(&axis, json_array_get(list, (size_t)i)))
            axis = -1;
        if (axis < 0 || axis >= a->n_axes || seen >> axis & 1)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "the 'order' of its codec transpose is not an order of %d axes",
                              a->n_axes);
        seen |= 1u << axis;
        order[i] = a->order[axis];
    }
    memcpy(a->order, order, sizeof order);
    return VV_OK;
}

/* The byte order is that of the filters before, too. */
static vv_status use_bytes(vvi_zarr_array *a, const json_t *config, const char *name)
{
    const char *endian = vvi_json_text(config, "endian");
    if (endian && strcmp(endian, "little") != 0 && strcmp(endian, "big") != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "the 'endian' of its codec bytes is neither little nor big");
    if (!endian && a->type.bytes > 1)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its codec bytes does not say which 'endian'");
    const bool swap = endian && vvi_order_swapped(*endian == 'b');
    a->type.swap = a->type.bytes > 1 && swap;
    for (int i = 0; i < a->chain.n; i++)
        a->chain.codec[i].plain.swap = a->chain.codec[i].stored.swap = swap;
    return VV_OK;
}

/* Its index is fixed in size: bytes, perhaps with a checksum. */
static vv_status read_index(vvi_zarr_array *a, const json_t *config, const char *name)
{
    const json_t *list = json_object_get(config, "index_codecs"), *inner;
    const char *location = vvi_json_text(config, "index_location");
    a->index_first = location && strcmp(location, "start") == 0;
    if (location && !a->index_first && strcmp(location, "end") != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "the 'index_location' of its shards is neither start nor end");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *codec = named(json_array_get(list, i), &inner);
        const char *endian = vvi_json_text(inner, "endian");
        if (i == 0 && codec && strcmp(codec, "bytes") == 0 && endian)
            a->index_swap = vvi_order_swapped(strcmp(endian, "big") == 0);
        else if (i == 1 && codec && strcmp(codec, "crc32c") == 0)
            a->index_crc = true;
        else
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "the index of its shards is coded by '%.40s'; bytes and then crc32c are known",
                              codec ? codec : "");
    }
    return json_array_size(list) > 0 ? VV_OK : vv_fail_at(VV_E_FORMAT, name, NULL, "its shards have no 'index_codecs'");
}

static vv_status read_codecs(vvi_zarr_array *a, const json_t *list, const char *name);

static vv_status use_shards(vvi_zarr_array *a, const json_t *config, const char *name)
{
    int n;
    if (a->sharded)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has shards in shards");
    for (int i = 0; i < a->n_axes; i++)
        if (a->order[i] != i || a->chain.n > 0)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has codecs before its shards; they can be read inside");
    memcpy(a->shard, a->chunk, sizeof a->shard);
    a->sharded = true;
    vv_status st = vvi_zarr_sizes(a->chunk, &n, json_object_get(config, "chunk_shape"), "chunk_shape", name);
    if (st == VV_OK && n != a->n_axes)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "the chunks of its shards have %d axes, not %d", n, a->n_axes);
    if (st == VV_OK)
        st = read_index(a, config, name);
    return st == VV_OK ? read_codecs(a, json_object_get(config, "codecs"), name) : st;
}

/* Codecs of arrays, then the one that makes bytes, then those of bytes. */
static vv_status read_codecs(vvi_zarr_array *a, const json_t *list, const char *name)
{
    vv_status st = VV_OK;
    bool has_bytes = false, has_shards = false;
    for (size_t i = 0; i < json_array_size(list) && st == VV_OK; i++) {
        const json_t *config;
        const char *codec = named(json_array_get(list, i), &config);
        if (!codec)
            return vv_fail_at(VV_E_FORMAT, name, NULL, "codec %zu has no name", i + 1);
        if (has_shards)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has the codec '%.40s' after its shards", codec);
        if (strcmp(codec, "transpose") == 0 && !has_bytes) {
            st = use_transpose(a, config, name);
        } else if (strcmp(codec, "sharding_indexed") == 0 && !has_bytes) {
            st = use_shards(a, config, name);
            has_shards = has_bytes = true;
        } else if ((strcmp(codec, "bytes") == 0 || strcmp(codec, "endian") == 0) && !has_bytes) {
            st = use_bytes(a, config, name);
            has_bytes = true;
        } else {
            st = vvi_zarr_codec_named(&a->chain, codec, config, a, name);
        }
    }
    if (st == VV_OK && !has_bytes)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "none of its codecs makes bytes");
    return st;
}

static vv_status check_extensions(const json_t *meta, const char *name)
{
    const char *key;
    json_t *value;
    if (json_array_size(json_object_get(meta, "storage_transformers")) > 0)
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL, "has storage transformers, none of which are known");
    json_object_foreach((json_t *)meta, key, value) if (
        json_is_true(json_object_get(
            value, "must_understand"))) return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                                                          "must be understood with '%.40s', which is not known", key);
    return VV_OK;
}

static void read_names(vvi_zarr_array *a, const json_t *meta)
{
    const json_t *names = json_object_get(meta, "dimension_names");
    for (int i = 0; i < a->n_axes; i++)
        vvi_json_copy_text(a->axis_name[i], sizeof a->axis_name[i],
                           json_string_value(json_array_get(names, (size_t)i)));
}

vv_status vvi_zarr_array_v3(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    *a = (vvi_zarr_array){0};
    vv_status st = vvi_zarr_sizes(a->shape, &a->n_axes, json_object_get(meta, "shape"), "shape", name);
    if (st != VV_OK || (st = read_grid(a, meta, name)) != VV_OK || (st = read_type(a, meta, name)) != VV_OK ||
        (st = read_keys(a, meta, name)) != VV_OK || (st = check_extensions(meta, name)) != VV_OK)
        return st;
    for (int i = 0; i < a->n_axes; i++)
        a->order[i] = i;
    if ((st = read_codecs(a, json_object_get(meta, "codecs"), name)) != VV_OK ||
        (st = vvi_zarr_fill(&a->fill, json_object_get(meta, "fill_value"), &a->type, name)) != VV_OK)
        return st;
    read_names(a, meta);
    return vvi_zarr_check_array(a, name);
}
