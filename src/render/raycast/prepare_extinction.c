/* What clouds, solids and meshes of a frame take of the light, in cells a few voxels wide. */
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "render/raycast/prepare_light.h"
#include <math.h>
#include <string.h>

/* Optical depth of a voxel beyond which it only makes the cells around it darker than they are. */
#define MOST_DEPTH 3
/* Samples of a cell on each axis, at most. */
enum { MOST_SAMPLES = 4 };

/* Values to extinction ----------------------------------------------------------------------------------------------
 */

/* One volume as it takes light. */
typedef struct taker {
    const vvi_raycast_volume *volume;
    vvi_lattice_hold plain; /* of cubic volumes samples instead of coefficients, of bricks an array */
    const vvi_lattice *lattice;
    double to_stored, to_stored_shift; /* from the lattice's numbers to those that the classifier takes */
    float most;                        /* per world length */
    float *by_entry;                   /* NULL: a solid, or by value and gradient */
    float entry_scale, entry_shift, last_place;
    vv_affine from_first; /* indices of the first volume, or of the grid's own, to these */
    bool aligned;         /* that is nothing */
} taker;

static float extinction_of(const vvi_raycast_volume *v, int64_t row, float most)
{
    const float *rows = v->ray.classifier.color;
    return fminf((float)((double)rows[4 * row + 3] / v->ray.step), most);
}

/* Entries that are split stand for the mean of theirs. */
static vv_status open_table(taker *t, vv_job *job)
{
    const vvi_raycast_volume *v = t->volume;
    const vvi_classifier *c = &v->ray.classifier;
    const size_t n = (size_t)c->last_place + 1;
    t->last_place = c->last_place;
    t->entry_scale = (float)(t->to_stored * (double)c->entry_scale);
    t->entry_shift = (float)(t->to_stored_shift * (double)c->entry_scale + (double)c->entry_shift);
    t->by_entry = vvi_alloc(job, n * sizeof *t->by_entry, VVI_MEM_SCRATCH);
    if (!t->by_entry)
        return vv_fail_memory(n * sizeof *t->by_entry);
    for (size_t i = 0; i < n; i++) {
        const bool split = c->alpha[i] >= VVI_ENTRY_SPLIT;
        const int64_t first = split ? (int64_t)c->alpha[i] - VVI_ENTRY_SPLIT : (int64_t)i;
        const int64_t parts = split ? (int64_t)c->color[4 * i] : 1;
        double sum = 0;
        for (int64_t k = 0; k < parts; k++)
            sum += (double)extinction_of(v, first + k, t->most);
        t->by_entry[i] = (float)(sum / (double)parts);
    }
    return VV_OK;
}

static vv_status open_taker(taker *t, const vvi_raycast_volume *v, const vvi_light_frame *frame, vv_job *job)
{
    vv_status st = VV_OK;
    const vvi_lattice_hold *h = &v->hold;
    vv_affine to_index;
    *t = (taker){.volume = v, .lattice = &h->lattice, .to_stored = 1};
    t->most = (float)(MOST_DEPTH / vvi_actor_voxel(v->actor));
    if (v->ray.sampler.cubic || h->lattice.fetch == VVI_FETCH_BRICKS) {
        if ((st = vvi_lattice_open(&t->plain, v->actor->field, v->actor->component, job)) != VV_OK)
            return st;
        t->lattice = &t->plain.lattice;
        t->to_stored = t->plain.value_scale / h->value_scale;
        t->to_stored_shift = (t->plain.value_offset - h->value_offset) / h->value_scale;
    }
    t->aligned = frame->first == v;
    if (!vv_affine_invert(&to_index, v->actor->index_to_world))
        return vv_fail(VV_E_ARGUMENT, "volumes.%s.place: flattens the volume; give it a scale other than 0",
                       v->actor->id);
    t->from_first = vv_affine_compose(to_index, frame->to_world);
    return v->solid || v->ray.classifier.kind == VVI_CLASSIFY_PLANE ? VV_OK : open_table(t, job);
}

