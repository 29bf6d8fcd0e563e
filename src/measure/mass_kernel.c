#include "measure/mass_kernel.h"
#include "core/simd.h"

/* Eight triangles at a time, whatever the machine has: the compiler makes of a vector what it can. */
enum { LANES = 8 };
typedef double vd __attribute__((vector_size(64)));
typedef float vf8 __attribute__((vector_size(32)));
typedef uint32_t vi8 __attribute__((vector_size(32)));
typedef uint64_t vu __attribute__((vector_size(64)));
typedef int64_t vs __attribute__((vector_size(64)));

typedef struct vec {
    vd x, y, z;
} vec;

VV_INLINE vd sqrt8(vd a)
{
#if defined(VV_ISA_AVX512)
    return (vd)_mm512_sqrt_pd((__m512d)a);
#else
    vd r;
    for (int l = 0; l < LANES; l++)
        r[l] = sqrt(a[l]);
    return r;
#endif
}

VV_INLINE vd abs8(vd a)
{
    return (vd)((vs)a & 0x7fffffffffffffff);
}

VV_INLINE vd min8(vd a, vd b)
{
    const vs less = a < b;
    return (vd)((less & (vs)a) | (~less & (vs)b));
}

VV_INLINE vec minus(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}

VV_INLINE vec plus(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}

VV_INLINE vd dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

VV_INLINE vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/* One corner of eight triangles: its vertices, and what an array of three floats a vertex has there. */
VV_INLINE vi8 corner_of(const uint32_t *triangles, int corner)
{
    vi8 v;
    for (int l = 0; l < LANES; l++)
        v[l] = triangles[3 * l + corner];
    return v;
}

VV_INLINE vec gather(const float *from, vi8 vertex)
{
    vf8 x, y, z;
    for (int l = 0; l < LANES; l++) {
        const float *p = from + 3 * (size_t)vertex[l];
        x[l] = p[0];
        y[l] = p[1];
        z[l] = p[2];
    }
    return (vec){__builtin_convertvector(x, vd), __builtin_convertvector(y, vd), __builtin_convertvector(z, vd)};
}

VV_INLINE vec centered(vec p, const vvi_mass_block *b)
{
    return (vec){p.x - b->center[0], p.y - b->center[1], p.z - b->center[2]};
}

VV_INLINE vec map(vec p, const double m[3][3])
{
    return (vec){m[0][0] * p.x + m[0][1] * p.y + m[0][2] * p.z, m[1][0] * p.x + m[1][1] * p.y + m[1][2] * p.z,
                 m[2][0] * p.x + m[2][1] * p.y + m[2][2] * p.z};
}

/* The numbers of the edges from one corner to another: negative backwards, 0 from a vertex to itself. */
VV_INLINE vu edges_between(vi8 from8, vi8 to8)
{
    const vu from = __builtin_convertvector(from8, vu), to = __builtin_convertvector(to8, vu);
    const vu backward = (vu)((vs)from > (vs)to), there = (vu)(from != to);
    vu z = (~backward & (from << 32 | to)) | (backward & (to << 32 | from));
    z += 0x9e3779b97f4a7c15u; /* the finalizer of splitmix64 */
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    z ^= z >> 31;
    return ((z ^ backward) - backward) & there;
}

/* What lies between triangles and the surface that their normals tell of. a, b, c: the sides opposite to the corners,
 * before the linear map; qa, qb, qc: second derivatives of the surface's height along them, times their squared
 * lengths; after the map by `scale`. E: the sides after it; n: twice the area. r: distance of the triangle from the
 * center. */
typedef struct chords {
    vd volume, area, offset;
} chords;

VV_INLINE chords between(vd qa, vd qb, vd qc, vec ea, vec eb, vec ec, vd n)
{
    /* The height is g = 1/2 (qa Lb Lc + qb Lc La + qc La Lb), L the barycentric coordinates: its integral, half that of
     * its squared gradient, and its Laplacian (the sum of the curvatures) follow from theirs. */
    const vd quarter = 1 / (2 * n + 1e-300); /* 1 / (4 A) */
    const vd aa = dot(ea, ea), bb = dot(eb, eb), cc = dot(ec, ec);
    const vd ab = dot(ea, eb), bc = dot(eb, ec), ca = dot(ec, ea);
    const vd square = qa * qa * (bb + cc + bc) + qb * qb * (cc + aa + ca) + qc * qc * (aa + bb + ab) +
                      2 * (qa * qb * ab + qb * qc * bc + qc * qa * ca);
    const vd curvature = abs8(qa * bc + qb * ca + qc * ab) * quarter; /* times the area */
    const vd height = (abs8(qa) + abs8(qb) + abs8(qc)) * (1 / 24.0);
    chords out;
    out.volume = height * n * 0.5;
    out.area = min8(abs8(square) * quarter * (1 / 48.0), n * 0.5); /* slivers have wild normals: no more than all */
    out.offset = min8(curvature * height, n * 0.5);
    return out;
}

