/* The volumes of VolVis itself as of 1994: a header of text, a picture of what is in the file, and slices of bytes,
 * each plain or run-length coded. Read only. */
#include "core/job.h"
#include "core/memory.h"
#include "io/layout.h"
#include "io/notes.h"
#include "io/placement.h"
#include "io/scan.h"
#include "registry.h"
#include <ctype.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define MAGIC "11111"
#define RUN_MOST 127 /* voxels that one control byte speaks of */

typedef struct slc {
    const char *name;
    bool coded;
    uint64_t offset; /* of the first slice */
    vvi_layout layout;
    bool mappable;
} slc;

static int probe(const uint8_t *head, size_t n, const char *path)
{
    return n > 6 && memcmp(head, MAGIC, 5) == 0 && isspace(head[5]) ? 2 : 0;
}

/* The header ------------------------------------------------------------------------------------------------------- */

enum field { NX, NY, NZ, BITS, DX, DY, DZ, UNIT, ORIGIN, MODIFICATION, COMPRESSION, ICON_WIDTH, ICON_HEIGHT, FIELDS };

static const struct {
    const char *name;
    double lo, hi;
    bool whole;
} fields[FIELDS] = {
    {"the width", 1, 1 << 20, true},
    {"the height", 1, 1 << 20, true},
    {"the number of slices", 1, 1 << 20, true},
    {"the bits of a voxel", 1, 64, true},
    {"the spacing along x", 0, 1e30, false},
    {"the spacing along y", 0, 1e30, false},
    {"the spacing along z", 0, 1e30, false},
    {"the unit", 0, 1000, true},
    {"the data origin", 0, 1000, true},
    {"the data modification", 0, 1000, true},
    {"the compression", 0, 1, true},
    {"the width of the icon", 0, 1 << 14, true},
    {"the height of the icon", 0, 1 << 14, true},
};

/* The next word between white space; 0 letters when there is none. */
static size_t next_word(char out[64], const uint8_t *head, size_t n, size_t *at)
{
    size_t length = 0;
    while (*at < n && isspace(head[*at]))
        ++*at;
    while (*at < n && !isspace(head[*at]) && length < 63)
        out[length++] = (char)head[(*at)++];
    out[length] = 0;
    return length;
}

static vv_status parse_field(double *out, enum field f, const char *word, const char *name)
{
    const char *end;
    if (!vvi_scan_real(out, word, &end) || *end)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "has '%.40s' where %s was expected", word, fields[f].name);
    if (!(*out >= fields[f].lo && *out <= fields[f].hi) || (fields[f].whole && *out != floor(*out)) ||
        (f >= DX && f <= DZ && *out == 0))
        return vv_fail_at(VV_E_FORMAT, name, NULL, "%s is %.40s; %s%g to %g is possible", fields[f].name, word,
                          fields[f].whole ? "" : "more than ", fields[f].lo, fields[f].hi);
    return VV_OK;
}

/* All fields and the X that ends them; the source stands behind it afterwards. */
static vv_status parse_header(double value[FIELDS], vv_source *source)
{
    size_t n, at = strlen(MAGIC);
    char word[64];
    const char *name = vvi_source_name(source);
    const uint8_t *head = vvi_source_peek(source, 4096, &n);
    vv_status st = VV_OK;
    if (!head)
        return vv_error_last()->status;
    if (probe(head, n, name) == 0)
        return vv_fail_at(VV_E_FORMAT, name, NULL, "does not begin with " MAGIC ", so it is not a .slc of VolVis");
    for (int f = 0; f < FIELDS && st == VV_OK; f++) {
        next_word(word, head, n, &at);
        st = parse_field(&value[f], (enum field)f, word, name);
    }
    while (at < n && isspace(head[at]))
        at++;
    if (st == VV_OK && (at >= n || head[at] != 'X'))
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "has no X after the size of its icon; its header is damaged");
    return st == VV_OK ? vvi_source_skip(source, at + 1) : st;
}

static vv_status note_fields(const double value[FIELDS], vv_notes *notes)
{
    char text[64];
    vv_status st = VV_OK;
    static const struct {
        enum field field;
        const char *key;
    } kept[] = {{UNIT, "unit type"}, {ORIGIN, "data origin"}, {MODIFICATION, "data modification"}};
    for (size_t i = 0; i < 3 && st == VV_OK; i++) {
        snprintf(text, sizeof text, "%.0f", value[kept[i].field]);
        st = vvi_notes_add(notes, kept[i].key, text);
    }
    snprintf(text, sizeof text, "%.0f x %.0f", value[ICON_WIDTH], value[ICON_HEIGHT]);
    return st == VV_OK ? vvi_notes_add(notes, "icon", text) : st;
}

