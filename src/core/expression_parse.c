/* From the text of a formula to its program: precedence climbing, with what is constant reckoned at once. */
#include "core/expression_kernel.h"
#include "core/names.h"
#include "core/status.h"
#include "core/units.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DEEPEST = 200, NAME_MOST = 63, LEVEL_COMPARE = 4, LEVEL_SIGN = 7, LEVEL_POWER = 8 };

typedef struct parser {
    vvi_expression *out;
    const char *text, *at;
    const char *const *names;
    size_t n_names;
    int depth;                          /* of what is open; of no use after a failure */
    bool taken[VVI_EXPRESSION_BETWEEN]; /* rows that hold something which is still needed */
} parser;

typedef struct word {
    char name[NAME_MOST + 1];
    const char *at;
} word;

/* Levels of operators, the loosest first. */
static const struct {
    const char *sign;
    int level;
    vvi_expression_op op;
    bool swapped; /* a > b is b < a */
} operators[] = {
    {"||", 1, VVI_OP_OR, false},
    {"&&", 2, VVI_OP_AND, false},
    {"==", 3, VVI_OP_EQUAL, false},
    {"!=", 3, VVI_OP_NOT_EQUAL, false},
    {"<=", LEVEL_COMPARE, VVI_OP_LESS_EQUAL, false},
    {">=", LEVEL_COMPARE, VVI_OP_LESS_EQUAL, true},
    {"<", LEVEL_COMPARE, VVI_OP_LESS, false},
    {">", LEVEL_COMPARE, VVI_OP_LESS, true},
    {"+", 5, VVI_OP_ADD, false},
    {"-", 5, VVI_OP_SUBTRACT, false},
    {"*", 6, VVI_OP_MULTIPLY, false},
    {"/", 6, VVI_OP_DIVIDE, false},
    {"%", 6, VVI_OP_REMAINDER, false},
    {"^", LEVEL_POWER, VVI_OP_POWER, false},
};
enum { OPERATORS = sizeof operators / sizeof operators[0] };

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

static char next(parser *p)
{
    p->at += strspn(p->at, " \t\n\r");
    return *p->at;
}

static bool follows(parser *p, const char *sign)
{
    next(p);
    return strncmp(p->at, sign, strlen(sign)) == 0;
}

static bool skip(parser *p, const char *sign)
{
    if (!follows(p, sign))
        return false;
    p->at += strlen(sign);
    return true;
}

/* Errors --------------------------------------------------------------------------------------------------------- */

/* "column 7", counted in characters from 1. */
static void print_column(char out[32], const parser *p, const char *at)
{
    int column = 1;
    for (const char *c = p->text; c < at; c++)
        column += ((unsigned char)*c & 0xc0) != 0x80;
    snprintf(out, 32, "column %d", column);
}

/* A few characters of what stands there, or "the end". */
static void print_found(char out[64], const char *at)
{
    size_t n = 0;
    while (n < 12 && (is_letter(at[n]) || is_digit(at[n])))
        n++;
    if (n == 0 && *at)
        n = vvi_utf8_length(at) ? vvi_utf8_length(at) : 1;
    char some[32];
    snprintf(some, sizeof some, "%.*s", (int)n, at);
    vvi_text_clean(some);
    snprintf(out, 64, n ? "'%s'" : "%sthe end", some);
}

static vv_status fail_expected(const parser *p, const char *at, const char *expected)
{
    char column[32], found[64];
    print_column(column, p, at);
    print_found(found, at);
    return vv_fail_at(VV_E_ARGUMENT, NULL, column, "expected %s, found %s", expected, found);
}

static vv_status fail_text(const parser *p, const char *at, const char *sentence)
{
    char column[32];
    print_column(column, p, at);
    return vv_fail_at(VV_E_ARGUMENT, NULL, column, "%s", sentence);
}

/* What may stand there, so that the nearest can be told. */
static vv_status fail_unknown(const parser *p, const word *w, bool called)
{
    const char *known[VVI_EXPRESSION_NAMES + 64];
    const char *name, *doc;
    double value;
    char column[32];
    size_t n = 0;
    print_column(column, p, w->at);
    for (size_t i = 0; i < p->n_names && !called; i++)
        known[n++] = p->names[i];
    for (size_t i = 0; !called && (name = vvi_expression_constant(i, &value)) != NULL; i++)
        known[n++] = name;
    for (size_t i = 0; called && (name = vvi_expression_function(i, &doc)) != NULL; i++)
        known[n++] = name;
    return vvi_fail_name(VV_E_ARGUMENT, NULL, column, w->name, &(vvi_known){.name = known, .n = n}, "%s '%s'",
                         called ? "there is no function" : "nothing is called", w->name);
}

