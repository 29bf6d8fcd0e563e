/* Formulas against the same ones in C, for every operator, function and instruction set; and what is refused. */
#include "core/cpu.h"
#include "core/expression.h"
#include "core/expression_kernel.h"
#include "core/status.h"
#include "fields.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const char *const names[] = {"a", "b", "c"};
static const double some[] = {0,      -0.0,  1,     -1,       2,         0.5, -2.5, 3,
                              1e-300, 1e300, -7.25, INFINITY, -INFINITY, NAN, 100,  0.1};
enum { NAMES = 3, SOME = sizeof some / sizeof some[0] };

static bool same(double x, double y)
{
    return (isnan(x) && isnan(y)) || (x == y && signbit(x) == signbit(y));
}

/* Value number v of name n: all pairs of values appear, and all triples in turn. */
static double value_of(int n, int v)
{
    const int index[NAMES] = {v % SOME, v / SOME % SOME, (v * 7 + v / SOME) % SOME};
    return some[index[n]];
}

static void check(const char *text, double (*expected)(double a, double b, double c))
{
    vvi_expression *e;
    vvi_expression_rows *rows;
    if (vvi_expression_new(&e, text, names, NAMES) != VV_OK)
        fail_msg("%s: %s", text, vv_error_last()->message);
    assert_int_equal(vvi_expression_rows_new(&rows, e, NULL), VV_OK);
    for (size_t n = 0; n < NAMES; n++)
        for (int v = 0; v < VVI_EXPRESSION_ROW && vvi_expression_uses(e, n); v++)
            vvi_expression_row(rows, n)[v] = value_of((int)n, v);
    const double *got = vvi_expression_run(rows, VVI_EXPRESSION_ROW);
    for (int v = 0; v < VVI_EXPRESSION_ROW; v++) {
        const double a = value_of(0, v), b = value_of(1, v), c = value_of(2, v), want = expected(a, b, c);
        if (!same(got[v], want))
            fail_msg("%s with a %g, b %g, c %g is %.17g, not %.17g", text, a, b, c, got[v], want);
    }
    vvi_expression_rows_free(rows);
    vvi_expression_free(e);
}

static double constant(const char *text)
{
    vvi_expression *e;
    vvi_expression_rows *rows;
    if (vvi_expression_new(&e, text, NULL, 0) != VV_OK)
        fail_msg("%s: %s", text, vv_error_last()->message);
    assert_int_equal(vvi_expression_rows_new(&rows, e, NULL), VV_OK);
    const double value = vvi_expression_run(rows, VVI_EXPRESSION_ROW)[VVI_EXPRESSION_ROW - 1];
    vvi_expression_rows_free(rows);
    vvi_expression_free(e);
    return value;
}

/* Each formula means what the same text means in C. */
#define FORMULAS(X)                                                                                                    \
    X("a", a)                                                                                                          \
    X("a - 0.5*b", a - 0.5 * b)                                                                                        \
    X("a - b - c", a - b - c)                                                                                          \
    X("a / b / c", a / b / c)                                                                                          \
    X("a + b * c", a + b * c)                                                                                          \
    X("(a + b) * c", (a + b) * c)                                                                                      \
    X("a % b", fmod(a, b))                                                                                             \
    X("-a * -b", -a * -b)                                                                                              \
    X("+a", a)                                                                                                         \
    X("a^b", pow(a, b))                                                                                                \
    X("pow(a, b)", pow(a, b))                                                                                          \
    X("-a^2", -(a * a))                                                                                                \
    X("a^-b", pow(a, -b))                                                                                              \
    X("a^b^c", pow(a, pow(b, c)))                                                                                      \
    X("a < b", a < b)                                                                                                  \
    X("a <= b", a <= b)                                                                                                \
    X("a > b", a > b)                                                                                                  \
    X("a >= b", a >= b)                                                                                                \
    X("a == b", a == b)                                                                                                \
    X("a != b", a != b)                                                                                                \
    X("a && b", a &&b)                                                                                                 \
    X("a || b", a || b)                                                                                                \
    X("a || b && c", a || (b && c))                                                                                    \
    X("!a", !a)                                                                                                        \
    X("!a == b", (double)!a == b)                                                                                      \
    X("a < b == b > c", (a < b) == (b > c))                                                                            \
    X("a ? b : c", a ? b : c)                                                                                          \
    X("a < b ? b < c ? 1 : 2 : a == b ? 3 : 4", a < b ? b < c ? 1 : 2 : a == b ? 3 : 4)                                \
    X("where(a > b, a, c)", a > b ? a : c)                                                                             \
    X("min(a, b)", isnan(a) || isnan(b) ? NAN : a < b ? a : b)                                                         \
    X("max(a, b)", isnan(a) || isnan(b) ? NAN : a > b ? a : b)                                                         \
    X("min(a, 2, c)", isnan(a) || isnan(c) ? NAN : (a < 2 ? a : 2) < c ? (a < 2 ? a : 2) : c)                          \
    X("clamp(a, -1, 2)", a<-1 ? -1 : a> 2 ? 2 : a)                                                                     \
    X("abs(a)", fabs(a))                                                                                               \
    X("sign(a)", a > 0 ? 1 : a < 0 ? -1 : a)                                                                           \
    X("sqrt(a)", sqrt(a))                                                                                              \
    X("exp(a)", exp(a))                                                                                                \
    X("log(a)", log(a))                                                                                                \
    X("log2(a)", log2(a))                                                                                              \
    X("log10(a)", log10(a))                                                                                            \
    X("sin(a)", sin(a))                                                                                                \
    X("cos(a)", cos(a))                                                                                                \
    X("tan(a)", tan(a))                                                                                                \
    X("asin(a)", asin(a))                                                                                              \
    X("acos(a)", acos(a))                                                                                              \
    X("atan(a)", atan(a))                                                                                              \
    X("atan2(a, b)", atan2(a, b))                                                                                      \
    X("hypot(a, b)", hypot(a, b))                                                                                      \
    X("floor(a)", floor(a))                                                                                            \
    X("ceil(a)", ceil(a))                                                                                              \
    X("round(a)", round(a))                                                                                            \
    X("isnan(a)", isnan(a) ? 1 : 0)                                                                                    \
    X("a + (b - (c * (a / (b + (c - 1)))))", a + (b - (c * (a / (b + (c - 1))))))                                      \
    X("((a*b) + (b*c)) * ((a*c) - (b*b))", ((a * b) + (b * c)) * ((a * c) - (b * b)))

