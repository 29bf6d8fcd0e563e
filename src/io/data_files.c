#include "io/data_files.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/format.h"
#include "io/numbers.h"
#include <stdlib.h>
#include <string.h>

/* One open file --------------------------------------------------------------------------------------------------- */

typedef struct reader {
    const vvi_data_files *d;
    vv_source *header;
    vv_job *job;
    size_t element_bytes;
    size_t file;                        /* which is open; SIZE_MAX: none */
    bool absent;                        /* it could not be opened */
    vv_source *raw, *decoded, *section; /* as it lies; without the coding of its name; without that of the header */
    vv_source *source;                  /* to be read: the innermost of them */
    uint64_t base;
    vvi_numbers numbers;
    uint64_t missing; /* elements, of several files */
    vvi_error_copy why;
} reader;

static size_t n_files(const vvi_data_files *d)
{
    return d->n ? d->n : 1;
}

static bool is_plain(const reader *r)
{
    return !r->d->numbers && !r->section && !r->decoded;
}

static void close_file(reader *r)
{
    vvi_numbers_end(&r->numbers);
    vvi_source_close(r->section);
    vvi_source_close(r->decoded);
    vvi_source_close(r->raw);
    r->section = r->decoded = r->raw = r->source = NULL;
    r->file = SIZE_MAX;
    r->absent = false;
}

/* Data that end the file are counted from there, which only plain files tell. */
static vv_status find_base(reader *r)
{
    const vvi_data_files *d = r->d;
    const uint64_t bytes = d->coding == VVI_CODING_NONE ? d->per_file * r->element_bytes : d->coded_bytes;
    bool exact;
    vv_status st = VV_OK;
    r->base = (uint64_t)d->skip;
    if (d->skip >= 0)
        return VV_OK;
    vvi_source_left(r->source, &exact);
    if (!exact && (st = vvi_source_spool(r->source, r->job)) != VV_OK)
        return st;
    const uint64_t all = vvi_source_tell(r->source) + vvi_source_left(r->source, &exact);
    r->base = all > bytes ? all - bytes : 0;
    if (r->base < d->begins)
        r->base = d->begins;
    return VV_OK;
}

static vv_status open_beside(reader *r, size_t index)
{
    size_t n;
    const char *name = r->d->name[index];
    vv_status st = vvi_source_open_beside(&r->raw, r->header, name, r->job);
    if (st != VV_OK)
        return st;
    r->source = r->raw;
    const vvi_coding coding = vvi_path_coding(name, &n);
    if (coding != VVI_CODING_NONE && r->d->coding == VVI_CODING_NONE &&
        (st = vvi_source_section(&r->decoded, r->raw, 0, UINT64_MAX, coding, r->job)) == VV_OK)
        r->source = r->decoded;
    return st;
}

/* Packed data in one piece: whoever reads slab after slab goes on where the last read ended. */
static bool goes_on(const reader *r)
{
    size_t n;
    const vvi_data_files *d = r->d;
    return n_files(d) == 1 && !d->numbers &&
           (d->coding != VVI_CODING_NONE ||
            (d->n && d->skip >= 0 && vvi_path_coding(d->name[0], &n) != VVI_CODING_NONE));
}

static void keep_section(reader *r)
{
    vv_source **section = r->section ? &r->section : &r->decoded;
    vvi_source_keep(r->header, *section);
    *section = NULL;
}

static vv_status open_file(reader *r, size_t index)
{
    const vvi_data_files *d = r->d;
    close_file(r);
    if (goes_on(r) && (r->section = vvi_source_kept(r->header, r->job))) {
        r->source = r->section;
        r->base = d->coding == VVI_CODING_NONE ? (uint64_t)d->skip : 0;
        r->file = index;
        return VV_OK;
    }
    r->source = r->header;
    vv_status st = d->n ? open_beside(r, index) : VV_OK;
    if (st == VV_OK)
        st = find_base(r);
    if (st == VV_OK && (d->coding != VVI_CODING_NONE || d->numbers)) {
        st = vvi_source_section(&r->section, r->source, r->base, d->coded_bytes, d->coding, r->job);
        r->source = r->section;
        r->base = 0;
    }
    if (st == VV_OK && d->numbers)
        st = vvi_numbers_begin(&r->numbers, r->source, d->layout.type, d->per_file, r->job);
    r->file = index;
    r->absent = st != VV_OK;
    return st;
}

static vv_status read_numbers(reader *r, void *out, uint64_t element, size_t n, size_t *n_got)
{
    vv_status st = VV_OK;
    if (element < r->numbers.at && (st = open_file(r, r->file)) != VV_OK)
        return st;
    st = vvi_numbers_skip(&r->numbers, element - r->numbers.at);
    return st == VV_OK ? vvi_numbers_read_some(&r->numbers, out, n, n_got) : st;
}