/* The program ---------------------------------------------------------------------------------------------------- */

static bool is_constant(int row)
{
    return row >= VVI_EXPRESSION_FIRST_CONSTANT && row < VVI_EXPRESSION_FIRST_BETWEEN;
}

static double constant_of(const parser *p, int row)
{
    return p->out->constants[row - VVI_EXPRESSION_FIRST_CONSTANT];
}

static bool same_bits(double a, double b)
{
    uint64_t x, y;
    memcpy(&x, &a, sizeof x);
    memcpy(&y, &b, sizeof y);
    return x == y; /* 0 and -0 are two, and NaN is itself */
}

static vv_status add_constant(int *row_out, parser *p, double value)
{
    vvi_expression *e = p->out;
    int c = 0;
    while (c < e->n_constants && !same_bits(e->constants[c], value))
        c++;
    if (c == VVI_EXPRESSION_CONSTANTS)
        return fail_text(p, p->at, "there are more than 256 different numbers");
    e->constants[c] = value;
    e->n_constants = c == e->n_constants ? c + 1 : e->n_constants;
    *row_out = VVI_EXPRESSION_FIRST_CONSTANT + c;
    return VV_OK;
}

static void give_back(parser *p, int row)
{
    if (row >= VVI_EXPRESSION_FIRST_BETWEEN)
        p->taken[row - VVI_EXPRESSION_FIRST_BETWEEN] = false;
}

/* The result has a row of its own before those of the operands are given back. */
static vv_status add_step(int *row_out, parser *p, vvi_expression_op op, const int in[3])
{
    vvi_expression *e = p->out;
    int b = 0;
    while (b < VVI_EXPRESSION_BETWEEN && p->taken[b])
        b++;
    if (b == VVI_EXPRESSION_BETWEEN || e->n_steps == VVI_EXPRESSION_STEPS)
        return fail_text(p, p->at, "the formula is too large from here on; compute a part of it first");
    const int n = vvi_expression_operands(op);
    vvi_expression_step *s = &e->steps[e->n_steps++];
    *s = (vvi_expression_step){.op = (uint16_t)op, .out = (uint16_t)(VVI_EXPRESSION_FIRST_BETWEEN + b)};
    for (int i = 0; i < 3; i++)
        s->in[i] = (uint16_t)in[i < n ? i : 0];
    p->taken[b] = true;
    for (int i = 0; i < n && i < 3; i++)
        give_back(p, in[i]);
    e->n_between = b >= e->n_between ? b + 1 : e->n_between;
    *row_out = s->out;
    return VV_OK;
}

/* By the function that rows are worked on with, so that it makes no difference. */
static double reckon(const parser *p, vvi_expression_op op, const int in[3])
{
    double rows[4][VVI_EXPRESSION_ROW];
    memset(rows, 0, sizeof rows);
    for (int i = 0; i < 3 && i < vvi_expression_operands(op); i++)
        rows[i][0] = constant_of(p, in[i]);
    vvi_expression_kernels_for(0)->ops[op](rows[3], rows[0], rows[1], rows[2], VVI_EXPRESSION_BLOCK);
    return rows[3][0];
}

static vv_status apply(int *row_out, parser *p, vvi_expression_op op, int a, int b, int c)
{
    const int in[3] = {a, b, c};
    bool constant = true;
    for (int i = 0; i < 3 && i < vvi_expression_operands(op); i++)
        constant &= is_constant(in[i]);
    if (constant)
        return add_constant(row_out, p, reckon(p, op, in));
    if (op == VVI_OP_POWER && is_constant(b) && constant_of(p, b) == 2) /* a square is exact to the last digit so */
        return add_step(row_out, p, VVI_OP_MULTIPLY, (int[3]){a, a, a});
    return add_step(row_out, p, op, in);
}

/* The grammar ---------------------------------------------------------------------------------------------------- */

static vv_status parse_choice(int *row_out, parser *p);
static vv_status parse_level(int *row_out, parser *p, int level);

static vv_status enter(parser *p)
{
    return ++p->depth <= DEEPEST ? VV_OK : fail_text(p, p->at, "brackets, signs and choices are nested too deeply");
}

