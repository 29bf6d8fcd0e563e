#include "core/memory.h"
#include "core/text.h"
#include "core/units.h"
#include "grid/field.h"
#include "io/coding.h"
#include "io/formats/metaimage/metaimage.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

const char *const vvi_metaimage_encodings[] = {"raw", "zlib", NULL};

static const char *type_name(vv_type type)
{
    static const char *const names[VV_TYPE_COUNT] = {"MET_UCHAR", "MET_CHAR",  "MET_USHORT",     "MET_SHORT",
                                                     "MET_UINT",  "MET_INT",   "MET_ULONG_LONG", "MET_LONG_LONG",
                                                     "MET_FLOAT", "MET_DOUBLE"};
    return names[type];
}

static vv_vec3 to_lps(vv_vec3 v, bool anatomical)
{
    return anatomical ? (vv_vec3){-v.x, -v.y, v.z} : v;
}

/* Directions, origin and spacing of n axes; the fourth is time and has none of the first two. */
static void add_place(vvi_text *t, const vv_field_info *info, const vv_grid *grid, int n)
{
    const bool anatomical = grid->space == VV_SPACE_RAS;
    const vv_vec3 o = to_lps(grid->index_to_world.origin, anatomical);
    double matrix[16] = {0}, spacing[4] = {1, 1, 1, info->frame_step != 0 ? info->frame_step : 1};
    const double origin[4] = {o.x, o.y, o.z, 0}, centre[4] = {0};
    vv_affine lps = vv_affine_identity();
    char letters[4] = "???";
    matrix[15] = 1;
    for (int a = 0; a < 3; a++) {
        const vv_vec3 v = to_lps(grid->index_to_world.axis[a], anatomical);
        spacing[a] = vvi_length(v);
        lps.axis[a] = (vv_vec3){v.x / spacing[a], v.y / spacing[a], v.z / spacing[a]};
        matrix[a * n] = lps.axis[a].x;
        matrix[a * n + 1] = lps.axis[a].y;
        matrix[a * n + 2] = lps.axis[a].z;
    }
    if (anatomical)
        vvi_metaimage_letters(letters, &lps);
    vvi_keys_print_numbers(t, "TransformMatrix", " =", matrix, n * n);
    vvi_keys_print_numbers(t, "Offset", " =", origin, n);
    vvi_keys_print_numbers(t, "CenterOfRotation", " =", centre, n);
    vvi_text_printf(t, "AnatomicalOrientation = %s\n", letters);
    vvi_keys_print_numbers(t, "ElementSpacing", " =", spacing, n);
}

static bool is_placed(const vv_grid *grid)
{
    return grid->space != VV_SPACE_PLAIN || strcmp(grid->unit, "voxels") != 0 ||
           !vvi_is_identity(&grid->index_to_world);
}

/* Nothing where a reader takes the samples for it anyway: three or four bytes are colours. */
static const char *meaning_name(const vv_field_info *info)
{
    const bool colours = info->type == VV_TYPE_U8 && (info->components == 3 || info->components == 4);
    const vv_meaning plain = !colours ? VV_MEANING_SCALAR : info->components == 3 ? VV_MEANING_RGB : VV_MEANING_RGBA;
    return info->meaning == plain ? "" : vvi_meaning_name(info->meaning);
}

/* What the format has keys for, and what it has none for. */
static void add_meaning(vvi_text *t, const vv_field_info *info, const char *file_unit, size_t n_frames)
{
    const vv_grid *grid = &info->grid;
    const double scale[2] = {info->value_scale, info->value_offset};
    bool known = strcmp(grid->unit, "voxels") == 0 && !is_placed(grid) && n_frames < 2;
    if (file_unit) {
        vvi_text_printf(t, "DistanceUnits = %s\n", file_unit);
        known = strcmp(grid->unit, file_unit) == 0;
    }
    if (!known)
        vvi_keys_print(t, VVI_METAIMAGE_UNIT, " = ", grid->unit);
    if (grid->space == VV_SPACE_PLAIN && is_placed(grid))
        vvi_text_add(t, VVI_METAIMAGE_SPACE " = plain\n");
    if (scale[0] != 1 || scale[1] != 0) {
        vvi_keys_print_numbers(t, "ElementToIntensityFunctionSlope", " =", &scale[0], 1);
        vvi_keys_print_numbers(t, "ElementToIntensityFunctionOffset", " =", &scale[1], 1);
    }
    const char *meaning = meaning_name(info);
    vvi_keys_print(t, VVI_METAIMAGE_MEANING, " = ", meaning);
    vvi_keys_print(t, VVI_METAIMAGE_VALUE_UNIT, " = ", info->value_unit);
    vvi_keys_print(t, VVI_METAIMAGE_FRAME_UNIT, " = ", info->frame_unit);
}

