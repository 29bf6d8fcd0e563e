/* Names, colours and windows in the keys of a NRRD: segments as 3D Slicer writes them, channels in keys of our own. */
#include "core/memory.h"
#include "core/units.h"
#include "grid/label_id.h"
#include "io/formats/nrrd/nrrd.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <volvis/image.h>

struct vvi_nrrd_names {
    vvi_nrrd_segment *segments;
    vv_channel *channels;
    size_t n_segments, n_channels;
};

/* Entry `number` of an array that grows to it; what lies between is zero. */
static void *entry(void **items, size_t *n, size_t number, size_t bytes)
{
    if (number >= *n) {
        size_t room = number + 1;
        while (room & (room - 1)) /* powers of two, so that numbers in order do not copy each time */
            room += room & (~room + 1);
        char *grown = vvi_realloc(NULL, *items, room * bytes, VVI_MEM_MODEL);
        if (!grown)
            return NULL;
        memset(grown + *n * bytes, 0, (room - *n) * bytes);
        *items = grown;
        *n = room;
    }
    return (char *)*items + number * bytes;
}

bool vvi_nrrd_numbered(size_t *number_out, const char **rest_out, const char *key, const char *prefix)
{
    const size_t n = strlen(prefix);
    uint64_t number;
    if (strncmp(key, prefix, n) != 0 || key[n] < '0' || key[n] > '9' || !vvi_scan_uint(&number, key + n, rest_out) ||
        number >= VVI_NRRD_NAMES_MOST)
        return false;
    *number_out = (size_t)number;
    return true;
}

/* Red, green and blue as a screen has them. */
static bool parse_color(vv_color *out, const char *value)
{
    double c[3];
    for (int i = 0; i < 3; i++)
        if (!vvi_scan_real(&c[i], value, &value) || !(c[i] >= 0 && c[i] <= 1))
            return false;
    *out = (vv_color){vv_srgb_decode(c[0]), vv_srgb_decode(c[1]), vv_srgb_decode(c[2]), 1};
    return true;
}

static void copy_name(char out[64], const char *value)
{
    snprintf(out, 64, "%.*s", (int)vvi_utf8_cut(value, strlen(value), 63), value);
}

/* They belong to the names. */
static vv_status keep_codes(vvi_nrrd_segment *s, const char *tags)
{
    vv_code codes[VV_LABEL_CODES];
    if (s->codes || !vvi_nrrd_parse_tags(codes, tags))
        return VV_OK;
    s->codes = vvi_alloc(NULL, sizeof codes, VVI_MEM_MODEL);
    if (!s->codes)
        return vv_fail_memory(sizeof codes);
    memcpy(s->codes, codes, sizeof codes);
    return VV_OK;
}

static vv_status keep_segment(vvi_nrrd_names *names, size_t number, const char *rest, const char *value)
{
    int64_t whole;
    double real;
    const char *end;
    vvi_nrrd_segment *s = entry((void **)&names->segments, &names->n_segments, number, sizeof *names->segments);
    if (!s)
        return vv_fail_memory(sizeof *s);
    if (!s->there)
        *s = (vvi_nrrd_segment){.there = true, .opacity = 1, .label.value = (int64_t)number + 1};
    if (strcmp(rest, "_Name") == 0)
        copy_name(s->label.name, value);
    else if (strcmp(rest, "_LabelValue") == 0 && vvi_scan_label(&whole, value, &end))
        s->label.value = whole;
    else if (strcmp(rest, "_Layer") == 0 && vvi_scan_int(&whole, value, &end) && whole >= 0 && whole < INT32_MAX)
        s->layer = (int)whole;
    else if (strcmp(rest, "_Color") == 0)
        s->label.has_color = parse_color(&s->label.color, value);
    else if (strcmp(rest, "_VolVisOpacity") == 0 && vvi_scan_real(&real, value, &end) && real >= 0 && real <= 1)
        s->opacity = real;
    else if (strcmp(rest, "_Tags") == 0)
        return keep_codes(s, value);
    return VV_OK;
}

