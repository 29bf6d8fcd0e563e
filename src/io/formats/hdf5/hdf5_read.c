/* Samples of HDF5 data sets: by slabs along the slowest axis, each as thick as the chunks are, so that every chunk is
 * decoded once. What cannot be decoded is filled and said, when at least half of the samples are there. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"
#include "registry.h"
#include <stdio.h>
#include <string.h>

#define SLAB_BYTES ((uint64_t)4 << 20)

/* The box of one frame as an array by itself, its axes in the order of the file; components that are data sets of their
 * own come one after another. */
typedef struct slabs {
    vvi_h5 h5;
    const vvi_h5_plan *plan;
    int64_t frame;
    hsize_t start[VVI_H5_RANK], count[VVI_H5_RANK];
    int outer;          /* the axis that slabs follow each other along */
    uint64_t row, sets; /* elements of one step along it, of one data set */
    hsize_t thick;      /* steps in a slab */
    size_t element;     /* bytes */
    uint8_t *slab;
    int component; /* of what is in the slab */
    hsize_t lo, n; /* steps in the slab, counted from start */
    uint64_t missing, read;
    hid_t data, type; /* of the component */
    vvi_h5_set set;
    vv_job *job;
} slabs;

static void close_data(slabs *s)
{
    if (s->type >= 0)
        H5Tclose(s->type);
    if (s->data >= 0)
        H5Oclose(s->data);
    s->data = s->type = -1;
}

static bool same_shape(const vvi_h5_set *a, const vvi_h5_set *b)
{
    return a->rank == b->rank && a->bytes == b->bytes && a->type == b->type && a->half == b->half &&
           a->swap == b->swap && a->convert == b->convert && a->by_chunks == b->by_chunks &&
           memcmp(a->dims, b->dims, sizeof a->dims) == 0 && memcmp(a->chunk, b->chunk, sizeof a->chunk) == 0;
}

/* The lock is held. */
static vv_status open_data(slabs *s, int component)
{
    vvi_h5_set set = {0};
    close_data(s);
    vvi_h5_path_of(set.path, s->plan, s->frame, component);
    s->data = vvi_h5_object(&s->h5, set.path);
    if (s->data < 0 || H5Iget_type(s->data) != H5I_DATASET)
        return vv_fail_at(VV_E_FORMAT, s->h5.name, set.path, "is not there");
    vv_status st = vvi_h5_describe(&set, &s->h5, s->data);
    if (st == VV_OK)
        st = vvi_h5_check(&set, &s->h5, s->data);
    if (st != VV_OK)
        return st;
    vvi_h5_adapt(s->plan, &set);
    if (!same_shape(&set, &s->plan->set))
        return vv_fail_at(VV_E_FORMAT, s->h5.name, set.path, "has other dims or another type than %s",
                          s->plan->set.path);
    s->set = set;
    s->type = vvi_h5_memory_type(&set, s->data);
    return s->type >= 0 ? VV_OK : vvi_h5_fail(&s->h5, set.path, "has a type that cannot be read");
}

/* Part of a slab, [start, start + count) of the data set, to where it belongs in the slab. */
static bool read_part(slabs *s, const hsize_t *start, const hsize_t *count, const hsize_t *slab_start,
                      const hsize_t *slab_count)
{
    const int rank = s->plan->set.rank;
    hsize_t at[VVI_H5_RANK];
    for (int a = 0; a < rank; a++)
        at[a] = start[a] - slab_start[a];
    const hid_t from = H5Dget_space(s->data), to = H5Screate_simple(rank, slab_count, NULL);
    const bool read = from >= 0 && to >= 0 &&
                      H5Sselect_hyperslab(from, H5S_SELECT_SET, start, NULL, count, NULL) >= 0 &&
                      H5Sselect_hyperslab(to, H5S_SELECT_SET, at, NULL, count, NULL) >= 0 &&
                      H5Dread(s->data, s->type, to, from, H5P_DEFAULT, s->slab) >= 0;
    if (from >= 0)
        H5Sclose(from);
    if (to >= 0)
        H5Sclose(to);
    return read;
}

static uint64_t product(const hsize_t *n, int rank)
{
    uint64_t all = 1;
    for (int a = 0; a < rank; a++)
        all *= n[a];
    return all;
}

