/* Morphology of labels, tile by tile: each label of a tile is a mask of its own. */
#include "core/memory.h"
#include "filter/dilation.h"
#include "filter/morphology.h"
#include "filter/near_offsets.h"
#include "grid/label_set.h"
#include "grid/making.h"

#include <stdlib.h>
#include <string.h>

/* What a cell of a tile has in it: nothing of the volume; no label; or 1 + the number of its label in the tile. */
enum { OUTSIDE, BACKGROUND, FIRST_LABEL };

typedef struct shared {
    vvi_making making;
    const vv_field_info *info;
    const vvi_morphology *m;
    const vv_label_id *only;
    vvi_near_offsets near; /* where dilation looks for the nearest label */
    int64_t margin[3], tile[3];
    vv_job *job;
} shared;

typedef struct label {
    vv_label_id id;
    uint32_t cell;
    vv_box box; /* of its cells */
} label;

typedef struct scratch {
    uint32_t *cells;      /* of a tile with its margin */
    uint32_t *result;     /* of a tile */
    uint8_t *mask, *more; /* of a label, after one step, and what the next begins with */
    vv_label_id *ids;     /* of a row */
    label *labels;
    size_t n_labels, room;
    vvi_dilation dilation;
} scratch;

/* A tile, and how it lies among its cells. */
typedef struct tile {
    vv_box box;
    int64_t n[3]; /* cells */
    vv_box inner; /* the tile's own among them */
    int64_t component;
} tile;

static void finish(void *scratch_in, void *user)
{
    scratch *own = scratch_in;
    if (!own)
        return;
    vvi_free(own->cells);
    vvi_free(own->result);
    vvi_free(own->mask);
    vvi_free(own->more);
    vvi_free(own->ids);
    vvi_free(own->labels);
    vvi_dilation_finish(&own->dilation);
    vvi_free(own);
}

static vv_status start(void **scratch_out, void *user, int worker)
{
    const shared *s = user;
    const int64_t *r = s->m->element.radius;
    int64_t most[3], cells = 1, samples = 1;
    for (int a = 0; a < 3; a++) {
        cells *= s->tile[a] + 2 * s->margin[a];
        samples *= s->tile[a];
        most[a] = s->tile[a] + 2 * (s->margin[a] - r[a]);
    }
    const size_t masks = (size_t)cells + VVI_DILATE_GUARD;
    scratch *own = vvi_alloc_zeroed(s->job, sizeof *own, VVI_MEM_SCRATCH);
    if (!own)
        return vv_fail_memory(sizeof *own);
    own->cells = vvi_alloc(s->job, (size_t)cells * sizeof *own->cells, VVI_MEM_SCRATCH);
    own->result = vvi_alloc(s->job, (size_t)samples * sizeof *own->result, VVI_MEM_SCRATCH);
    own->ids = vvi_alloc(s->job, (size_t)(s->tile[0] + 2 * s->margin[0]) * sizeof *own->ids, VVI_MEM_SCRATCH);
    own->mask = vvi_alloc_zeroed(s->job, masks, VVI_MEM_SCRATCH);
    own->more = vvi_alloc_zeroed(s->job, masks, VVI_MEM_SCRATCH);
    vv_status st = own->cells && own->result && own->ids && own->mask && own->more
                       ? VV_OK
                       : vv_fail_memory((size_t)cells * sizeof *own->cells);
    if (st == VV_OK)
        st = vvi_dilation_init(&own->dilation, &s->m->element, most, 1, s->job);
    if (st == VV_OK)
        *scratch_out = own;
    else
        finish(own, user);
    return st;
}

static size_t cell_at(const int64_t n[3], int64_t i, int64_t j, int64_t k)
{
    return (size_t)((k * n[1] + j) * n[0] + i);
}

static vv_box common(const vv_box *a, const vv_box *b)
{
    vv_box out;
    for (int d = 0; d < 3; d++) {
        const int64_t ea = a->lo[d] + a->n[d], eb = b->lo[d] + b->n[d];
        out.lo[d] = a->lo[d] > b->lo[d] ? a->lo[d] : b->lo[d];
        out.n[d] = (ea < eb ? ea : eb) - out.lo[d];
        out.n[d] = out.n[d] < 0 ? 0 : out.n[d];
    }
    return out;
}

