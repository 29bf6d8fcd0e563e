/* Elements of a DICOM file, one after the other. Every length is held against the bytes that are left before it is
 * used, and sequences nest to a fixed depth. */
#include "core/job.h"
#include "core/memory.h"
#include "grid/field.h"
#include "io/formats/dicom/dicom.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>

#define PIECE_BYTES ((size_t)8192)

vv_status vvi_dicom_stream_init(vvi_dicom_stream *s, vv_source *source, vv_job *job)
{
    bool exact;
    *s = (vvi_dicom_stream){.source = source, .job = job};
    s->size = vvi_source_left(source, &exact) + vvi_source_tell(source);
    s->piece = vvi_alloc(job, PIECE_BYTES, VVI_MEM_SCRATCH);
    return s->piece ? VV_OK : vv_fail_memory(PIECE_BYTES);
}

void vvi_dicom_stream_finish(vvi_dicom_stream *s)
{
    vvi_free(s->piece);
    s->piece = NULL;
}

/* A section reads no further than its end, where the source itself would fetch a quarter of a megabyte: of thousands of
 * files only the headers are wanted. */
static vv_status fetch(vvi_dicom_stream *s, uint64_t at)
{
    vv_source *section;
    vv_status st = vvi_source_section(&section, s->source, at, PIECE_BYTES, VVI_CODING_NONE, s->job);
    if (st != VV_OK)
        return st;
    s->piece_at = at;
    st = vvi_source_read_some(section, s->piece, PIECE_BYTES, &s->n_piece);
    vvi_source_close(section);
    return st;
}

vv_status vvi_dicom_bytes(vvi_dicom_stream *s, uint64_t at, void *out, size_t n, size_t *n_got)
{
    *n_got = 0;
    while (*n_got < n) {
        const uint64_t from = at + *n_got;
        if (from >= s->size)
            return VV_OK;
        if (from < s->piece_at || from - s->piece_at >= s->n_piece) {
            vv_status st = fetch(s, from);
            if (st != VV_OK || s->n_piece == 0)
                return st;
        }
        const size_t skip = (size_t)(from - s->piece_at), there = s->n_piece - skip;
        const size_t m = there < n - *n_got ? there : n - *n_got;
        memcpy((uint8_t *)out + *n_got, s->piece + skip, m);
        *n_got += m;
    }
    return VV_OK;
}

static uint32_t number(const uint8_t *b, size_t n, bool big)
{
    uint32_t out = 0;
    for (size_t i = 0; i < n; i++)
        out |= (uint32_t)b[i] << 8 * (big ? n - 1 - i : i);
    return out;
}

static bool is_letter(uint8_t c)
{
    return c >= 'A' && c <= 'Z';
}

/* Representations whose length has 32 bits. */
static bool is_long(uint16_t vr)
{
    static const char names[] = "OBOWOFODOLOVSQUCURUTUNSVUV";
    for (size_t i = 0; i + 1 < sizeof names; i += 2)
        if (vr == VVI_DICOM_VR(names[i], names[i + 1]))
            return true;
    return false;
}

static vv_status fail_end(const vvi_dicom_stream *s, uint64_t at)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                      "ends inside an element at byte %llu; the file is cut short, get a complete copy",
                      (unsigned long long)at);
}

static vv_status fail_vr(const vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                      "element (%04x,%04x) at byte %llu has no value representation; its header is damaged",
                      (unsigned)(e->tag >> 16), (unsigned)(e->tag & 0xffff), (unsigned long long)e->at - 8);
}

/* The pixel data may be cut short: what is there is read. */
static vv_status check_length(const vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    const bool pixels =
        e->tag == VVI_DICOM_PIXEL_DATA || e->tag == VVI_DICOM_PIXEL_F32 || e->tag == VVI_DICOM_PIXEL_F64;
    if (e->length == VVI_DICOM_UNDEFINED || pixels || e->length <= s->size - e->at)
        return VV_OK;
    return vv_fail_at(
        VV_E_FORMAT, vvi_source_name(s->source), NULL,
        "element (%04x,%04x) at byte %llu should have %lu bytes, but %llu are left; the file is cut short or "
        "its header damaged",
        (unsigned)(e->tag >> 16), (unsigned)(e->tag & 0xffff), (unsigned long long)e->at, (unsigned long)e->length,
        (unsigned long long)(s->size - e->at));
}

