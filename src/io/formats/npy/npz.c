/* NumPy's .npz: a ZIP archive of .npy files, stored (savez) or deflated (savez_compressed), with 64-bit sizes too. Its
 * arrays are parts. ZIP: https://pkware.cachefly.net/webdocs/casestudies/APPNOTE.TXT */
#include "core/job.h"
#include "core/memory.h"
#include "core/text.h"
#include "grid/field.h"
#include "io/formats/npy/npy.h"
#include "registry.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

enum { ENTRIES_MOST = 1024, TAIL = 22 + 65535, NAME = 200 };

typedef struct entry {
    char name[NAME];
    uint64_t at, packed_bytes; /* of its local header; of what follows that */
    uint32_t crc;              /* of its .npy file */
    int method;                /* 0: stored, 8: deflated */
} entry;

typedef struct npz {
    vvi_npy array;
    char name[NAME];
    uint64_t at, packed_bytes; /* of its .npy file */
    uint32_t crc;
    bool deflated, mappable;
    bool *checked; /* the samples that are mapped are what the CRC-32 says */
} npz;

static uint64_t number(const uint8_t *at, int n)
{
    uint64_t v = 0;
    for (int i = n - 1; i >= 0; i--)
        v = v << 8 | at[i];
    return v;
}

static int probe(const uint8_t *head, size_t n, const char *path)
{
    const size_t n_path = strlen(path);
    if (n < 30 || (memcmp(head, "PK\3\4", 4) != 0 && memcmp(head, "PK\5\6", 4) != 0))
        return 0;
    const size_t n_name = (size_t)number(head + 26, 2);
    if (30 + n_name <= n && n_name > 4 && memcmp(head + 30 + n_name - 4, ".npy", 4) == 0)
        return 2;
    return n_path > 4 && strcasecmp(path + n_path - 4, ".npz") == 0 ? 1 : 0;
}

/* The directory stands at the end. */
static vv_status find_directory(uint64_t *at, uint64_t *bytes, vv_source *source, vv_job *job)
{
    const char *name = vvi_source_name(source);
    bool exact;
    uint64_t total;
    vvi_source_left(source, &exact);
    vv_status st = vvi_source_spool(source, job);
    if (st != VV_OK)
        return st;
    total = vvi_source_tell(source) + vvi_source_left(source, &exact);
    const size_t n = total < TAIL ? (size_t)total : TAIL;
    uint8_t *tail = vvi_alloc(job, n + 1, VVI_MEM_SCRATCH);
    if (!tail)
        return vv_fail_memory(n);
    if ((st = vvi_source_seek(source, total - n)) == VV_OK)
        st = vvi_source_read(source, tail, n, "the end of the archive");
    size_t i = n < 22 ? 0 : n - 22 + 1;
    while (st == VV_OK && i > 0 && memcmp(tail + i - 1, "PK\5\6", 4) != 0)
        i--;
    if (st == VV_OK && i == 0)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "has no directory at its end: it is cut short or not a ZIP archive");
    if (st == VV_OK) {
        const uint8_t *end = tail + i - 1;
        *bytes = number(end + 12, 4);
        *at = number(end + 16, 4);
        uint8_t big[56];
        if (i > 20 && memcmp(end - 20, "PK\6\7", 4) == 0 && vvi_source_seek(source, number(end - 12, 8)) == VV_OK &&
            vvi_source_read(source, big, sizeof big, "the 64-bit end of the archive") == VV_OK &&
            memcmp(big, "PK\6\6", 4) == 0) {
            *bytes = number(big + 40, 8);
            *at = number(big + 48, 8);
        }
    }
    vvi_free(tail);
    if (st == VV_OK && (*at > total || *bytes > total - *at || *bytes > vvi_job_limits(job)->header_bytes))
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "its directory does not lie in the file");
    return st;
}

