/* Metadata of what is written: groups and arrays of Zarr 2 or 3, OME-Zarr's image in them, and what OME-Zarr has no
 * words for among VolVis' own attributes. */
#include "core/units.h"
#include "grid/label_id.h"
#include "io/channel_colors.h"
#include "io/formats/zarr/zarr_write.h"
#include "io/placement.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include <inttypes.h>
#include <math.h>
#include <string.h>
#include <volvis/image.h>

static void add_number(vvi_text *t, double value)
{
    char text[32];
    vvi_print_unsigned_zero(text, value);
    vvi_text_add(t, text);
}

/* Letters of the axes, slowest first. */
static void letters_of(char out[6], const vvi_zarr_writing *w)
{
    snprintf(out, 6, "%s%szyx", w->n_frames > 1 ? "t" : "", w->info->components > 1 ? "c" : "");
}

/* Units by the names that OME-Zarr has; NULL when it has none. */
static const char *long_unit(const char *said)
{
    char unit[16];
    vvi_unit_name(unit, said, strlen(said));
    static const struct {
        const char *unit, *name;
    } known[] = {{"um", "micrometer"},  {"mm", "millimeter"}, {"nm", "nanometer"}, {"cm", "centimeter"},
                 {"m", "meter"},        {"pm", "picometer"},  {"A", "angstrom"},   {"km", "kilometer"},
                 {"in", "inch"},        {"ft", "foot"},       {"s", "second"},     {"ms", "millisecond"},
                 {"us", "microsecond"}, {"min", "minute"},    {"h", "hour"}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(unit, known[i].unit) == 0)
            return known[i].name;
    return NULL;
}

/* Arrays --------------------------------------------------------------------------------------------------------- */

typedef enum shape_kind { SHAPE, CHUNKS, SHARDS } shape_kind;

static void add_sizes(vvi_text *t, const vvi_zarr_writing *w, const vvi_zarr_level *l, shape_kind kind)
{
    int64_t n[3];
    for (int a = 0; a < 3; a++)
        n[a] = kind == SHAPE ? l->dims[a] : l->chunk[a] * (kind == SHARDS && a < 2 ? l->shard[a] : 1);
    vvi_text_add(t, "[");
    if (w->n_frames > 1)
        vvi_text_printf(t, "%" PRId64 ",", kind == SHAPE ? w->n_frames : 1);
    if (w->info->components > 1)
        vvi_text_printf(t, "%d,", kind == SHAPE ? w->info->components : 1);
    vvi_text_printf(t, "%" PRId64 ",%" PRId64 ",%" PRId64 "]", n[2], n[1], n[0]);
}

static void add_array_v2(vvi_text *t, const vvi_zarr_writing *w, const vvi_zarr_level *l)
{
    static const char *const types[VV_TYPE_COUNT] = {"u1", "i1", "u2", "i2", "u4", "i4", "u8", "i8", "f4", "f8"};
    const int level = vvi_zarr_pack_level(w->packing, w->options->level);
    const char order = w->type_bytes == 1 ? '|' : w->options->big_endian ? '>' : '<';
    vvi_text_add(t, "{\n  \"zarr_format\": 2,\n  \"shape\": ");
    add_sizes(t, w, l, SHAPE);
    vvi_text_add(t, ",\n  \"chunks\": ");
    add_sizes(t, w, l, CHUNKS);
    vvi_text_printf(t, ",\n  \"dtype\": \"%c%s\",\n  \"compressor\": ", order, types[w->info->type]);
    if (w->packing == VVI_ZARR_PACK_RAW)
        vvi_text_add(t, "null");
    else if (w->packing == VVI_ZARR_PACK_BLOSC)
        vvi_text_printf(t,
                        "{\"id\": \"blosc\", \"cname\": \"zstd\", \"clevel\": %d, \"shuffle\": %d, \"blocksize\": 0}",
                        level, w->type_bytes > 1);
    else
        vvi_text_printf(t, "{\"id\": \"%s\", \"level\": %d}", w->packing == VVI_ZARR_PACK_ZSTD ? "zstd" : "gzip",
                        level);
    vvi_text_add(
        t, ",\n  \"fill_value\": 0,\n  \"order\": \"C\",\n  \"filters\": null,\n  \"dimension_separator\": \"/\"\n}\n");
}