static vv_status read_word(word *out, parser *p)
{
    size_t n = 0;
    out->at = p->at;
    while (is_letter(p->at[n]) || is_digit(p->at[n]))
        n++;
    if (n > NAME_MOST)
        return fail_text(p, p->at, "a name has at most 63 characters");
    memcpy(out->name, p->at, n);
    out->name[n] = 0;
    p->at += n;
    return VV_OK;
}

static vv_status fail_count(const parser *p, const word *w, const vvi_expression_call *call, int n)
{
    char column[32], most[24] = "";
    print_column(column, p, w->at);
    if (call->most == 0)
        snprintf(most, sizeof most, " or more");
    return vv_fail_at(VV_E_ARGUMENT, NULL, column, "%s takes %d%s value%s in brackets, found %d", w->name, call->least,
                      most, call->least == 1 ? "" : "s", n);
}

/* The bracket is open. What takes any number takes them two by two. */
static vv_status parse_call(int *row_out, parser *p, const word *w)
{
    const vvi_expression_call *call = vvi_expression_call_of(w->name);
    int in[3] = {0, 0, 0}, n = 0, row = 0;
    vv_status st = VV_OK;
    if (!call)
        return fail_unknown(p, w, true);
    if (next(p) == ')')
        return fail_count(p, w, call, 0);
    do {
        if ((st = parse_choice(&row, p)) != VV_OK)
            return st;
        if (call->most == 0 && n > 0)
            st = apply(&in[0], p, call->op, in[0], row, row);
        else if (n < 3)
            in[n] = row;
        n++;
    } while (st == VV_OK && skip(p, ","));
    if (st != VV_OK)
        return st;
    if (!skip(p, ")"))
        return fail_expected(p, p->at, "an operator, ',' or ')'");
    if (n < call->least || (call->most && n > call->most))
        return fail_count(p, w, call, n);
    *row_out = in[0];
    return call->most == 0 ? VV_OK : apply(row_out, p, call->op, in[0], in[1], in[2]);
}

static vv_status parse_name(int *row_out, parser *p)
{
    const char *constant;
    double value;
    char sentence[224];
    word w;
    vv_status st = read_word(&w, p);
    if (st != VV_OK)
        return st;
    if (skip(p, "("))
        return parse_call(row_out, p, &w);
    for (size_t i = 0; i < p->n_names; i++)
        if (strcmp(p->names[i], w.name) == 0) {
            p->out->used |= (uint64_t)1 << i;
            *row_out = (int)i;
            return VV_OK;
        }
    for (size_t i = 0; (constant = vvi_expression_constant(i, &value)) != NULL; i++)
        if (strcmp(constant, w.name) == 0)
            return add_constant(row_out, p, value);
    if (!vvi_expression_call_of(w.name))
        return fail_unknown(p, &w, false);
    snprintf(sentence, sizeof sentence, "'%s' is a function: its values stand in brackets, as in %s(...)", w.name,
             w.name);
    return fail_text(p, w.at, sentence);
}

static vv_status parse_number(int *row_out, parser *p)
{
    double value;
    const char *end;
    if (!vvi_scan_number(&value, p->at, &end) || end == p->at)
        return fail_expected(p, p->at, "a number");
    if (is_letter(*end) || *end == '.')
        return fail_expected(p, end, "an operator, as in 2*a");
    p->at = end;
    return add_constant(row_out, p, value);
}

static vv_status parse_value(int *row_out, parser *p)
{
    const char c = next(p);
    if (is_digit(c) || c == '.')
        return parse_number(row_out, p);
    if (is_letter(c))
        return parse_name(row_out, p);
    if (!skip(p, "("))
        return fail_expected(p, p->at, "a number, a name or '('");
    const char *open = p->at - 1;
    const vv_status st = parse_choice(row_out, p);
    if (st != VV_OK || skip(p, ")"))
        return st;
    return *p->at ? fail_expected(p, p->at, "an operator or ')'") : fail_text(p, open, "this '(' has no ')'");
}

static vv_status parse_sign(int *row_out, parser *p)
{
    const char c = next(p);
    int row = 0;
    vv_status st = VV_OK;
    if (c == '-' || c == '+' || (c == '!' && p->at[1] != '=')) {
        p->at++;
        if ((st = parse_level(&row, p, LEVEL_SIGN)) == VV_OK && c == '+')
            *row_out = row;
        else if (st == VV_OK)
            st = apply(row_out, p, c == '-' ? VVI_OP_NEGATE : VVI_OP_NOT, row, row, row);
    } else {
        st = parse_value(row_out, p);
    }
    return st;
}