/* The slab could not be read at once: chunk by chunk, what fails stays missing. */
static void read_by_chunks(slabs *s, const hsize_t *start, const hsize_t *count)
{
    const vvi_h5_set *set = &s->plan->set;
    hsize_t at[VVI_H5_RANK] = {0}, n[VVI_H5_RANK] = {0};
    memcpy(at, start, (size_t)set->rank * sizeof *at);
    for (;;) {
        int a = set->rank - 1;
        for (int b = 0; b < set->rank; b++) {
            const hsize_t end = start[b] + count[b], step = set->chunked ? set->chunk[b] : count[b];
            n[b] = set->chunked ? step - at[b] % step : step;
            n[b] = n[b] < end - at[b] ? n[b] : end - at[b];
        }
        if (s->h5.st != VV_OK || !read_part(s, at, n, start, count))
            s->missing += product(n, set->rank);
        for (; a >= 0; at[a] = start[a], a--)
            if ((at[a] += n[a]) < start[a] + count[a])
                break;
        if (a < 0)
            return;
    }
}

/* Numbers of a type that the library alone knows become the machine's. */
static bool convert(slabs *s, size_t n)
{
    vvi_h5_lock();
    const hid_t from = H5Dget_type(s->data);
    const bool done = H5Tconvert(from, s->type, n, s->slab, NULL, H5P_DEFAULT) >= 0;
    H5Tclose(from);
    vvi_h5_unlock();
    return done;
}

static vv_status read_own_chunks(slabs *s, const hsize_t *start, const hsize_t *count)
{
    const vvi_h5_slab slab = {&s->set, start, count, s->slab, s->set.bytes};
    const uint64_t n = product(count, s->plan->set.rank);
    vv_status st = vvi_h5_read_chunks(&slab, &s->h5, s->data, &s->missing, s->job);
    if (st == VV_OK && s->plan->set.convert && !convert(s, (size_t)n))
        st = vv_fail_at(VV_E_FORMAT, s->h5.name, s->plan->set.path, "has numbers that cannot be converted");
    return st;
}

/* By the library: contiguous samples, and filters that are its own. */
static vv_status read_by_library(slabs *s, const hsize_t *start, const hsize_t *count)
{
    vvi_h5_lock();
    if (!read_part(s, start, count, start, count) && s->h5.st == VV_OK) {
        memset(s->slab, vv_type_is_float(s->plan->set.type) ? 0xff : 0, (size_t)(s->n * s->row) * s->element);
        read_by_chunks(s, start, count);
    }
    vvi_h5_unlock();
    return s->h5.st;
}

static vv_status read_slab(slabs *s, int component, hsize_t step)
{
    hsize_t start[VVI_H5_RANK], count[VVI_H5_RANK];
    const hsize_t from = s->start[s->outer], end = from + s->count[s->outer];
    const hsize_t lo = from + step - (from + step) % s->thick;
    vv_status st = VV_OK;
    if (component != s->component || s->data < 0) {
        vvi_h5_lock();
        st = open_data(s, component);
        vvi_h5_unlock();
        if (st != VV_OK)
            return st;
    }
    memcpy(start, s->start, sizeof start);
    memcpy(count, s->count, sizeof count);
    start[s->outer] = lo > from ? lo : from;
    count[s->outer] = (lo + s->thick < end ? lo + s->thick : end) - start[s->outer];
    s->component = component;
    s->lo = start[s->outer] - from;
    s->n = count[s->outer];
    s->read += product(count, s->plan->set.rank);
    st = s->set.by_chunks ? read_own_chunks(s, start, count) : read_by_library(s, start, count);
    if (st == VV_OK && s->plan->slice_ends)
        vvi_minc_scale(s->plan, (float *)(void *)s->slab, start, count);
    if (st == VV_OK && s->plan->gaps.any)
        vvi_cf_mark_gaps(&s->plan->gaps, s->slab, (size_t)(s->n * s->row));
    return st;
}

