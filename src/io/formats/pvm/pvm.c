/* PVM volumes (PVM, PVM2, PVM3), plain or packed as a DDS stream: https://paulbourke.net/dataformats/pvm. A stream is
 * unpacked as soon as the file is opened, because what it holds can be told in no other way. Read only. */
#include "io/formats/pvm/pvm.h"
#include "core/memory.h"
#include "io/layout.h"
#include "io/notes.h"
#include "io/sample_writer.h"
#include "io/scan.h"
#include "registry.h"
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define TEXT_MOST 1024

typedef struct pvm {
    uint8_t *unpacked; /* and a source on it; NULL: the file is plain */
    vv_source *inner;
    uint64_t offset;
    vvi_layout layout;
    bool mappable;
} pvm;

static int probe(const uint8_t *head, size_t n, const char *path)
{
    const size_t n_path = strlen(path);
    if (vvi_pvm_dds_version(head, n)) /* pictures are packed so as well */
        return n_path > 4 && strcmp(path + n_path - 4, ".pvm") == 0 ? 2 : 1;
    if (n < 6 || memcmp(head, "PVM", 3) != 0)
        return 0;
    return head[3] == '\n' || ((head[3] == '2' || head[3] == '3') && head[4] == '\n') ? 2 : 0;
}

static void free_plan(void *plan)
{
    pvm *p = plan;
    vvi_source_close(p->inner);
    vvi_free(p->unpacked);
    vvi_free(p);
}

/* The header ---------------------------------------------------------------------------------------------------------
 */

static vv_status next_line(const char **line, vv_source *source, const char *what)
{
    bool end;
    vv_status st = vvi_source_line(source, line, TEXT_MOST, &end);
    return st == VV_OK && end ? vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "ends before %s", what) : st;
}

static vv_status read_version(int *version, vv_source *source)
{
    const char *line;
    vv_status st = next_line(&line, source, "its first line");
    if (st != VV_OK)
        return st;
    *version = strcmp(line, "PVM") == 0 ? 1 : strcmp(line, "PVM2") == 0 ? 2 : strcmp(line, "PVM3") == 0 ? 3 : 0;
    return *version ? VV_OK
                    : vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                                 "holds no volume: PVM, PVM2 or PVM3 should stand in its first line");
}

static vv_status read_dims(int64_t dims[3], vv_source *source)
{
    const char *line, *at;
    vv_status st = next_line(&line, source, "its sizes");
    if (st != VV_OK)
        return st;
    at = line;
    for (int a = 0; a < 3; a++)
        if (!vvi_scan_int(&dims[a], at, &at) || dims[a] < 1 || (uint64_t)dims[a] > vvi_source_limits(source)->dim)
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                              "'%.40s' should be the samples along x, y and z, 1 to %" PRIu64
                              " each (--limit dim=N allows more)",
                              line, vvi_source_limits(source)->dim);
    return VV_OK;
}

static vv_status read_spacing(vv_grid *grid, vv_source *source)
{
    double step[3];
    const char *line, *at;
    vv_status st = next_line(&line, source, "its spacing");
    if (st != VV_OK)
        return st;
    at = line;
    for (int a = 0; a < 3; a++)
        if (!vvi_scan_real(&step[a], at, &at) || !isfinite(step[a]) || !(step[a] > 0))
            return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                              "'%.40s' should be the spacing along x, y and z, more than 0 each", line);
    grid->index_to_world = (vv_affine){{{step[0], 0, 0}, {0, step[1], 0}, {0, 0, step[2]}}, {0, 0, 0}};
    snprintf(grid->unit, sizeof grid->unit, "units");
    return VV_OK;
}

/* Bytes of a sample: two are a number, three and four a colour. */
static vv_status read_components(vv_field_info *info, vv_source *source)
{
    int64_t n = 0;
    const char *line, *end;
    vv_status st = next_line(&line, source, "the bytes of a sample");
    if (st != VV_OK)
        return st;
    if (!vvi_scan_int(&n, line, &end) || n < 1 || n > 4)
        return vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL,
                          "'%.40s' should be the bytes of a sample: 1, 2, or 3 and 4 for colours", line);
    info->type = n == 2 ? VV_TYPE_U16 : VV_TYPE_U8;
    info->components = n > 2 ? (int)n : 1;
    info->meaning = n == 3 ? VV_MEANING_RGB : n == 4 ? VV_MEANING_RGBA : VV_MEANING_SCALAR;
    return VV_OK;
}

