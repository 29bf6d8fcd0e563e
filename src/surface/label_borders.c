/* Changes of the label from one voxel to the next are kept as bits: from them follows which voxels are near a border,
 * and which rows around those have one label, so that the Gaussian's weights of a whole row are one number. */
#include "surface/label_borders.h"
#include "core/job.h"
#include "core/memory.h"

#include <math.h>
#include <string.h>

enum { MOST_RADIUS = 29, MOST_NEAR = 64, WAYS = 2 };

/* Weights along an axis, and those before each of them. */
typedef struct gaussian {
    float weight[2 * MOST_RADIUS + 1], sum[2 * MOST_RADIUS + 2];
} gaussian;

typedef struct smoothing {
    const vvi_label_map *map;
    vvi_label_borders *borders;
    size_t words;       /* of a row of bits, with one to spare */
    uint64_t *along;    /* bit x: voxels x and x + 1 of the row differ */
    uint64_t *changes;  /* or the next along y or z does */
    gaussian way[WAYS]; /* of the deviation, and of sqrt(2) times it */
    double square;      /* of how far a row may be away */
} smoothing;

/* Labels around a voxel. */
typedef struct near_labels {
    int n;
    uint16_t label[MOST_NEAR];
    float weight[MOST_NEAR];
    float all;
} near_labels;

/* Changes --------------------------------------------------------------------------------------------------------- */

static uint64_t *bits_of(const smoothing *s, uint64_t *bits, int64_t j, int64_t k)
{
    return bits + (size_t)(k * s->map->n[1] + j) * s->words;
}

/* Item: the changes of one slice. */
static vv_status find_changes(void *scratch, void *user, size_t item)
{
    const smoothing *s = user;
    const vvi_label_map *m = s->map;
    const int64_t nx = m->n[0], k = (int64_t)item;
    (void)scratch;
    for (int64_t j = 0; j < m->n[1]; j++) {
        const uint16_t *row = vvi_label_row(m, j, k);
        const uint16_t *y = j + 1 < m->n[1] ? row + nx : row, *z = k + 1 < m->n[2] ? row + nx * m->n[1] : row;
        uint64_t *along = bits_of(s, s->along, j, k), *changes = bits_of(s, s->changes, j, k);
        for (int64_t x = 0; x < nx; x++) {
            const uint64_t differs = x + 1 < nx && row[x] != row[x + 1];
            along[x >> 6] |= differs << (x & 63);
            changes[x >> 6] |= (differs | (row[x] != y[x]) | (row[x] != z[x])) << (x & 63);
        }
    }
    return vvi_job_poll(m->job);
}

/* Bits from `begin` to before `end` of a row: whether all are 0. At most 64 of them. */
static bool none_set(const uint64_t *row, int64_t begin, int64_t end)
{
    if (begin >= end)
        return true;
    const uint64_t *w = row + (begin >> 6);
    const int at = (int)(begin & 63);
    const uint64_t bits = w[0] >> at | (at ? w[1] << (64 - at) : 0);
    return (bits & (end - begin >= 64 ? ~(uint64_t)0 : ((uint64_t)1 << (end - begin)) - 1)) == 0;
}

/* Bit x of out: some change is within the radius. */
static void find_near(uint64_t *out, const smoothing *s, int64_t j, int64_t k)
{
    const int64_t r = s->borders->radius, *n = s->map->n;
    memset(out, 0, s->words * sizeof *out);
    for (int64_t z = k - r > 0 ? k - r : 0; z <= k + r && z < n[2]; z++)
        for (int64_t y = j - r > 0 ? j - r : 0; y <= j + r && y < n[1]; y++) {
            const uint64_t *changes = bits_of(s, s->changes, y, z);
            for (size_t w = 0; w < s->words; w++)
                out[w] |= changes[w];
        }
    for (int64_t step = 0; step < r; step++) {
        uint64_t before = 0;
        for (size_t w = 0; w < s->words; w++) {
            const uint64_t here = out[w], after = w + 1 < s->words ? out[w + 1] : 0;
            out[w] = here | here << 1 | before >> 63 | here >> 1 | after << 63;
            before = here;
        }
    }
}

/* Weights --------------------------------------------------------------------------------------------------------- */

static void add_weight(near_labels *near, uint16_t label, float weight)
{
    int i = 0;
    near->all += weight;
    while (i < near->n && near->label[i] != label)
        i++;
    if (i == MOST_NEAR)
        return;
    if (i == near->n) {
        near->label[near->n++] = label;
        near->weight[i] = 0;
    }
    near->weight[i] += weight;
}

/* `weight`: of the row, with each Gaussian. */
static float run_weight(const smoothing *s, const float weight[WAYS], int64_t begin, int64_t end)
{
    const float *a = s->way[0].sum, *b = s->way[1].sum;
    return weight[0] * (a[end] - a[begin]) + weight[1] * (b[end] - b[begin]);
}

