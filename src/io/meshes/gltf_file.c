/* The JSON of glTF, and its buffers. */
#include "core/job.h"
#include "core/limits.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/json.h"
#include "io/meshes/gltf.h"
#include "io/meshes/mesh_column.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { BUFFERS_MOST = 4096 };

vv_status vvi_gltf_fail(const vvi_gltf *g, const char *format, ...)
{
    char text[512];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);
    return vv_fail_at(VV_E_FORMAT, g->file, NULL, "%s", text);
}

vv_status vvi_gltf_index(const vvi_gltf *g, const json_t *object, const char *key, size_t n, size_t *out, bool *there)
{
    const json_t *value = json_object_get(object, key);
    int64_t v;
    *there = value != NULL;
    if (!value)
        return VV_OK;
    if (!vvi_json_whole(&v, value) || v < 0 || (uint64_t)v >= n)
        return vvi_json_whole(&v, value)
                   ? vvi_gltf_fail(g, "'%s' is %lld, but there are %zu, counted from 0", key, (long long)v, n)
                   : vvi_gltf_fail(g, "'%s' is not the number of one of the %zu that there are", key, n);
    *out = (size_t)v;
    return VV_OK;
}

bool vvi_gltf_numbers_at(double *out, size_t n, const json_t *object, const char *key)
{
    const json_t *list = json_object_get(object, key);
    if (json_array_size(list) != n)
        return false;
    for (size_t i = 0; i < n; i++)
        if (!vvi_json_real(&out[i], json_array_get(list, i)))
            return false;
    return true;
}

/* JSON ------------------------------------------------------------------------------------------------------------ */

