/* What ImageJ keeps beside its description, in tags 50838 and 50839: texts of slices, ranges of display, colours.
 * https://imagej.net/ij/developer/source/ij/io/TiffDecoder.java.html (getMetaData), TiffEncoder.java.html. A header of
 * a mark, then a kind and a number of items for each kind; then the items, whose lengths are the other tag's. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/tiff/tiff.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/image.h>

#define ITEMS_MOST 65536
#define KINDS_MOST 16
#define INFO_LINES_MOST 200
#define LUT_BYTES 768 /* red, green and blue of 256 values */

typedef struct extras {
    uint8_t *data;
    uint64_t *place; /* where the header, each item and their end lie in it */
    size_t n_places; /* of header and items */
    bool swapped;    /* numbers have their lowest byte first */
    vv_job *job;
} extras;

typedef struct item {
    const uint8_t *data;
    size_t n;
} item;

static uint32_t word(const extras *x, const uint8_t *at)
{
    uint32_t v = 0;
    for (int i = 0; i < 4; i++)
        v = v << 8 | at[x->swapped ? 3 - i : i];
    return v;
}

/* How many items of a kind there are, and the number of the first; none where the header lies about them. */
static size_t find_kind(size_t *first, const extras *x, const char *kind)
{
    const uint32_t name = (uint32_t)(uint8_t)kind[0] << 24 | (uint32_t)(uint8_t)kind[1] << 16 |
                          (uint32_t)(uint8_t)kind[2] << 8 | (uint8_t)kind[3];
    size_t next = 1;
    for (size_t k = 4; k + 8 <= (size_t)x->place[1] && k < 8 * KINDS_MOST; k += 8) {
        const uint32_t n = word(x, x->data + k + 4);
        if (n > x->n_places - next)
            return 0;
        *first = next;
        if (word(x, x->data + k) == name)
            return n;
        next += n;
    }
    return 0;
}

static item item_of(const extras *x, size_t number)
{
    return (item){x->data + x->place[number], (size_t)(x->place[number + 1] - x->place[number])};
}

static size_t put_utf8(char *out, uint32_t c)
{
    if (c < 0x80) {
        out[0] = (char)c;
        return 1;
    }
    if (c < 0x800) {
        out[0] = (char)(0xc0 | c >> 6);
        out[1] = (char)(0x80 | (c & 63));
        return 2;
    }
    out[0] = (char)(0xe0 | c >> 12);
    out[1] = (char)(0x80 | (c >> 6 & 63));
    out[2] = (char)(0x80 | (c & 63));
    return 3;
}

/* UTF-16 to UTF-8, as much as fits; pairs of surrogates become '?'. */
static void to_text(char *out, size_t room, const extras *x, item t)
{
    size_t n = 0;
    for (size_t i = 0; i + 2 <= t.n && n + 4 <= room; i += 2) {
        const uint32_t c =
            x->swapped ? (uint32_t)t.data[i + 1] << 8 | t.data[i] : (uint32_t)t.data[i] << 8 | t.data[i + 1];
        n += put_utf8(out + n, c >= 0xd800 && c < 0xe000 ? '?' : c);
    }
    out[n] = 0;
}

static double real(const extras *x, const uint8_t *at)
{
    uint64_t v = 0;
    double d;
    for (int i = 0; i < 8; i++)
        v = v << 8 | at[x->swapped ? 7 - i : i];
    memcpy(&d, &v, 8);
    return d;
}

/* Channels --------------------------------------------------------------------------------------------------------- */

/* A ramp from black is a colour; grey and tables of several colours are none. */
static void take_color(vv_channel *channel, const uint8_t *lut)
{
    const uint8_t last[3] = {lut[255], lut[511], lut[767]};
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 256; i++)
            if (abs(lut[256 * c + i] - last[c] * i / 255) > 2)
                return;
    if (last[0] == last[1] && last[1] == last[2])
        return;
    channel->has_color = true;
    channel->color = (vv_color){vv_srgb_decode(last[0] / 255.0), vv_srgb_decode(last[1] / 255.0),
                                vv_srgb_decode(last[2] / 255.0), 1};
}

/* Texts of slices are names of channels where all planes of a channel have the same. */
static bool labels_name_channels(const extras *x, size_t first, size_t n, size_t channels)
{
    if (channels < 2 || n < channels || n % channels != 0)
        return false;
    for (size_t i = channels; i < n; i++) {
        const item a = item_of(x, first + i), b = item_of(x, first + i - channels);
        if (a.n != b.n || memcmp(a.data, b.data, a.n) != 0)
            return false;
    }
    return true;
}

static void take_range(vv_channel *channel, const extras *x, const uint8_t *at, const vv_field_info *info)
{
    const double lo = real(x, at), hi = real(x, at + 8);
    if (!isfinite(lo) || !isfinite(hi) || lo >= hi)
        return;
    channel->lo = lo * info->value_scale + info->value_offset;
    channel->hi = hi * info->value_scale + info->value_offset;
}