/* Sizes that do not fit in 32 bits stand in a field of their own, those that are needed one after the other. */
static void take_big(entry *e, bool whole_is_big, const uint8_t *extra, size_t n)
{
    while (n >= 4 && 4 + number(extra + 2, 2) <= n) {
        const size_t m = (size_t)number(extra + 2, 2);
        size_t at = 4 + (whole_is_big ? 8 : 0);
        if (number(extra, 2) == 1 && e->packed_bytes == UINT32_MAX && at + 8 <= 4 + m) {
            e->packed_bytes = number(extra + at, 8);
            at += 8;
        }
        if (number(extra, 2) == 1 && e->at == UINT32_MAX && at + 8 <= 4 + m)
            e->at = number(extra + at, 8);
        extra += 4 + m;
        n -= 4 + m;
    }
}

/* One entry of the directory; bytes of it, 0 at its end or where it is damaged. */
static size_t take_entry(entry *out, const uint8_t *d, size_t n)
{
    if (n < 46 || memcmp(d, "PK\1\2", 4) != 0)
        return 0;
    const size_t n_name = (size_t)number(d + 28, 2), n_extra = (size_t)number(d + 30, 2);
    const size_t all = 46 + n_name + n_extra + (size_t)number(d + 32, 2);
    if (all > n)
        return 0;
    *out = (entry){.method = (int)number(d + 10, 2),
                   .crc = (uint32_t)number(d + 16, 4),
                   .packed_bytes = number(d + 20, 4),
                   .at = number(d + 42, 4)};
    if (n_name > 4 && n_name - 4 < NAME && memcmp(d + 46 + n_name - 4, ".npy", 4) == 0 && !(d[8] & 1)) {
        memcpy(out->name, d + 46, n_name - 4);
        vvi_text_clean(out->name);
    }
    take_big(out, number(d + 24, 4) == UINT32_MAX, d + 46 + n_name, n_extra);
    return all;
}

/* The array's own header; *z says where its file lies. */
static vv_status look(npz *z, const entry *e, vv_source *source, vv_job *job)
{
    uint8_t local[30];
    vv_source *file;
    *z = (npz){.packed_bytes = e->packed_bytes, .crc = e->crc, .deflated = e->method == 8};
    memcpy(z->name, e->name, NAME);
    if (e->method != 0 && e->method != 8)
        return vv_fail_at(VV_E_UNSUPPORTED, vvi_source_name(source), NULL,
                          "its array '%s' is packed by method %d; stored and deflated ones are read", e->name,
                          e->method);
    vv_status st = vvi_source_seek(source, e->at);
    if (st == VV_OK)
        st = vvi_source_read(source, local, sizeof local, "an array");
    if (st == VV_OK && memcmp(local, "PK\3\4", 4) != 0)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(source), NULL, "its array '%s' is not where its directory says",
                        e->name);
    if (st != VV_OK)
        return st;
    z->at = e->at + sizeof local + number(local + 26, 2) + number(local + 28, 2);
    st = vvi_source_section(&file, source, z->at, z->packed_bytes, z->deflated ? VVI_CODING_DEFLATE : VVI_CODING_NONE,
                            job);
    if (st != VV_OK)
        return st;
    st = vvi_npy_parse(&z->array, file, job);
    vvi_source_close(file);
    return st;
}

/* The part "name" or "name,axes". */
static bool is_asked(const char *part, const char *name, const char **axes)
{
    const size_t n = strlen(name);
    if (!part || strncmp(part, name, n) != 0 || (part[n] && part[n] != ','))
        return false;
    *axes = part[n] ? part + n + 1 : NULL;
    return true;
}

static const char *type_word(const vvi_npy *p)
{
    return p->layout.half ? "f16" : vv_type_name(p->layout.type);
}

/* "6 x 5 x 4 u8": x first, as everywhere. */
static vv_status note(vv_notes *notes, const entry *e, const vvi_npy *p, bool chosen)
{
    char about[160];
    int n = 0;
    about[0] = 0;
    for (int i = 0; i < p->n_shape; i++)
        n += snprintf(about + n, sizeof about - (size_t)n, "%s%" PRId64, i ? " x " : "", p->shape[p->n_shape - 1 - i]);
    snprintf(about + n, sizeof about - (size_t)n, " %s", type_word(p));
    return vvi_notes_part(notes, e->name, about, chosen);
}

