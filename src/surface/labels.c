#include "surface/labels.h"
#include "core/job.h"
#include "core/memory.h"
#include "surface/joined_mesh.h"
#include "surface/label_borders.h"
#include "surface/marching.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#define MOST_SMOOTHING 8.0

typedef struct label_work {
    vvi_label_map map;
    vvi_label_borders borders;
    const vvi_labels_options *options;
    const vv_grid *grid;
    size_t n;
    size_t *numbers;     /* of the labels that are wanted */
    vv_mesh_part *parts; /* their names */
    vv_mesh **meshes;
    vv_job *job;
} label_work;

/* One label ------------------------------------------------------------------------------------------------------- */

typedef struct one_label {
    const label_work *work;
    uint16_t number;
    vv_box box;  /* of the volume's voxels; may reach beyond them */
    int16_t *to; /* its indicator less the largest of the others */
} one_label;

static int16_t difference(const vvi_label_voxel *v, uint16_t label)
{
    int own = 0;
    for (int i = 0; i < VVI_LABELS_KEPT; i++)
        own = v->label[i] == label && v->weight[i] > own ? v->weight[i] : own;
    return (int16_t)(own - (v->label[0] == label ? v->weight[1] : v->weight[0]));
}

static int64_t clamp(int64_t at, int64_t n)
{
    return at < 0 ? 0 : at >= n ? n - 1 : at;
}

/* Row j of slice k, which may lie beyond the volume: there no label is, and a surface lies half-way to the border. */
static void fill_row(int16_t *to, const one_label *l, int64_t j, int64_t k)
{
    const vvi_label_map *m = &l->work->map;
    const int64_t row_j = clamp(j, m->n[1]), row_k = clamp(k, m->n[2]), lo = l->box.lo[0], n = l->box.n[0];
    const bool beyond = row_j != j || row_k != k;
    const vvi_label_slice *near = &l->work->borders.slices[row_k];
    const uint16_t *row = vvi_label_row(m, row_j, row_k);
    for (int64_t i = 0; i < n; i++)
        to[i] = row[clamp(lo + i, m->n[0])] == l->number ? VVI_LABEL_ONE : -VVI_LABEL_ONE;
    for (uint32_t v = near->first[row_j]; v < near->first[row_j + 1]; v++) {
        const int64_t i = near->voxels[v].x - lo;
        if (i >= 0 && i < n)
            to[i] = difference(&near->voxels[v], l->number);
    }
    const int64_t begin = lo < 0 ? -lo : 0, end = lo + n > m->n[0] ? m->n[0] - lo : n;
    for (int64_t i = 0; i < n; i++)
        if (beyond || i < begin || i >= end) {
            const int16_t edge = to[i < begin ? begin : i >= end ? end - 1 : i];
            to[i] = edge > 0 ? (int16_t)-edge : edge < 0 ? edge : -1;
        }
}

/* Item: a slice of the box. */
static vv_status fill_slice(void *scratch, void *user, size_t item)
{
    const one_label *l = user;
    const int64_t *n = l->box.n;
    int16_t *to = l->to + (int64_t)item * n[0] * n[1];
    (void)scratch;
    for (int64_t y = 0; y < n[1]; y++)
        fill_row(to + y * n[0], l, l->box.lo[1] + y, l->box.lo[2] + (int64_t)item);
    return vvi_job_poll(l->work->job);
}

static vv_status surface_of(vv_mesh **out, const label_work *w, size_t number)
{
    static const vvi_work work = {.item = fill_slice};
    const vvi_label_box *b = &w->map.boxes[number];
    const int margin = w->borders.radius + 1;
    one_label l = {.work = w, .number = (uint16_t)number};
    vv_field_info info = vv_field_info_default();
    vv_field *field;
    void *samples;
    for (int a = 0; a < 3; a++) {
        l.box.lo[a] = (int64_t)b->lo[a] - margin;
        l.box.n[a] = (int64_t)b->hi[a] - b->lo[a] + 1 + 2 * (int64_t)margin;
    }
    info.type = VV_TYPE_I16;
    info.grid = vv_grid_crop(w->grid, &l.box);
    vv_status st = vv_field_new_empty(&field, &samples, &info, w->job);
    if (st != VV_OK)
        return st;
    l.to = samples;
    if ((st = vvi_parallel_for(w->job, &work, &l, (size_t)l.box.n[2])) == VV_OK) {
        const vvi_marching_options o = {.value = 0, .no_normals = w->options->no_normals};
        st = vvi_marching_cubes(out, field, &o, w->job);
    }
    vv_field_release(field);
    char label_text[VVI_LABEL_DIGITS];
    if (st == VV_OK && vv_mesh_get_info(*out)->n_triangles == 0)
        vvi_log(w->job, VV_LOG_WARNING, "surface",
                "label %s is thinner than the smoothing everywhere and has no surface; smooth it less",
                vvi_label_print(label_text, w->map.labels[number], w->map.is_unsigned));
    return st;
}