static void close_takers(taker *t, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        vvi_free(t[i].by_entry);
        vvi_lattice_close(&t[i].plain);
    }
}

static double number_at(const taker *t, int64_t at)
{
    switch (t->lattice->sample_type) {
    case VVI_SAMPLE_U8:
        return ((const uint8_t *)t->lattice->data)[at];
    case VVI_SAMPLE_U16:
        return ((const uint16_t *)t->lattice->data)[at];
    case VVI_SAMPLE_I16:
        return ((const int16_t *)t->lattice->data)[at];
    default:
        return (double)((const float *)t->lattice->data)[at];
    }
}

/* Length of the gradient as the kernels count it, by central differences. */
static double gradient_at(const taker *t, int64_t at)
{
    const vvi_lattice *g = t->lattice;
    const int64_t stride[3] = {1, g->row, g->slice};
    const int64_t place[3] = {at % g->slice % g->row, at % g->slice / g->row, at / g->slice};
    const vvi_sampler *s = &t->volume->ray.sampler;
    double d[3], length = 0;
    for (int a = 0; a < 3; a++) {
        const int64_t up = place[a] + 1 < g->n[a] ? stride[a] : 0, down = place[a] > 0 ? stride[a] : 0;
        d[a] = (number_at(t, at + up) - number_at(t, at - down)) / 2 * t->to_stored;
    }
    for (int a = 0; a < 3; a++) {
        const float *m = s->gradient_to_world[a];
        const double w = (double)m[0] * d[0] + (double)m[1] * d[1] + (double)m[2] * d[2];
        length += w * w;
    }
    return sqrt(length);
}

static float by_plane(const taker *t, double stored, double gradient)
{
    const vvi_classifier *b = &t->volume->ray.classifier;
    const double last = VVI_PLANE_SIDE - 1;
    const double x = fmin(fmax(stored * (double)b->plane_scale + (double)b->plane_shift, 0), last);
    const double y = fmin(gradient * (double)b->plane_gradient, last);
    const size_t at = (size_t)(y + 0.5) * VVI_PLANE_SIDE + (size_t)(x + 0.5);
    return fminf((float)((double)b->plane[4 * at + 3] / t->volume->ray.step), t->most);
}

/* Per world length, where a volume has this number. */
static inline float take(const taker *t, float number)
{
    const float place = number * t->entry_scale + t->entry_shift;
    return place >= 0 ? t->by_entry[(int32_t)(place < t->last_place ? place : t->last_place)] : t->by_entry[0];
}

static float take_solid(const taker *t, float number)
{
    const double stored = (double)number * t->to_stored + t->to_stored_shift;
    const vvi_solid *solid = &t->volume->ray.solid;
    return stored >= (double)solid->lo && stored <= (double)solid->hi ? t->most : 0;
}

/* The same where gradients matter, of the sample there. */
static float take_by_gradient(const taker *t, int64_t at)
{
    const vvi_classifier *b = &t->volume->ray.classifier;
    const double number = number_at(t, at);
    if (!t->by_entry)
        return by_plane(t, number * t->to_stored + t->to_stored_shift, gradient_at(t, at));
    const float most = take(t, (float)number);
    const double share = most > 0 ? fmin(gradient_at(t, at) * (double)b->modulate_scale, 1) : 0;
    return share > 0 ? most * (float)pow(share, (double)b->modulate_power) : 0;
}

/* Rows of samples to cells ------------------------------------------------------------------------------------------
 */

typedef struct filling {
    const vvi_light_frame *frame;
    const taker *taker;
    size_t n_takers;
    float *extinction;
    double *x; /* of the n_row samples of a row, in voxels of the frame */
    int32_t n_row;
    vv_job *job;
} filling;