static vv_box grown(const vv_box *box, const int64_t by[3])
{
    vv_box out = *box;
    for (int d = 0; d < 3; d++) {
        out.lo[d] -= by[d];
        out.n[d] += 2 * by[d];
    }
    return out;
}

static vv_status add_label(uint32_t *cell_out, scratch *own, vvi_label_set *set, vv_label_id id, vv_job *job)
{
    uint32_t number;
    const vv_status st = vvi_label_set_add(&number, set, id, job);
    if (st != VV_OK)
        return st;
    *cell_out = BACKGROUND + number;
    if (number < own->n_labels)
        return VV_OK;
    if (own->n_labels == own->room) {
        const size_t room = own->room ? 2 * own->room : 64;
        label *labels = vvi_realloc(job, own->labels, room * sizeof *labels, VVI_MEM_SCRATCH);
        if (!labels)
            return vv_fail_memory(room * sizeof *labels);
        own->labels = labels;
        own->room = room;
    }
    own->labels[own->n_labels++] = (label){.id = id, .cell = BACKGROUND + number};
    return VV_OK;
}

static void widen(label *l, int64_t i, int64_t end, int64_t j, int64_t k)
{
    const int64_t lo[3] = {i, j, k}, hi[3] = {end, j + 1, k + 1};
    for (int a = 0; a < 3; a++) {
        const int64_t last = l->box.lo[a] + l->box.n[a];
        if (l->box.n[a] == 0) {
            l->box.lo[a] = lo[a];
            l->box.n[a] = hi[a] - lo[a];
            continue;
        }
        l->box.lo[a] = lo[a] < l->box.lo[a] ? lo[a] : l->box.lo[a];
        l->box.n[a] = (hi[a] > last ? hi[a] : last) - l->box.lo[a];
    }
}

/* The cells of one row that lies in the volume. */
static vv_status gather_row(scratch *own, vvi_label_set *set, const shared *s, const tile *t, const vv_box *row)
{
    const vv_brick part = vvi_brick_part(&s->making.brick, row);
    const int64_t at[3] = {row->lo[0] - t->box.lo[0] + s->margin[0], row->lo[1] - t->box.lo[1] + s->margin[1],
                           row->lo[2] - t->box.lo[2] + s->margin[2]};
    uint32_t *cells = own->cells + cell_at(t->n, at[0], at[1], at[2]);
    vv_status st = VV_OK;
    vvi_label_read(own->ids, &part, (int)t->component, NULL, 0, 0);
    for (int64_t i = 0, end; i < row->n[0] && st == VV_OK; i = end) {
        uint32_t cell = BACKGROUND;
        st = add_label(&cell, own, set, own->ids[i], s->job);
        for (end = i; end < row->n[0] && own->ids[end] == own->ids[i]; end++)
            cells[end] = cell;
        if (st == VV_OK)
            widen(&own->labels[cell - BACKGROUND], at[0] + i, at[0] + end, at[1], at[2]);
    }
    return st;
}

static vv_status gather(scratch *own, const shared *s, const tile *t)
{
    const vv_box all = grown(&t->box, s->margin), there = common(&all, &s->making.brick.box);
    vvi_label_set set = {0};
    uint32_t none;
    own->n_labels = 0;
    memset(own->cells, 0, (size_t)(t->n[0] * t->n[1] * t->n[2]) * sizeof *own->cells);
    vv_status st = add_label(&none, own, &set, 0, s->job);
    for (int64_t k = 0; k < there.n[2] && st == VV_OK; k++)
        for (int64_t j = 0; j < there.n[1] && st == VV_OK; j++) {
            const vv_box row = {{there.lo[0], there.lo[1] + j, there.lo[2] + k}, {there.n[0], 1, 1}};
            st = gather_row(own, &set, s, t, &row);
        }
    vvi_label_set_finish(&set);
    return st;
}

/* The first step's mask: the label, or where the volume is something else. */
static void mask_of(uint8_t *mask, const scratch *own, const tile *t, const vv_box *box, uint32_t cell, bool others)
{
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++, mask += box->n[0]) {
            const uint32_t *cells = own->cells + cell_at(t->n, box->lo[0], box->lo[1] + j, box->lo[2] + k);
            for (int64_t i = 0; i < box->n[0]; i++)
                mask[i] = others ? cells[i] != cell && cells[i] != OUTSIDE : cells[i] == cell;
        }
}