static vv_status read_elements(void *user, void *out, uint64_t first, size_t n)
{
    slabs *s = user;
    uint8_t *to = out;
    while (n > 0) {
        const int component = (int)(first / s->sets);
        const uint64_t in_set = first % s->sets, step = in_set / s->row;
        if (s->data < 0 || component != s->component || step < s->lo || step >= s->lo + s->n) {
            const vv_status st = read_slab(s, component, step);
            if (st != VV_OK)
                return st;
        }
        const uint64_t in_slab = in_set - s->lo * s->row, left = s->n * s->row - in_slab;
        const size_t m = n < left ? n : (size_t)left;
        memcpy(to, s->slab + in_slab * s->element, m * s->element);
        to += m * s->element;
        first += m;
        n -= m;
    }
    return VV_OK;
}

/* The box ------------------------------------------------------------------------------------------------------------
 */

static vvi_role role_of(char letter)
{
    static const char letters[] = "cxyzt"; /* as vvi_role counts */
    return (vvi_role)(strchr(letters, letter) - letters);
}

static void select_box(slabs *s, vvi_layout *layout, const vv_box *box, int components)
{
    const vvi_h5_plan *plan = s->plan;
    *layout = plan->layout;
    layout->n_axes = 0;
    s->outer = 0;
    for (int a = plan->set.rank - 1; a >= 0; a--) {
        const vvi_role role = role_of(plan->roles[a]);
        const bool space = role != VVI_ROLE_COMPONENT && role != VVI_ROLE_FRAME;
        s->start[a] = role == VVI_ROLE_FRAME ? (hsize_t)s->frame : space ? (hsize_t)box->lo[role - VVI_ROLE_X] : 0;
        s->count[a] = role == VVI_ROLE_FRAME ? 1 : space ? (hsize_t)box->n[role - VVI_ROLE_X] : (hsize_t)plan->dims[a];
        if (role == VVI_ROLE_FRAME)
            continue;
        layout->axis[layout->n_axes++] = (vvi_layout_axis){(int64_t)s->count[a], role};
        s->outer = a;
    }
    if (plan->n_sets > 1)
        layout->axis[layout->n_axes++] = (vvi_layout_axis){components, VVI_ROLE_COMPONENT};
    s->sets = product(s->count, plan->set.rank);
    s->row = s->sets / s->count[s->outer];
}

/* As thick as the chunks, and not thinner than what makes reading worth while. */
static void choose_thickness(slabs *s)
{
    const uint64_t row_bytes = s->row * s->element, rows = row_bytes >= SLAB_BYTES ? 1 : SLAB_BYTES / row_bytes;
    const hsize_t chunk = s->plan->set.chunked ? s->plan->set.chunk[s->outer] : 1;
    s->thick = chunk * ((rows + chunk - 1) / chunk);
}

static vv_status tell_missing(const slabs *s, vv_job *job)
{
    const unsigned long long there = s->read - s->missing, all = s->read;
    if (s->missing == 0)
        return VV_OK;
    if (s->missing > s->read / 2)
        return vv_fail_at(VV_E_FORMAT, s->h5.name, s->plan->set.path,
                          "is damaged: %llu of %llu numbers can be read, less than half; get a complete copy", there,
                          all);
    vvi_job_damage(job, "io", "%s: %s is damaged: %llu of %llu numbers can be read, the rest is %s", s->h5.name,
                   s->plan->set.path, there, all, vv_type_is_float(s->plan->set.type) ? "NaN" : "0");
    return VV_OK;
}

static vv_status read_slabs(vv_field **out, slabs *s, const vv_field_info *info, const vv_box *box, vv_job *job)
{
    vvi_layout layout;
    uint64_t bytes;
    vv_field_info part = *info;
    part.grid = vv_grid_crop(&info->grid, box);
    select_box(s, &layout, box, info->components);
    s->element = vvi_layout_element_bytes(&layout);
    choose_thickness(s);
    const hsize_t most = s->thick < s->count[s->outer] ? s->thick : s->count[s->outer];
    const size_t room = s->element > s->plan->set.bytes ? s->element : s->plan->set.bytes;
    const uint64_t slab_bytes = most * s->row * room;
    vv_status st = vv_field_info_bytes(&bytes, &part);
    if (st == VV_OK)
        st = vvi_memory_plan(job, bytes + slab_bytes, "volume");
    if (st != VV_OK)
        return st;
    s->slab = vvi_alloc(job, (size_t)slab_bytes, VVI_MEM_SCRATCH);
    if (!s->slab)
        return vv_fail_memory((size_t)slab_bytes);
    const vvi_elements elements = {.user = s, .read = read_elements};
    st = vvi_layout_read(out, &part, &layout, &elements, s->frame, NULL, job);
    vvi_free(s->slab);
    return st;
}

