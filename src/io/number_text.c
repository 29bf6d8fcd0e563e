#include "io/number_text.h"
#include "core/job.h"
#include "core/memory.h"

struct vvi_number_text {
    vv_source *source, *section;
    uint64_t begin, end;
    vv_job *job;
    vvi_numbers numbers;
};

static vv_status begin(vvi_number_text *t, vv_type type)
{
    vvi_numbers_end(&t->numbers);
    vvi_source_close(t->section);
    t->section = NULL;
    const uint64_t n = t->end > t->begin ? t->end - t->begin : 0;
    vv_status st = vvi_source_section(&t->section, t->source, t->begin, t->end == UINT64_MAX ? UINT64_MAX : n,
                                      VVI_CODING_NONE, t->job);
    if (st == VV_OK && (st = vvi_numbers_begin(&t->numbers, t->section, type, 0, t->job)) == VV_OK &&
        t->end != UINT64_MAX)
        t->numbers.job = NULL;
    return st;
}

vv_status vvi_number_text_open(vvi_number_text **out, vv_source *source, uint64_t begins, uint64_t end, vv_type type,
                               vv_job *job)
{
    *out = NULL;
    vvi_number_text *t = vvi_alloc_zeroed(job, sizeof *t, VVI_MEM_SCRATCH);
    if (!t)
        return vv_fail_memory(sizeof *t);
    t->source = source;
    t->begin = begins;
    t->end = end;
    t->job = job;
    vv_status st = begin(t, type);
    if (st != VV_OK)
        vvi_number_text_close(t);
    else
        *out = t;
    return st;
}

void vvi_number_text_close(vvi_number_text *t)
{
    if (!t)
        return;
    vvi_numbers_end(&t->numbers);
    vvi_source_close(t->section);
    vvi_free(t);
}

uint64_t vvi_number_text_tell(const vvi_number_text *t)
{
    return t->begin + vvi_source_tell(t->section) - (t->numbers.text_end - t->numbers.text_at);
}

vv_status vvi_number_text_skip(vvi_number_text *t, uint64_t n, uint64_t *n_got)
{
    uint8_t thrown[2048];
    const size_t room = sizeof thrown / vv_type_bytes(t->numbers.type);
    vv_status st = VV_OK;
    for (*n_got = 0; st == VV_OK && *n_got < n;) {
        size_t got, m = n - *n_got < room ? (size_t)(n - *n_got) : room;
        if ((st = vvi_numbers_read_some(&t->numbers, thrown, m, &got)) == VV_OK)
            st = vvi_job_poll(t->job);
        *n_got += got;
        if (got < m)
            break;
    }
    return st;
}

vv_status vvi_number_text_read(vvi_number_text *t, void *out, uint64_t index, size_t n, size_t *n_got)
{
    uint64_t passed;
    vv_status st = VV_OK;
    *n_got = 0;
    if (index < t->numbers.at)
        st = begin(t, t->numbers.type);
    if (st == VV_OK)
        st = vvi_number_text_skip(t, index - t->numbers.at, &passed);
    return st == VV_OK ? vvi_numbers_read_some(&t->numbers, out, n, n_got) : st;
}
