/* Running the programs of expressions: which kernels, and the rows that they work on. */
#include "core/expression.h"
#include "config.h"
#include "core/cpu.h"
#include "core/expression_kernel.h"
#include "core/memory.h"
#include "core/status.h"

#ifdef VV_HAVE_AVX512
extern const vvi_expression_kernels vvi_expression_kernels_avx512;
#endif
#ifdef VV_HAVE_AVX2
extern const vvi_expression_kernels vvi_expression_kernels_avx2;
#endif
extern const vvi_expression_kernels vvi_expression_kernels_base;

static const vvi_expression_kernels *const builds[] = {/* best first; the last always runs */
#ifdef VV_HAVE_AVX512
                                                       &vvi_expression_kernels_avx512,
#endif
#ifdef VV_HAVE_AVX2
                                                       &vvi_expression_kernels_avx2,
#endif
                                                       &vvi_expression_kernels_base};
enum { BUILDS = sizeof builds / sizeof builds[0] };

const vvi_expression_kernels *vvi_expression_kernels_for(uint32_t cpu)
{
    for (size_t i = 0; i < BUILDS; i++)
        if ((builds[i]->needs & ~cpu) == 0)
            return builds[i];
    return builds[BUILDS - 1];
}

const vvi_expression_kernels *vvi_expression_kernels_nth(size_t index)
{
    return index < BUILDS ? builds[index] : NULL;
}

#define OPERANDS(name, operands, value) [VVI_OP_##name] = operands,
int vvi_expression_operands(vvi_expression_op op)
{
    static const int of_op[] = {VVI_EXPRESSION_OPS(OPERANDS)};
    return of_op[op];
}

bool vvi_expression_uses(const vvi_expression *expression, size_t name)
{
    return name < VVI_EXPRESSION_NAMES && (expression->used >> name & 1);
}

struct vvi_expression_rows {
    const vvi_expression *expression;
    const vvi_expression_kernels *kernels;
    double *rows[VVI_EXPRESSION_ROWS]; /* NULL: not used */
    double *all;
};

/* The rows that the program names, in one block. */
static size_t lay_out(vvi_expression_rows *r, double *all)
{
    const vvi_expression *e = r->expression;
    size_t n = 0;
    for (size_t i = 0; i < VVI_EXPRESSION_ROWS; i++) {
        const bool named = vvi_expression_uses(e, i);
        const bool constant =
            i >= VVI_EXPRESSION_FIRST_CONSTANT && i < VVI_EXPRESSION_FIRST_CONSTANT + (size_t)e->n_constants;
        const bool between =
            i >= VVI_EXPRESSION_FIRST_BETWEEN && i < VVI_EXPRESSION_FIRST_BETWEEN + (size_t)e->n_between;
        if ((named || constant || between) && all)
            r->rows[i] = all + n * VVI_EXPRESSION_ROW;
        n += named || constant || between;
    }
    return n;
}

vv_status vvi_expression_rows_new(vvi_expression_rows **out, const vvi_expression *expression, vv_job *job)
{
    *out = NULL;
    vvi_expression_rows *r = vvi_alloc_zeroed(job, sizeof *r, VVI_MEM_SCRATCH);
    if (!r)
        return vv_fail_memory(sizeof *r);
    r->expression = expression;
    r->kernels = vvi_expression_kernels_for(vvi_job_cpu(job));
    const size_t bytes = lay_out(r, NULL) * VVI_EXPRESSION_ROW * sizeof(double);
    r->all = vvi_alloc_zeroed(job, bytes, VVI_MEM_SCRATCH);
    if (!r->all) {
        vvi_free(r);
        return vv_fail_memory(bytes);
    }
    lay_out(r, r->all);
    for (int c = 0; c < expression->n_constants; c++)
        for (int i = 0; i < VVI_EXPRESSION_ROW; i++)
            r->rows[VVI_EXPRESSION_FIRST_CONSTANT + c][i] = expression->constants[c];
    *out = r;
    return VV_OK;
}

void vvi_expression_rows_free(vvi_expression_rows *rows)
{
    if (!rows)
        return;
    vvi_free(rows->all);
    vvi_free(rows);
}

double *vvi_expression_row(vvi_expression_rows *rows, size_t name)
{
    return name < VVI_EXPRESSION_NAMES ? rows->rows[name] : NULL;
}

const double *vvi_expression_run(vvi_expression_rows *rows, size_t n)
{
    const size_t all = (n + VVI_EXPRESSION_BLOCK - 1) / VVI_EXPRESSION_BLOCK * VVI_EXPRESSION_BLOCK;
    const vvi_expression *e = rows->expression;
    for (int i = 0; i < e->n_steps; i++) {
        const vvi_expression_step *s = &e->steps[i];
        rows->kernels->ops[s->op](rows->rows[s->out], rows->rows[s->in[0]], rows->rows[s->in[1]], rows->rows[s->in[2]],
                                  all);
    }
    return rows->rows[e->result];
}