/* Less than n only where the file ends. */
static vv_status read_in_file(reader *r, void *out, uint64_t element, size_t n, size_t *n_got)
{
    size_t bytes = 0;
    *n_got = 0;
    if (r->d->numbers)
        return read_numbers(r, out, element, n, n_got);
    vv_status st = vvi_source_seek(r->source, r->base + element * r->element_bytes);
    if (st == VV_OK)
        st = vvi_source_read_whole(r->source, out, n * r->element_bytes, &bytes);
    *n_got = bytes / r->element_bytes;
    return st;
}

static vv_status check_end(void *user)
{
    const reader *r = user;
    return r->d->numbers || !r->source ? VV_OK : vvi_source_check_tail(r->source);
}

/* Elements --------------------------------------------------------------------------------------------------------- */

static vv_status read_only_file(void *user, void *out, uint64_t first, size_t n, size_t *n_got)
{
    reader *r = user;
    vv_status st = r->file == 0 ? VV_OK : open_file(r, 0);
    return st == VV_OK ? read_in_file(r, out, first, n, n_got) : st;
}

static uint64_t end_of_only_file(const void *user)
{
    const reader *r = user;
    if (r->d->numbers)
        return r->numbers.at;
    const uint64_t end = vvi_source_end(r->source);
    return end > r->base ? (end - r->base) / r->element_bytes : 0;
}

static bool is_about_the_file(vv_status st)
{
    return st == VV_E_READ || st == VV_E_FORMAT;
}

/* The first of several reasons is kept. */
static void keep_reason(reader *r)
{
    if (!r->why.message)
        vvi_error_take(&r->why);
}

static vv_status read_of_several(reader *r, uint8_t *out, uint64_t first, size_t n)
{
    size_t got = 0;
    vv_status st = VV_OK;
    const size_t file = (size_t)(first / r->d->per_file);
    if (file != r->file)
        st = open_file(r, file);
    if (st == VV_OK && !r->absent)
        st = read_in_file(r, out, first % r->d->per_file, n, &got);
    if (st != VV_OK && !is_about_the_file(st))
        return st;
    if (st == VV_OK && got < n && !r->absent)
        st = vv_fail_at(VV_E_FORMAT, vvi_source_name(r->source), NULL, "is cut short");
    else if (st == VV_OK && first % r->d->per_file + n == r->d->per_file && (st = check_end(r)) != VV_OK)
        return st;
    if (st != VV_OK)
        keep_reason(r);
    memset(out + got * r->element_bytes, vv_type_is_float(r->d->layout.type) ? 0xff : 0, (n - got) * r->element_bytes);
    r->missing += n - got;
    return VV_OK;
}

static vv_status read_elements(void *user, void *out, uint64_t first, size_t n)
{
    reader *r = user;
    vv_status st = VV_OK;
    for (uint8_t *to = out; n > 0 && st == VV_OK;) {
        const uint64_t left = r->d->per_file - first % r->d->per_file;
        const size_t m = left < n ? (size_t)left : n;
        st = read_of_several(r, to, first, m);
        to += m * r->element_bytes;
        first += m;
        n -= m;
    }
    return st;
}

static vv_status tell_missing(reader *r, vv_field *field)
{
    const vv_field_info *info = vv_field_get_info(field);
    const int64_t *n = info->grid.dims;
    const uint64_t all = (uint64_t)(n[0] * n[1] * n[2]) * (uint64_t)info->components;
    if (r->missing == 0)
        return VV_OK;
    if (r->missing > all / 2)
        return vvi_error_put(&r->why);
    vvi_job_damage(r->job, "io", "%s: %llu of %llu numbers are there, the rest is %s (%s)", r->d->header,
                   (unsigned long long)(all - r->missing), (unsigned long long)all,
                   vv_type_is_float(info->type) ? "NaN" : "0", r->why.message ? r->why.message : "");
    return VV_OK;
}

static reader reader_of(const vvi_data_files *d, vv_source *header, vv_job *job)
{
    return (reader){
        .d = d, .header = header, .job = job, .element_bytes = vvi_layout_element_bytes(&d->layout), .file = SIZE_MAX};
}