void vvi_h5_adapt(const vvi_h5_plan *plan, vvi_h5_set *set)
{
    if (plan->slice_ends) { /* made floats as they are read */
        set->type = VV_TYPE_F32;
        set->convert = true;
        set->swap = false;
    }
    if (plan->gaps.turned && !plan->gaps.any)
        set->type = plan->gaps.stored;
    if (plan->gaps.any) { /* these too */
        set->type = plan->gaps.type;
        set->convert = true;
        set->swap = set->half = false;
        memcpy(set->lost, plan->gap, sizeof set->lost);
    }
    if (plan->kind == VVI_H5_BDV && set->type == VV_TYPE_I16) /* it writes so and means u16 */
        set->type = VV_TYPE_U16;
}

void vvi_h5_path_of(char out[VVI_H5_PATH], const vvi_h5_plan *plan, int64_t frame, int component)
{
    if (plan->kind == VVI_H5_IMARIS)
        vvi_imaris_path(out, plan->level, frame, component);
    else if (plan->kind == VVI_H5_BDV)
        vvi_bdv_path(out, plan->first_frame + frame, plan->setups[component], plan->level);
    else
        memcpy(out, plan->set.path, VVI_H5_PATH);
}

static vv_status read_by_slabs(vv_field **out, const vv_field_info *info, const vvi_h5_plan *plan, vv_source *source,
                               int64_t frame, const vv_box *box, vv_job *job)
{
    slabs s = {.plan = plan, .frame = frame, .job = job, .data = -1, .type = -1};
    vvi_h5_lock();
    vv_status st = vvi_h5_open(&s.h5, source, job);
    vvi_h5_unlock();
    if (st == VV_OK)
        st = read_slabs(out, &s, info, box, job);
    if (st == VV_OK && (st = tell_missing(&s, job)) != VV_OK) {
        vv_field_release(*out);
        *out = NULL;
    }
    vvi_h5_lock();
    close_data(&s);
    vvi_h5_close(&s.h5);
    vvi_h5_unlock();
    return st;
}

vv_status vvi_h5_read(vv_field **out, const vv_field_info *info, const void *user, vv_source *source, int64_t frame,
                      const vv_box *region, vv_job *job)
{
    const vvi_h5_plan *plan = user;
    const int64_t *n = info->grid.dims;
    const vv_box all = {{0, 0, 0}, {n[0], n[1], n[2]}};
    *out = NULL;
    if (plan->plain)
        return vvi_layout_read_plain(out, info, &plan->layout, source, plan->set.offset, frame, region, job);
    if (!plan->beside[0])
        return read_by_slabs(out, info, plan, source, frame, region ? region : &all, job);
    vv_source *beside;
    vv_status st = vvi_source_open_beside(&beside, source, plan->beside, job);
    if (st == VV_OK)
        st = read_by_slabs(out, info, plan, beside, frame, region ? region : &all, job);
    vvi_source_close(beside);
    return st;
}

/* The layout of the whole -------------------------------------------------------------------------------------------
 */

vv_status vvi_h5_lay_out(vv_field_info *info, vvi_h5_plan *plan, const char *name)
{
    uint64_t n;
    vvi_layout *layout = &plan->layout;
    *layout = (vvi_layout){.type = plan->set.type, .half = plan->set.half, .swap = plan->set.swap};
    for (int a = plan->set.rank - 1; a >= 0; a--) {
        const vvi_role role = role_of(plan->roles[a]);
        layout->axis[layout->n_axes++] = (vvi_layout_axis){plan->dims[a], role};
        if (role == VVI_ROLE_COMPONENT)
            info->components = (int)plan->dims[a];
        else if (role == VVI_ROLE_FRAME)
            info->n_frames = plan->dims[a];
        else
            info->grid.dims[role - VVI_ROLE_X] = plan->dims[a];
    }
    info->type = plan->set.type;
    plan->plain =
        plan->set.offset != UINT64_MAX && plan->n_sets <= 1 && !plan->set.convert && plan->kind == VVI_H5_PLAIN;
    return vvi_layout_count(&n, layout, name);
}