/* One function a formula, by its number. */
static double meaning(int number, double a, double b, double c)
{
    int n = 0;
#define CASE(text, value)                                                                                              \
    if (n++ == number)                                                                                                 \
        return (double)(value);
    FORMULAS(CASE)
    return NAN;
}

static int meant;

static double expected(double a, double b, double c)
{
    return meaning(meant, a, b, c);
}

static void formulas_mean_what_they_mean_in_c(void **state)
{
#define TEXT(text, value) text,
    static const char *const texts[] = {FORMULAS(TEXT)};
    for (meant = 0; meant < (int)(sizeof texts / sizeof texts[0]); meant++)
        check(texts[meant], expected);
}

static void what_is_constant_is_reckoned_at_once(void **state)
{
    static const struct {
        const char *text;
        double value;
    } cases[] = {{"1 + 2 * 3", 7},       {"-2^2", -4},
                 {"2^-1", 0.5},          {"2^3^2", 512},
                 {"1e3 / .5", 2000},     {"10 % 4", 2},
                 {"-7 % 4", -3},         {"!0 + !3", 1},
                 {"nan == nan", 0},      {"1 ? 2 : 3", 2},
                 {"max(1, 2, 3, 4)", 4}, {"hypot(3, 4)", 5},
                 {" ( 1 ) ", 1},         {"round(-2.5)", -3},
                 {"-inf < inf", 1},      {"isnan(min(nan, 1)) + isnan(max(1, nan))", 2}};
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++)
        if (!same(constant(cases[i].text), cases[i].value))
            fail_msg("%s is %.17g", cases[i].text, constant(cases[i].text));
    assert_true(fabs(constant("pi") - acos(-1)) < 1e-15);
    vvi_expression *e;
    assert_int_equal(vvi_expression_new(&e, "a * (1 + 2 * 3) - sqrt(4)", names, NAMES), VV_OK);
    assert_int_equal(e->n_steps, 2);
    assert_true(vvi_expression_uses(e, 0) && !vvi_expression_uses(e, 1) && !vvi_expression_uses(e, 99));
    vvi_expression_free(e);
}