static vv_status fill_info(vv_field_info *info, const double value[FIELDS], vv_notes *notes)
{
    static const char *const units[] = {"m", "mm", "um", "ft"};
    vv_grid *grid = &info->grid;
    for (int a = 0; a < 3; a++)
        grid->dims[a] = (int64_t)value[NX + a];
    grid->index_to_world = (vv_affine){{{value[DX], 0, 0}, {0, value[DY], 0}, {0, 0, value[DZ]}}, {0, 0, 0}};
    const bool known = value[UNIT] < 4;
    snprintf(grid->unit, sizeof grid->unit, "%s", known ? units[(int)value[UNIT]] : "units");
    return known ? VV_OK : vvi_notes_warn(notes, "its unit type is %.0f, which is not known", value[UNIT]);
}

/* The shortest code has two bytes for every run. */
static vv_status check_slices(slc *s, vv_source *source)
{
    uint64_t n;
    vv_status st = vvi_layout_count(&n, &s->layout, s->name);
    if (st != VV_OK)
        return st;
    const uint64_t slices = (uint64_t)s->layout.axis[2].n, slice = n / slices;
    const uint64_t bytes = s->coded ? slices * (2 * ((slice + RUN_MOST - 1) / RUN_MOST) + 2) : n;
    s->mappable =
        !s->coded && vvi_layout_mappable(&s->layout, s->offset) && vvi_source_mappable(source, s->offset, bytes);
    return vvi_source_expect_half(source, s->offset, bytes, "slices");
}

static vv_status understand(vv_field_info *info, slc *s, vv_source *source, vv_notes *notes)
{
    double value[FIELDS] = {0};
    vv_status st = parse_header(value, source);
    if (st != VV_OK)
        return st;
    if (value[BITS] != 8)
        return vv_fail_at(VV_E_UNSUPPORTED, s->name, NULL, "its voxels have %.0f bits; files of 8 are known",
                          value[BITS]);
    s->coded = value[COMPRESSION] == 1;
    s->offset = vvi_source_tell(source) + (uint64_t)(3 * value[ICON_WIDTH] * value[ICON_HEIGHT]);
    if ((st = fill_info(info, value, notes)) != VV_OK || (st = note_fields(value, notes)) != VV_OK)
        return st;
    const int64_t *n = info->grid.dims;
    s->layout = (vvi_layout){
        .n_axes = 3, .axis = {{n[0], VVI_ROLE_X}, {n[1], VVI_ROLE_Y}, {n[2], VVI_ROLE_Z}}, .type = VV_TYPE_U8};
    return check_slices(s, source);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    slc *s = vvi_alloc_zeroed(job, sizeof *s, VVI_MEM_MODEL);
    if (!s)
        return vv_fail_memory(sizeof *s);
    s->name = vvi_source_name(source);
    vv_status st = understand(info, s, source, notes);
    if (st == VV_OK)
        *plan_out = s;
    else
        vvi_free(s);
    return st;
}

/* Coded slices ------------------------------------------------------------------------------------------------------
 */

typedef struct reader {
    const slc *s;
    vv_source *source;
    size_t slice_voxels;
    int64_t next;    /* slice that the source stands before */
    int64_t current; /* that is decoded; -1: none */
    bool ended;      /* no slice can follow any more */
    size_t there;    /* voxels of the current slice that its code had */
    uint8_t *voxels;
    uint64_t missing;
    int64_t first_damaged;
} reader;

/* "1234 X": how many bytes of code follow. False where there is no such text. */
static bool read_count(uint64_t *out, vv_source *source)
{
    size_t n, at = 0, digits = 0;
    const uint8_t *head = vvi_source_peek(source, 64, &n);
    *out = 0;
    while (head && at < n && isspace(head[at]))
        at++;
    for (; head && at < n && isdigit(head[at]) && digits < 15; at++, digits++)
        *out = *out * 10 + (uint64_t)(head[at] - '0');
    while (head && at < n && isspace(head[at]))
        at++;
    return digits > 0 && at < n && head[at] == 'X' && vvi_source_skip(source, at + 1) == VV_OK;
}

/* One control byte and what it speaks of; false at the end of the code. */
static bool decode_run(reader *r, uint64_t *left, vv_status *st)
{
    uint8_t control, value;
    size_t got, n;
    if (*left == 0 || (*st = vvi_source_read_some(r->source, &control, 1, &got)) != VV_OK || got == 0)
        return false;
    --*left;
    n = control & RUN_MOST;
    if (n == 0)
        return false;
    const size_t room = r->slice_voxels - r->there;
    if (control & 128) {
        const size_t wanted = n < room ? n : room, take = wanted < *left ? wanted : (size_t)*left;
        *st = vvi_source_read_some(r->source, r->voxels + r->there, take, &got);
        r->there += got;
        *left -= got;
        return *st == VV_OK && got == n;
    }
    if (*left == 0 || (*st = vvi_source_read_some(r->source, &value, 1, &got)) != VV_OK || got == 0)
        return false;
    --*left;
    memset(r->voxels + r->there, value, n < room ? n : room);
    r->there += n < room ? n : room;
    return n <= room;
}