static void add_codecs_v3(vvi_text *t, const vvi_zarr_writing *w)
{
    const int level = vvi_zarr_pack_level(w->packing, w->options->level);
    vvi_text_printf(t, "[{\"name\": \"bytes\", \"configuration\": {\"endian\": \"%s\"}}",
                    w->options->big_endian && w->type_bytes > 1 ? "big" : "little");
    if (w->packing == VVI_ZARR_PACK_BLOSC)
        vvi_text_printf(
            t,
            ", {\"name\": \"blosc\", \"configuration\": {\"typesize\": %zu, \"cname\": \"zstd\", \"clevel\": "
            "%d, \"shuffle\": \"%s\", \"blocksize\": 0}}",
            w->type_bytes, level, w->type_bytes > 1 ? "shuffle" : "noshuffle");
    else if (w->packing == VVI_ZARR_PACK_ZSTD)
        vvi_text_printf(t, ", {\"name\": \"zstd\", \"configuration\": {\"level\": %d, \"checksum\": false}}", level);
    else if (w->packing == VVI_ZARR_PACK_GZIP)
        vvi_text_printf(t, ", {\"name\": \"gzip\", \"configuration\": {\"level\": %d}}", level);
    vvi_text_add(t, "]");
}

/* Chunks as they are coded: alone, or in shards with an index at the end. */
static void add_coding_v3(vvi_text *t, const vvi_zarr_writing *w, const vvi_zarr_level *l)
{
    if (l->shard[0] == 0) {
        add_codecs_v3(t, w);
        return;
    }
    vvi_text_add(t, "[{\"name\": \"sharding_indexed\", \"configuration\": {\"chunk_shape\": ");
    add_sizes(t, w, l, CHUNKS);
    vvi_text_add(t, ", \"codecs\": ");
    add_codecs_v3(t, w);
    vvi_text_add(t, ",\n    \"index_codecs\": [{\"name\": \"bytes\", \"configuration\": {\"endian\": \"little\"}}, "
                    "{\"name\": \"crc32c\"}], \"index_location\": \"end\"}}]");
}

static void add_array_v3(vvi_text *t, const vvi_zarr_writing *w, const vvi_zarr_level *l)
{
    static const char *const types[VV_TYPE_COUNT] = {"uint8", "int8",   "uint16", "int16",   "uint32",
                                                     "int32", "uint64", "int64",  "float32", "float64"};
    char letters[6];
    letters_of(letters, w);
    vvi_text_add(t, "{\n  \"zarr_format\": 3,\n  \"node_type\": \"array\",\n  \"shape\": ");
    add_sizes(t, w, l, SHAPE);
    vvi_text_printf(t,
                    ",\n  \"data_type\": \"%s\",\n  \"chunk_grid\": {\"name\": \"regular\", \"configuration\": "
                    "{\"chunk_shape\": ",
                    types[w->info->type]);
    add_sizes(t, w, l, l->shard[0] > 0 ? SHARDS : CHUNKS);
    vvi_text_add(t,
                 "}},\n  \"chunk_key_encoding\": {\"name\": \"default\", \"configuration\": {\"separator\": \"/\"}},\n"
                 "  \"fill_value\": 0,\n  \"codecs\": ");
    add_coding_v3(t, w, l);
    vvi_text_add(t, ",\n  \"dimension_names\": [");
    for (size_t i = 0; letters[i]; i++)
        vvi_text_printf(t, "%s\"%c\"", i ? ", " : "", letters[i]);
    vvi_text_add(t, "],\n  \"attributes\": {}\n}\n");
}

/* The image ------------------------------------------------------------------------------------------------------ */