/* Whether others could be meant: of volumes the other volumes, else all; a matrix or a list beside a volume is none. */
static bool has_rival(const npz *all, size_t n, size_t best)
{
    const int least = all[best].array.n_shape >= 3 ? 3 : 1;
    size_t rivals = 0;
    for (size_t i = 0; i < n; i++)
        rivals += all[i].array.n_shape >= least;
    return rivals > 1;
}

/* The array that is asked for, else the first of three axes or more, else the first; all that can be read are parts. */
static vv_status choose(npz *out, const char **axes, const entry *list, size_t n, const char *part, vv_source *source,
                        vv_notes *notes, vv_job *job)
{
    const char *name = vvi_source_name(source);
    vv_status st = VV_OK;
    size_t best = SIZE_MAX;
    npz *all = vvi_alloc_zeroed(job, (n + 1) * sizeof *all, VVI_MEM_SCRATCH);
    if (!all)
        return vv_fail_memory(n * sizeof *all);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        const bool asked = is_asked(part, list[i].name, axes);
        if (look(&all[i], &list[i], source, job) != VV_OK) {
            all[i].array.n_shape = 0;
            st = asked ? vv_error_last()->status : vvi_job_poll(job);
            continue;
        }
        const bool better = best == SIZE_MAX || (all[best].array.n_shape < 3 && all[i].array.n_shape >= 3);
        if (part ? asked : better)
            best = i;
    }
    if (st == VV_OK && best == SIZE_MAX && !part)
        st = vv_fail_at(VV_E_FORMAT, name, NULL, "has no array of numbers in it");
    for (size_t i = 0; i < n && st == VV_OK; i++)
        if (all[i].array.n_shape > 0)
            st = note(notes, &list[i], &all[i].array, i == best);
    if (st == VV_OK && best == SIZE_MAX)
        st = vvi_notes_fail_part(notes, VV_E_NOT_FOUND, name, "array", part);
    if (st == VV_OK && !part && has_rival(all, n, best))
        st = vvi_notes_warn_unnamed(notes, name, "arrays");
    if (st == VV_OK)
        *out = all[best];
    vvi_free(all);
    return st;
}

static vv_status read_list(entry *list, size_t *n_out, vv_source *source, vv_job *job)
{
    uint64_t at = 0, bytes = 0;
    entry e;
    *n_out = 0;
    vv_status st = find_directory(&at, &bytes, source, job);
    if (st != VV_OK)
        return st;
    uint8_t *directory = vvi_alloc(job, (size_t)bytes + 1, VVI_MEM_SCRATCH);
    if (!directory)
        return vv_fail_memory((size_t)bytes);
    if ((st = vvi_source_seek(source, at)) == VV_OK)
        st = vvi_source_read(source, directory, (size_t)bytes, "the directory");
    for (size_t i = 0, n; st == VV_OK && *n_out < ENTRIES_MOST; i += n) {
        if ((n = take_entry(&e, directory + i, (size_t)bytes - i)) == 0)
            break;
        if (e.name[0])
            list[(*n_out)++] = e;
    }
    vvi_free(directory);
    return st;
}

static vv_status understand(vv_field_info *info, npz *z, vv_source *source, const vv_read_options *options,
                            vv_notes *notes, vv_job *job)
{
    const char *axes = NULL, *name = vvi_source_name(source);
    size_t n;
    uint64_t n_samples;
    entry *list = vvi_alloc(job, ENTRIES_MOST * sizeof *list, VVI_MEM_SCRATCH);
    if (!list)
        return vv_fail_memory(ENTRIES_MOST * sizeof *list);
    vv_status st = read_list(list, &n, source, job);
    if (st == VV_OK)
        st = choose(z, &axes, list, n, options->part, source, notes, job);
    vvi_free(list);
    if (st != VV_OK || (st = vvi_npy_place(info, &z->array, axes, name, NULL)) != VV_OK)
        return st;
    snprintf(info->name, sizeof info->name, "%.63s", z->name);
    if ((st = vvi_layout_count(&n_samples, &z->array.layout, name)) != VV_OK || z->deflated)
        return st;
    const uint64_t at = z->at + z->array.offset, bytes = n_samples * (uint64_t)z->array.bytes;
    z->mappable = vvi_layout_mappable(&z->array.layout, at) && vvi_source_mappable(source, at, bytes);
    return vvi_source_expect_half(source, at, bytes, "samples");
}