static void refusals_tell_the_column_and_what_was_expected(void **state)
{
    static const struct {
        const char *text, *said;
    } cases[] = {
        {"", "the formula is empty"},
        {"  ", "the formula is empty"},
        {"a +", "column 4: expected a number, a name or '(', found the end"},
        {"a + * b", "column 5: expected a number, a name or '(', found '*'"},
        {"(a + b", "column 1: this '(' has no ')'"},
        {"a b", "column 3: expected an operator, found 'b'"},
        {"2a", "column 2: expected an operator, as in 2*a, found 'a'"},
        {"0x10", "column 2: expected an operator, as in 2*a, found 'x10'"},
        {"1.2.3", "column 4: expected an operator, as in 2*a, found '.'"},
        {"a + .", "column 5: expected a number, found '.'"},
        {"\303\244 + 1", "column 1: expected a number, a name or '(', found '\303\244'"},
        {"'\303\244' ", "column 1: "},
        {"a + \001", "column 5: expected a number, a name or '(', found '?'"},
        {"a + d", "column 5: nothing is called 'd'; there are a, b, c, inf, nan and pi"},
        {"sqr(a)", "column 1: there is no function 'sqr'; did you mean 'sqrt'?"},
        {"a(1)", "column 1: there is no function 'a'"},
        {"1 + sqrt", "column 5: 'sqrt' is a function: its values stand in brackets, as in sqrt(...)"},
        {"sqrt()", "column 1: sqrt takes 1 value in brackets, found 0"},
        {"sqrt(a, b)", "column 1: sqrt takes 1 value in brackets, found 2"},
        {"clamp(a)", "column 1: clamp takes 3 values in brackets, found 1"},
        {"min(a)", "column 1: min takes 2 or more values in brackets, found 1"},
        {"sqrt(a", "column 7: expected an operator, ',' or ')', found the end"},
        {"a ? b", "column 6: expected ':' of a choice, as in a > 0 ? a : 0, found the end"},
        {"a = b", "column 3: 'equal to' is =="},
        {"a & b", "column 3: 'and' is &&, 'or' is ||"},
        {"a ** 2", "column 3: 'to the power of' is ^, as in a^2"},
        {"0 < a < 1", "column 7: comparisons are of two values: write a < b && b < c"},
        {"a $ b", "column 3: expected an operator, found '$'"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
        vvi_expression *e;
        assert_int_equal(vvi_expression_new(&e, cases[i].text, names, NAMES), VV_E_ARGUMENT);
        assert_null(e);
        if (strncmp(vv_error_last()->message, cases[i].said, strlen(cases[i].said)) != 0)
            fail_msg("'%s' is answered with: %s", cases[i].text, vv_error_last()->message);
    }
}

/* `unit` so many times, then `end`. */
static void check_long(const char *begin, const char *unit, int times, const char *end, const char *said)
{
    static char text[20000];
    vvi_expression *e;
    strcpy(text, begin);
    char *at = text + strlen(begin);
    for (int i = 0; i < times; i++, at += strlen(unit))
        strcpy(at, unit);
    strcpy(at, end);
    const vv_status st = vvi_expression_new(&e, text, names, NAMES);
    if (said ? st != VV_E_ARGUMENT || !strstr(vv_error_last()->message, said) : st != VV_OK)
        fail_msg("%d times '%s': %s", times, unit, st == VV_OK ? "taken" : vv_error_last()->message);
    vvi_expression_free(e);
}

static void what_is_too_large_is_refused(void **state)
{
    check_long("", "a+", 1500, "a", NULL);
    check_long("", "a+", 2500, "a", "may have 4000");
    check_long("", "(", 90, "a", "no ')'");
    check_long("", "(", 3000, "a", "nested too deeply");
    check_long("", "-", 3000, "a", "nested too deeply");
    check_long("", "a^", 1900, "a", "nested too deeply");
    check_long("", "a?b:", 900, "a", "nested too deeply");
    check_long("", "a==1?b:", 90, "a", NULL);
    check_long("", "-a+", 1300, "a", "too large");
    check_long("min(a", ",b", 1500, ")", NULL);
    char text[4000] = "a", number[16];
    for (int i = 0; i < 300; i++) {
        snprintf(number, sizeof number, "+a*%d", i);
        strcat(text, number);
    }
    check_long(text, "", 0, "", "256 different numbers");
}

static void names_of_functions_and_constants_are_no_names(void **state)
{
    assert_int_equal(vvi_expression_check_name("a_1"), VV_OK);
    static const char *const bad[] = {"", "1a", "a-b", "sqrt", "pi", "a b", "\303\244"};
    for (size_t i = 0; i < sizeof bad / sizeof bad[0]; i++)
        assert_int_equal(vvi_expression_check_name(bad[i]), VV_E_ARGUMENT);
}

/* The same bits, whatever the vectors: with values of all kinds in every place of a row. */
static void instruction_sets_give_the_same_bits(void **state)
{
    static double rows[3][VVI_EXPRESSION_ROW], want[VVI_EXPRESSION_ROW], got[VVI_EXPRESSION_ROW];
    const vvi_expression_kernels *base = vvi_expression_kernels_for(0), *one;
    const uint32_t has = vvi_job_cpu(NULL);
    for (int n = 0; n < 3; n++)
        for (int v = 0; v < VVI_EXPRESSION_ROW; v++)
            rows[n][v] = v % 2 ? value_of(n, v) : 20 * test_random_unit(5, (uint64_t)(n * 1000 + v)) - 10;
    for (size_t b = 0; (one = vvi_expression_kernels_nth(b)) != NULL; b++)
        for (int op = 0; op < VVI_EXPRESSION_N_OPS && (one->needs & ~has) == 0; op++) {
            base->ops[op](want, rows[0], rows[1], rows[2], VVI_EXPRESSION_ROW);
            one->ops[op](got, rows[0], rows[1], rows[2], VVI_EXPRESSION_ROW);
            for (int v = 0; v < VVI_EXPRESSION_ROW; v++)
                if (!same(want[v], got[v]))
                    fail_msg("%s, operation %d, place %d: %.17g, not %.17g", one->isa, op, v, got[v], want[v]);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formulas_mean_what_they_mean_in_c),
        cmocka_unit_test(what_is_constant_is_reckoned_at_once),
        cmocka_unit_test(refusals_tell_the_column_and_what_was_expected),
        cmocka_unit_test(what_is_too_large_is_refused),
        cmocka_unit_test(names_of_functions_and_constants_are_no_names),
        cmocka_unit_test(instruction_sets_give_the_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
