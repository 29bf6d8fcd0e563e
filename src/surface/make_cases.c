/* Writes the table of cases of Marching Cubes as C to the file that is named: see cases.h.
 *
 * A face is walked clockwise, seen from outside; where the walk leaves the inside a segment of the surface begins, and
 * it ends where the walk comes in again. On a face with four crossings it ends either before the corner that was just
 * left (the corners inside are apart) or before the next one (they are joined). Every crossed edge is on two faces, so
 * the segments chain into loops. A loop is cut into triangles by diagonals whose ends lie on no common face: such a
 * diagonal could be an edge of the neighbour's triangles too. Where that cannot be, the triangles meet in a vertex
 * inside the cell. Lorensen & Cline 1987; the decision on faces: Nielson & Hamann 1991. */
#include "cases.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { EDGES = 12, FACES = 6 };

static int edge_corner[EDGES][2]; /* lower, higher */
static int face_corner[FACES][4];
static int edge_of[8][8]; /* between two corners; -1: none */
static int edge_faces[EDGES];

static void make_edges(void)
{
    memset(edge_of, -1, sizeof edge_of);
    for (int e = 0; e < EDGES; e++) {
        const int axis = e / 4, b = axis == 0 ? 1 : 0, c = axis == 2 ? 1 : 2;
        const int low = (e & 1) << b | (e >> 1 & 1) << c;
        edge_corner[e][0] = low;
        edge_corner[e][1] = low | 1 << axis;
        edge_of[low][low | 1 << axis] = edge_of[low | 1 << axis][low] = e;
        edge_faces[e] = 1 << (2 * b + (e & 1)) | 1 << (2 * c + (e >> 1 & 1));
    }
}

static void make_faces(void)
{
    for (int f = 0; f < FACES; f++) {
        const int a = f / 2, b = (a + 1) % 3, c = (a + 2) % 3, side = (f & 1) << a;
        const int order[4] = {0, 1 << b, 1 << b | 1 << c, 1 << c};
        for (int i = 0; i < 4; i++)
            face_corner[f][i] = side | order[f & 1 ? 3 - i : i];
    }
}

static bool inside(int pattern, int corner)
{
    return pattern >> corner & 1;
}

static bool is_ambiguous(int pattern, int f)
{
    const int *c = face_corner[f];
    return inside(pattern, c[0]) == inside(pattern, c[2]) && inside(pattern, c[1]) == inside(pattern, c[3]) &&
           inside(pattern, c[0]) != inside(pattern, c[1]);
}

/* next[e]: the edge at which the segment that begins on e ends. */
static void make_segments(int next[EDGES], int pattern, int joined)
{
    for (int e = 0; e < EDGES; e++)
        next[e] = -1;
    for (int f = 0; f < FACES; f++)
        for (int i = 0; i < 4; i++) {
            const int *c = face_corner[f];
            if (!inside(pattern, c[i]) || inside(pattern, c[(i + 1) & 3]))
                continue;
            const int step = joined >> f & 1 ? 1 : 3; /* to the next way in, or back to the last one */
            int k = joined >> f & 1 ? i + 1 : i + 3;
            while (inside(pattern, c[k & 3]) || !inside(pattern, c[(k + 1) & 3]))
                k += step;
            next[edge_of[c[i]][c[(i + 1) & 3]]] = edge_of[c[k & 3]][c[(k + 1) & 3]];
        }
}

static double area(const int e[3])
{
    double p[3][3];
    for (int i = 0; i < 3; i++)
        for (int a = 0; a < 3; a++)
            p[i][a] = 0.5 * ((edge_corner[e[i]][0] >> a & 1) + (edge_corner[e[i]][1] >> a & 1));
    double sum = 0;
    for (int a = 0; a < 3; a++) {
        const int b = (a + 1) % 3, c = (a + 2) % 3;
        const double x = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
        sum += x * x;
    }
    return 0.5 * sqrt(sum);
}