/* The next step's mask: what one step left, the other way round. */
static void mask_again(uint8_t *mask, const vvi_dilated *d, const scratch *own, const tile *t, const vv_box *box)
{
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++, mask += box->n[0]) {
            const uint32_t *cells = own->cells + cell_at(t->n, box->lo[0], box->lo[1] + j, box->lo[2] + k);
            const char *from = d->keys + j * d->stride[0] + k * d->stride[1];
            for (int64_t i = 0; i < box->n[0]; i++)
                mask[i] = !from[i] && cells[i] != OUTSIDE;
        }
}

/* Who has the cell, of all that come there: the nearest, of equally near ones the one with the lowest id. */
static uint32_t nearest(const scratch *own, const shared *s, const tile *t, const uint32_t *at)
{
    const label *best = NULL;
    double most = 0;
    for (size_t o = 0; o < s->near.n; o++) {
        const vvi_near_offset *near = &s->near.offset[o];
        if (best && near->away > most)
            break;
        const uint32_t cell = at[(near->k * t->n[1] + near->j) * t->n[0] + near->i];
        if (cell < FIRST_LABEL)
            continue;
        const label *l = own->labels;
        while (l->cell != cell)
            l++;
        if (s->only && l->id != *s->only)
            continue;
        if (!best)
            most = near->away * (1 + 1e-9);
        if (!best || l < best)
            best = l;
    }
    return best ? best->cell : BACKGROUND;
}

static void put_mask(scratch *own, const shared *s, const tile *t, const vvi_dilated *d, const vv_box *box,
                     const label *l)
{
    const int last = s->m->n_steps - 1;
    const bool turned = s->m->erodes[last], grows = !s->m->erodes[0];
    for (int64_t k = 0; k < box->n[2]; k++)
        for (int64_t j = 0; j < box->n[1]; j++) {
            const char *from = d->keys + j * d->stride[0] + k * d->stride[1];
            const uint32_t *cells = own->cells + cell_at(t->n, box->lo[0], box->lo[1] + j, box->lo[2] + k);
            uint32_t *to = own->result + cell_at(t->box.n, box->lo[0] - t->inner.lo[0], box->lo[1] + j - t->inner.lo[1],
                                                 box->lo[2] + k - t->inner.lo[2]);
            for (int64_t i = 0; i < box->n[0]; i++) {
                if (!from[i] != turned)
                    continue;
                if (!grows || to[i] == BACKGROUND)
                    to[i] = l->cell;
                else if (last == 0 && cells[i] == BACKGROUND && to[i] != l->cell)
                    to[i] = nearest(own, s, t, cells + i);
            }
        }
}

static vv_status run_label(scratch *own, const shared *s, const tile *t, const label *l)
{
    const vvi_morphology *m = s->m;
    const int64_t *r = m->element.radius;
    const vv_box wide = grown(&l->box, r), box = common(m->erodes[0] ? &l->box : &wide, &t->inner);
    const vv_box first = m->n_steps == 2 ? grown(&box, r) : box, input = grown(&first, r);
    vvi_dilated d;
    if (box.n[0] == 0 || box.n[1] == 0 || box.n[2] == 0)
        return VV_OK;
    mask_of(own->mask, own, t, &input, l->cell, m->erodes[0]);
    vv_status st = vvi_dilation_run(&d, &own->dilation, own->mask, first.n);
    if (st == VV_OK && m->n_steps == 2) {
        mask_again(own->more, &d, own, t, &first);
        st = vvi_dilation_run(&d, &own->dilation, own->more, box.n);
    }
    if (st == VV_OK)
        put_mask(own, s, t, &d, &box, l);
    return st;
}

/* What a tile is before its labels come: with all of them where they grow, and else with those that do not change. */
static void begin(scratch *own, const shared *s, const tile *t)
{
    uint32_t kept = BACKGROUND;
    for (size_t l = 0; l < own->n_labels && s->only; l++)
        if (own->labels[l].id == *s->only)
            kept = own->labels[l].cell;
    uint32_t *to = own->result;
    for (int64_t k = 0; k < t->box.n[2]; k++)
        for (int64_t j = 0; j < t->box.n[1]; j++, to += t->box.n[0]) {
            const uint32_t *cells = own->cells + cell_at(t->n, t->inner.lo[0], t->inner.lo[1] + j, t->inner.lo[2] + k);
            for (int64_t i = 0; i < t->box.n[0]; i++)
                to[i] = s->m->erodes[0] && (!s->only || cells[i] == kept) ? BACKGROUND : cells[i];
        }
}