/* ITK, and with it most readers, passes over DistanceUnits and takes all lengths for millimetres. */
static bool in_millimetres(vv_grid *out, const vv_grid *grid)
{
    const double metres = vvi_length_unit_metres(grid->unit);
    *out = *grid;
    if (metres > 0 && strcmp(grid->unit, "mm") != 0)
        vvi_grid_scale(out, metres / vvi_length_unit_metres("mm"), "mm");
    return metres > 0;
}

static void build_header(vvi_text *t, const vv_field_info *info, size_t n_frames, const uint64_t *n_coded, bool big)
{
    const int n = n_frames > 1 ? 4 : 3;
    vv_grid grid;
    const bool is_length = in_millimetres(&grid, &info->grid);
    vvi_text_printf(t, "ObjectType = Image\nNDims = %d\n", n);
    vvi_keys_print(t, "Name", " = ", info->name);
    vvi_text_printf(t, "BinaryData = True\nBinaryDataByteOrderMSB = %s\nCompressedData = %s\n",
                    big && vv_type_bytes(info->type) > 1 ? "True" : "False", n_coded ? "True" : "False");
    if (n_coded)
        vvi_text_printf(t, "CompressedDataSize = %" PRIu64 "\n", *n_coded);
    if (is_placed(&info->grid) || n == 4)
        add_place(t, info, &grid, n);
    add_meaning(t, info, is_length ? grid.unit : NULL, n_frames);
    vvi_text_printf(t, "DimSize = %" PRId64 " %" PRId64 " %" PRId64, info->grid.dims[0], info->grid.dims[1],
                    info->grid.dims[2]);
    if (n == 4)
        vvi_text_printf(t, " %zu", n_frames);
    vvi_text_add(t, "\n");
    if (info->components > 1)
        vvi_text_printf(t, "ElementNumberOfChannels = %d\n", info->components);
    vvi_text_printf(t, "ElementType = %s\n", type_name(info->type));
}

/* Samples ---------------------------------------------------------------------------------------------------------- */

#define CODED_ROOM ((size_t)64 << 10)

/* Where samples go: as they are, or through zlib. Readers want to know in the header how many bytes that makes. */
typedef struct writing {
    vv_sink *sink; /* NULL: they are only counted */
    vv_type type;
    bool swap, negate; /* vectors of three: right and front to left and back */
    vvi_encoder *encoder;
    uint8_t *coded;
    uint64_t n_coded;
} writing;

static vv_status encode(writing *w, const void *data, size_t n_bytes, bool finish)
{
    bool done = false;
    vvi_coding_step step = {.in = data, .n_in = n_bytes};
    while (finish ? !done : step.n_in > 0) {
        step.out = w->coded;
        step.n_out = CODED_ROOM;
        if (!vvi_encoder_run(w->encoder, &step, finish, &done))
            return vv_fail(VV_E_INTERNAL, "the samples cannot be encoded");
        const size_t n = CODED_ROOM - step.n_out;
        vv_status st = w->sink ? vvi_sink_write(w->sink, w->coded, n) : VV_OK;
        if (st != VV_OK)
            return st;
        w->n_coded += n;
    }
    return VV_OK;
}