/* The cheapest triangles of a polygon, by its pieces from i to j (dynamic programming). */
typedef struct polygon {
    int n, edge[EDGES];
    double cost[EDGES][EDGES];
    int middle[EDGES][EDGES];
} polygon;

static bool legal(const polygon *p, int i, int j)
{
    const bool side = j == i + 1 || (i == 0 && j == p->n - 1);
    return side || !(edge_faces[p->edge[i]] & edge_faces[p->edge[j]]);
}

static bool triangulate(polygon *p)
{
    for (int span = 1; span < p->n; span++)
        for (int i = 0; i + span < p->n; i++) {
            const int j = i + span;
            p->cost[i][j] = span == 1 ? 0 : INFINITY;
            for (int k = i + 1; k < j && legal(p, i, j); k++) {
                const double cost = p->cost[i][k] + p->cost[k][j] + area((int[3]){p->edge[i], p->edge[k], p->edge[j]});
                if (cost < p->cost[i][j] - 1e-9) {
                    p->cost[i][j] = cost;
                    p->middle[i][j] = k;
                }
            }
        }
    return p->cost[0][p->n - 1] < INFINITY;
}

static void add_triangle(vvi_case *c, int a, int b, int d)
{
    uint8_t *t = c->triangle + 3 * c->n_triangles;
    t[0] = (uint8_t)a;
    t[1] = (uint8_t)b;
    t[2] = (uint8_t)d;
    c->loop[c->n_triangles++] = c->n_loops;
}

static void add_piece(vvi_case *c, const polygon *p, int i, int j)
{
    if (j < i + 2)
        return;
    const int k = p->middle[i][j];
    add_piece(c, p, i, k);
    add_triangle(c, p->edge[i], p->edge[k], p->edge[j]);
    add_piece(c, p, k, j);
}

static void add_loop(vvi_case *c, polygon *p)
{
    for (int i = 0; i < p->n; i++)
        c->faces[c->n_loops] |= (uint8_t)(edge_faces[p->edge[i]] & edge_faces[p->edge[(i + 1) % p->n]]);
    if (triangulate(p)) {
        add_piece(c, p, 0, p->n - 1);
    } else {
        for (int i = 0; i < p->n; i++) {
            add_triangle(c, p->edge[i], p->edge[(i + 1) % p->n], EDGES + c->n_interior);
            c->around[c->n_interior] |= (uint16_t)(1 << p->edge[i]);
        }
        c->n_interior++;
    }
    c->n_loops++;
}

static vvi_case make_case(int pattern, int joined)
{
    vvi_case c = {0};
    int next[EDGES];
    make_segments(next, pattern, joined);
    for (int e = 0; e < EDGES; e++)
        if (next[e] >= 0)
            c.edges |= (uint16_t)(1 << e);
    for (int first = 0; first < EDGES; first++) {
        polygon p = {0};
        for (int e = first; next[e] >= 0;) {
            const int to = next[e];
            p.edge[p.n++] = e;
            next[e] = -1;
            e = to;
        }
        if (p.n)
            add_loop(&c, &p);
    }
    return c;
}

static void print_bytes(FILE *out, const char *name, const uint8_t *bytes, int n)
{
    fprintf(out, ".%s = {", name);
    for (int i = 0; i < n; i++)
        fprintf(out, "%s%d", i ? "," : "", bytes[i]);
    fprintf(out, "}, ");
}

static void print_case(FILE *out, const vvi_case *c)
{
    fprintf(out, "    {.edges = %d, .n_triangles = %d, .n_interior = %d, .n_loops = %d, ", c->edges, c->n_triangles,
            c->n_interior, c->n_loops);
    print_bytes(out, "triangle", c->triangle, c->n_triangles ? 3 * c->n_triangles : 1);
    print_bytes(out, "loop", c->loop, c->n_triangles ? c->n_triangles : 1);
    print_bytes(out, "faces", c->faces, VVI_CASE_LOOPS);
    fprintf(out, ".around = {%d}},\n", c->around[0]);
}