vv_status vvi_dicom_next(vvi_dicom_stream *s, vvi_dicom_element *e)
{
    uint8_t b[12];
    size_t n;
    vv_status st = vvi_dicom_bytes(s, s->at, b, sizeof b, &n);
    if (st != VV_OK)
        return st;
    if (n < 8)
        return fail_end(s, s->at);
    *e = (vvi_dicom_element){.tag = number(b, 2, s->big) << 16 | number(b + 2, 2, s->big), .at = s->at + 8};
    if (s->implicit || e->tag >> 16 == 0xfffe) {
        e->length = number(b + 4, 4, s->big);
    } else {
        if (!is_letter(b[4]) || !is_letter(b[5]))
            return fail_vr(s, e);
        e->vr = VVI_DICOM_VR(b[4], b[5]);
        e->length = number(b + 6, 2, s->big);
        if (is_long(e->vr)) {
            if (n < 12)
                return fail_end(s, s->at);
            e->length = number(b + 8, 4, s->big);
            e->at += 4;
        }
    }
    s->at = e->at;
    if (++s->n_elements % 1024 == 0 && (st = vvi_job_poll(s->job)) != VV_OK)
        return st;
    return check_length(s, e);
}

/* The walk ------------------------------------------------------------------------------------------------------- */

typedef struct walk {
    vvi_dicom_stream *s;
    vvi_dicom_visit *visit;
    void *user;
    uint64_t item; /* where the one begins in which it is */
    vvi_dicom_element pixels;
} walk;

/* Where things are said that are wanted of a frame; others in the groups (images referred to, say) have elements of the
 * same tags that mean something else. */
static bool is_frame_sequence(uint32_t tag)
{
    static const uint32_t tags[] = {0x00180000 | 0x9114, 0x00189117,          0x00189118, 0x00209111, 0x00209113,
                                    0x00209116,          0x00280000 | 0x9110, 0x00289145, 0x0062000a};
    for (size_t i = 0; i < sizeof tags / sizeof *tags; i++)
        if (tag == tags[i])
            return true;
    return false;
}

/* Sequences whose items are walked, and what they are; counts: items are numbered. */
typedef struct way {
    vvi_dicom_where from;
    uint32_t tag;
    vvi_dicom_where to;
    bool counts;
} way;

static const way ways[] = {
    {VVI_DICOM_TOP, VVI_DICOM_SHARED_GROUPS, VVI_DICOM_SHARED, false},
    {VVI_DICOM_TOP, VVI_DICOM_FRAME_GROUPS, VVI_DICOM_FRAME, true},
    {VVI_DICOM_TOP, VVI_DICOM_SEGMENTS, VVI_DICOM_SEGMENT, true},
    {VVI_DICOM_SEGMENT, 0x00620003, VVI_DICOM_SEGMENT_CATEGORY, false},
    {VVI_DICOM_SEGMENT, 0x0062000f, VVI_DICOM_SEGMENT_TYPE, false},
    {VVI_DICOM_SEGMENT_TYPE, 0x00620011, VVI_DICOM_SEGMENT_TYPE_MODIFIER, false},
    {VVI_DICOM_SEGMENT, 0x00082218, VVI_DICOM_SEGMENT_REGION, false},
    {VVI_DICOM_SEGMENT_REGION, 0x00082220, VVI_DICOM_SEGMENT_REGION_MODIFIER, false},
    {VVI_DICOM_TOP, 0x30060010, VVI_DICOM_REFERENCE, false},       /* frames of reference, */
    {VVI_DICOM_REFERENCE, 0x30060012, VVI_DICOM_REFERENCE, false}, /* their studies, */
    {VVI_DICOM_REFERENCE, 0x30060014, VVI_DICOM_REFERENCE, false}, /* and the series of these */
    {VVI_DICOM_TOP, VVI_DICOM_ROIS, VVI_DICOM_ROI, true},
    {VVI_DICOM_TOP, VVI_DICOM_ROI_OBSERVATIONS, VVI_DICOM_OBSERVATION, true},
    {VVI_DICOM_OBSERVATION, 0x30060086, VVI_DICOM_OBSERVATION_CODE, false},
    {VVI_DICOM_TOP, VVI_DICOM_ROI_CONTOURS, VVI_DICOM_IN_ROI_CONTOURS, true},
    {VVI_DICOM_IN_ROI_CONTOURS, 0x30060040, VVI_DICOM_CONTOUR, false},
};

static const way *way_of(const vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where)
{
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++)
        if (ways[i].from == where && ways[i].tag == e->tag)
            return ways[i].to == VVI_DICOM_IN_ROI_CONTOURS && !s->contours ? NULL : &ways[i];
    return NULL;
}

static vvi_dicom_where inside(const vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where)
{
    const way *next = way_of(s, e, where);
    if (next)
        return next->to;
    return (where == VVI_DICOM_SHARED || where == VVI_DICOM_FRAME) && is_frame_sequence(e->tag) ? where
                                                                                                : VVI_DICOM_ELSEWHERE;
}

static vv_status walk_elements(walk *w, uint64_t end, int depth, vvi_dicom_where where, int64_t frame);