static vv_status write_piece(void *user, void *data, size_t n_bytes)
{
    writing *w = user;
    const size_t bytes = vv_type_bytes(w->type), n = n_bytes / bytes;
    for (size_t i = 0; w->negate && i < n; i++) {
        double v;
        uint8_t *at = (uint8_t *)data + i * bytes;
        if (i % 3 == 2)
            continue;
        vvi_samples_to_f64(&v, at, w->type, 1);
        v = -v;
        vvi_samples_from_f64(at, &v, w->type, 1);
    }
    if (w->swap)
        vvi_swap_bytes(data, bytes, n);
    return w->encoder ? encode(w, data, n_bytes, false) : vvi_sink_write(w->sink, data, n_bytes);
}

/* n_coded: how many bytes zlib made of them; NULL: raw. */
static vv_status write_samples(uint64_t *n_coded, vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                               const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    writing w = {.sink = sink,
                 .type = info->type,
                 .swap = vv_type_bytes(info->type) > 1 && vvi_order_swapped(options->big_endian),
                 .negate = info->meaning == VV_MEANING_VECTOR && info->components == 3 &&
                           info->grid.space == VV_SPACE_RAS && vvi_type_min(info->type) < 0};
    vv_status st = n_coded ? vvi_encoder_new(&w.encoder, VVI_CODING_ZLIB, options->level, job) : VV_OK;
    if (st == VV_OK && n_coded && !(w.coded = vvi_alloc(job, CODED_ROOM, VVI_MEM_SCRATCH)))
        st = vv_fail_memory(CODED_ROOM);
    for (size_t f = 0; f < n_frames && st == VV_OK; f++)
        st = vvi_samples_each(frames[f], -1, write_piece, &w, job);
    if (st == VV_OK && n_coded)
        st = encode(&w, NULL, 0, true);
    if (n_coded)
        *n_coded = w.n_coded;
    vvi_encoder_free(w.encoder);
    vvi_free(w.coded);
    return st;
}

static bool is_detached(const char *path)
{
    const size_t n = strlen(path);
    return n > 4 && strcasecmp(path + n - 4, ".mhd") == 0;
}

/* "head.mhd" keeps its samples in "head.raw" or "head.zraw". */
static char *data_name(const char *path, bool zlib)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    return vvi_asprintf("%.*s%s", (int)(strlen(base) - 4), base, zlib ? ".zraw" : ".raw");
}

static vv_status write_header(vv_sink *sink, const vv_field_info *info, size_t n_frames, const uint64_t *n_coded,
                              const char *data, bool big)
{
    vvi_text t = {0};
    build_header(&t, info, n_frames, n_coded, big);
    vvi_text_printf(&t, "ElementDataFile = %s\n", data);
    vv_status st = t.bad ? vv_fail_memory(t.n) : vvi_sink_write(sink, t.s, t.n);
    vvi_text_free(&t);
    return st;
}

vv_status vvi_metaimage_write(vv_sink *sink, const vv_field *const *frames, size_t n_frames,
                              const vv_write_options *options, vv_job *job)
{
    const vv_field_info *info = vv_field_get_info(frames[0]);
    const bool zlib = options->encoding && strcmp(options->encoding, "zlib") == 0;
    const bool detached = is_detached(vvi_sink_name(sink));
    uint64_t n = 0, *n_coded = zlib ? &n : NULL;
    vv_sink *data = sink;
    vv_status st = VV_OK;
    char *name = detached ? data_name(vvi_sink_name(sink), zlib) : vvi_strdup("LOCAL");
    if (!name)
        return vv_fail_memory(strlen(vvi_sink_name(sink)));
    vvi_log_lost_unit(sink, &info->grid, "mm", job);
    vvi_log_lost_names(sink, options, 0, "metaimage", job);
    if (detached && (st = vvi_sink_beside_on_line(&data, sink, name)) == VV_OK)
        st = write_samples(n_coded, data, frames, n_frames, options, job);
    else if (st == VV_OK && zlib) /* once to count: the header stands before them */
        st = write_samples(n_coded, NULL, frames, n_frames, options, job);
    if (st == VV_OK)
        st = write_header(sink, info, n_frames, n_coded, name, options->big_endian);
    if (st == VV_OK && !detached)
        st = write_samples(n_coded, sink, frames, n_frames, options, job);
    free(name);
    return st;
}
