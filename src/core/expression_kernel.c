#include "core/expression_kernel.h"
#include "core/simd.h"

/* Blocks have a fixed length: the compiler makes vectors of these loops, and no fused arithmetic (-ffp-contract=off).
 */
#define ROW_OP(name, operands, value) ROW_OP_##operands(name, value)
#define ROW_OP_1(name, value) ROW_LOOP(name, a = as[at + i], value)
#define ROW_OP_2(name, value) ROW_LOOP(name, a = as[at + i] COMMA b = bs[at + i], value)
#define ROW_OP_3(name, value) ROW_LOOP(name, a = as[at + i] COMMA b = bs[at + i] COMMA c = cs[at + i], value)
#define COMMA ,
#define ROW_LOOP(name, operands, value)                                                                                \
    static void row_##name(double *restrict out, const double *as, const double *bs, const double *cs, size_t n)       \
    {                                                                                                                  \
        for (size_t at = 0; at < n; at += VVI_EXPRESSION_BLOCK)                                                        \
            for (size_t i = 0; i < VVI_EXPRESSION_BLOCK; i++) {                                                        \
                const double operands;                                                                                 \
                out[at + i] = (value);                                                                                 \
            }                                                                                                          \
    }
VVI_EXPRESSION_OPS(ROW_OP)

#define ROW_NAME(name, operands, value) [VVI_OP_##name] = row_##name,
const vvi_expression_kernels VV_KERNEL_TABLE(vvi_expression_kernels) = {
    .isa = VV_ISA_NAME,
    .needs = VV_ISA_NEEDS,
    .ops = {VVI_EXPRESSION_OPS(ROW_NAME)},
};