/* The operator that stands there, OPERATORS: none. */
static size_t find_operator(parser *p)
{
    size_t i = 0;
    while (i < OPERATORS && !follows(p, operators[i].sign))
        i++;
    return i;
}

/* Operators of the level and of those that bind more tightly. */
static vv_status parse_level(int *row_out, parser *p, int level)
{
    int left = 0, right = 0, compared = 0;
    size_t i;
    vv_status st = enter(p);
    if (st == VV_OK)
        st = parse_sign(&left, p);
    while (st == VV_OK && (i = find_operator(p)) < OPERATORS && operators[i].level >= level) {
        const char *sign = p->at;
        const int own = operators[i].level;
        p->at += strlen(operators[i].sign);
        if (operators[i].op == VVI_OP_MULTIPLY && *p->at == '*')
            return fail_text(p, sign, "'to the power of' is ^, as in a^2");
        if (own == LEVEL_COMPARE && compared++)
            return fail_text(p, sign, "comparisons are of two values: write a < b && b < c");
        if ((st = parse_level(&right, p, own == LEVEL_POWER ? own : own + 1)) != VV_OK)
            return st;
        const bool swapped = operators[i].swapped;
        st = apply(&left, p, operators[i].op, swapped ? right : left, swapped ? left : right, 0);
        compared = own == LEVEL_COMPARE ? compared : 0;
    }
    p->depth--;
    *row_out = left;
    return st;
}

static vv_status parse_choice(int *row_out, parser *p)
{
    int condition = 0, yes = 0, no = 0;
    vv_status st = enter(p);
    if (st != VV_OK || (st = parse_level(&condition, p, 1)) != VV_OK)
        return st;
    *row_out = condition;
    if (skip(p, "?")) {
        if ((st = parse_choice(&yes, p)) == VV_OK && !skip(p, ":"))
            st = fail_expected(p, p->at, "':' of a choice, as in a > 0 ? a : 0");
        if (st == VV_OK && (st = parse_choice(&no, p)) == VV_OK)
            st = apply(row_out, p, VVI_OP_WHERE, condition, yes, no);
    }
    p->depth--;
    return st;
}

static vv_status parse_all(parser *p)
{
    vv_status st = VV_OK;
    if (!next(p))
        return vv_fail(VV_E_ARGUMENT, "the formula is empty; write one, such as 'a - 0.5*b'");
    if ((st = parse_choice(&p->out->result, p)) != VV_OK || !next(p))
        return st;
    if (*p->at == '=')
        return fail_text(p, p->at, "'equal to' is ==");
    if (*p->at == '&' || *p->at == '|')
        return fail_text(p, p->at, "'and' is &&, 'or' is ||");
    return fail_expected(p, p->at, "an operator");
}

vv_status vvi_expression_new(vvi_expression **out, const char *text, const char *const *names, size_t n_names)
{
    *out = NULL;
    vvi_check(n_names <= VVI_EXPRESSION_NAMES);
    const size_t n = text ? strlen(text) : 0;
    if (n > VVI_EXPRESSION_BYTES)
        return vv_fail(VV_E_ARGUMENT, "the formula has %zu bytes; it may have %d", n, VVI_EXPRESSION_BYTES);
    vvi_expression *e = calloc(1, sizeof *e);
    if (!e)
        return vv_fail_memory(sizeof *e);
    parser p = {.out = e, .text = text ? text : "", .names = names, .n_names = n_names};
    p.at = p.text;
    const vv_status st = parse_all(&p);
    if (st == VV_OK)
        *out = e;
    else
        free(e);
    return st;
}

void vvi_expression_free(vvi_expression *expression)
{
    free(expression);
}

vv_status vvi_expression_check_name(const char *name)
{
    const char *constant;
    double value;
    size_t n = 0;
    while (is_letter(name[n]) || (n > 0 && is_digit(name[n])))
        n++;
    if (n == 0 || name[n] || n > NAME_MOST)
        return vv_fail(VV_E_ARGUMENT, "'%s' is no name: a name is a letter, then letters, digits and _, at most 63",
                       name);
    bool known = vvi_expression_call_of(name) != NULL;
    for (size_t i = 0; (constant = vvi_expression_constant(i, &value)) != NULL; i++)
        known |= strcmp(constant, name) == 0;
    return known ? vv_fail(VV_E_ARGUMENT, "'%s' means something else in formulas; choose another name", name) : VV_OK;
}
