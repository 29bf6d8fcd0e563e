/* The visible labels of a segmentation as smooth surfaces, each in its colour. */
#include "surface/labels.h"
#include "core/cache.h"
#include "core/memory.h"
#include "render/surface/surface.h"
#include "scene/transfer.h"
#include "surface/label_map.h"
#include <stdio.h>

typedef struct chosen {
    vv_label_id *labels;
    vv_mesh_part *parts;
    size_t n;
} chosen;

static void choose(chosen *c, const vv_actor *actor, const vvi_label_map *map)
{
    for (size_t i = 0; i < map->n_labels; i++) {
        double rgbk[4];
        char number[VVI_LABEL_DIGITS];
        vvi_transfer_label(rgbk, &actor->classes, map->labels[i], map->is_unsigned);
        if (!(rgbk[3] > 0) || map->labels[i] == 0)
            continue;
        vv_mesh_part *part = &c->parts[c->n];
        *part = (vv_mesh_part){.color = {rgbk[0], rgbk[1], rgbk[2], 1}};
        snprintf(part->name, sizeof part->name, "label %s", vvi_label_print(number, map->labels[i], map->is_unsigned));
        c->labels[c->n++] = map->labels[i];
    }
}

vv_status vvi_surface_make_labels(vvi_surface_model *out, const vvi_surface_request *r, vv_job *job)
{
    vvi_label_map map;
    chosen c = {0};
    vv_status st = vvi_label_map_init(&map, r->field, r->component, job);
    if (st != VV_OK)
        return st;
    const size_t n = map.n_labels + 1;
    c.labels = vvi_alloc(job, n * sizeof *c.labels, VVI_MEM_SCRATCH);
    c.parts = vvi_alloc(job, n * sizeof *c.parts, VVI_MEM_SCRATCH);
    if (c.labels && c.parts)
        choose(&c, r->actor, &map);
    else
        st = vv_fail_memory(n * (sizeof *c.labels + sizeof *c.parts));
    vvi_label_map_finish(&map);
    const vvi_labels_options o = {
        .labels = c.labels, .parts = c.parts, .n_labels = c.n, .smoothing = r->params->smoothing};
    if (st == VV_OK && c.n)
        st = vvi_label_surfaces(&out->mesh, r->field, r->component, &o, job);
    vvi_free(c.labels);
    vvi_free(c.parts);
    return st;
}

uint64_t vvi_surface_hash_labels(const vvi_surface_request *r)
{
    const vv_classification *c = &r->actor->classes;
    const double numbers[3] = {r->component, r->params->smoothing, c->label_opacity};
    const uint64_t h = vvi_hash(numbers, sizeof numbers, 0);
    const uint64_t rows = c->n_labels ? vvi_hash(c->labels, c->n_labels * 5 * sizeof *c->labels, h) : h;
    return c->label_ids ? vvi_hash(c->label_ids, c->n_labels * sizeof *c->label_ids, rows) : rows;
}