static void add_axes(vvi_text *t, const vvi_zarr_writing *w)
{
    static const char *const anatomical[3] = {"left-to-right", "posterior-to-anterior", "inferior-to-superior"};
    char letters[6];
    letters_of(letters, w);
    vvi_text_add(t, "[");
    for (size_t i = 0; letters[i]; i++) {
        const char c = letters[i];
        const char *unit = long_unit(c == 't' ? w->info->frame_unit : w->info->grid.unit);
        vvi_text_printf(t, "%s{\"name\": \"%c\", \"type\": \"%s\"", i ? ", " : "", c,
                        c == 't'   ? "time"
                        : c == 'c' ? "channel"
                                   : "space");
        if (unit && c != 'c')
            vvi_text_printf(t, ", \"unit\": \"%s\"", unit);
        if (c >= 'x' && w->info->grid.space == VV_SPACE_RAS && !w->oblique)
            vvi_text_printf(t, ", \"orientation\": {\"type\": \"anatomical\", \"value\": \"%s\"}", anatomical[c - 'x']);
        vvi_text_add(t, "}");
    }
    vvi_text_add(t, "]");
}

/* Samples of a level lie in the middle of the blocks that they stand for. */
static void add_level(vvi_text *t, const vvi_zarr_writing *w, int number)
{
    const vvi_zarr_level *l = &w->level[number];
    const double step = w->info->frame_step;
    char letters[6];
    letters_of(letters, w);
    vvi_text_printf(t, "%s{\"path\": \"%d\", \"coordinateTransformations\": [", number ? ",\n        " : "", number);
    for (int kind = 0; kind < 2; kind++) {
        vvi_text_printf(t, "%s{\"type\": \"%s\", \"%s\": [", kind ? ", " : "", kind ? "translation" : "scale",
                        kind ? "translation" : "scale");
        for (size_t i = 0; letters[i]; i++) {
            const int a = letters[i] - 'x';
            vvi_text_add(t, i ? ", " : "");
            if (a >= 0)
                add_number(t, kind ? w->origin[a] + w->spacing[a] * 0.5 * (double)(l->factor[a] - 1)
                                   : w->spacing[a] * (double)l->factor[a]);
            else
                add_number(t, kind ? 0 : letters[i] == 't' && step > 0 ? step : 1);
        }
        vvi_text_add(t, "]}");
    }
    vvi_text_add(t, "]}");
}

static int byte_of(double linear)
{
    return (int)lround(vv_srgb_encode(fmin(fmax(linear, 0), 1)) * 255);
}

static bool has_channels(const vvi_zarr_writing *w)
{
    return w->options->n_channels == (size_t)w->info->components;
}

/* Every channel must have a colour here. */
static void add_channels(vvi_text *t, const vvi_zarr_writing *w)
{
    const vv_write_options *o = w->options;
    if (!has_channels(w))
        return;
    vvi_text_add(t, ",\n    \"omero\": {\"channels\": [");
    for (size_t i = 0; i < o->n_channels; i++) {
        const vv_channel *c = &o->channels[i];
        const vv_color color = vvi_channel_color(o->channels, o->n_channels, i);
        vvi_text_add(t, i ? ", {\"label\": " : "{\"label\": ");
        vvi_text_json_ascii(t, c->name);
        vvi_text_printf(t, ", \"color\": \"%02X%02X%02X\", \"active\": true", byte_of(color.r), byte_of(color.g),
                        byte_of(color.b));
        if (c->lo < c->hi) {
            static const char *const keys[4] = {"min", "start", "end", "max"};
            for (int k = 0; k < 4; k++) {
                vvi_text_printf(t, "%s\"%s\": ", k ? ", " : ", \"window\": {", keys[k]);
                add_number(t, k < 2 ? c->lo : c->hi);
            }
            vvi_text_add(t, "}");
        }
        vvi_text_add(t, "}");
    }
    vvi_text_add(t, "]}");
}

static void begin_label(vvi_text *t, vv_label_id value, bool is_unsigned)
{
    char digits[VVI_LABEL_DIGITS];
    vvi_text_printf(t, "%s{\"label-value\": %s", t->n ? ", " : "", vvi_label_print(digits, value, is_unsigned));
}