static vv_status keep_channel(vvi_nrrd_names *names, size_t number, const char *rest, const char *value)
{
    vv_channel *c = entry((void **)&names->channels, &names->n_channels, number, sizeof *names->channels);
    double lo, hi;
    if (!c)
        return vv_fail_memory(sizeof *c);
    if (strcmp(rest, " name") == 0)
        copy_name(c->name, value);
    else if (strcmp(rest, " color") == 0)
        c->has_color = parse_color(&c->color, value);
    else if (strcmp(rest, " window") == 0 && vvi_scan_real(&lo, value, &value) && vvi_scan_real(&hi, value, &value) &&
             isfinite(lo) && isfinite(hi) && lo < hi) {
        c->lo = lo;
        c->hi = hi;
    }
    return VV_OK;
}

vv_status vvi_nrrd_name_key(vvi_nrrd *h, const char *key, const char *value)
{
    size_t number;
    const char *rest;
    const bool segment = vvi_nrrd_numbered(&number, &rest, key, "Segment") && rest[0] == '_';
    if (!segment && !vvi_nrrd_numbered(&number, &rest, key, "volvis channel "))
        return VV_OK;
    if (!h->names && !(h->names = vvi_alloc_zeroed(NULL, sizeof *h->names, VVI_MEM_MODEL)))
        return vv_fail_memory(sizeof *h->names);
    h->is_segmentation |= segment;
    return segment ? keep_segment(h->names, number, rest, value) : keep_channel(h->names, number, rest, value);
}

void vvi_nrrd_names_free(vvi_nrrd_names *names)
{
    if (!names)
        return;
    for (size_t i = 0; i < names->n_segments; i++)
        vvi_free(names->segments[i].codes);
    vvi_free(names->segments);
    vvi_free(names->channels);
    vvi_free(names);
}

const vvi_nrrd_segment *vvi_nrrd_get_segment(const vvi_nrrd_names *names, size_t index)
{
    return names && index < names->n_segments ? &names->segments[index] : NULL;
}

static bool is_repeated(const vvi_nrrd_names *names, size_t index)
{
    const vvi_nrrd_segment *s = &names->segments[index];
    for (size_t i = 0; i < index; i++) {
        const vvi_nrrd_segment *t = &names->segments[i];
        if (t->there && t->layer == s->layer && t->label.value == s->label.value)
            return true;
    }
    return false;
}

static vv_status note_labels(const vvi_nrrd *h, vv_notes *notes)
{
    const vvi_nrrd_names *names = h->names;
    char digits[VVI_LABEL_DIGITS];
    vv_status st = VV_OK;
    for (size_t i = 0; i < names->n_segments && st == VV_OK; i++) {
        const vvi_nrrd_segment *s = &names->segments[i];
        if (!s->there || s->layer != h->layer)
            continue;
        if (is_repeated(names, i)) {
            st = vvi_notes_warn(notes, "its segment %zu has the label %s of another and is left out", i,
                                vvi_label_print(digits, s->label.value, vvi_label_is_unsigned(h->type)));
            continue;
        }
        vv_label label = s->label;
        label.color.a = s->opacity;
        label.codes = s->codes;
        label.layer = s->layer;
        st = vvi_notes_label(notes, &label);
    }
    return st;
}

vv_status vvi_nrrd_note_names(const vvi_nrrd *h, const vv_field_info *info, vv_notes *notes)
{
    vv_status st = VV_OK;
    const vvi_nrrd_names *names = h->names;
    if (!names)
        return VV_OK;
    if (info->meaning == VV_MEANING_LABEL)
        return note_labels(h, notes);
    for (int c = 0; c < info->components && names->n_channels > 0 && st == VV_OK; c++) {
        static const vv_channel none;
        st = vvi_notes_channel(notes, (size_t)c < names->n_channels ? &names->channels[c] : &none);
    }
    return st;
}

/* Layers ---------------------------------------------------------------------------------------------------------- */

/* A part that is none may name a segment: which label it is, and where. */
static vv_status fail_part(const vvi_nrrd *h, int n_layers, const char *part)
{
    char digits[VVI_LABEL_DIGITS];
    for (size_t s = 0; h->names && s < h->names->n_segments; s++) {
        const vvi_nrrd_segment *segment = &h->names->segments[s];
        if (segment->there && strcasecmp(segment->label.name, part) == 0)
            return vv_fail_at(VV_E_NOT_FOUND, h->name, NULL, "'%.60s' is no part, but the label %s of its part layer%d",
                              part, vvi_label_print(digits, segment->label.value, vvi_label_is_unsigned(h->type)),
                              segment->layer);
    }
    return vv_fail_at(VV_E_NOT_FOUND, h->name, NULL, "has no part '%.60s'; its segments lie in layer0 to layer%d", part,
                      n_layers - 1);
}