static void free_plan(void *plan)
{
    npz *z = plan;
    vvi_free(z->checked);
    vvi_free(z);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    *plan_out = NULL;
    npz *z = vvi_alloc_zeroed(job, sizeof *z, VVI_MEM_MODEL);
    if (!z)
        return vv_fail_memory(sizeof *z);
    vv_status st = understand(info, z, source, options, notes, job);
    if (st == VV_OK && !(z->checked = vvi_alloc_zeroed(job, sizeof *z->checked, VVI_MEM_MODEL)))
        st = vv_fail_memory(sizeof *z->checked);
    if (st == VV_OK)
        *plan_out = z;
    else
        free_plan(z);
    return st;
}

/* The array's .npy file, whose CRC-32 is looked at by whoever reads all of it. */
static vv_status open_array(vv_source **out, const npz *z, vv_source *source, vv_job *job)
{
    const vv_status st = vvi_source_section(out, source, z->at, z->packed_bytes,
                                            z->deflated ? VVI_CODING_DEFLATE : VVI_CODING_NONE, job);
    if (st == VV_OK)
        vvi_source_guard(*out, z->crc);
    return st;
}

/* Slabs and frames that are read in order unpack nothing twice, and the last one sees the sum of all. */
static vv_status read_in_passing(vv_field **out, const vv_field_info *info, const npz *z, vv_source *source,
                                 int64_t frame, const vv_box *region, vv_job *job)
{
    const vvi_npy *p = &z->array;
    vv_source *file = vvi_source_kept(source, job);
    vv_status st = file ? VV_OK : open_array(&file, z, source, job);
    if (st != VV_OK)
        return st;
    st = vvi_layout_read_plain(out, info, &p->layout, file, p->offset, frame, region, job);
    if (st == VV_E_FORMAT)
        st = vv_fail_in(st, "array '%s'", z->name);
    if (st == VV_OK)
        vvi_source_keep(source, file);
    else
        vvi_source_close(file);
    return st;
}

/* What is mapped is read for its CRC-32 once. */
static vv_status check_stored(const npz *z, vv_source *source, vv_job *job)
{
    enum { PIECE = 1 << 20 };
    vv_source *file;
    uint8_t *piece = vvi_alloc(job, PIECE, VVI_MEM_SCRATCH);
    vv_status st = piece ? open_array(&file, z, source, job) : vv_fail_memory(PIECE);
    if (st != VV_OK) {
        vvi_free(piece);
        return st;
    }
    for (uint64_t left = z->packed_bytes; left > 0 && st == VV_OK;) {
        const size_t n = left < PIECE ? (size_t)left : PIECE;
        st = vvi_source_read(file, piece, n, "an array");
        left -= n;
        if (st == VV_OK)
            st = vvi_job_poll(job);
    }
    if (st == VV_OK)
        st = vvi_source_check_end(file);
    if (st == VV_E_FORMAT)
        st = vv_fail_in(st, "array '%s'", z->name);
    vvi_source_close(file);
    vvi_free(piece);
    *z->checked = st == VV_OK;
    return st;
}

static vv_status read_samples(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    const npz *z = plan;
    *out = NULL;
    if (!z->mappable || region)
        return read_in_passing(out, info, z, source, frame, region, job);
    const vv_status st = *z->checked ? VV_OK : check_stored(z, source, job);
    if (st != VV_OK)
        return st;
    return vvi_layout_read_plain(out, info, &z->array.layout, source, z->at + z->array.offset, frame, region, job);
}

static bool mappable(const vv_field_info *info, const void *plan)
{
    return ((const npz *)plan)->mappable;
}

static const char *const suffixes[] = {".npz", NULL};

const vv_format vvi_format_npz = {
    .api = VV_FORMAT_API,
    .name = "npz",
    .doc = "NumPy archives of arrays, stored or deflated: FILE:ARRAY, or FILE:ARRAY,czyx with its axis order",
    .suffixes = suffixes,
    .encodings = vvi_npz_encodings,
    .probe = probe,
    .read_header = read_header,
    .free_plan = free_plan,
    .read = read_samples,
    .mappable = mappable,
    .write = vvi_npz_write,
};
