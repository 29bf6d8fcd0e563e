/* Arrays of Zarr 2: https://zarr-specs.readthedocs.io/en/latest/v2/v2.0.html */
#include "io/formats/zarr/zarr.h"
#include <string.h>

static vv_status read_type(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    const json_t *type = json_object_get(meta, "dtype");
    const char *text = json_string_value(type);
    if (json_is_array(type))
        return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                          "its elements are structures; save one of their fields as an array");
    if (!text)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has no 'dtype'");
    if (vvi_zarr_type_v2(&a->type, text))
        return VV_OK;
    return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                      "its elements are of type '%.20s'; integers and floats of 1 to 8 bytes and booleans can be shown",
                      text);
}

static vv_status read_order(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    const char *order = vvi_json_text(meta, "order");
    if (!order || (strcmp(order, "C") != 0 && strcmp(order, "F") != 0))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'order' is neither C nor F");
    for (int i = 0; i < a->n_axes; i++)
        a->order[i] = *order == 'C' ? i : a->n_axes - 1 - i;
    return VV_OK;
}

static vv_status read_keys(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    const char *separator = vvi_json_text(meta, "dimension_separator");
    a->separator = separator ? *separator : '.';
    if (separator && strcmp(separator, ".") != 0 && strcmp(separator, "/") != 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'dimension_separator' is neither . nor /");
    return VV_OK;
}

static vv_status read_coding(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    const json_t *filters = json_object_get(meta, "filters"), *compressor = json_object_get(meta, "compressor");
    vv_status st = VV_OK;
    for (size_t i = 0; i < json_array_size(filters) && st == VV_OK; i++) {
        const json_t *filter = json_array_get(filters, i);
        const char *id = vvi_json_text(filter, "id");
        st = id ? vvi_zarr_codec_named(&a->chain, id, filter, a, name)
                : vv_fail_at(VV_E_FORMAT, name, NULL, "filter %zu has no 'id'", i + 1);
    }
    if (st != VV_OK || !compressor || json_is_null(compressor))
        return st;
    const char *id = vvi_json_text(compressor, "id");
    return id ? vvi_zarr_codec_named(&a->chain, id, compressor, a, name)
              : vv_fail_at(VV_E_FORMAT, name, NULL, "its 'compressor' has no 'id'");
}

vv_status vvi_zarr_array_v2(vvi_zarr_array *a, const json_t *meta, const char *name)
{
    int n;
    *a = (vvi_zarr_array){0};
    vv_status st = vvi_zarr_sizes(a->shape, &a->n_axes, json_object_get(meta, "shape"), "shape", name);
    if (st != VV_OK || (st = vvi_zarr_sizes(a->chunk, &n, json_object_get(meta, "chunks"), "chunks", name)) != VV_OK)
        return st;
    if (n != a->n_axes)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "its 'shape' has %d axes but its 'chunks' %d", a->n_axes, n);
    if ((st = read_type(a, meta, name)) != VV_OK || (st = read_order(a, meta, name)) != VV_OK ||
        (st = read_keys(a, meta, name)) != VV_OK || (st = read_coding(a, meta, name)) != VV_OK ||
        (st = vvi_zarr_fill(&a->fill, json_object_get(meta, "fill_value"), &a->type, name)) != VV_OK)
        return st;
    return vvi_zarr_check_array(a, name);
}
