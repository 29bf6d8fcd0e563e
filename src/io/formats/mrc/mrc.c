/* MRC and CCP4 maps: the row of the table. */
#include "io/formats/mrc/mrc.h"
#include "core/memory.h"
#include "registry.h"
#include <string.h>
#include <strings.h>

static const char *const suffixes[] = {".mrc", ".map", ".ccp4", ".rec", ".st", ".mrcs", ".ali", NULL};
static const char *const encodings[] = {"raw", NULL};

/* Old files have no mark: suffix and a header that makes sense must do. */
static int probe(const uint8_t *head, size_t n, const char *path)
{
    const size_t n_path = strlen(path);
    if (n < VVI_MRC_BYTES || (!vvi_mrc_plausible(head, false) && !vvi_mrc_plausible(head, true)))
        return n >= 212 && memcmp(head + 208, "MAP ", 4) == 0 ? 2 : 0;
    if (memcmp(head + 208, "MAP", 3) == 0)
        return 2;
    for (const char *const *s = suffixes; *s; s++)
        if (n_path > strlen(*s) && strcasecmp(path + n_path - strlen(*s), *s) == 0)
            return 1;
    return 0;
}

/* Numbers of 4 bits ------------------------------------------------------------------------------------------------ */

static size_t packed_row(const vvi_mrc *h)
{
    return ((size_t)h->n[0] + 1) / 2;
}

typedef struct packed {
    const vvi_mrc *header;
    vv_source *source;
} packed;

/* The low half of a byte first; each row begins with a byte of its own. */
static vv_status read_nibbles(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    const packed *p = user;
    const size_t row = (size_t)p->header->n[0];
    uint8_t *to = out, bytes[4096];
    *n_got = 0;
    while (n > 0) {
        const size_t x = first % row, odd = x % 2, most = 2 * sizeof bytes - 2;
        const size_t in_row = row - x < n ? row - x : n, m = in_row < most ? in_row : most;
        size_t got;
        vv_status st = vvi_source_seek(p->source, p->header->offset + first / row * packed_row(p->header) + x / 2);
        if (st != VV_OK || (st = vvi_source_read_whole(p->source, bytes, (odd + m + 1) / 2, &got)) != VV_OK)
            return st;
        const size_t there = got == 0 ? 0 : 2 * got - odd < m ? 2 * got - odd : m;
        for (size_t i = 0; i < there; i++)
            to[i] = bytes[(odd + i) / 2] >> ((odd + i) % 2 * 4) & 15;
        *n_got += there;
        if (there < m)
            return VV_OK;
        to += m;
        first += m;
        n -= m;
    }
    return VV_OK;
}

static vv_status check_end(void *user)
{
    return vvi_source_check_end(((packed *)user)->source);
}

/* The row of the table --------------------------------------------------------------------------------------------- */

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    vvi_mrc h = {0};
    uint64_t n;
    *plan_out = NULL;
    vv_status st = vvi_mrc_read_header(&h, source, notes);
    if (st != VV_OK || (st = vvi_mrc_describe(info, &h, vvi_source_name(source), notes)) != VV_OK ||
        (st = vvi_layout_count(&n, &h.layout, vvi_source_name(source))) != VV_OK)
        return st;
    n = h.nibbles ? n / (uint64_t)h.n[0] * packed_row(&h) : n * vvi_layout_element_bytes(&h.layout);
    if (h.nibbles && (st = vvi_source_spool(source, job)) != VV_OK) /* a byte may be read twice */
        return st;
    if ((st = vvi_source_expect_half(source, h.offset, n, "samples")) != VV_OK)
        return st;
    h.mappable = !h.nibbles && vvi_layout_mappable(&h.layout, h.offset) && vvi_source_mappable(source, h.offset, n);
    vvi_mrc *plan = vvi_alloc(job, sizeof *plan, VVI_MEM_MODEL);
    if (!plan)
        return vv_fail_memory(sizeof *plan);
    *plan = h;
    *plan_out = plan;
    return VV_OK;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const vvi_mrc *h = plan;
    packed p = {h, source};
    const vvi_elements nibbles = {
        .user = &p, .read_some = read_nibbles, .name = vvi_source_name(source), .check_end = check_end};
    if (h->nibbles)
        return vvi_layout_read(out, info, &h->layout, &nibbles, frame, region, job);
    return vvi_layout_read_plain(out, info, &h->layout, source, h->offset, frame, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_mrc *)plan)->mappable;
}

static void free_plan(void *plan)
{
    vvi_free(plan);
}

const vv_format vvi_format_mrc = {
    .api = VV_FORMAT_API,
    .name = "mrc",
    .doc = "MRC and CCP4 maps of electron microscopy, IMOD's too",
    .suffixes = suffixes,
    .encodings = encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
    .write = vvi_mrc_write,
    .types = 1u << VV_TYPE_U8 | 1u << VV_TYPE_I8 | 1u << VV_TYPE_U16 | 1u << VV_TYPE_I16,
};