/* Packed bytes inside a sequence (an icon): pieces, not elements. */
static bool holds_bytes(const vvi_dicom_element *e)
{
    return e->tag == VVI_DICOM_PIXEL_DATA || e->vr == VVI_DICOM_VR('O', 'B') || e->vr == VVI_DICOM_VR('O', 'W');
}

static vv_status walk_item(walk *w, const vvi_dicom_element *item, int depth, vvi_dicom_where where, int64_t frame,
                           bool bytes)
{
    vvi_dicom_stream *s = w->s;
    if (bytes || (where == VVI_DICOM_ELSEWHERE && item->length != VVI_DICOM_UNDEFINED)) {
        if (item->length == VVI_DICOM_UNDEFINED)
            return fail_end(s, item->at);
        s->at = item->at + item->length;
        return VV_OK;
    }
    const uint64_t end = item->length == VVI_DICOM_UNDEFINED ? UINT64_MAX : item->at + item->length;
    const uint64_t outer = w->item;
    w->item = item->at;
    const vv_status st = walk_elements(w, end, depth, where, frame);
    w->item = outer;
    return st;
}

static vv_status walk_items(walk *w, const vvi_dicom_element *e, int depth, vvi_dicom_where where, int64_t frame,
                            bool counts)
{
    vvi_dicom_stream *s = w->s;
    const uint64_t end = e->length == VVI_DICOM_UNDEFINED ? UINT64_MAX : e->at + e->length;
    vv_status st = VV_OK;
    const uint64_t deepest = vvi_source_limits(s->source)->nesting;
    if ((uint64_t)depth >= deepest)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                          "has sequences nested more than %llu deep at byte %llu; its header is damaged, or --limit "
                          "nesting=N allows more",
                          (unsigned long long)deepest, (unsigned long long)e->at);
    for (int64_t i = 0; s->at < end && st == VV_OK; i++) {
        vvi_dicom_element item;
        if ((st = vvi_dicom_next(s, &item)) != VV_OK || item.tag == VVI_DICOM_SEQUENCE_END)
            return st;
        if (item.tag != VVI_DICOM_ITEM)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(s->source), NULL,
                              "found element (%04x,%04x) at byte %llu where an item of a sequence should begin; its "
                              "header is damaged",
                              (unsigned)(item.tag >> 16), (unsigned)(item.tag & 0xffff), (unsigned long long)item.at);
        st = walk_item(w, &item, depth + 1, where, counts ? i : frame, holds_bytes(e));
    }
    return st;
}

/* Values of an unknown representation with an undefined length are sequences that are written implicitly (CP-246). */
static vv_status walk_sequence(walk *w, const vvi_dicom_element *e, int depth, vvi_dicom_where where, int64_t frame)
{
    vvi_dicom_stream *s = w->s;
    const bool implicit = s->implicit, big = s->big;
    if (e->vr == VVI_DICOM_VR('U', 'N')) {
        s->implicit = true;
        s->big = false;
    }
    const way *next = way_of(s, e, where);
    const vv_status st = walk_items(w, e, depth, inside(s, e, where), frame, next && next->counts);
    s->implicit = implicit;
    s->big = big;
    return st;
}

static bool is_pixels(uint32_t tag)
{
    return tag == VVI_DICOM_PIXEL_DATA || tag == VVI_DICOM_PIXEL_F32 || tag == VVI_DICOM_PIXEL_F64;
}

static vv_status walk_elements(walk *w, uint64_t end, int depth, vvi_dicom_where where, int64_t frame)
{
    vvi_dicom_stream *s = w->s;
    vv_status st = VV_OK;
    const bool top = depth == 0;
    while (s->at < end && st == VV_OK && !(top && s->at + 8 > s->size)) {
        vvi_dicom_element e;
        if ((st = vvi_dicom_next(s, &e)) != VV_OK || e.tag == VVI_DICOM_ITEM_END)
            return st;
        if (top && is_pixels(e.tag)) {
            w->pixels = e;
            return VV_OK;
        }
        e.item = w->item;
        const bool wanted = inside(s, &e, where) != VVI_DICOM_ELSEWHERE;
        if (e.length == VVI_DICOM_UNDEFINED || wanted) {
            st = walk_sequence(w, &e, depth, where, frame);
        } else {
            if (where != VVI_DICOM_ELSEWHERE)
                st = w->visit(w->user, s, &e, where, frame);
            s->at = e.at + e.length;
        }
    }
    return st;
}

vv_status vvi_dicom_walk(vvi_dicom_stream *s, vvi_dicom_element *pixels_out, vvi_dicom_visit *visit, void *user)
{
    walk w = {.s = s, .visit = visit, .user = user};
    const vv_status st = walk_elements(&w, UINT64_MAX, 0, VVI_DICOM_TOP, 0);
    *pixels_out = w.pixels;
    return st;
}