vv_status vvi_data_files_read(vv_field **out, const vv_field_info *info, const vvi_data_files *d, vv_source *header,
                              int64_t frame, const vv_box *region, vv_job *job)
{
    reader r = reader_of(d, header, job);
    vv_status st = VV_OK;
    *out = NULL;
    if (n_files(d) == 1) {
        vvi_elements elements = {.user = &r,
                                 .read_some = read_only_file,
                                 .end = end_of_only_file,
                                 .end_by_bytes = !d->numbers,
                                 .name = d->n ? d->name[0] : d->header,
                                 .check_end = check_end};
        if ((st = open_file(&r, 0)) == VV_OK)
            elements.source = r.source;
        if (st == VV_OK)
            st = is_plain(&r) ? vvi_layout_read_plain(out, info, &d->layout, r.source, r.base, frame, region, job)
                              : vvi_layout_read(out, info, &d->layout, &elements, frame, region, job);
    } else {
        const vvi_elements elements = {.user = &r, .read = read_elements};
        if ((st = vvi_layout_read(out, info, &d->layout, &elements, frame, region, job)) == VV_OK &&
            (st = tell_missing(&r, *out)) != VV_OK) {
            vv_field_release(*out);
            *out = NULL;
        }
    }
    if (st == VV_OK && goes_on(&r))
        keep_section(&r);
    close_file(&r);
    vvi_error_copy_free(&r.why);
    return st;
}

/* Before anything is read ------------------------------------------------------------------------------------------ */

/* Samples as numbers take a digit each and something between them. */
static uint64_t expected_bytes(const reader *r)
{
    return r->d->numbers ? 2 * r->d->per_file - 1 : r->d->per_file * r->element_bytes;
}

static vv_status check_only_file(vvi_data_files *d, reader *r)
{
    vv_status st = open_file(r, 0);
    if (st != VV_OK)
        return st;
    const uint64_t bytes = expected_bytes(r);
    if (d->numbers)
        return vvi_source_expect(r->source, r->base, bytes, "samples");
    d->mappable = vvi_layout_mappable(&d->layout, r->base) && vvi_source_mappable(r->source, r->base, bytes);
    return vvi_source_expect_half(r->source, r->base, bytes, "samples");
}

/* Half of all is enough; which pieces are missing does not matter. */
static vv_status check_several(const vvi_data_files *d, reader *r)
{
    uint64_t there = 0;
    for (size_t i = 0; i < d->n; i++) {
        bool exact;
        vv_status st = vvi_job_poll(r->job);
        if (st != VV_OK || ((st = open_file(r, i)) != VV_OK && !is_about_the_file(st)))
            return st;
        const uint64_t bytes = expected_bytes(r);
        if (st == VV_OK)
            st = vvi_source_expect(r->source, r->base, bytes, "samples");
        if (st != VV_OK)
            keep_reason(r);
        const uint64_t all = r->absent ? 0 : vvi_source_left(r->source, &exact) + vvi_source_tell(r->source);
        const uint64_t left = r->absent || all < r->base ? 0 : all - r->base;
        there += left < bytes ? left / r->element_bytes : d->per_file;
    }
    return there >= d->per_file * d->n - d->per_file * d->n / 2 ? VV_OK : vvi_error_put(&r->why);
}

vv_status vvi_data_files_check(vvi_data_files *d, vv_source *header, vv_job *job)
{
    uint64_t all;
    vv_status st = vvi_layout_count(&all, &d->layout, d->header);
    if (st != VV_OK)
        return st;
    if (all % n_files(d) != 0)
        return vv_fail_at(VV_E_FORMAT, d->header, NULL, "names %zu data files, which cannot share %llu samples evenly",
                          d->n, (unsigned long long)all);
    d->per_file = all / n_files(d);
    reader r = reader_of(d, header, job);
    st = n_files(d) == 1 ? check_only_file(d, &r) : check_several(d, &r);
    close_file(&r);
    vvi_error_copy_free(&r.why);
    return st;
}

/* Formats whose plan this is -----------------------------------------------------------------------------------------
 */

vv_status vvi_data_files_open(vv_field_info *info, void **plan_out, vv_source *source, vvi_data_files_header_fn *header,
                              vv_notes *notes, vv_job *job)
{
    vvi_keys keys = {.file = vvi_source_name(source)};
    *plan_out = NULL;
    vvi_data_files *d = vvi_alloc_zeroed(job, sizeof *d, VVI_MEM_MODEL);
    if (!d)
        return vv_fail_memory(sizeof *d);
    d->header = keys.file;
    d->limits = vvi_source_limits(source);
    d->coded_bytes = UINT64_MAX;
    vv_status st = header(info, d, &keys, source, notes, job);
    if (st == VV_OK)
        st = vvi_data_files_check(d, source, job);
    vvi_keys_finish(&keys);
    if (st == VV_OK)
        *plan_out = d;
    else
        vvi_data_files_free_plan(d);
    return st;
}

void vvi_data_files_free_plan(void *plan)
{
    vvi_data_files_finish(plan);
    vvi_free(plan);
}

vv_status vvi_data_files_read_plan(vv_field **out, const vv_field_info *info, const void *plan, vv_source *source,
                                   int64_t frame, const vv_box *region, vv_job *job)
{
    return vvi_data_files_read(out, info, plan, source, frame, region, job);
}

bool vvi_data_files_mappable(const vv_field_info *info, const void *plan)
{
    return ((const vvi_data_files *)plan)->mappable;
}
