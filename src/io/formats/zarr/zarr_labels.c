/* What OME-Zarr says of channels and labels, and what VolVis itself writes beside it ("volvis" among the attributes):
 * what OME-Zarr has no words for. */
#include "core/memory.h"
#include "grid/field.h"
#include "io/channel_colors.h"
#include "io/formats/zarr/zarr.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

static double channel_of_byte(double byte)
{
    return vv_srgb_decode(fmin(fmax(byte, 0), 255) / 255);
}

/* "FF8000" */
static void read_hex_color(vv_channel *out, const char *text)
{
    if (text && *text == '#')
        text++;
    if (!text || strlen(text) != 6 || strspn(text, "0123456789abcdefABCDEF") != 6)
        return;
    const unsigned long rgb = strtoul(text, NULL, 16);
    out->has_color = true;
    out->color = (vv_color){channel_of_byte((double)(rgb >> 16)), channel_of_byte((double)(rgb >> 8 & 255)),
                            channel_of_byte((double)(rgb & 255)), 1};
}

static bool same_byte(double a, double b)
{
    return fabs(vv_srgb_encode(a) - vv_srgb_encode(b)) < 0.5 / 255;
}

/* Where we wrote that a channel had no colour, and it still has the one that we put in its place. */
static bool is_uncolored(const vv_channel *channel, const json_t *uncolored, size_t index)
{
    const vv_color a = channel->color, b = vvi_channel_color(NULL, 0, index);
    bool listed = false;
    for (size_t i = 0; i < json_array_size(uncolored); i++) {
        const json_t *number = json_array_get(uncolored, i);
        listed = listed || (json_is_integer(number) && json_integer_value(number) == (json_int_t)index);
    }
    return listed && same_byte(a.r, b.r) && same_byte(a.g, b.g) && same_byte(a.b, b.b);
}

static vv_status read_channels(const vv_field_info *info, const json_t *ome, const json_t *own, vv_notes *notes)
{
    const json_t *list = json_object_get(json_object_get(ome, "omero"), "channels");
    const json_t *uncolored = json_object_get(own, "uncolored_channels");
    vv_status st = VV_OK;
    if (json_array_size(list) != (size_t)info->components)
        return VV_OK;
    for (size_t i = 0; i < json_array_size(list) && st == VV_OK; i++) {
        const json_t *said = json_array_get(list, i), *window = json_object_get(said, "window");
        vv_channel channel = {0};
        double lo, hi;
        vvi_json_copy_text(channel.name, sizeof channel.name, vvi_json_text(said, "label"));
        read_hex_color(&channel, vvi_json_text(said, "color"));
        channel.has_color = channel.has_color && !is_uncolored(&channel, uncolored, i);
        if (vvi_json_real(&lo, json_object_get(window, "start")) &&
            vvi_json_real(&hi, json_object_get(window, "end")) && lo < hi) {
            channel.lo = lo;
            channel.hi = hi;
        }
        st = vvi_notes_channel(notes, &channel);
    }
    return st;
}

/* Labels --------------------------------------------------------------------------------------------------------- */

static void read_name(vv_label *label, const json_t *property)
{
    static const char *const keys[] = {"name", "Name", "label", "class", "cell type", "structure"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys && !label->name[0]; i++)
        vvi_json_copy_text(label->name, sizeof label->name, vvi_json_text(property, keys[i]));
}

static void read_rgba(vv_label *label, const json_t *rgba)
{
    double v[4] = {0, 0, 0, 255};
    if (json_array_size(rgba) < 3 || json_array_size(rgba) > 4)
        return;
    for (size_t i = 0; i < json_array_size(rgba); i++)
        if (!vvi_json_real(&v[i], json_array_get(rgba, i)))
            return;
    label->has_color = true;
    label->color =
        (vv_color){channel_of_byte(v[0]), channel_of_byte(v[1]), channel_of_byte(v[2]), fmin(fmax(v[3], 0), 255) / 255};
}

static int by_value(const void *a, const void *b)
{
    const int64_t p = ((const vv_label *)a)->value, q = ((const vv_label *)b)->value;
    return p < q ? -1 : p > q;
}

/* Colours and properties are lists of their own; a value may be in one of them or in both. */
static size_t gather(vv_label *out, const json_t *image_label)
{
    static const char *const lists[2] = {"colors", "properties"};
    size_t n = 0;
    for (int l = 0; l < 2; l++) {
        size_t i;
        json_t *entry;
        json_array_foreach(json_object_get(image_label, lists[l]), i, entry)
        {
            vv_label label = {0};
            if (!vvi_json_label(&label.value, json_object_get(entry, "label-value")))
                continue;
            if (l == 0)
                read_rgba(&label, json_object_get(entry, "rgba"));
            else
                read_name(&label, entry);
            out[n++] = label;
        }
    }
    qsort(out, n, sizeof *out, by_value);
    return n;
}

