#include "surface/reduced.h"
#include "core/job.h"
#include "core/memory.h"
#include "surface/cell.h"
#include "surface/reduced_encode.h"
#include "surface/reduced_records.h"

#include <string.h>

enum { MOST_STEP = 256 };

void vvi_reduced_free(void *reduced)
{
    vvi_reduced *r = reduced;
    if (!r)
        return;
    vvi_free(r->bricks);
    vvi_free(r->records);
    vv_field_release(r->samples);
    vvi_free(r);
}

size_t vvi_reduced_bytes(const vvi_reduced *r)
{
    return sizeof *r + r->n_bricks * sizeof *r->bricks + r->n_bytes;
}

static vv_status check(const vvi_reduced_options *o)
{
    if (o->step < 0 || o->step > MOST_STEP || (o->step & (o->step - 1)) != 0)
        return vv_fail(VV_E_ARGUMENT, "a step of %d samples; 1, 2, 4, ... %d are possible", o->step, MOST_STEP);
    return VV_OK;
}

/* The grid of the samples that were taken. */
static void set_grid(vvi_reduced *r, const vv_grid *grid, const vvi_lattice_samples *l)
{
    r->grid = *grid;
    r->grid.index_to_world.origin =
        vv_affine_point(grid->index_to_world, (vv_vec3){l->offset[0], l->offset[1], l->offset[2]});
    for (int a = 0; a < 3; a++) {
        vv_vec3 *axis = &r->grid.index_to_world.axis[a];
        r->step[a] = l->step[a];
        r->grid.dims[a] = l->n[a];
        axis->x *= l->step[a];
        axis->y *= l->step[a];
        axis->z *= l->step[a];
    }
}

/* The finest that the budgets allow, or what was asked for. */
static vv_status fit(vvi_reduced *r, vvi_lattice_samples *l, const vvi_march *m, const vvi_reduced_options *o)
{
    vv_status st = VV_OK;
    bool over = true, more = true;
    for (int step = 1; over && st == VV_OK; step *= 2) {
        if (step > 1 && (st = vvi_lattice_halve(l, &more, m, o->filter)) != VV_OK)
            break;
        const bool last = o->step ? step == o->step : step == MOST_STEP || !more;
        if (o->step && !last)
            continue;
        st = vvi_reduced_encode(r, &over, l, m, last ? 0 : o->max_triangles, last ? 0 : o->max_bytes);
    }
    return st;
}

/* The floats become a field. */
static vv_status keep_samples(vvi_reduced *r, vvi_lattice_samples *l, vv_job *job)
{
    vv_field_info info = vv_field_info_default();
    float *made = l->made;
    info.grid = r->grid;
    info.type = VV_TYPE_F32;
    l->made = NULL;
    return vv_field_new(&r->samples, &info, made, 0, vvi_free, made, job);
}

static vv_status reduce(vvi_reduced *r, const vvi_march *m, const vvi_reduced_options *o, bool some)
{
    vvi_lattice_samples l = {.step = {1, 1, 1}, .n = {m->grid.dims[0], m->grid.dims[1], m->grid.dims[2]}};
    vv_status st = some ? vvi_lattice_begin(&l, m) : VV_OK;
    if (st == VV_OK && some)
        st = fit(r, &l, m, o);
    if (st == VV_OK)
        set_grid(r, &m->grid, &l);
    if (st == VV_OK && o->keep && l.made)
        st = keep_samples(r, &l, m->job);
    vvi_lattice_finish(&l);
    return st;
}

vv_status vvi_reduced_make(vvi_reduced **out, const vv_field *field, const vvi_reduced_options *o, vv_job *job)
{
    const vvi_marching_options surface = {.value = o->value, .component = o->component, .topology = VVI_MARCHING_APART};
    vvi_march m = {.job = job};
    *out = NULL;
    vv_status st = check(o);
    if (st != VV_OK)
        return st;
    vvi_reduced *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_DERIVED);
    if (!r)
        return vv_fail_memory(sizeof *r);
    if ((st = vvi_march_open(&m, field, &surface, job)) == VV_OK)
        st = reduce(r, &m, o, m.some);
    vv_brick_release(&m.brick);
    if (st == VV_OK)
        st = vv_field_health(field);
    if (st == VV_OK)
        *out = r;
    else
        vvi_reduced_free(r);
    return st;
}

/* Triangles ------------------------------------------------------------------------------------------------------- */

/* Where the surface crosses an edge of a cell, in eighths from the brick's corner. */
static void corner_place(uint8_t out[3], const vvi_reduced_cell *c, unsigned edge)
{
    const int axis = (int)edge / 4, b = vvi_across(axis, 0), d = vvi_across(axis, 1);
    for (int a = 0; a < 3; a++)
        out[a] = (uint8_t)(8 * c->at[a]);
    out[axis] = (uint8_t)(out[axis] + 2 * c->q[edge] + 1);
    out[b] = (uint8_t)(out[b] + 8 * (edge & 1));
    out[d] = (uint8_t)(out[d] + 8 * (edge >> 1 & 1));
}

static void find_normal(int16_t n[3], const uint8_t p[3][3])
{
    int u[3], v[3];
    for (int a = 0; a < 3; a++) {
        u[a] = p[1][a] - p[0][a];
        v[a] = p[2][a] - p[0][a];
    }
    for (int a = 0; a < 3; a++)
        n[a] = (int16_t)(u[(a + 1) % 3] * v[(a + 2) % 3] - u[(a + 2) % 3] * v[(a + 1) % 3]);
}

void vvi_reduced_triangles(vvi_reduced_triangle *out, const vvi_reduced_cell *c)
{
    for (int t = 0; t < c->k->n_triangles; t++, out++) {
        for (int v = 0; v < 3; v++)
            corner_place(out->corner[v], c, c->k->triangle[3 * t + v]);
        find_normal(out->normal, (const uint8_t(*)[3])out->corner);
    }
}

void vvi_reduced_expand(vvi_reduced_triangle *out, const vvi_reduced *r, size_t brick)
{
    vvi_reduced_reader reader = {.at = r->records + r->bricks[brick].first_byte};
    for (uint32_t i = 0; i < r->bricks[brick].n_cells; i++) {
        vvi_reduced_cell c;
        vvi_reduced_read(&c, &reader);
        vvi_reduced_triangles(out, &c);
        out += c.k->n_triangles;
    }
}