static void add_label_colors(vvi_text *t, const vv_write_options *o, bool is_unsigned)
{
    for (size_t i = 0; i < o->n_labels; i++) {
        const vv_label *l = &o->labels[i];
        if (!l->has_color)
            continue;
        begin_label(t, l->value, is_unsigned);
        vvi_text_printf(t, ", \"rgba\": [%d, %d, %d, %d]}", byte_of(l->color.r), byte_of(l->color.g),
                        byte_of(l->color.b), (int)lround(fmin(fmax(l->color.a, 0), 1) * 255));
    }
}

static void add_label_names(vvi_text *t, const vv_write_options *o, bool is_unsigned)
{
    for (size_t i = 0; i < o->n_labels; i++) {
        if (!o->labels[i].name[0])
            continue;
        begin_label(t, o->labels[i].value, is_unsigned);
        vvi_text_add(t, ", \"name\": ");
        vvi_text_json_ascii(t, o->labels[i].name);
        vvi_text_add(t, "}");
    }
}

/* At the image itself: a group "labels" belongs into the image that was segmented, of which nothing is known here.
 * Lists without entries are not valid. */
static void add_labels(vvi_text *t, const vvi_zarr_writing *w)
{
    vvi_text colors = {0}, names = {0};
    const bool is_unsigned = vvi_label_is_unsigned(w->info->type);
    const char *version = w->version == 2 ? "\"version\": \"0.4\"" : "";
    if (!w->label)
        return;
    add_label_colors(&colors, w->options, is_unsigned);
    add_label_names(&names, w->options, is_unsigned);
    vvi_text_printf(t, ",\n    \"image-label\": {%s", version);
    if (colors.n > 0)
        vvi_text_printf(t, "%s\"colors\": [%s]", *version ? ", " : "", colors.bad ? "" : colors.s);
    if (names.n > 0)
        vvi_text_printf(t, "%s\"properties\": [%s]", *version || colors.n > 0 ? ", " : "", names.bad ? "" : names.s);
    vvi_text_add(t, "}");
    t->bad = t->bad || colors.bad || names.bad;
    vvi_text_free(&colors);
    vvi_text_free(&names);
}

static void add_image(vvi_text *t, const vvi_zarr_writing *w)
{
    vvi_text_add(t, w->version == 3 ? "\"ome\": {\n    \"version\": \"0.5\",\n    " : "");
    vvi_text_printf(t, "\"multiscales\": [{%s\n      \"axes\": ", w->version == 2 ? "\"version\": \"0.4\"," : "");
    add_axes(t, w);
    vvi_text_add(t, ",\n      \"datasets\": [");
    for (int i = 0; i < w->n_levels; i++)
        add_level(t, w, i);
    vvi_text_printf(t, "],\n      \"type\": \"%s\"}]", w->label ? "mode" : "mean");
    add_channels(t, w);
    add_labels(t, w);
    vvi_text_add(t, w->version == 3 ? "}" : "");
}

/* VolVis' own ----------------------------------------------------------------------------------------------------- */

static void begin_own(vvi_text *own, const char *key)
{
    vvi_text_printf(own, "%s\"%s\": ", own->n ? ", " : "", key);
}

static void add_own_text(vvi_text *own, const char *key, const char *text)
{
    if (!*text)
        return;
    begin_own(own, key);
    vvi_text_json_ascii(own, text);
}

static void add_own_placement(vvi_text *own, const vvi_zarr_writing *w)
{
    const vv_affine *p = &w->placement;
    const double *spacing = w->spacing, *o = w->origin;
    double m[4][3] = {{p->axis[0].x / spacing[0], p->axis[0].y / spacing[0], p->axis[0].z / spacing[0]},
                      {p->axis[1].x / spacing[1], p->axis[1].y / spacing[1], p->axis[1].z / spacing[1]},
                      {p->axis[2].x / spacing[2], p->axis[2].y / spacing[2], p->axis[2].z / spacing[2]},
                      {p->origin.x, p->origin.y, p->origin.z}};
    for (int row = 0; row < 3; row++)
        m[3][row] -= m[0][row] * o[0] + m[1][row] * o[1] + m[2][row] * o[2];
    begin_own(own, "placement");
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            vvi_text_add(own, column ? ", " : row ? "], [" : "[[");
            add_number(own, m[column][row]);
        }
    vvi_text_add(own, "]]");
}