static vv_status read_labels(const json_t *image_label, vv_notes *notes, vv_job *job)
{
    const size_t most = json_array_size(json_object_get(image_label, "colors")) +
                        json_array_size(json_object_get(image_label, "properties"));
    if (most == 0)
        return VV_OK;
    vv_label *labels = vvi_alloc(job, most * sizeof *labels, VVI_MEM_SCRATCH);
    if (!labels)
        return vv_fail_memory(most * sizeof *labels);
    const size_t n = gather(labels, image_label);
    vv_status st = VV_OK;
    for (size_t i = 0, next; i < n && st == VV_OK; i = next) {
        for (next = i + 1; next < n && labels[next].value == labels[i].value; next++) {
            if (labels[next].has_color && !labels[i].has_color) {
                labels[i].has_color = true;
                labels[i].color = labels[next].color;
            }
            if (!labels[i].name[0])
                memcpy(labels[i].name, labels[next].name, sizeof labels[i].name);
        }
        st = vvi_notes_label(notes, &labels[i]);
    }
    vvi_free(labels);
    return st;
}

/* Whether an image lies in a group "labels". */
static bool lies_in_labels(const char *path)
{
    const char *last = strrchr(path, '/');
    const size_t n = last ? (size_t)(last - path) : 0;
    return n >= 6 && strncmp(path + n - 6, "labels", 6) == 0 && (n == 6 || path[n - 7] == '/');
}

/* What VolVis wrote ---------------------------------------------------------------------------------------------- */

static void read_meaning(vv_field_info *info, const char *meaning)
{
    static const struct {
        const char *name;
        vv_meaning meaning;
        int components; /* 0: any */
    } known[] = {{"rgb", VV_MEANING_RGB, 3}, {"rgba", VV_MEANING_RGBA, 4}, {"vector", VV_MEANING_VECTOR, 0}};
    for (size_t i = 0; meaning && i < sizeof known / sizeof *known; i++)
        if (strcmp(meaning, known[i].name) == 0 &&
            (known[i].components == 0 || known[i].components == info->components))
            info->meaning = known[i].meaning;
}

/* Rows of four numbers that lead from the image's world to the volume's. */
static void read_placement(vv_field_info *info, const json_t *rows)
{
    double m[3][4];
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 4; k++)
            if (json_array_size(rows) != 3 || json_array_size(json_array_get(rows, i)) != 4 ||
                !vvi_json_real(&m[i][k], json_array_get(json_array_get(rows, i), k)))
                return;
    const vv_affine old = info->grid.index_to_world;
    const vv_affine turn = {{{m[0][0], m[1][0], m[2][0]}, {m[0][1], m[1][1], m[2][1]}, {m[0][2], m[1][2], m[2][2]}},
                            {0, 0, 0}};
    for (int a = 0; a < 3; a++)
        info->grid.index_to_world.axis[a] = vv_affine_point(turn, old.axis[a]);
    vv_vec3 origin = vv_affine_point(turn, old.origin);
    info->grid.index_to_world.origin = (vv_vec3){origin.x + m[0][3], origin.y + m[1][3], origin.z + m[2][3]};
    if (vv_field_info_check(info) != VV_OK)
        info->grid.index_to_world = old;
}

static void read_own(vv_field_info *info, const json_t *own)
{
    double scale, offset;
    const char *space = vvi_json_text(own, "space");
    if (vvi_json_real(&scale, json_object_get(own, "value_scale")) && scale != 0 &&
        vvi_json_real(&offset, json_object_get(own, "value_offset"))) {
        info->value_scale = scale;
        info->value_offset = offset;
    }
    vvi_json_copy_text(info->value_unit, sizeof info->value_unit, vvi_json_text(own, "value_unit"));
    vvi_json_copy_text(info->name, sizeof info->name, vvi_json_text(own, "name"));
    if (vvi_json_text(own, "unit"))
        vvi_json_copy_text(info->grid.unit, sizeof info->grid.unit, vvi_json_text(own, "unit"));
    read_meaning(info, vvi_json_text(own, "meaning"));
    read_placement(info, json_object_get(own, "placement"));
    if (space && strcmp(space, "RAS") == 0)
        info->grid.space = VV_SPACE_RAS;
}

vv_status vvi_zarr_describe(vv_field_info *info, const vvi_zarr_node *node, vv_notes *notes, vv_job *job)
{
    const json_t *ome = vvi_zarr_ome(node), *image_label = json_object_get(ome, "image-label");
    const json_t *own = json_object_get(node->attributes, "volvis");
    if (json_is_object(own))
        read_own(info, own);
    vv_status st = read_channels(info, ome, own, notes);
    if ((image_label || lies_in_labels(node->path)) && info->components == 1 && !vv_type_is_float(info->type))
        info->meaning = VV_MEANING_LABEL;
    return st == VV_OK && json_is_object(image_label) ? read_labels(image_label, notes, job) : st;
}