VV_INLINE void add(vd sums[VVI_MASS_SUMS], vu *edges, const vvi_mass_block *block, const uint32_t *triangles,
                   bool mapped, bool curved)
{
    const vi8 ia = corner_of(triangles, 0), ib = corner_of(triangles, 1), ic = corner_of(triangles, 2);
    vec a = centered(gather(block->positions, ia), block), b = centered(gather(block->positions, ib), block),
        c = centered(gather(block->positions, ic), block);
    vd qa = {0}, qb = qa, qc = qa, before = qa;
    if (curved) {
        const vec na = gather(block->normals, ia), nb = gather(block->normals, ib), nc = gather(block->normals, ic);
        qa = dot(minus(nc, nb), minus(c, b));
        qb = dot(minus(na, nc), minus(a, c));
        qc = dot(minus(nb, na), minus(b, a));
        if (mapped) {
            const vec cut = cross(minus(b, a), minus(c, a));
            before = sqrt8(dot(cut, cut));
        }
    }
    if (mapped) {
        a = map(a, block->matrix);
        b = map(b, block->matrix);
        c = map(c, block->matrix);
    }
    const vec ea = minus(c, b), eb = minus(a, c), ec = minus(b, a);
    const vec cut = cross(ec, minus(c, a));
    const vd twice = sqrt8(dot(cut, cut));
    const vd six = dot(a, cut);
    const vec s = plus(plus(a, b), c);
    *edges += edges_between(ia, ib) + edges_between(ib, ic) + edges_between(ic, ia);
    sums[VVI_MASS_AREA] += twice;
    sums[VVI_MASS_PERIMETER] += sqrt8(3 * (dot(ea, ea) + dot(eb, eb) + dot(ec, ec)));
    sums[VVI_MASS_VOLUME] += six;
    sums[VVI_MASS_FIRST] += six * s.x;
    sums[VVI_MASS_FIRST + 1] += six * s.y;
    sums[VVI_MASS_FIRST + 2] += six * s.z;
    sums[VVI_MASS_SECOND] += six * (s.x * s.x + a.x * a.x + b.x * b.x + c.x * c.x);
    sums[VVI_MASS_SECOND + 1] += six * (s.y * s.y + a.y * a.y + b.y * b.y + c.y * c.y);
    sums[VVI_MASS_SECOND + 2] += six * (s.z * s.z + a.z * a.z + b.z * b.z + c.z * c.z);
    sums[VVI_MASS_SECOND + 3] += six * (s.x * s.y + a.x * a.y + b.x * b.y + c.x * c.y);
    sums[VVI_MASS_SECOND + 4] += six * (s.x * s.z + a.x * a.z + b.x * b.z + c.x * c.z);
    sums[VVI_MASS_SECOND + 5] += six * (s.y * s.z + a.y * a.z + b.y * b.z + c.y * c.z);
    if (!curved)
        return;
    if (mapped) { /* a height h along the normal becomes h det / |cofactors normal|: by the areas */
        const vd scale = block->determinant * before / (twice + 1e-300);
        qa *= scale;
        qb *= scale;
        qc *= scale;
    }
    const chords k = between(qa, qb, qc, ea, eb, ec, twice);
    const vd rr = dot(s, s) * (1 / 9.0);
    sums[VVI_MASS_CHORD] += k.volume;
    sums[VVI_MASS_CHORD_R] += k.volume * sqrt8(rr);
    sums[VVI_MASS_CHORD_RR] += k.volume * rr;
    sums[VVI_MASS_CHORD_AREA] += k.area;
    sums[VVI_MASS_OFFSET_AREA] += k.offset;
}

VV_INLINE void add_all(double out[VVI_MASS_SUMS], uint64_t *edges, const vvi_mass_block *block, bool mapped,
                       bool curved)
{
    vd sums[VVI_MASS_SUMS] = {0};
    vu hashed = {0};
    const uint32_t *t = block->triangles;
    for (size_t i = 0; i < block->n / LANES; i++, t += 3 * LANES)
        add(sums, &hashed, block, t, mapped, curved);
    if (block->n % LANES) { /* filled up with triangles of one vertex, which have no area and no edge */
        uint32_t rest[3 * LANES];
        for (size_t i = 0; i < 3 * LANES; i++)
            rest[i] = t[i < 3 * (block->n % LANES) ? i : 0];
        add(sums, &hashed, block, rest, mapped, curved);
    }
    for (int i = 0; i < VVI_MASS_SUMS; i++) {
        out[i] = 0;
        for (int l = 0; l < LANES; l++)
            out[i] += sums[i][l];
    }
    for (int l = 0; l < LANES; l++)
        *edges += hashed[l];
}

static void sum(double sums[VVI_MASS_SUMS], uint64_t *edges, const vvi_mass_block *block)
{
    const double(*const m)[3] = block->matrix;
    const bool mapped = m[0][0] != 1 || m[1][1] != 1 || m[2][2] != 1 || m[0][1] != 0 || m[0][2] != 0 || m[1][0] != 0 ||
                        m[1][2] != 0 || m[2][0] != 0 || m[2][1] != 0;
    if (mapped)
        add_all(sums, edges, block, true, block->normals != NULL);
    else if (block->normals)
        add_all(sums, edges, block, false, true);
    else
        add_all(sums, edges, block, false, false);
}

const vvi_mass_kernels VV_KERNEL_TABLE(vvi_mass_kernels) = {
    .needs = VV_ISA_NEEDS,
    .isa = VV_ISA_NAME,
    .sum = sum,
};