/* Where the i-th sample of a cell lies, in voxels of the frame from its border: in the middle of one. */
static double sample_place(const vvi_light_frame *f, int axis, int32_t cell, int i)
{
    const int32_t side = f->side[axis], n = side < MOST_SAMPLES ? side : MOST_SAMPLES;
    const int32_t within = (2 * i + 1) * side / (2 * n);
    return f->lo[axis] + 0.5 + (double)cell * side + within;
}

static int samples_of(const vvi_light_frame *f, int axis)
{
    return f->side[axis] < MOST_SAMPLES ? f->side[axis] : MOST_SAMPLES;
}

/* The part of a row, which goes from x = 0 on in voxels of the frame, that cut planes leave. */
static void cut_row(double *from, double *to, const taker *t, const vvi_light_frame *f, vv_vec3 start)
{
    const vv_actor *actor = t->volume->actor;
    const vv_vec3 o = vv_affine_point(f->to_world, start);
    for (size_t i = 0; i < actor->n_planes; i++) {
        const vv_plane *p = &actor->planes[i];
        const double d = vvi_dot(p->normal, f->to_world.axis[0]), rest = p->offset - vvi_dot(p->normal, o);
        if (d > 0)
            *from = fmax(*from, rest / d);
        else if (d < 0)
            *to = fmin(*to, rest / d);
        else if (rest > 0)
            *to = -INFINITY;
    }
}

/* The sample that owns a place, as an offset; -1: none. */
static inline int64_t owner(const vvi_lattice *g, vv_vec3 p)
{
    const double x = p.x + 0.5, y = p.y + 0.5, z = p.z + 0.5;
    if (!(x >= 0 && x < g->n[0] && y >= 0 && y < g->n[1] && z >= 0 && z < g->n[2]))
        return -1;
    return (int64_t)z * g->slice + (int64_t)y * g->row + (int64_t)x;
}

/* Offsets of a row of samples; false: none is left. */
static bool find_row(int64_t *at, const filling *f, const taker *t, double y, double z)
{
    const int32_t n = f->n_row;
    const vv_vec3 start = vvi_vec(0, y, z), first = vv_affine_point(t->from_first, start);
    const int64_t row = owner(t->lattice, start);
    double from = -INFINITY, to = INFINITY;
    cut_row(&from, &to, t, f->frame, start);
    if (from > to || (t->aligned && row < 0))
        return false;
    for (int32_t i = 0; i < n; i++) {
        const double x = f->x[i];
        const bool kept = x >= from && x <= to;
        if (t->aligned)
            at[i] = kept && x >= 0 && x < t->lattice->n[0] ? row + (int64_t)x : -1;
        else
            at[i] = kept ? owner(t->lattice, vvi_add(first, vvi_scaled(t->from_first.axis[0], x))) : -1;
    }
    return true;
}

#define READ_ROW(type)                                                                                                 \
    do {                                                                                                               \
        const type *data = t->lattice->data;                                                                           \
        for (int32_t i = 0; i < n; i++)                                                                                \
            out[i] = at[i] < 0 ? NAN : (float)data[at[i]];                                                             \
    } while (0)

/* Their numbers; NAN where there is none. */
static void read_row(float *out, const int64_t *at, const taker *t, int32_t n)
{
    switch (t->lattice->sample_type) {
    case VVI_SAMPLE_U8:
        READ_ROW(uint8_t);
        break;
    case VVI_SAMPLE_U16:
        READ_ROW(uint16_t);
        break;
    case VVI_SAMPLE_I16:
        READ_ROW(int16_t);
        break;
    default:
        READ_ROW(float);
        break;
    }
}

typedef struct row_room {
    int64_t *at;
    float *number;
} row_room;

