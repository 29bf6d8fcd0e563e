/* Cutting closed polyhedra. */
#include "measure/triangle_chain.h"

#define ON_PLANE 1e-8

static vvi_chain_triangle *add(vvi_chain *chain, const vvi_chain_triangle *t)
{
    if (chain->n == VVI_CHAIN_ROOM) {
        chain->full = true;
        return NULL;
    }
    chain->triangle[chain->n] = *t;
    return &chain->triangle[chain->n++];
}

void vvi_chain_add(vvi_chain *chain, vvi_chain_part part, vv_vec3 a, vv_vec3 b, vv_vec3 c)
{
    add(chain, &(vvi_chain_triangle){{a, b, c}, part, {0, 0, 0}});
}

/* The point of an edge on the plane, found alike from both ends. */
static vv_vec3 crossing(vv_vec3 a, vv_vec3 b, double da, double db)
{
    return da < 0 ? vvi_add(b, vvi_scaled(vvi_sub(a, b), db / (db - da)))
                  : vvi_add(a, vvi_scaled(vvi_sub(b, a), da / (da - db)));
}

/* A wall that lies in the plane is the cap already. */
static void add_in_plane(vvi_chain *out, const vvi_chain_triangle *t, const vv_plane *plane)
{
    vvi_chain_triangle *added = add(out, t);
    if (added && added->part == VVI_CHAIN_WALL) {
        added->part = VVI_CHAIN_CUT;
        added->outwards = vvi_scaled(plane->normal, -1);
    }
}

/* Keeps the part of a triangle above the plane; from the edge that is cut a triangle goes to `apex`, which lies in the
 * plane. */
static void cut_triangle(vvi_chain *out, const vvi_chain_triangle *t, const double d[3], const vv_plane *plane,
                         vv_vec3 apex)
{
    vv_vec3 kept[4], edge[2];
    int n = 0, cuts = 0;
    for (int i = 0; i < 3; i++) {
        const int next = (i + 1) % 3;
        if (d[i] >= 0)
            kept[n++] = t->p[i];
        if ((d[i] >= 0) != (d[next] >= 0)) {
            kept[n] = crossing(t->p[i], t->p[next], d[i], d[next]);
            edge[d[i] >= 0 ? 0 : 1] = kept[n++];
            cuts++;
        }
    }
    for (int i = 1; i + 1 < n; i++)
        add(out, &(vvi_chain_triangle){{kept[0], kept[i], kept[i + 1]}, t->part, t->outwards});
    if (cuts == 2) /* the triangle runs from edge[0] to edge[1], so the cap runs back */
        add(out, &(vvi_chain_triangle){{apex, edge[1], edge[0]}, VVI_CHAIN_CUT, vvi_scaled(plane->normal, -1)});
}

void vvi_chain_cut(vvi_chain *chain, vvi_chain *other, const vv_plane *plane)
{
    vv_vec3 apex = {0, 0, 0};
    other->n = 0;
    other->full = chain->full;
    if (chain->n) /* near the cell, so that nothing is lost to rounding */
        apex = chain->triangle[0].p[0];
    apex = vvi_add(apex, vvi_scaled(plane->normal, plane->offset - vvi_dot(plane->normal, apex)));
    for (int i = 0; i < chain->n; i++) {
        const vvi_chain_triangle *t = &chain->triangle[i];
        double d[3];
        for (int c = 0; c < 3; c++)
            d[c] = vvi_dot(plane->normal, t->p[c]) - plane->offset;
        if (fabs(d[0]) < ON_PLANE && fabs(d[1]) < ON_PLANE && fabs(d[2]) < ON_PLANE)
            add_in_plane(other, t, plane);
        else
            cut_triangle(other, t, d, plane, apex);
    }
    chain->n = other->n;
    chain->full = other->full;
    for (int i = 0; i < other->n; i++)
        chain->triangle[i] = other->triangle[i];
}