static void add_row(near_labels *near, const smoothing *s, int64_t x, int64_t y, int64_t z, const float weight[WAYS])
{
    const int64_t r = s->borders->radius, last = s->map->n[0] - 1;
    const int64_t lo = x - r > 0 ? x - r : 0, hi = x + r < last ? x + r : last;
    const uint16_t *row = vvi_label_row(s->map, y, z);
    if (none_set(bits_of(s, s->along, y, z), lo, hi)) {
        add_weight(near, row[x], run_weight(s, weight, lo - x + r, hi - x + r + 1));
        return;
    }
    for (int64_t i = lo, end; i <= hi; i = end) {
        for (end = i + 1; end <= hi && row[end] == row[i]; end++)
            continue;
        add_weight(near, row[i], run_weight(s, weight, i - x + r, end - x + r));
    }
}

static bool row_counts(const smoothing *s, int64_t y, int64_t z)
{
    return (double)(y * y + z * z) <= s->square;
}

static void look_around(near_labels *near, const smoothing *s, int64_t x, int64_t j, int64_t k)
{
    const int64_t r = s->borders->radius, *n = s->map->n;
    near->n = 0;
    near->all = 0;
    for (int64_t z = k - r > 0 ? k - r : 0; z <= k + r && z < n[2]; z++)
        for (int64_t y = j - r > 0 ? j - r : 0; y <= j + r && y < n[1]; y++) {
            if (!row_counts(s, y - j, z - k))
                continue;
            const float weight[WAYS] = {s->way[0].weight[z - k + r] * s->way[0].weight[y - j + r],
                                        s->way[1].weight[z - k + r] * s->way[1].weight[y - j + r]};
            add_row(near, s, x, y, z, weight);
        }
}

#define TAKEN (-1e30f)

/* Beside corners an indicator may be a little below 0 or above 1. */
static uint16_t stored(float weight)
{
    return (uint16_t)lrintf(fminf(fmaxf(weight, 0), 1) * VVI_LABEL_ONE);
}

/* The largest first; of equals the lower label. */
static void keep_largest(vvi_label_voxel *v, near_labels *near)
{
    for (int kept = 0; kept < VVI_LABELS_KEPT; kept++) {
        int best = -1;
        for (int i = 0; i < near->n; i++)
            if (near->weight[i] >= 0 &&
                (best < 0 || near->weight[i] > near->weight[best] ||
                 (!(near->weight[i] < near->weight[best]) && near->label[i] < near->label[best])))
                best = i;
        v->label[kept] = best < 0 ? v->label[0] : near->label[best];
        v->weight[kept] = best < 0 ? 0 : stored(near->weight[best] / near->all);
        if (best >= 0)
            near->weight[best] = TAKEN;
    }
}

/* Slices ---------------------------------------------------------------------------------------------------------- */

static vv_status start(void **scratch, void *user, int worker)
{
    const smoothing *s = user;
    (void)worker;
    *scratch = vvi_alloc(s->map->job, s->words * sizeof(uint64_t), VVI_MEM_SCRATCH);
    return *scratch ? VV_OK : vv_fail_memory(s->words * sizeof(uint64_t));
}

static void finish(void *scratch, void *user)
{
    (void)user;
    vvi_free(scratch);
}

static vv_status make_room(vvi_label_slice *s, vv_job *job)
{
    if (s->n < s->room)
        return VV_OK;
    const size_t room = s->room ? 2 * s->room : 256;
    vvi_label_voxel *voxels = vvi_realloc(job, s->voxels, room * sizeof *voxels, VVI_MEM_SCRATCH);
    if (!voxels)
        return vv_fail_memory(room * sizeof *voxels);
    s->voxels = voxels;
    s->room = room;
    return VV_OK;
}

static vv_status smooth_row(vvi_label_slice *to, const smoothing *s, const uint64_t *near, int64_t j, int64_t k)
{
    near_labels labels;
    vv_status st = VV_OK;
    for (size_t w = 0; w < s->words && st == VV_OK; w++)
        for (uint64_t rest = near[w]; rest && st == VV_OK; rest &= rest - 1) {
            const int64_t x = (int64_t)(64 * w) + __builtin_ctzll(rest);
            if (x >= s->map->n[0])
                break;
            look_around(&labels, s, x, j, k);
            if (labels.n < 2 || (st = make_room(to, s->map->job)) != VV_OK)
                continue;
            to->voxels[to->n].x = (int32_t)x;
            keep_largest(&to->voxels[to->n++], &labels);
        }
    return st;
}

