/* Concave polygons: cut by ears (Meisters 1975) in the plane that their normal (Newell's sum) is nearest to. */
#include "core/memory.h"
#include "io/meshes/mesh_builder.h"

#include <math.h>
#include <string.h>

/* Corners past this many are left as a fan: cutting takes time by their square. */
enum { CORNERS_MOST = 4096 };

typedef struct point {
    double x, y;
} point;

typedef struct polygon {
    uint32_t *corner;     /* n vertices */
    uint32_t *coordinate; /* and on textures; where there are some */
    point *at;            /* in the plane, counter-clockwise */
    uint32_t *left;       /* numbers of corners that are not cut off yet */
    size_t n, n_left;
} polygon;

static double turn(point a, point b, point c)
{
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

/* The fan tells the corners: its first triangle three, each further one the next. */
static void corners_of_fan(uint32_t *out, const uint32_t *t, size_t n)
{
    memcpy(out, t, 3 * sizeof *t);
    for (size_t i = 3; i < n; i++)
        out[i] = t[3 * (i - 2) + 2];
}

/* Leaves out the axis along which the polygon is seen largest. */
static void project(polygon *p, const float *positions)
{
    double normal[3] = {0, 0, 0};
    for (size_t i = 0; i < p->n; i++) {
        const float *a = positions + 3 * (size_t)p->corner[i], *b = positions + 3 * (size_t)p->corner[(i + 1) % p->n];
        for (int k = 0; k < 3; k++)
            normal[k] += ((double)a[(k + 1) % 3] - b[(k + 1) % 3]) * ((double)a[(k + 2) % 3] + b[(k + 2) % 3]);
    }
    int drop = fabs(normal[0]) > fabs(normal[1]) ? 0 : 1;
    drop = fabs(normal[2]) > fabs(normal[drop]) ? 2 : drop;
    const int u = normal[drop] < 0 ? (drop + 2) % 3 : (drop + 1) % 3,
              v = normal[drop] < 0 ? (drop + 1) % 3 : (drop + 2) % 3;
    for (size_t i = 0; i < p->n; i++) {
        const float *a = positions + 3 * (size_t)p->corner[i];
        p->at[i] = (point){a[u], a[v]};
    }
}

static bool fan_is_right(const polygon *p)
{
    for (size_t i = 1; i + 1 < p->n; i++)
        if (turn(p->at[0], p->at[i], p->at[i + 1]) < 0)
            return false;
    return true;
}

static bool is_inside(point q, point a, point b, point c)
{
    return turn(a, b, q) >= 0 && turn(b, c, q) >= 0 && turn(c, a, q) >= 0;
}

static bool is_ear(const polygon *p, size_t i)
{
    const uint32_t before = p->left[(i + p->n_left - 1) % p->n_left], at = p->left[i],
                   after = p->left[(i + 1) % p->n_left];
    const point a = p->at[before], b = p->at[at], c = p->at[after];
    if (turn(a, b, c) <= 0)
        return false;
    for (size_t k = 0; k < p->n_left; k++) {
        const uint32_t q = p->left[k];
        const point here = p->at[q];
        const bool corner = q == before || q == at || q == after || (here.x == a.x && here.y == a.y) ||
                            (here.x == b.x && here.y == b.y) || (here.x == c.x && here.y == c.y);
        if (!corner && is_inside(here, a, b, c))
            return false;
    }
    return true;
}

/* False where no ear was left, so that some triangles turn back. c: of coordinates, NULL: there are none. */
static bool cut(uint32_t *t, uint32_t *c, polygon *p)
{
    bool right = true;
    size_t at = 0;
    for (size_t i = 0; i < p->n; i++)
        p->left[i] = (uint32_t)i;
    for (p->n_left = p->n; p->n_left > 2; t += 3) {
        size_t tried = 0;
        while (tried < p->n_left && !is_ear(p, (at + tried) % p->n_left))
            tried++;
        right = right && (tried < p->n_left || p->n_left == 3);
        at = (at + tried) % p->n_left;
        for (size_t k = 0; k < 3; k++) {
            const uint32_t of = p->left[(at + p->n_left + k - 1) % p->n_left];
            t[k] = p->corner[of];
            if (c)
                c[k] = p->coordinate[of];
        }
        if (c)
            c += 3;
        memmove(p->left + at, p->left + at + 1, (p->n_left - at - 1) * sizeof *p->left);
        p->n_left--;
        at = at < p->n_left ? at : 0;
    }
    return right;
}

vv_status vvi_mesh_cut_fans(size_t *n_bad_out, vvi_mesh_builder *b)
{
    *n_bad_out = 0;
    if (b->n_fans == 0)
        return VV_OK;
    const size_t bytes = CORNERS_MOST * (sizeof(point) + 3 * sizeof(uint32_t));
    point *room = vvi_alloc(b->job, bytes, VVI_MEM_SCRATCH);
    if (!room)
        return vv_fail_memory(bytes);
    polygon p = {.at = room, .corner = (uint32_t *)(room + CORNERS_MOST)};
    p.left = p.corner + CORNERS_MOST;
    p.coordinate = p.left + CORNERS_MOST;
    for (size_t i = 0; i < b->n_fans; i++) {
        const size_t first = b->fans[i].first_triangle;
        uint32_t *t = b->arrays.triangles + 3 * first;
        uint32_t *c = b->arrays.coordinate_of ? b->arrays.coordinate_of + 3 * first : NULL;
        p.n = b->fans[i].n;
        if (p.n > CORNERS_MOST) {
            ++*n_bad_out;
            continue;
        }
        corners_of_fan(p.corner, t, p.n);
        if (c)
            corners_of_fan(p.coordinate, c, p.n);
        project(&p, b->arrays.positions);
        if (!fan_is_right(&p))
            *n_bad_out += !cut(t, c, &p);
    }
    vvi_free(room);
    return VV_OK;
}