static int by_id(const void *a, const void *b)
{
    return vvi_label_compare(((const label *)a)->id, ((const label *)b)->id, false);
}

static int by_unsigned_id(const void *a, const void *b)
{
    return vvi_label_compare(((const label *)a)->id, ((const label *)b)->id, true);
}

static void put_id(char *out, vv_label_id id, vv_type type)
{
    const double v = (double)id;
    if (vv_type_bytes(type) == sizeof id && !vv_type_is_float(type))
        memcpy(out, &id, sizeof id);
    else
        vvi_samples_from_f64(out, &v, type, 1);
}

/* `at` by cell: its label. */
static void write_tile(const scratch *own, const shared *s, const tile *t)
{
    const int64_t each = (int64_t)vv_type_bytes(s->info->type), step = each * s->info->components;
    const uint32_t *from = own->result;
    for (int64_t k = 0; k < t->box.n[2]; k++)
        for (int64_t j = 0; j < t->box.n[1]; j++, from += t->box.n[0]) {
            char *out = s->making.out + vvi_slabs_row(&s->making.slabs, &t->box, j, k) * step + t->component * each;
            for (int64_t i = 0; i < t->box.n[0]; i++) {
                if (i > 0 && from[i] == from[i - 1]) {
                    memcpy(out + i * step, out + (i - 1) * step, (size_t)each);
                    continue;
                }
                const label *l = own->labels;
                while (l->cell != from[i])
                    l++;
                put_id(out + i * step, l->id, s->info->type);
            }
        }
}

static vv_status write_component(scratch *own, const shared *s, const tile *t)
{
    vv_status st = gather(own, s, t);
    if (st != VV_OK)
        return st;
    qsort(own->labels, own->n_labels, sizeof *own->labels,
          vvi_label_is_unsigned(s->info->type) ? by_unsigned_id : by_id);
    begin(own, s, t);
    for (size_t l = 0; l < own->n_labels && st == VV_OK; l++)
        if (own->labels[l].cell != BACKGROUND && (!s->only || own->labels[l].id == *s->only)) {
            st = run_label(own, s, t, &own->labels[l]);
            if (st == VV_OK)
                st = vvi_job_poll(s->job);
        }
    if (st == VV_OK)
        write_tile(own, s, t);
    return st;
}

static vv_status item(void *scratch_in, void *user, size_t index)
{
    const shared *s = user;
    tile t = {.box = vvi_slabs_item(&s->making.slabs, index)};
    vv_status st = VV_OK;
    for (int a = 0; a < 3; a++) {
        t.n[a] = t.box.n[a] + 2 * s->margin[a];
        t.inner.lo[a] = s->margin[a];
        t.inner.n[a] = t.box.n[a];
    }
    for (; t.component < s->info->components && st == VV_OK; t.component++)
        st = write_component(scratch_in, s, &t);
    return st;
}

vv_status vvi_morphology_of_labels(vv_field **out, const vv_field *in, const vv_box *box, const vvi_morphology *m,
                                   const vv_label_id *only, vv_job *job)
{
    const vvi_work work = {.stage = m->name, .start = start, .item = item, .finish = finish};
    const vv_field_info *info = vv_field_get_info(in);
    shared s = {.making = {.in = in}, .info = info, .m = m, .only = only, .job = job};
    vv_status st = VV_OK;
    *out = NULL;
    for (int a = 0; a < 3; a++)
        s.margin[a] = m->n_steps * m->element.radius[a];
    if (m->n_steps == 1 && !m->erodes[0])
        st = vvi_near_offsets_init(&s.near, &m->element, &info->grid, m->name, job);
    if (st != VV_OK)
        return st;
    s.making.slabs = vvi_window_wide_tiles(box, s.margin);
    for (int a = 0; a < 3; a++)
        s.tile[a] = s.making.slabs.step[a];
    const vv_box needed = vvi_window_reach(box, s.margin, info->grid.dims);
    st = vvi_making_run(out, &s.making, info, box, &needed, &work, &s, job);
    vvi_near_offsets_finish(&s.near);
    return st;
}