static void print_quick(FILE *out, const vvi_case *c)
{
    static const int before[EDGES] = {-1, -1, -1, -1, -1, 4, -1, 6, -1, 8, -1, 10}; /* edge with the same counter */
    static const int counted[8] = {0, 1, 2, 3, 4, 6, 8, 10};                        /* edge that moves a counter on */
    uint8_t ahead[16] = {0}, step[8];
    for (int e = 0; e < EDGES; e++)
        ahead[e] = before[e] >= 0 && c->edges >> before[e] & 1;
    for (int i = 0; i < 8; i++)
        step[i] = c->edges >> counted[i] & 1;
    fprintf(out, "    {");
    print_bytes(out, "triangle", c->triangle, 15);
    print_bytes(out, "ahead", ahead, 16);
    print_bytes(out, "step", step, 8);
    fprintf(out, ".n_triangles = %d, .n_interior = %d},\n", c->n_triangles, c->n_interior);
}

static int ambiguous_faces(int pattern)
{
    int faces = 0;
    for (int f = 0; f < FACES; f++)
        faces |= is_ambiguous(pattern, f) << f;
    return faces;
}

/* The bits of `decision` at the places of the bits of `faces`. */
static int spread(int decision, int faces)
{
    int joined = 0;
    for (int f = 0, bit = 0; f < FACES; f++)
        if (faces >> f & 1)
            joined |= (decision >> bit++ & 1) << f;
    return joined;
}

typedef void print_fn(FILE *out, const vvi_case *c);

static int print_cases(FILE *out, int first[256], print_fn *print)
{
    int n = 0;
    for (int pattern = 0; pattern < 256; pattern++) {
        const int faces = ambiguous_faces(pattern), decisions = 1 << __builtin_popcount((unsigned)faces);
        first[pattern] = n;
        for (int d = 0; d < decisions; d++, n++) {
            const vvi_case c = make_case(pattern, spread(d, faces));
            print(out, &c);
        }
    }
    fprintf(out, "};\n");
    return n;
}

int main(int argc, char **argv)
{
    int first[256];
    FILE *out = argc == 2 ? fopen(argv[1], "w") : NULL;
    if (!out) {
        fprintf(stderr, "usage: make_cases FILE.c\n");
        return 2;
    }
    make_edges();
    make_faces();
    fprintf(out,
            "/* Made by make_cases.c. */\n#include \"surface/cases.h\"\n\nconst vvi_case vvi_cases[VVI_CASES] = {\n");
    const int n = print_cases(out, first, print_case);
    fprintf(out, "const vvi_case_quick vvi_cases_quick[VVI_CASES] = {\n");
    print_cases(out, first, print_quick);
    fprintf(out, "const uint16_t vvi_case_first[256] = {");
    for (int p = 0; p < 256; p++)
        fprintf(out, "%s%d", p ? "," : "", first[p]);
    fprintf(out, "};\nconst uint8_t vvi_case_ambiguous[256] = {");
    for (int p = 0; p < 256; p++)
        fprintf(out, "%s%d", p ? "," : "", ambiguous_faces(p));
    fprintf(out, "};\nconst uint8_t vvi_case_triangles[256] = {");
    for (int p = 0; p < 256; p++) {
        const vvi_case c = make_case(p, 0);
        const bool one = !ambiguous_faces(p) && !c.n_interior;
        fprintf(out, "%s%d", p ? "," : "", one ? c.n_triangles : VVI_CASE_AMBIGUOUS);
    }
    fprintf(out, "};\nconst uint8_t vvi_face_corners[6][4] = {");
    for (int f = 0; f < FACES; f++)
        fprintf(out, "%s{%d,%d,%d,%d}", f ? "," : "", face_corner[f][0], face_corner[f][1], face_corner[f][2],
                face_corner[f][3]);
    fprintf(out, "};\n");
    return fclose(out) == 0 && n == VVI_CASES ? 0 : 1;
}