/* Values --------------------------------------------------------------------------------------------------------- */

vv_status vvi_dicom_value(vvi_dicom_stream *s, const vvi_dicom_element *e, char *out, size_t most)
{
    size_t n = e->length < most - 1 ? e->length : most - 1, skip = 0;
    vv_status st = vvi_dicom_bytes(s, e->at, out, n, &n);
    out[n] = 0;
    n = strlen(out);
    while (n > 0 && out[n - 1] == ' ')
        out[--n] = 0;
    while (out[skip] == ' ')
        skip++;
    memmove(out, out + skip, n - skip + 1);
    vvi_text_clean(out);
    return st;
}

static double binary(const uint8_t *b, uint16_t vr, bool big)
{
    uint8_t v[8];
    memcpy(v, b, 8);
    const bool swap = vvi_order_swapped(big);
    double d;
    float f;
    switch (vr) {
    case VVI_DICOM_VR('F', 'D'):
        if (swap)
            vvi_swap_bytes(v, 8, 1);
        memcpy(&d, v, 8);
        return d;
    case VVI_DICOM_VR('F', 'L'):
        if (swap)
            vvi_swap_bytes(v, 4, 1);
        memcpy(&f, v, 4);
        return f;
    case VVI_DICOM_VR('S', 'S'):
        return (int16_t)number(b, 2, big);
    case VVI_DICOM_VR('S', 'L'):
        return (int32_t)number(b, 4, big);
    case VVI_DICOM_VR('U', 'L'):
        return number(b, 4, big);
    default:
        return number(b, 2, big);
    }
}

static size_t binary_bytes(uint16_t vr)
{
    switch (vr) {
    case VVI_DICOM_VR('F', 'D'):
        return 8;
    case VVI_DICOM_VR('F', 'L'):
    case VVI_DICOM_VR('S', 'L'):
    case VVI_DICOM_VR('U', 'L'):
        return 4;
    case VVI_DICOM_VR('S', 'S'):
    case VVI_DICOM_VR('U', 'S'):
        return 2;
    default:
        return 0;
    }
}

/* The next of a list of numbers; false: it is none. */
static bool next_number(double *out, const char **text)
{
    const char *end;
    const bool is_number = vvi_scan_real(out, *text, &end) && isfinite(*out);
    *text = strchr(*text, '\\');
    *text = *text ? *text + 1 : NULL;
    return is_number;
}

static void text_numbers(const char *text, double *out, size_t n)
{
    for (size_t i = 0; i < n && text; i++) {
        double value;
        if (next_number(&value, &text))
            out[i] = value;
    }
}

vv_status vvi_dicom_list(double **out, size_t *n_out, vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    const size_t n_text = (size_t)e->length + 1;
    size_t n = 1;
    *out = NULL;
    *n_out = 0;
    if (e->length == 0)
        return VV_OK;
    char *text = vvi_alloc(s->job, n_text, VVI_MEM_SCRATCH);
    if (!text)
        return vv_fail_memory(n_text);
    vv_status st = vvi_dicom_value(s, e, text, n_text);
    for (const char *at = text; st == VV_OK && (at = strchr(at, '\\')) != NULL; at++)
        n++;
    *out = st == VV_OK ? vvi_alloc(s->job, n * sizeof **out, VVI_MEM_MODEL) : NULL;
    if (st == VV_OK && !*out)
        st = vv_fail_memory(n * sizeof **out);
    const char *at = text;
    for (size_t i = 0; st == VV_OK && i < n; i++)
        if (!at || !next_number(&(*out)[i], &at))
            (*out)[i] = NAN;
    *n_out = st == VV_OK ? n : 0;
    vvi_free(text);
    return st;
}

vv_status vvi_dicom_numbers(vvi_dicom_stream *s, const vvi_dicom_element *e, uint16_t vr, double *out, size_t n)
{
    char text[512];
    size_t got;
    if (e->vr && e->vr != VVI_DICOM_VR('U', 'N') && (binary_bytes(e->vr) > 0 || binary_bytes(vr) > 0))
        vr = e->vr;
    const size_t bytes = binary_bytes(vr);
    if (bytes == 0) {
        vv_status st = vvi_dicom_value(s, e, text, sizeof text);
        if (st == VV_OK)
            text_numbers(text, out, n);
        return st;
    }
    for (size_t i = 0; i < n && (i + 1) * bytes <= e->length; i++) {
        uint8_t b[8] = {0};
        vv_status st = vvi_dicom_bytes(s, e->at + i * bytes, b, bytes, &got);
        if (st != VV_OK || got < bytes)
            return st;
        const double value = binary(b, vr, s->big);
        if (isfinite(value))
            out[i] = value;
    }
    return VV_OK;
}