/* Four texts behind the samples of PVM3. */
static vv_status read_texts(vv_source *source, uint64_t at, vv_notes *notes)
{
    static const char *const keys[] = {"description", "courtesy", "parameters", "comment"};
    char text[4 * TEXT_MOST + 1];
    size_t n, from = 0;
    vv_status st = vvi_source_seek(source, at);
    if (st != VV_OK || (st = vvi_source_read_whole(source, text, sizeof text - 1, &n)) != VV_OK)
        return st;
    text[n] = 0;
    for (int i = 0; i < 4 && from < n && st == VV_OK; i++) {
        if (text[from])
            st = vvi_notes_add(notes, keys[i], text + from);
        from += strlen(text + from) + 1;
    }
    return st;
}

static vv_status find_samples(pvm *p, vv_source *source, int version, vv_notes *notes)
{
    uint64_t n;
    bool exact;
    size_t there;
    vv_status st = vvi_layout_count(&n, &p->layout, vvi_source_name(source));
    if (st != VV_OK)
        return st;
    const uint64_t bytes = n * vv_type_bytes(p->layout.type), left = vvi_source_left(source, &exact);
    const uint8_t *head = vvi_source_peek(source, 1, &there);
    p->offset = vvi_source_tell(source);
    if (version < 3 && exact && left == bytes + 1 && head && there == 1 && head[0] == 0)
        p->offset++; /* some writers end the header as C ends a string */
    if ((st = vvi_source_expect_half(source, p->offset, bytes, "samples")) != VV_OK)
        return st;
    p->mappable = vvi_layout_mappable(&p->layout, p->offset) && vvi_source_mappable(source, p->offset, bytes);
    return version == 3 && exact && left > bytes ? read_texts(source, p->offset + bytes, notes) : VV_OK;
}

static vv_status understand(vv_field_info *info, pvm *p, vv_source *source, vv_notes *notes)
{
    int version;
    int64_t *dims = info->grid.dims;
    vv_status st = read_version(&version, source);
    if (st != VV_OK || (st = read_dims(dims, source)) != VV_OK ||
        (version > 1 && (st = read_spacing(&info->grid, source)) != VV_OK) ||
        (st = read_components(info, source)) != VV_OK)
        return st;
    p->layout = (vvi_layout){.n_axes = 4,
                             .axis = {{info->components, VVI_ROLE_COMPONENT},
                                      {dims[0], VVI_ROLE_X},
                                      {dims[1], VVI_ROLE_Y},
                                      {dims[2], VVI_ROLE_Z}},
                             .type = info->type,
                             .swap = info->type == VV_TYPE_U16 && vvi_order_swapped(true)};
    return find_samples(p, source, version, notes);
}

static vv_status unpack(pvm *p, vv_source *source, vv_job *job)
{
    size_t n;
    const uint8_t *head = vvi_source_peek(source, 8, &n);
    if (!head)
        return vv_error_last()->status;
    const int version = vvi_pvm_dds_version(head, n);
    if (!version)
        return VV_OK;
    vv_status st = vvi_pvm_decode_dds(&p->unpacked, &n, source, version, job);
    return st == VV_OK ? vvi_source_memory(&p->inner, p->unpacked, n, vvi_source_name(source), job) : st;
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    pvm *p = vvi_alloc_zeroed(job, sizeof *p, VVI_MEM_MODEL);
    if (!p)
        return vv_fail_memory(sizeof *p);
    vv_status st = unpack(p, source, job);
    if (st == VV_OK)
        st = understand(info, p, p->inner ? p->inner : source, notes);
    if (st != VV_OK) {
        free_plan(p);
        return st;
    }
    *plan_out = p;
    return VV_OK;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const pvm *p = plan;
    return vvi_layout_read_plain(out, info, &p->layout, p->inner ? p->inner : source, p->offset, frame, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const pvm *)plan)->mappable;
}

static const char *const suffixes[] = {".pvm", NULL};

const vv_format vvi_format_pvm = {
    .api = VV_FORMAT_API,
    .name = "pvm",
    .doc = "PVM, PVM2 and PVM3, plain or packed (DDS)",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
};
