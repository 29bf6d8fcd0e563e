/* Numbers of slices to places on a grid of channels, slices and time steps, some of which may be empty. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/slices/slices.h"
#include <stdlib.h>
#include <string.h>

static const char *const what[] = {"channels", "slices", "time steps"};

static int by_value(const void *a, const void *b)
{
    const uint64_t p = *(const uint64_t *)a, q = *(const uint64_t *)b;
    return p < q ? -1 : p > q;
}

/* The usual step of the numbers: the smallest. More than half of the places empty: they count something else. */
static vv_status count_places(vvi_slice_axis *axis, int role, vv_notes *notes)
{
    const uint64_t *v = axis->value;
    const size_t n = axis->n_values;
    uint64_t step = UINT64_MAX;
    axis->n = n;
    if (n == 1 || role == VVI_SLICE_C)
        return VV_OK;
    for (size_t i = 1; i < n; i++)
        step = v[i] - v[i - 1] < step ? v[i] - v[i - 1] : step;
    bool even = true;
    for (size_t i = 1; i < n; i++)
        even = even && (v[i] - v[0]) % step == 0;
    const uint64_t places = (v[n - 1] - v[0]) / step + 1;
    if (even && places <= 2 * (uint64_t)n) {
        axis->n = (size_t)places;
        axis->step = step;
        return VV_OK;
    }
    return vvi_notes_warn(notes,
                          "its numbers are uneven, from %llu to %llu for %zu %s: they are taken one after another",
                          (unsigned long long)v[0], (unsigned long long)v[n - 1], n, what[role]);
}

static vv_status find_axis(vvi_slice_axis *axis, int role, const vvi_slice *slice, size_t n, vv_notes *notes,
                           vv_job *job)
{
    axis->value = vvi_alloc(job, n * sizeof *axis->value, VVI_MEM_SCRATCH);
    if (!axis->value)
        return vv_fail_memory(n * sizeof *axis->value);
    for (size_t i = 0; i < n; i++)
        axis->value[i] = slice[i].number[role];
    qsort(axis->value, n, sizeof *axis->value, by_value);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || axis->value[i] != axis->value[i - 1])
            axis->value[axis->n_values++] = axis->value[i];
    return count_places(axis, role, notes);
}

/* Two files in one place: nobody can know which one is meant. */
static vv_status check_single(const vvi_slices *s, const vvi_series *series, vv_source *folder)
{
    const vvi_slice *slice = s->slice + series->first;
    for (size_t i = 1; i < series->n; i++)
        if (memcmp(slice[i].number, slice[i - 1].number, sizeof slice->number) == 0)
            return vv_fail_at(VV_E_ARGUMENT, vvi_source_name(folder), NULL,
                              "'%.80s' and '%.80s' have the same number; choose files by a pattern of their names, as "
                              "FOLDER:a_*_{z}.tif",
                              s->names.name[slice[i - 1].name], s->names.name[slice[i].name]);
    return VV_OK;
}

static vv_status check_half(const vvi_slice_axis axes[3], const vvi_series *series, vv_source *folder)
{
    const unsigned long long n[3] = {axes[0].n, axes[1].n, axes[2].n};
    if (n[0] * n[1] * n[2] <= 2 * (unsigned long long)series->n)
        return VV_OK;
    return vv_fail_at(VV_E_FORMAT, vvi_source_name(folder), NULL,
                      "'%.80s' promises %llu time steps x %llu slices x %llu channels, but only %zu of those files are "
                      "there, less than half; choose some by a pattern of their names, as FOLDER:a_t001_{z}.tif",
                      series->key, n[VVI_SLICE_T], n[VVI_SLICE_Z], n[VVI_SLICE_C], series->n);
}

vv_status vvi_slices_grid(vvi_slice_axis axes[3], const vvi_slices *s, const vvi_series *series, vv_source *folder,
                          vv_notes *notes, vv_job *job)
{
    vv_status st = check_single(s, series, folder);
    for (int role = VVI_SLICE_C; role <= VVI_SLICE_T && st == VV_OK; role++)
        st = find_axis(&axes[role], role, s->slice + series->first, series->n, notes, job);
    return st == VV_OK ? check_half(axes, series, folder) : st;
}

size_t vvi_slices_place(const vvi_slice_axis *axis, uint64_t value)
{
    if (axis->step > 0)
        return (size_t)((value - axis->value[0]) / axis->step);
    const uint64_t *at = bsearch(&value, axis->value, axis->n_values, sizeof value, by_value);
    return (size_t)(at - axis->value);
}

uint64_t vvi_slices_value(const vvi_slice_axis *axis, size_t place)
{
    return axis->step > 0 ? axis->value[0] + place * axis->step : axis->value[place];
}