/* Channels whose colour is not the file's: what would be shown stands in its place. */
static void add_own_uncolored(vvi_text *own, const vvi_zarr_writing *w)
{
    bool any = false;
    for (size_t i = 0; has_channels(w) && i < w->options->n_channels; i++) {
        if (w->options->channels[i].has_color)
            continue;
        if (!any)
            begin_own(own, "uncolored_channels");
        vvi_text_printf(own, "%s%zu", any ? ", " : "[", i);
        any = true;
    }
    vvi_text_add(own, any ? "]" : "");
}

static void add_own(vvi_text *t, const vvi_zarr_writing *w)
{
    static const char *const meanings[] = {[VV_MEANING_SCALAR] = "",
                                           [VV_MEANING_RGB] = "rgb",
                                           [VV_MEANING_RGBA] = "rgba",
                                           [VV_MEANING_VECTOR] = "vector",
                                           [VV_MEANING_LABEL] = ""};
    const vv_field_info *info = w->info;
    vvi_text own = {0};
    if (info->value_scale != 1 || info->value_offset != 0) {
        begin_own(&own, "value_scale");
        add_number(&own, info->value_scale);
        begin_own(&own, "value_offset");
        add_number(&own, info->value_offset);
    }
    add_own_text(&own, "value_unit", info->value_unit);
    add_own_text(&own, "name", info->name);
    add_own_text(&own, "meaning", meanings[info->meaning]);
    add_own_text(&own, "unit", long_unit(info->grid.unit) ? "" : info->grid.unit);
    add_own_text(&own, "space", info->grid.space == VV_SPACE_RAS ? "RAS" : "");
    if (w->oblique)
        add_own_placement(&own, w);
    add_own_uncolored(&own, w);
    if (own.n > 0)
        vvi_text_printf(t, ",\n    \"volvis\": {%s}", own.bad ? "" : own.s);
    t->bad = t->bad || own.bad;
    vvi_text_free(&own);
}

/* Files ---------------------------------------------------------------------------------------------------------- */

/* Writes the text under a name and frees it. */
static vv_status put(const vvi_zarr_writing *w, const char *name, vvi_text *t)
{
    vv_status st = t->bad ? vv_fail_memory(t->n) : vvi_sink_put(w->sink, name, t->s, t->n);
    vvi_text_free(t);
    return st;
}

static vv_status write_group(const vvi_zarr_writing *w)
{
    vvi_text t = {0};
    vv_status st = VV_OK;
    if (w->version == 2) {
        vvi_text_add(&t, "{\n  \"zarr_format\": 2\n}\n");
        if ((st = put(w, ".zgroup", &t)) != VV_OK)
            return st;
    }
    vvi_text_add(&t, w->version == 2
                         ? "{\n    "
                         : "{\n  \"zarr_format\": 3,\n  \"node_type\": \"group\",\n  \"attributes\": {\n    ");
    add_image(&t, w);
    add_own(&t, w);
    vvi_text_add(&t, w->version == 2 ? "\n}\n" : "\n  }\n}\n");
    return put(w, w->version == 2 ? ".zattrs" : "zarr.json", &t);
}

vv_status vvi_zarr_write_meta(const vvi_zarr_writing *w)
{
    vv_status st = write_group(w);
    for (int i = 0; i < w->n_levels && st == VV_OK; i++) {
        vvi_text t = {0};
        char name[32];
        snprintf(name, sizeof name, "%d/%s", i, w->version == 2 ? ".zarray" : "zarr.json");
        if (w->version == 2)
            add_array_v2(&t, w, &w->level[i]);
        else
            add_array_v3(&t, w, &w->level[i]);
        st = put(w, name, &t);
    }
    return st;
}
