/* What a formula may name without being told: functions and constants. */
#include "core/expression_kernel.h"

#include <math.h>
#include <string.h>

static const vvi_expression_call calls[] = {
    {"abs", VVI_OP_ABS, 1, 1, "without its sign"},
    {"acos", VVI_OP_ACOS, 1, 1, "angle of a cosine, in radians"},
    {"asin", VVI_OP_ASIN, 1, 1, "angle of a sine, in radians"},
    {"atan", VVI_OP_ATAN, 1, 1, "angle of a tangent, in radians"},
    {"atan2", VVI_OP_ATAN2, 2, 2, "atan2(y, x): angle of a point, in radians"},
    {"ceil", VVI_OP_CEIL, 1, 1, "the whole number above"},
    {"clamp", VVI_OP_CLAMP, 3, 3, "clamp(v, lo, hi): v, or the end that it is beyond"},
    {"cos", VVI_OP_COS, 1, 1, "cosine of radians"},
    {"exp", VVI_OP_EXP, 1, 1, "e to the power of"},
    {"floor", VVI_OP_FLOOR, 1, 1, "the whole number below"},
    {"hypot", VVI_OP_HYPOT, 2, 2, "hypot(a, b): sqrt(a*a + b*b)"},
    {"isnan", VVI_OP_ISNAN, 1, 1, "1 where a value is missing, else 0"},
    {"log", VVI_OP_LOG, 1, 1, "natural logarithm"},
    {"log10", VVI_OP_LOG10, 1, 1, "logarithm to base 10"},
    {"log2", VVI_OP_LOG2, 1, 1, "logarithm to base 2"},
    {"max", VVI_OP_MAX, 2, 0, "the largest of two or more"},
    {"min", VVI_OP_MIN, 2, 0, "the smallest of two or more"},
    {"pow", VVI_OP_POWER, 2, 2, "pow(a, b): a^b"},
    {"round", VVI_OP_ROUND, 1, 1, "the nearest whole number; halves go away from 0"},
    {"sign", VVI_OP_SIGN, 1, 1, "-1, 0 or 1"},
    {"sin", VVI_OP_SIN, 1, 1, "sine of radians"},
    {"sqrt", VVI_OP_SQRT, 1, 1, "square root"},
    {"tan", VVI_OP_TAN, 1, 1, "tangent of radians"},
    {"where", VVI_OP_WHERE, 3, 3, "where(c, a, b): c ? a : b"},
};

static const struct {
    const char *name;
    double value;
} constants[] = {{"inf", INFINITY}, {"nan", NAN}, {"pi", 3.14159265358979323846}};

const char *vvi_expression_constant(size_t index, double *value_out)
{
    if (index >= sizeof constants / sizeof constants[0])
        return NULL;
    *value_out = constants[index].value;
    return constants[index].name;
}

const char *vvi_expression_function(size_t index, const char **doc_out)
{
    if (index >= sizeof calls / sizeof calls[0])
        return NULL;
    *doc_out = calls[index].doc;
    return calls[index].name;
}

const vvi_expression_call *vvi_expression_call_of(const char *name)
{
    for (size_t i = 0; i < sizeof calls / sizeof calls[0]; i++)
        if (strcmp(calls[i].name, name) == 0)
            return &calls[i];
    return NULL;
}
