/** @file
 * What programs of expressions do to rows, and the programs themselves.
 */
#ifndef VVI_CORE_EXPRESSION_KERNEL_H
#define VVI_CORE_EXPRESSION_KERNEL_H
#include "core/expression.h"

/** Name, number of operands, value of a, b and c. NaN of one operand of min and max is NaN of both: what is missing
 * stays so. */
#define VVI_EXPRESSION_OPS(X)                                                                                          \
    X(ADD, 2, a + b)                                                                                                   \
    X(SUBTRACT, 2, a - b)                                                                                              \
    X(MULTIPLY, 2, a *b)                                                                                               \
    X(DIVIDE, 2, a / b)                                                                                                \
    X(REMAINDER, 2, fmod(a, b))                                                                                        \
    X(POWER, 2, pow(a, b))                                                                                             \
    X(LESS, 2, a < b ? 1.0 : 0.0)                                                                                      \
    X(LESS_EQUAL, 2, a <= b ? 1.0 : 0.0)                                                                               \
    X(EQUAL, 2, a == b ? 1.0 : 0.0)                                                                                    \
    X(NOT_EQUAL, 2, a != b ? 1.0 : 0.0)                                                                                \
    X(AND, 2, ((a != 0) & (b != 0)) ? 1.0 : 0.0)                                                                       \
    X(OR, 2, ((a != 0) | (b != 0)) ? 1.0 : 0.0)                                                                        \
    X(NOT, 1, a == 0 ? 1.0 : 0.0)                                                                                      \
    X(NEGATE, 1, -a)                                                                                                   \
    X(WHERE, 3, a != 0 ? b : c)                                                                                        \
    X(MIN, 2, ((a < b) | (a != a)) ? a : b)                                                                            \
    X(MAX, 2, ((a > b) | (a != a)) ? a : b)                                                                            \
    X(CLAMP, 3, (a < b) ? b : (a > c) ? c : a)                                                                         \
    X(ABS, 1, fabs(a))                                                                                                 \
    X(SIGN, 1, a > 0 ? 1.0 : a < 0 ? -1.0 : a)                                                                         \
    X(SQRT, 1, sqrt(a))                                                                                                \
    X(EXP, 1, exp(a))                                                                                                  \
    X(LOG, 1, log(a))                                                                                                  \
    X(LOG2, 1, log2(a))                                                                                                \
    X(LOG10, 1, log10(a))                                                                                              \
    X(SIN, 1, sin(a))                                                                                                  \
    X(COS, 1, cos(a))                                                                                                  \
    X(TAN, 1, tan(a))                                                                                                  \
    X(ASIN, 1, asin(a))                                                                                                \
    X(ACOS, 1, acos(a))                                                                                                \
    X(ATAN, 1, atan(a))                                                                                                \
    X(ATAN2, 2, atan2(a, b))                                                                                           \
    X(HYPOT, 2, hypot(a, b))                                                                                           \
    X(FLOOR, 1, floor(a))                                                                                              \
    X(CEIL, 1, ceil(a))                                                                                                \
    X(ROUND, 1, round(a))                                                                                              \
    X(ISNAN, 1, a != a ? 1.0 : 0.0)

#define VVI_EXPRESSION_ENUM(name, operands, value) VVI_OP_##name,
typedef enum vvi_expression_op { VVI_EXPRESSION_OPS(VVI_EXPRESSION_ENUM) VVI_EXPRESSION_N_OPS } vvi_expression_op;

enum { VVI_EXPRESSION_BLOCK = 64 };
/** n numbers, whole blocks; out is none of the others. */
typedef void vvi_expression_row_op(double *restrict out, const double *a, const double *b, const double *c, size_t n);

typedef struct vvi_expression_kernels {
    const char *isa;
    uint32_t needs; /**< VVI_CPU_* */
    vvi_expression_row_op *ops[VVI_EXPRESSION_N_OPS];
} vvi_expression_kernels;

/** The best that these VVI_CPU_* bits allow. */
const vvi_expression_kernels *vvi_expression_kernels_for(uint32_t cpu);
/** All that this build has, the best first; NULL past the end. */
const vvi_expression_kernels *vvi_expression_kernels_nth(size_t index);
int vvi_expression_operands(vvi_expression_op op);

/** Rows of a program by number: those of names, then constants, then what is between. */
enum {
    VVI_EXPRESSION_NAMES = 64,
    VVI_EXPRESSION_CONSTANTS = 256,
    VVI_EXPRESSION_BETWEEN = 96,
    VVI_EXPRESSION_FIRST_CONSTANT = VVI_EXPRESSION_NAMES,
    VVI_EXPRESSION_FIRST_BETWEEN = VVI_EXPRESSION_FIRST_CONSTANT + VVI_EXPRESSION_CONSTANTS,
    VVI_EXPRESSION_ROWS = VVI_EXPRESSION_FIRST_BETWEEN + VVI_EXPRESSION_BETWEEN,
    VVI_EXPRESSION_STEPS = 2000
};

typedef struct vvi_expression_step {
    uint16_t op, out, in[3];
} vvi_expression_step;

struct vvi_expression {
    uint64_t used; /* names, a bit each */
    double constants[VVI_EXPRESSION_CONSTANTS];
    vvi_expression_step steps[VVI_EXPRESSION_STEPS];
    int n_constants, n_between, n_steps;
    int result; /* the row of it */
};

/** A function of the text by its name; NULL: there is none. `most` 0: as many as one likes. */
typedef struct vvi_expression_call {
    const char *name;
    vvi_expression_op op;
    int least, most;
    const char *doc;
} vvi_expression_call;
const vvi_expression_call *vvi_expression_call_of(const char *name);
#endif
