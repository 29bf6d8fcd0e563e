/* Gaussian smoothing in double precision: for 32- and 64-bit integers and doubles. */
#define REAL double
#define NAME(x) x##_f64
#include "filter/gaussian_body.h"

size_t vvi_gaussian_slice_room(int64_t nx, int64_t ny, int components, const vvi_gaussian_weights *x)
{
    return (size_t)((nx + 2 * x->radius + nx * ny) * components);
}