static vv_status decode_slice(reader *r)
{
    uint64_t left;
    vv_status st = VV_OK;
    r->current = r->next++;
    r->there = 0;
    if (!r->ended && read_count(&left, r->source)) {
        const uint64_t end = vvi_source_tell(r->source) + left;
        while (decode_run(r, &left, &st))
            ;
        if (st == VV_OK)
            st = vvi_source_seek(r->source, end);
    } else {
        r->ended = true;
    }
    memset(r->voxels + r->there, 0, r->slice_voxels - r->there);
    return st;
}

static vv_status skip_slice(reader *r)
{
    uint64_t bytes;
    r->next++;
    if (!r->ended && read_count(&bytes, r->source))
        return vvi_source_skip(r->source, bytes);
    r->ended = true;
    return VV_OK;
}

static vv_status go_to_slice(reader *r, int64_t slice)
{
    vv_status st = VV_OK;
    if (slice == r->current)
        return VV_OK;
    if (slice < r->next) {
        if ((st = vvi_source_seek(r->source, r->s->offset)) != VV_OK)
            return st;
        r->next = 0;
        r->ended = false;
    }
    while (r->next < slice && st == VV_OK)
        st = skip_slice(r);
    return st == VV_OK ? decode_slice(r) : st;
}

static vv_status read_elements(void *user, void *out, uint64_t first, size_t n)
{
    reader *r = user;
    for (uint8_t *to = out; n > 0;) {
        const size_t in_slice = (size_t)(first % r->slice_voxels), left = r->slice_voxels - in_slice;
        const size_t m = left < n ? left : n, end = in_slice + m;
        vv_status st = go_to_slice(r, (int64_t)(first / r->slice_voxels));
        if (st != VV_OK)
            return st;
        memcpy(to, r->voxels + in_slice, m);
        if (end > r->there) {
            r->missing += end - (r->there > in_slice ? r->there : in_slice);
            r->first_damaged = r->first_damaged < 0 ? r->current : r->first_damaged;
        }
        to += m;
        first += m;
        n -= m;
    }
    return VV_OK;
}

/* Of a part the same words each time, since parts are read one after the other, and words are told once. */
static vv_status tell_missing(const reader *r, const vv_field *field, bool whole, vv_job *job)
{
    const int64_t *n = vv_field_get_info(field)->grid.dims;
    const uint64_t all = (uint64_t)(n[0] * n[1] * n[2]);
    if (r->missing == 0)
        return VV_OK;
    if (r->missing > all / 2)
        return vv_fail_at(VV_E_FORMAT, r->s->name, NULL,
                          "its code ends too early: %" PRIu64 " of %" PRIu64
                          " voxels are there, less than half; get a complete copy",
                          all - r->missing, all);
    if (!whole)
        vvi_job_damage(job, "io", "%s: the code of slices ends too early: the voxels that are missing are 0",
                       r->s->name);
    else
        vvi_job_damage(job, "io",
                       "%s: the code of a slice ends too early: %" PRIu64 " of %" PRIu64
                       " voxels are there, the rest is 0, from slice %" PRId64 " on",
                       r->s->name, all - r->missing, all, r->first_damaged);
    return VV_OK;
}

static vv_status read_coded(vv_field **out, const vv_field_info *info, const slc *s, vv_source *source,
                            const vv_box *region, vv_job *job)
{
    reader r = {.s = s, .source = source, .current = -1, .first_damaged = -1};
    r.slice_voxels = (size_t)(info->grid.dims[0] * info->grid.dims[1]);
    vv_status st = vvi_source_seek(source, s->offset);
    if (st != VV_OK || (st = vvi_memory_plan(job, r.slice_voxels, "a slice")) != VV_OK)
        return st;
    r.voxels = vvi_alloc(job, r.slice_voxels, VVI_MEM_SCRATCH);
    if (!r.voxels)
        return vv_fail_memory(r.slice_voxels);
    const vvi_elements elements = {.user = &r, .read = read_elements};
    st = vvi_layout_read(out, info, &s->layout, &elements, 0, region, job);
    if (st == VV_OK &&
        (st = tell_missing(&r, *out, vv_field_get_info(*out)->grid.dims[2] == info->grid.dims[2], job)) != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    vvi_free(r.voxels);
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const slc *s = plan;
    *out = NULL;
    return s->coded ? read_coded(out, info, s, source, region, job)
                    : vvi_layout_read_plain(out, info, &s->layout, source, s->offset, 0, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const slc *)plan)->mappable;
}

static void free_plan(void *plan)
{
    vvi_free(plan);
}

static const char *const suffixes[] = {".slc", NULL};

const vv_format vvi_format_slc = {
    .api = VV_FORMAT_API,
    .name = "slc",
    .doc = "slices of the VolVis of 1994, plain or run-length coded",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
};