static uint32_t u32(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

static vv_status read_json(vvi_gltf *g, uint64_t n)
{
    const uint64_t most = vvi_job_limits(g->job)->header_bytes;
    g->json_bytes = n;
    bool exact;
    const uint64_t left = vvi_source_left(g->source, &exact);
    if (n > left)
        return vvi_gltf_fail(g, "its JSON has %llu bytes, but at most %llu follow; the file is cut short",
                             (unsigned long long)n, (unsigned long long)left);
    /* embedded buffers make long texts: they count as data where memory allows */
    if (n > most && vvi_memory_plan(g->job, 8 * n, "the JSON of glTF") != VV_OK)
        return vv_error_last()->status;
    char *text = vvi_alloc(g->job, (size_t)n + 1, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory((size_t)n + 1);
    vv_status st = vvi_source_read(g->source, text, (size_t)n, "JSON");
    if (st == VV_OK)
        st = vvi_json_read_text(&g->root, text, (size_t)n, g->file, g->job);
    vvi_free(text);
    return st;
}

/* The chunk after the JSON, unless there is none. */
static vv_status find_bin(vvi_gltf *g)
{
    uint8_t head[8];
    size_t n;
    bool exact;
    const vv_status st = vvi_source_read_some(g->source, head, sizeof head, &n);
    if (st != VV_OK || n < sizeof head || u32(head + 4) != VVI_GLB_BIN)
        return st;
    g->bin = vvi_source_tell(g->source);
    g->n_bin = u32(head);
    const uint64_t left = vvi_source_left(g->source, &exact);
    if (g->n_bin > left)
        return vvi_gltf_fail(g, "its binary part has %llu bytes, but at most %llu follow; the file is cut short",
                             (unsigned long long)g->n_bin, (unsigned long long)left);
    return VV_OK;
}

static vv_status open_binary(vvi_gltf *g)
{
    uint8_t head[20];
    vv_status st = vvi_source_read(g->source, head, sizeof head, "the header");
    if (st != VV_OK)
        return st;
    if (u32(head + 4) != 2)
        return vv_fail_at(VV_E_UNSUPPORTED, g->file, NULL, "is GLB version %u; only version 2 is read", u32(head + 4));
    if (u32(head + 16) != VVI_GLB_JSON)
        return vvi_gltf_fail(g, "its first part is not JSON");
    if ((st = read_json(g, u32(head + 12))) == VV_OK)
        st = find_bin(g);
    return st;
}

/* Extensions that must be understood are refused by name, unless they change nothing that is read. */
static vv_status check_extensions(const vvi_gltf *g)
{
    static const char *const harmless[] = {"KHR_materials_unlit", "KHR_mesh_quantization", "KHR_texture_transform",
                                           "KHR_lights_punctual"};
    const json_t *list = json_object_get(g->root, "extensionsRequired");
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *name = json_string_value(json_array_get(list, i));
        bool known = name && strncmp(name, "KHR_materials_", 14) == 0;
        for (size_t k = 0; name && k < sizeof harmless / sizeof *harmless; k++)
            known = known || strcmp(name, harmless[k]) == 0;
        if (!known)
            return vv_fail_at(VV_E_UNSUPPORTED, g->file, NULL,
                              "needs the extension '%.60s', which is not read; save it without (gltf-transform copy)",
                              name ? name : "?");
    }
    return VV_OK;
}

static vv_status check_version(const vvi_gltf *g)
{
    const char *version = json_string_value(json_object_get(json_object_get(g->root, "asset"), "version"));
    if (!version)
        return vvi_gltf_fail(g, "is not glTF: its 'asset' has no version");
    if (version[0] != '2' || version[1] != '.')
        return vv_fail_at(VV_E_UNSUPPORTED, g->file, NULL, "is glTF version %.20s; 2.x is read", version);
    return check_extensions(g);
}

vv_status vvi_gltf_open(vvi_gltf *g, vv_source *source, vv_job *job)
{
    size_t n;
    bool exact;
    *g = (vvi_gltf){.file = vvi_source_name(source), .source = source, .job = job};
    const uint8_t *head = vvi_source_peek(source, 4, &n);
    if (!head)
        return vv_error_last()->status;
    vv_status st =
        n == 4 && u32(head) == VVI_GLB_MAGIC ? open_binary(g) : read_json(g, vvi_source_left(source, &exact));
    if (st != VV_OK || (st = check_version(g)) != VV_OK)
        return st;
    g->n_buffers = json_array_size(json_object_get(g->root, "buffers"));
    if (g->n_buffers > BUFFERS_MOST)
        return vvi_gltf_fail(g, "has more than %d buffers", BUFFERS_MOST);
    g->buffer = vvi_alloc_zeroed(job, (g->n_buffers + 1) * sizeof *g->buffer, VVI_MEM_SCRATCH);
    g->n_bytes = vvi_alloc_zeroed(job, (g->n_buffers + 1) * sizeof *g->n_bytes, VVI_MEM_SCRATCH);
    return g->buffer && g->n_bytes ? VV_OK : vv_fail_memory(g->n_buffers * sizeof *g->buffer);
}

void vvi_gltf_finish(vvi_gltf *g)
{
    for (size_t i = 0; i < g->n_buffers && g->buffer; i++)
        vvi_free(g->buffer[i]);
    vvi_free(g->buffer);
    vvi_free(g->n_bytes);
    json_decref(g->root);
    *g = (vvi_gltf){0};
}

/* Buffers --------------------------------------------------------------------------------------------------------- */

static int digit(char c)
{
    return c >= 'A' && c <= 'Z'   ? c - 'A'
           : c >= 'a' && c <= 'z' ? c - 'a' + 26
           : c >= '0' && c <= '9' ? c - '0' + 52
           : c == '+' || c == '-' ? 62
           : c == '/' || c == '_' ? 63
                                  : -1;
}

/* False where the text is no base64, or has fewer bytes. */
static bool decode(uint8_t *out, uint64_t n, const char *text)
{
    uint32_t bits = 0;
    int n_bits = 0;
    uint64_t made = 0;
    for (; *text && *text != '=' && made < n; text++) {
        const int d = digit(*text);
        if (d < 0)
            return false;
        bits = bits << 6 | (uint32_t)d;
        n_bits += 6;
        if (n_bits >= 8) {
            n_bits -= 8;
            out[made++] = (uint8_t)(bits >> n_bits);
        }
    }
    return made == n;
}

bool vvi_gltf_decode_uri(char out[1024], const char *uri)
{
    size_t n = 0;
    for (; *uri; uri++) {
        unsigned v = (unsigned char)*uri;
        if (*uri == '%') {
            if (sscanf(uri + 1, "%2x", &v) != 1 || v == 0 || !uri[1] || !uri[2])
                return false;
            uri += 2;
        }
        if (n + 1 >= 1024)
            return false;
        out[n++] = (char)v;
    }
    out[n] = 0;
    return !strstr(out, "://");
}

static vv_status read_beside(vvi_gltf *g, uint8_t *out, uint64_t n, const char *uri)
{
    char name[1024];
    vv_source *source;
    if (!vvi_gltf_decode_uri(name, uri))
        return vvi_gltf_fail(g, "its buffer '%.100s' is not a file next to it", uri);
    vv_status st = vvi_source_open_beside(&source, g->source, name, g->job);
    if (st != VV_OK)
        return st;
    st = vvi_source_read(source, out, (size_t)n, "a buffer");
    vvi_source_close(source);
    return st;
}

static vv_status check_size(const vvi_gltf *g, const char *uri, uint64_t n)
{
    const char *base64 = uri && strncmp(uri, "data:", 5) == 0 ? strchr(uri, ',') : NULL;
    if (!uri && n > g->n_bin)
        return vvi_gltf_fail(g, "a buffer has %llu bytes, but the file has %llu for it", (unsigned long long)n,
                             (unsigned long long)g->n_bin);
    if (base64 && n > strlen(base64))
        return vvi_gltf_fail(g, "a buffer has %llu bytes, more than its text", (unsigned long long)n);
    return uri && !base64 ? vvi_memory_plan(g->job, n, "a buffer of glTF") : VV_OK;
}

static vv_status load_buffer(vvi_gltf *g, size_t i)
{
    const json_t *buffer = json_array_get(json_object_get(g->root, "buffers"), i);
    const char *uri = json_string_value(json_object_get(buffer, "uri"));
    int64_t n;
    if (!vvi_json_whole(&n, json_object_get(buffer, "byteLength")) || n < 0)
        return vvi_gltf_fail(g, "buffer %zu has no 'byteLength'", i);
    vv_status st = check_size(g, uri, (uint64_t)n);
    if (st != VV_OK || (st = vvi_source_grow(g->source, (uint64_t)n)) != VV_OK)
        return st;
    uint8_t *bytes = vvi_alloc(g->job, (size_t)n + 1, VVI_MEM_SCRATCH);
    if (!bytes)
        return vv_fail_memory((size_t)n + 1);
    if (uri && strncmp(uri, "data:", 5) == 0)
        st = strchr(uri, ',') && decode(bytes, (uint64_t)n, strchr(uri, ',') + 1)
                 ? VV_OK
                 : vvi_gltf_fail(g, "buffer %zu is not base64 of %lld bytes", i, (long long)n);
    else if (uri)
        st = read_beside(g, bytes, (uint64_t)n, uri);
    else if ((st = vvi_source_seek(g->source, g->bin)) == VV_OK)
        st = vvi_source_read(g->source, bytes, (size_t)n, "the buffer");
    if (st != VV_OK) {
        vvi_free(bytes);
        return st;
    }
    g->buffer[i] = bytes;
    g->n_bytes[i] = (uint64_t)n;
    return VV_OK;
}

/* Accessors ------------------------------------------------------------------------------------------------------- */

static bool type_of(vv_type *out, int64_t code)
{
    static const struct {
        int64_t code;
        vv_type type;
    } types[] = {{5120, VV_TYPE_I8},  {5121, VV_TYPE_U8},  {5122, VV_TYPE_I16},
                 {5123, VV_TYPE_U16}, {5125, VV_TYPE_U32}, {5126, VV_TYPE_F32}};
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (types[i].code == code) {
            *out = types[i].type;
            return true;
        }
    return false;
}

static int components_of(const json_t *accessor)
{
    const char *name = json_string_value(json_object_get(accessor, "type"));
    if (name && strcmp(name, "SCALAR") == 0)
        return 1;
    return name && strncmp(name, "VEC", 3) == 0 && name[3] >= '2' && name[3] <= '4' ? name[3] - '0' : 0;
}

/* Where n records of a view lie. */
static vv_status find_records(vvi_gltf *g, const uint8_t **out, size_t *stride, const json_t *object, size_t record,
                              uint64_t n)
{
    const json_t *views = json_object_get(g->root, "bufferViews"), *view;
    int64_t offset = 0, begin = 0, length = 0, step = 0;
    size_t index = 0, buffer = 0;
    bool there;
    vv_status st = vvi_gltf_index(g, object, "bufferView", json_array_size(views), &index, &there);
    if (st != VV_OK)
        return st;
    view = json_array_get(views, index);
    const json_t *offset_at = json_object_get(object, "byteOffset"), *begin_at = json_object_get(view, "byteOffset");
    const json_t *step_at = json_object_get(view, "byteStride");
    if ((st = vvi_gltf_index(g, view, "buffer", g->n_buffers, &buffer, &there)) != VV_OK)
        return st;
    if (!there || !vvi_json_whole(&length, json_object_get(view, "byteLength")) ||
        (offset_at && !vvi_json_whole(&offset, offset_at)) || (begin_at && !vvi_json_whole(&begin, begin_at)) ||
        (step_at && !vvi_json_whole(&step, step_at)) || offset < 0 || begin < 0 || length < 0 || step < 0 ||
        step > 4096)
        return vvi_gltf_fail(g, "buffer view %zu has no whole numbers for its position", index);
    if (!g->buffer[buffer] && (st = load_buffer(g, buffer)) != VV_OK)
        return st;
    const uint64_t apart = step ? (uint64_t)step : record;
    *stride = (size_t)apart;
    const uint64_t there_bytes = g->n_bytes[buffer];
    if ((uint64_t)begin > there_bytes || (uint64_t)length > there_bytes - (uint64_t)begin || offset > length ||
        (n > 0 && (apart == 0 || record > (uint64_t)(length - offset) ||
                   (n - 1) > ((uint64_t)(length - offset) - record) / apart)))
        return vvi_gltf_fail(g, "%llu records of %zu bytes do not fit into buffer view %zu", (unsigned long long)n,
                             record, index);
    *out = g->buffer[buffer] + begin + offset;
    return VV_OK;
}

/* Integers below 0 go to -1, those above to 1. */
static void normalize(double *v, size_t n, vv_type type)
{
    const double most = type == VV_TYPE_I8    ? 127
                        : type == VV_TYPE_U8  ? 255
                        : type == VV_TYPE_I16 ? 32767
                        : type == VV_TYPE_U16 ? 65535
                                              : 1;
    for (size_t i = 0; i < n; i++)
        v[i] = v[i] / most < -1 ? -1 : v[i] / most;
}

static void load(double *out, const uint8_t *in, size_t stride, vv_type type, int components, size_t n)
{
    const size_t bytes = vv_type_bytes(type);
    uint8_t packed[256 * 8 * 4];
    for (size_t i = 0; i < n; i += 256) {
        const size_t some = n - i < 256 ? n - i : 256, record = bytes * (size_t)components;
        for (size_t k = 0; k < some; k++)
            memcpy(packed + k * record, in + (i + k) * stride, record);
        if (vvi_machine_is_big())
            vvi_swap_bytes(packed, bytes, some * (size_t)components);
        vvi_samples_to_f64(out + i * (size_t)components, packed, type, some * (size_t)components);
    }
}

uint64_t vvi_gltf_count_bytes(const vvi_gltf *g)
{
    uint64_t n = g->json_bytes;
    for (size_t i = 0; i < g->n_buffers; i++)
        n += g->n_bytes[i];
    return n;
}

/* Some records are replaced by others. */
static vv_status fill_sparse(vvi_gltf *g, vvi_gltf_numbers *numbers, const json_t *sparse, vv_type type)
{
    const json_t *indices = json_object_get(sparse, "indices"), *values = json_object_get(sparse, "values");
    const size_t components = (size_t)numbers->components, record = vv_type_bytes(type) * components;
    const uint8_t *at = NULL, *from = NULL;
    size_t stride = 0, value_stride = 0;
    int64_t n, code;
    vv_type index_type;
    if (!vvi_json_whole(&n, json_object_get(sparse, "count")) || n < 0 || (uint64_t)n > numbers->n ||
        !vvi_json_whole(&code, json_object_get(indices, "componentType")) || !type_of(&index_type, code) ||
        vv_type_is_float(index_type))
        return vvi_gltf_fail(g, "a sparse accessor has no 'count' or no type for its indices");
    vv_status st = find_records(g, &at, &stride, indices, vv_type_bytes(index_type), (uint64_t)n);
    if (st != VV_OK || (st = find_records(g, &from, &value_stride, values, record, (uint64_t)n)) != VV_OK)
        return st;
    for (size_t i = 0; i < (size_t)n && at && from; i++) {
        double index = -1;
        load(&index, at + i * stride, stride, index_type, 1, 1);
        if (!(index >= 0 && index < (double)numbers->n))
            return vvi_gltf_fail(g, "a sparse accessor has an index past its end");
        load(numbers->v + (size_t)index * components, from + i * value_stride, value_stride, type, numbers->components,
             1);
    }
    return VV_OK;
}

static vv_status read_numbers(vvi_gltf_numbers *out, vvi_gltf *g, const json_t *accessor, vv_type type)
{
    const uint8_t *at = NULL;
    size_t stride = 0, bytes;
    const json_t *sparse = json_object_get(accessor, "sparse");
    vv_status st = VV_OK;
    if (json_object_get(accessor, "bufferView"))
        st = find_records(g, &at, &stride, accessor, vv_type_bytes(type) * (size_t)out->components, out->n);
    else
        st = vvi_memory_plan(g->job, (uint64_t)out->n * (uint64_t)out->components * sizeof(double), "an accessor");
    if (st != VV_OK || (st = vvi_mul3_size(&bytes, out->n + 1, (size_t)out->components, sizeof(double))) != VV_OK)
        return st;
    if ((st = vvi_source_grow(g->source, bytes)) != VV_OK)
        return st;
    if (!(out->v = vvi_alloc_zeroed(g->job, bytes, VVI_MEM_SCRATCH)))
        return vv_fail_memory(bytes);
    if (at)
        load(out->v, at, stride, type, out->components, out->n);
    if (sparse)
        st = fill_sparse(g, out, sparse, type);
    if (json_is_true(json_object_get(accessor, "normalized")))
        normalize(out->v, out->n * (size_t)out->components, type);
    return st;
}

/* Its count and components, but no numbers yet. */
static vv_status look_at(vvi_gltf_numbers *out, vv_type *type, const vvi_gltf *g, size_t index, int least, int most)
{
    const json_t *accessor = json_array_get(json_object_get(g->root, "accessors"), index);
    int64_t n, code;
    *out = (vvi_gltf_numbers){.components = components_of(accessor)};
    if (!vvi_json_whole(&n, json_object_get(accessor, "count")) || n < 0 || n >= UINT32_MAX ||
        !vvi_json_whole(&code, json_object_get(accessor, "componentType")) || !type_of(type, code) ||
        out->components < least || out->components > most)
        return vvi_gltf_fail(g, "accessor %zu has no count and type that fit its use", index);
    out->n = (size_t)n;
    return VV_OK;
}

vv_status vvi_gltf_count_accessor(size_t *out, vvi_gltf *g, size_t index, int least, int most)
{
    const json_t *accessor = json_array_get(json_object_get(g->root, "accessors"), index);
    vvi_gltf_numbers numbers;
    const uint8_t *at;
    size_t stride;
    vv_type type = VV_TYPE_U8;
    vv_status st = look_at(&numbers, &type, g, index, least, most);
    if (st == VV_OK && json_object_get(accessor, "bufferView"))
        st = find_records(g, &at, &stride, accessor, vv_type_bytes(type) * (size_t)numbers.components, numbers.n);
    *out = numbers.n;
    return st;
}

vv_status vvi_gltf_read_accessor(vvi_gltf_numbers *out, vvi_gltf *g, size_t index, int least, int most)
{
    const json_t *accessor = json_array_get(json_object_get(g->root, "accessors"), index);
    vv_type type = VV_TYPE_U8;
    vv_status st = look_at(out, &type, g, index, least, most);
    if (st != VV_OK)
        return st;
    st = read_numbers(out, g, accessor, type);
    if (st != VV_OK) {
        vvi_free(out->v);
        *out = (vvi_gltf_numbers){0};
    }
    return st;
}

static vv_status decode_text(vvi_gltf_bytes *out, const vvi_gltf *g, const char *uri)
{
    const char *text = strchr(uri, ',');
    size_t n = text ? strlen(++text) : 0;
    while (n > 0 && text[n - 1] == '=')
        n--;
    out->n = n / 4 * 3 + (n % 4 > 0 ? n % 4 - 1 : 0);
    out->owned = vvi_alloc(g->job, out->n + 1, VVI_MEM_SCRATCH);
    out->at = out->owned;
    if (!out->owned)
        return vv_fail_memory(out->n + 1);
    if (text && decode(out->owned, out->n, text))
        return VV_OK;
    vvi_free(out->owned);
    out->owned = NULL;
    return vvi_gltf_fail(g, "an image is not base64");
}

vv_status vvi_gltf_read_bytes(vvi_gltf_bytes *out, vvi_gltf *g, const json_t *object)
{
    const json_t *views = json_object_get(g->root, "bufferViews");
    const char *uri = json_string_value(json_object_get(object, "uri"));
    size_t view = 0, stride;
    bool there;
    int64_t n;
    *out = (vvi_gltf_bytes){0};
    if (uri)
        return decode_text(out, g, uri);
    const vv_status st = vvi_gltf_index(g, object, "bufferView", json_array_size(views), &view, &there);
    if (st != VV_OK)
        return st;
    if (!there || !vvi_json_whole(&n, json_object_get(json_array_get(views, view), "byteLength")) || n < 0)
        return vvi_gltf_fail(g, "an image has neither a file nor bytes");
    out->n = (size_t)n;
    return find_records(g, &out->at, &stride, object, out->n, 1);
}