/* Item: the voxels near borders of one slice. */
static vv_status smooth_slice(void *scratch, void *user, size_t k)
{
    const smoothing *s = user;
    vvi_label_slice *to = &s->borders->slices[k];
    const size_t rows = (size_t)s->map->n[1];
    to->first = vvi_alloc(s->map->job, (rows + 1) * sizeof *to->first, VVI_MEM_SCRATCH);
    if (!to->first)
        return vv_fail_memory((rows + 1) * sizeof *to->first);
    for (size_t j = 0; j < rows; j++) {
        to->first[j] = (uint32_t)to->n;
        find_near(scratch, s, (int64_t)j, (int64_t)k);
        vv_status st = smooth_row(to, s, scratch, (int64_t)j, (int64_t)k);
        if (st == VV_OK)
            st = vvi_job_poll(s->map->job);
        if (st != VV_OK)
            return st;
    }
    to->first[rows] = (uint32_t)to->n;
    return VV_OK;
}

/* The whole ------------------------------------------------------------------------------------------------------- */

/* Where a surface is curved, a Gaussian's value there is below one half by the mean curvature times this: half its
 * second moment in the plane through its middle. Scaled as if all its weights made 1; *mass_out is what they make. */
static double deficit(double *mass_out, const smoothing *s, const gaussian *g)
{
    const int r = s->borders->radius;
    double mass = 0, moment = 0;
    for (int z = -r; z <= r; z++)
        for (int y = -r; y <= r; y++)
            if (row_counts(s, y, z)) {
                const double weight = (double)g->weight[y + r] * (double)g->weight[z + r];
                mass += weight;
                moment += weight * (y * y + z * z);
            }
    *mass_out = mass;
    return moment * (double)g->weight[r] / mass;
}

/* Two Gaussians, of deviations 1 and sqrt(2), less of the second than of the first: as much as leaves no deficit. The
 * factors are the third axis' share. */
static void set_weights(smoothing *s, double deviation)
{
    const int r = s->borders->radius;
    double mass[WAYS], lack[WAYS], factor[WAYS] = {1, 0};
    for (int way = 0; way < WAYS; way++) {
        const double variance = deviation * deviation * (way + 1);
        double all = 0;
        for (int i = -r; i <= r; i++)
            all += r ? exp(-i * i / (2 * variance)) : 1;
        for (int i = -r; i <= r; i++)
            s->way[way].weight[i + r] = (float)((r ? exp(-i * i / (2 * variance)) : 1) / all);
        lack[way] = deficit(&mass[way], s, &s->way[way]);
    }
    if (lack[1] > lack[0]) {
        factor[0] = lack[1] / (lack[1] - lack[0]);
        factor[1] = -lack[0] / (lack[1] - lack[0]);
    }
    for (int way = 0; way < WAYS; way++)
        for (int i = 0; i <= 2 * r; i++)
            s->way[way].sum[i + 1] = s->way[way].sum[i] + s->way[way].weight[i] * (float)(factor[way] / mass[way]);
}

static vv_status smooth(smoothing *s)
{
    static const vvi_work find = {.stage = "borders", .item = find_changes};
    static const vvi_work work = {.stage = "smoothing", .start = start, .item = smooth_slice, .finish = finish};
    const vvi_label_map *m = s->map;
    size_t bits;
    vv_status st = vvi_mul3_size(&bits, (size_t)m->n[1], (size_t)m->n[2], s->words * sizeof *s->along);
    if (st != VV_OK)
        return st;
    s->borders->slices = vvi_alloc_zeroed(m->job, (size_t)m->n[2] * sizeof *s->borders->slices, VVI_MEM_SCRATCH);
    s->along = vvi_alloc_zeroed(m->job, bits + 8, VVI_MEM_SCRATCH);
    s->changes = vvi_alloc_zeroed(m->job, bits + 8, VVI_MEM_SCRATCH);
    if (!s->borders->slices || !s->along || !s->changes)
        return vv_fail_memory(2 * bits);
    s->borders->n_slices = m->n[2];
    if ((st = vvi_parallel_for(m->job, &find, s, (size_t)m->n[2])) == VV_OK)
        st = vvi_parallel_for(m->job, &work, s, (size_t)m->n[2]);
    return st;
}

vv_status vvi_label_borders_init(vvi_label_borders *out, const vvi_label_map *map, double deviation)
{
    const double reach = 2.5 * M_SQRT2 * deviation;
    smoothing s = {.map = map, .borders = out, .words = (size_t)(map->n[0] + 63) / 64 + 1};
    s.square = reach * reach;
    *out = (vvi_label_borders){.radius = (int)ceil(reach)};
    set_weights(&s, deviation);
    const vv_status st = smooth(&s);
    vvi_free(s.along);
    vvi_free(s.changes);
    if (st != VV_OK)
        vvi_label_borders_finish(out);
    return st;
}

void vvi_label_borders_finish(vvi_label_borders *borders)
{
    for (int64_t k = 0; k < borders->n_slices; k++) {
        vvi_free(borders->slices[k].voxels);
        vvi_free(borders->slices[k].first);
    }
    vvi_free(borders->slices);
    *borders = (vvi_label_borders){0};
}