/* Which labels ---------------------------------------------------------------------------------------------------- */

static vv_status check(const vvi_labels_options *o)
{
    if (!(o->smoothing >= 0 && o->smoothing <= MOST_SMOOTHING))
        return vv_fail(VV_E_ARGUMENT, "labels can be smoothed by 0 to %g voxels, not %g", MOST_SMOOTHING, o->smoothing);
    return VV_OK;
}

/* Whether it is wanted where nobody chose. */
static bool name_part(vv_mesh_part *part, const label_work *w, size_t i, vv_label_id label)
{
    const vvi_labels_options *o = w->options;
    char number[VVI_LABEL_DIGITS];
    *part = (vv_mesh_part){.color.a = -1};
    if (o->parts && o->labels)
        *part = o->parts[i];
    const bool wanted = !o->look || o->look(part, label, w->map.is_unsigned, o->look_user);
    if (!*part->name)
        snprintf(part->name, sizeof part->name, "label %s", vvi_label_print(number, label, w->map.is_unsigned));
    return wanted;
}

static vv_status fail_missing(const label_work *w, vv_label_id label)
{
    char wanted[VVI_LABEL_DIGITS], first[VVI_LABEL_DIGITS], last[VVI_LABEL_DIGITS];
    const vvi_label_map *map = &w->map;
    return vv_fail(VV_E_NOT_FOUND, "label %s is not in the volume; there are %zu, from %s to %s",
                   vvi_label_print(wanted, label, map->is_unsigned), map->n_labels,
                   vvi_label_print(first, map->labels[0], map->is_unsigned),
                   vvi_label_print(last, map->labels[map->n_labels - 1], map->is_unsigned));
}

static vv_status choose(label_work *w)
{
    const vvi_labels_options *o = w->options;
    char background[VVI_LABEL_DIGITS];
    const size_t most = (o->labels ? o->n_labels : w->map.n_labels) + 1;
    w->numbers = vvi_alloc(w->job, most * sizeof *w->numbers, VVI_MEM_SCRATCH);
    w->parts = vvi_alloc(w->job, most * sizeof *w->parts, VVI_MEM_SCRATCH);
    w->meshes = vvi_alloc_zeroed(w->job, most * sizeof(void *), VVI_MEM_SCRATCH);
    if (!w->numbers || !w->parts || !w->meshes)
        return vv_fail_memory(most * sizeof *w->parts);
    for (size_t i = 0; i + 1 < most; i++) {
        const vv_label_id label = o->labels ? o->labels[i] : w->map.labels[i];
        const size_t number = vvi_label_number(&w->map, label);
        if (!o->labels && label == o->background)
            continue;
        if (number == SIZE_MAX)
            return fail_missing(w, label);
        if (!name_part(&w->parts[w->n], w, i, label) && !o->labels)
            continue;
        w->numbers[w->n++] = number;
    }
    if (w->n == 0)
        return vv_fail(VV_E_NOT_FOUND, "there is no %slabel except the background, %s", o->look ? "visible " : "",
                       vvi_label_print(background, o->background, w->map.is_unsigned));
    return VV_OK;
}

static vv_status extract(vv_mesh **out, label_work *w)
{
    vv_status st = choose(w);
    if (st == VV_OK)
        st = vvi_label_borders_init(&w->borders, &w->map, w->options->smoothing);
    for (size_t i = 0; i < w->n && st == VV_OK; i++)
        st = surface_of(&w->meshes[i], w, w->numbers[i]);
    return st == VV_OK ? vvi_mesh_join(out, w->meshes, w->parts, w->n, w->job) : st;
}

vv_status vvi_label_surfaces(vv_mesh **out, const vv_field *field, int component, const vvi_labels_options *o,
                             vv_job *job)
{
    label_work w = {.options = o, .grid = &vv_field_get_info(field)->grid, .job = job};
    *out = NULL;
    vv_status st = check(o);
    if (st == VV_OK)
        st = vvi_label_map_init(&w.map, field, component, job);
    if (st == VV_OK)
        st = extract(out, &w);
    for (size_t i = 0; i < w.n; i++)
        vv_mesh_release(w.meshes[i]);
    vvi_free(w.meshes);
    vvi_free(w.parts);
    vvi_free(w.numbers);
    vvi_label_borders_finish(&w.borders);
    vvi_label_map_finish(&w.map);
    if (st == VV_OK && (st = vv_field_health(field)) != VV_OK) {
        vv_mesh_release(*out);
        *out = NULL;
    }
    return st;
}