/* "2 segments: liver, spleen" */
static void describe_layer(char *out, size_t room, const vvi_nrrd_names *names, int layer)
{
    enum { NAME_MOST = 70 };
    const size_t n_segments = names ? names->n_segments : 0;
    size_t n = 0, told = 0;
    for (size_t s = 0; s < n_segments; s++)
        n += names->segments[s].there && names->segments[s].layer == layer;
    size_t at = (size_t)snprintf(out, room, "%zu segment%s", n, n == 1 ? "" : "s");
    for (size_t s = 0; s < n_segments && at + NAME_MOST + 8 < room; s++) {
        const vvi_nrrd_segment *segment = &names->segments[s];
        if (segment->there && segment->layer == layer && segment->label.name[0])
            at += (size_t)snprintf(out + at, room - at, "%s%.*s", told++ ? ", " : ": ", NAME_MOST, segment->label.name);
    }
    if (told > 0 && told < n)
        snprintf(out + at, room - at, " ...");
}

/* Segments that overlap lie in layers, each a volume of labels of its own: parts of the file. */
vv_status vvi_nrrd_choose_layer(vvi_nrrd *h, int n_layers, const char *part, vv_notes *notes)
{
    char name[32], about[256];
    vv_status st = VV_OK;
    h->layer = part ? -1 : 0;
    for (int i = 0; i < n_layers && st == VV_OK; i++) {
        snprintf(name, sizeof name, "layer%d", i);
        h->layer = part && strcmp(part, name) == 0 ? i : h->layer;
        describe_layer(about, sizeof about, h->names, i);
        st = vvi_notes_part(notes, name, about, i == h->layer);
    }
    if (st == VV_OK && h->layer < 0)
        return fail_part(h, n_layers, part);
    if (st == VV_OK && !part)
        st = vvi_notes_warn(notes,
                            "its segments overlap and lie in %d layers; layer0 is read, FILE:layer1 and so on are the "
                            "others",
                            n_layers);
    return st;
}

/* Writing -----------------------------------------------------------------------------------------------------------
 */

void vvi_nrrd_add_name(vvi_text *t, const char *name)
{
    for (; *name; name++) {
        const char escape[2] = {'\\', *name == '\n' ? 'n' : *name};
        if (*name == '\n' || *name == '\\')
            vvi_text_add_n(t, escape, 2);
        else
            vvi_text_add_n(t, *name == '\r' ? " " : name, 1);
    }
    vvi_text_add(t, "\n");
}

void vvi_nrrd_add_color(vvi_text *t, const char *key, vv_color color)
{
    const double c[3] = {vv_srgb_encode(color.r), vv_srgb_encode(color.g), vv_srgb_encode(color.b)};
    vvi_text_printf(t, "%s:=", key);
    for (int i = 0; i < 3; i++)
        vvi_text_printf(t, "%s%.6g", i ? " " : "", c[i] < 0 ? 0 : c[i] > 1 ? 1 : c[i]);
    vvi_text_add(t, "\n");
}

static void add_channel(vvi_text *t, size_t i, const vv_channel *channel)
{
    char key[64], lo[32], hi[32];
    vvi_text_printf(t, "volvis channel %zu name:=", i); /* there in any case: all channels are, or none */
    vvi_nrrd_add_name(t, channel->name);
    snprintf(key, sizeof key, "volvis channel %zu color", i);
    if (channel->has_color)
        vvi_nrrd_add_color(t, key, channel->color);
    if (channel->lo < channel->hi) {
        vvi_print_number(lo, channel->lo);
        vvi_print_number(hi, channel->hi);
        vvi_text_printf(t, "volvis channel %zu window:=%s %s\n", i, lo, hi);
    }
}

void vvi_nrrd_add_channels(vvi_text *t, const vv_field_info *info, const vv_write_options *options)
{
    if (options->n_channels != (size_t)info->components)
        return;
    for (size_t i = 0; i < options->n_channels && i < VVI_NRRD_NAMES_MOST; i++)
        add_channel(t, i, &options->channels[i]);
}
