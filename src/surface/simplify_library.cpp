// All that we know of meshoptimizer. It is C++ inside, and the only thing it throws is that memory is short: no
// exception leaves this file.
#include "simplify_library.h"

#include <meshoptimizer.h>
#include <new>

extern "C" bool vvi_simplify_with_library(vvi_simplify_call *c)
{
    try {
        const size_t stride = 3 * sizeof(float);
        const double scale = meshopt_simplifyScale(c->positions, c->n_vertices, stride);
        const double largest = 1e9; // of errors relative to the mesh's size
        const double wanted = scale > 0 && c->error < largest * scale ? c->error / scale : largest;
        const unsigned options = c->fix_border ? unsigned(meshopt_SimplifyLockBorder) : 0u;
        float reached = 0;
        c->n_out = meshopt_simplify(c->out, c->indices, c->n_indices, c->positions, c->n_vertices, stride,
                                    c->target_indices, static_cast<float>(wanted), options, &reached);
        c->error_out = static_cast<double>(reached) * scale;
        return true;
    } catch (const std::bad_alloc &) {
        return false;
    }
}

extern "C" const char *vvi_meshoptimizer_version(void)
{
    static const char text[] = {'0' + MESHOPTIMIZER_VERSION / 1000, '.', '0' + MESHOPTIMIZER_VERSION / 100 % 10,
                                '0' + MESHOPTIMIZER_VERSION / 10 % 10, 0};
    return text;
}