static vv_status tell_channels(const extras *x, const vv_field_info *info, size_t channels, vv_notes *notes)
{
    size_t label = 0, lut = 0, range = 0;
    vv_status st = VV_OK;
    const size_t n_luts = find_kind(&lut, x, "luts"), n_ranges = find_kind(&range, x, "rang");
    const item ranges = n_ranges == 1 ? item_of(x, range) : (item){0};
    const size_t n_labels = find_kind(&label, x, "labl");
    const bool named = labels_name_channels(x, label, n_labels, channels);
    bool known = named;
    vv_channel *all = vvi_alloc_zeroed(x->job, channels * sizeof *all, VVI_MEM_SCRATCH);
    if (!all)
        return vv_fail_memory(channels * sizeof *all);
    for (size_t c = 0; c < channels; c++) {
        const item t = c < n_luts ? item_of(x, lut + c) : (item){0};
        if (named)
            to_text(all[c].name, sizeof all[c].name, x, item_of(x, label + c));
        vvi_text_clean(all[c].name);
        if (t.n == LUT_BYTES)
            take_color(&all[c], t.data);
        if (ranges.n >= 16 * (c + 1))
            take_range(&all[c], x, ranges.data + 16 * c, info);
        known = known || all[c].has_color || all[c].lo != all[c].hi;
    }
    for (size_t c = 0; c < channels && known && st == VV_OK; c++)
        st = vvi_notes_channel(notes, &all[c]);
    vvi_free(all);
    return st;
}

/* Texts ------------------------------------------------------------------------------------------------------------ */

/* The first texts of slices, for people. */
static vv_status tell_labels(const extras *x, size_t first, size_t n, vv_notes *notes)
{
    char text[512] = "", one[128];
    size_t at = 0, i = 0;
    for (; i < n && at + sizeof one + 8 < sizeof text; i++) {
        to_text(one, sizeof one, x, item_of(x, first + i));
        vvi_text_clean(one);
        at += (size_t)snprintf(text + at, sizeof text - at, "%s%s", i > 0 ? "; " : "", one);
    }
    snprintf(text + at, sizeof text - at, "%s", i < n ? "; ..." : "");
    return vvi_notes_add(notes, "slice labels", text);
}

/* "key = value" or "key: value" a line, as readers of microscopes' files leave them there. */
static vv_status tell_info(const extras *x, item t, vv_notes *notes)
{
    const size_t room = t.n / 2 * 3 + 4;
    vv_status st = VV_OK;
    char *text = vvi_alloc(x->job, room, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory(room);
    to_text(text, room, x, t);
    char *line = text;
    for (int i = 0; *line && i < INFO_LINES_MOST && st == VV_OK; i++) {
        const size_t n = strcspn(line, "\r\n"), after = strspn(line + n, "\r\n");
        line[n] = after > 0 ? 0 : line[n];
        char *value = strstr(line, " = ");
        value = value ? value : strstr(line, ": ");
        if (value && value > line) {
            *value = 0;
            value += value[1] == '=' ? 3 : 2;
            vvi_text_clean(line);
            vvi_text_clean(value);
            st = vvi_notes_add(notes, line, value);
        }
        line += n + after;
    }
    vvi_free(text);
    return st;
}

/* ------------------------------------------------------------------------------------------------------------------ */

/* Lengths to places; false where they are more than the data has. */
static bool place_items(extras *x, size_t n, uint64_t n_data)
{
    uint64_t at = 0;
    for (size_t i = 0; i < n; i++) {
        const uint64_t length = x->place[i];
        x->place[i] = at;
        if (length > n_data - at)
            return false;
        at += length;
    }
    x->place[n] = at;
    return x->place[1] >= 12;
}

/* Both tags, where they fit together; what is cut off is no reason to refuse the samples. */
static vv_status load(extras *x, const vvi_tiff_reader *r, const vvi_tiff_page *p)
{
    char *data = NULL;
    const size_t n = (size_t)p->imagej_lengths.n;
    if (n < 2 || n > ITEMS_MOST || p->imagej_data.n < 12 || p->imagej_data.n > vvi_job_limits(r->job)->header_bytes)
        return VV_OK;
    x->place = vvi_alloc(r->job, (n + 1) * sizeof *x->place, VVI_MEM_SCRATCH);
    if (!x->place)
        return vv_fail_memory((n + 1) * sizeof *x->place);
    vv_status st = vvi_tiff_numbers(x->place, r, &p->imagej_lengths, 0, n);
    if (st != VV_OK || !place_items(x, n, p->imagej_data.n))
        return st == VV_E_FORMAT ? VV_OK : st;
    if ((st = vvi_tiff_text(&data, r, &p->imagej_data, p->imagej_data.n)) != VV_OK || !data)
        return st;
    x->data = (uint8_t *)data;
    x->swapped = memcmp(data, "JIJI", 4) == 0;
    x->n_places = x->swapped || memcmp(data, "IJIJ", 4) == 0 ? n : 0;
    return VV_OK;
}

vv_status vvi_tiff_imagej_extras(const vv_field_info *info, const vvi_tiff *tiff, const vvi_tiff_page *page,
                                 const vvi_tiff_reader *r, vv_notes *notes)
{
    extras x = {.job = r->job};
    size_t first = 0;
    vv_status st = load(&x, r, page);
    if (st == VV_OK && x.n_places > 0) {
        const size_t n_labels = find_kind(&first, &x, "labl");
        if (n_labels > 0 && !labels_name_channels(&x, first, n_labels, (size_t)tiff->channels))
            st = tell_labels(&x, first, n_labels, notes);
        if (st == VV_OK && page->samples == 1)
            st = tell_channels(&x, info, (size_t)tiff->channels, notes);
        if (st == VV_OK && find_kind(&first, &x, "info") == 1)
            st = tell_info(&x, item_of(&x, first), notes);
    }
    vvi_free(x.place);
    vvi_free(x.data);
    return st;
}