/* Adds what one volume takes along one row of samples to the row's cells. */
static void add_row(float *row, const row_room *room, const filling *f, const taker *t, double y, double z)
{
    const int32_t n = f->n_row, each = samples_of(f->frame, 0);
    const bool solid = t->volume->solid,
               gradients = !solid && (!t->by_entry || t->volume->ray.classifier.modulate_power > 0);
    if (!find_row(room->at, f, t, y, z))
        return;
    read_row(room->number, room->at, t, n);
    for (int32_t i = 0; i < n; i++) {
        const float number = room->number[i];
        if (number == number)
            row[i / each] += gradients ? take_by_gradient(t, room->at[i])
                             : solid   ? take_solid(t, number)
                                       : take(t, number);
    }
}

static void close_room(void *scratch, void *shared)
{
    row_room *room = scratch;
    (void)shared;
    if (room) {
        vvi_free(room->at);
        vvi_free(room->number);
    }
    vvi_free(room);
}

static vv_status open_room(void **out, void *shared, int worker)
{
    const filling *f = shared;
    const size_t n = (size_t)f->n_row;
    (void)worker;
    row_room *room = vvi_alloc_zeroed(f->job, sizeof *room, VVI_MEM_SCRATCH);
    if (room) {
        room->at = vvi_alloc(f->job, n * sizeof *room->at, VVI_MEM_SCRATCH);
        room->number = vvi_alloc(f->job, n * sizeof *room->number, VVI_MEM_SCRATCH);
    }
    if (!room || !room->at || !room->number) {
        close_room(room, shared);
        return vv_fail_memory(n * (sizeof *room->at + sizeof *room->number));
    }
    *out = room;
    return VV_OK;
}

static vv_status fill_slice(void *scratch, void *shared, size_t index)
{
    const filling *f = shared;
    const vvi_light_frame *frame = f->frame;
    const int ny = samples_of(frame, 1), nz = samples_of(frame, 2);
    const float share = 1.0f / (float)(samples_of(frame, 0) * ny * nz);
    const int32_t cz = (int32_t)index;
    for (int32_t cy = 0; cy < frame->n[1]; cy++) {
        float *row = f->extinction + ((size_t)cz * (size_t)frame->n[1] + (size_t)cy) * (size_t)frame->n[0];
        for (int k = 0; k < nz; k++)
            for (int j = 0; j < ny; j++)
                for (size_t v = 0; v < f->n_takers; v++)
                    add_row(row, scratch, f, &f->taker[v], sample_place(frame, 1, cy, j),
                            sample_place(frame, 2, cz, k));
        for (int32_t i = 0; i < frame->n[0]; i++)
            row[i] *= share;
    }
    return vvi_job_poll(f->job);
}

vv_status vvi_raycast_fill_extinction(float *out, const vvi_light_frame *frame, const vvi_raycast_state *s, vv_job *job)
{
    static const vvi_work work = {.start = open_room, .item = fill_slice, .finish = close_room};
    taker takers[VVI_BLEND_VOLUMES];
    filling f = {.frame = frame, .taker = takers, .extinction = out, .job = job};
    vv_status st = VV_OK;
    const int each = samples_of(frame, 0);
    f.n_row = frame->n[0] * each;
    if (!(f.x = vvi_alloc(job, (size_t)f.n_row * sizeof *f.x, VVI_MEM_SCRATCH)))
        return vv_fail_memory((size_t)f.n_row * sizeof *f.x);
    for (int32_t i = 0; i < f.n_row; i++)
        f.x[i] = sample_place(frame, 0, i / each, i % each);
    memset(out, 0, vvi_light_cells(frame->n) * sizeof *out);
    for (size_t i = 0; i < s->n_volumes && st == VV_OK; i++)
        if (s->volume[i].visible && !s->volume[i].layer)
            st = open_taker(&takers[f.n_takers++], &s->volume[i], frame, job);
    if (st == VV_OK && f.n_takers)
        st = vvi_parallel_for(job, &work, &f, (size_t)frame->n[2]);
    close_takers(takers, f.n_takers);
    vvi_free(f.x);
    return st;
}
