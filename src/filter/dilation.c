#include "filter/dilation.h"
#include "core/cpu.h"
#include "core/memory.h"

#include <string.h>

#define CHORDS_AT_ONCE 256 /* more than an element has in one plane, and lengths of them */
#define LENGTHS_MOST 256

static vvi_dilate_most *most_of(const vvi_dilation *d)
{
    return d->kernels->most[d->bytes == 8 ? 3 : d->bytes / 2];
}

int64_t vvi_dilation_keys(const vvi_element *e, const int64_t n[3])
{
    return (n[0] + 2 * e->radius[0]) * (n[1] + 2 * e->radius[1]) * (n[2] + 2 * e->radius[2]);
}

/* Chords begin up to 2 radius[0] behind the first key of a row. */
static int64_t plane_keys(const vvi_element *e, const int64_t n[3])
{
    return (n[0] + 2 * e->radius[0]) * (n[1] + 2 * e->radius[1]) + 2 * e->radius[0];
}

vv_status vvi_dilation_init(vvi_dilation *out, const vvi_element *e, const int64_t n[3], int bytes, vv_job *job)
{
    *out = (vvi_dilation){.element = e, .bytes = bytes, .job = job};
    out->kernels = vvi_dilate_kernels_for(vvi_job_cpu(job));
    if (e->box)
        return VV_OK;
    out->table_bytes = plane_keys(e, n) * bytes + VVI_DILATE_GUARD;
    const int64_t result = (n[0] + 2 * e->radius[0]) * n[1] * n[2] * bytes + VVI_DILATE_GUARD;
    const size_t room = (size_t)(out->table_bytes * e->n_lengths + result);
    out->room = vvi_alloc_zeroed(job, room, VVI_MEM_SCRATCH);
    return out->room ? VV_OK : vv_fail_memory(room);
}

void vvi_dilation_finish(vvi_dilation *dilation)
{
    vvi_free(dilation->room);
    *dilation = (vvi_dilation){0};
}

/* Runs of `width` keys, `step` from one to the next, in place: the key at the beginning of each becomes its greatest.
 */
static void lift(char *keys, int64_t n, int64_t step, int64_t width, const vvi_dilation *d)
{
    for (int64_t done = 1; done < width;) {
        const int64_t add = 2 * done <= width ? done : width - done;
        const void *rows[2] = {keys, keys + add * step * d->bytes};
        most_of(d)(keys, rows, 2, n - add * step);
        done += add;
    }
}

static vv_status lift_box(vvi_dilated *out, const vvi_dilation *d, char *keys, const int64_t n[3])
{
    const int64_t *r = d->element->radius;
    const int64_t row = n[0] + 2 * r[0], plane = row * (n[1] + 2 * r[1]);
    const int64_t all = plane * (n[2] + 2 * r[2]), step[3] = {1, row, plane};
    vv_status st = VV_OK;
    for (int a = 0; a < 3 && st == VV_OK; a++) {
        lift(keys, all, step[a], 2 * r[a] + 1, d);
        st = vvi_job_poll(d->job);
    }
    *out = (vvi_dilated){.keys = keys, .stride = {row, plane}};
    return st;
}

/* Tables of runs of all lengths of one plane of keys; that of length 1 is the plane itself. */
static void fill_tables(const char **tables, const vvi_dilation *d, const char *plane, int64_t n)
{
    const vvi_element *e = d->element;
    tables[0] = plane;
    for (int t = 1; t < e->n_lengths; t++) {
        char *table = d->room + t * d->table_bytes;
        const void *rows[2] = {tables[t - 1], tables[t - 1] + (e->lengths[t] - e->lengths[t - 1]) * d->bytes};
        most_of(d)(table, rows, 2, n - e->lengths[t] + 1);
        tables[t] = table;
    }
}

/* The chords of an element that lie in its plane z, over one plane of the result. */
static void add_plane(char *out, const char *const *tables, const vvi_dilation *d, size_t first, size_t end,
                      int64_t row, int64_t n_rows)
{
    const vvi_element *e = d->element;
    const void *rows[CHORDS_AT_ONCE];
    int n = 0;
    rows[n++] = out;
    for (size_t c = first; c < end; c++) {
        const vvi_chord *chord = &e->chords[c];
        const int64_t at = (chord->y + e->radius[1]) * row + chord->lo + e->radius[0];
        rows[n++] = tables[chord->table] + at * d->bytes;
    }
    most_of(d)(out, rows, n, row * n_rows);
}

static vv_status run_chords(vvi_dilated *out, const vvi_dilation *d, const char *keys, const int64_t n[3])
{
    const vvi_element *e = d->element;
    const int64_t *r = e->radius;
    const int64_t row = n[0] + 2 * r[0], plane = row * (n[1] + 2 * r[1]), out_plane = row * n[1];
    char *result = d->room + e->n_lengths * d->table_bytes;
    const char *tables[LENGTHS_MOST];
    vv_status st = VV_OK;
    *out = (vvi_dilated){.keys = result, .stride = {row, out_plane}};
    for (int64_t k = 0; k < n[2]; k++) /* what is in the middle of the element */
        memcpy(result + k * out_plane * d->bytes, keys + ((k + r[2]) * plane + r[1] * row + r[0]) * d->bytes,
               (size_t)((out_plane - 2 * r[0]) * d->bytes));
    for (int64_t k = 0; k < n[2] + 2 * r[2] && st == VV_OK; k++) {
        fill_tables(tables, d, keys + k * plane * d->bytes, plane);
        for (size_t first = 0, end; first < e->n_chords; first = end) {
            const int64_t z = e->chords[first].z, to = k - r[2] - z;
            for (end = first; end < e->n_chords && e->chords[end].z == z;)
                end++;
            if (to >= 0 && to < n[2])
                add_plane(result + to * out_plane * d->bytes, tables, d, first, end, row, n[1]);
        }
        st = vvi_job_poll(d->job);
    }
    return st;
}

vv_status vvi_dilation_run(vvi_dilated *out, const vvi_dilation *dilation, void *keys, const int64_t n[3])
{
    return dilation->element->box ? lift_box(out, dilation, keys, n) : run_chords(out, dilation, keys, n);
}
