/* Formulas: a text is refused with a sentence, or its program runs and gives the same for the same values. */
#include "core/expression.h"
#include "fuzz.h"
#include <stdlib.h>
#include <string.h>

static void run(const vvi_expression *expression, size_t n_names)
{
    vvi_expression_rows *rows;
    double before[VVI_EXPRESSION_ROW];
    fuzz_expect(vvi_expression_rows_new(&rows, expression, fuzz_job()) == VV_OK);
    for (size_t i = 0; i < n_names; i++) {
        double *row = vvi_expression_row(rows, i);
        fuzz_expect((row != NULL) == vvi_expression_uses(expression, i));
        for (int v = 0; row && v < VVI_EXPRESSION_ROW; v++)
            row[v] = (double)(v - 100) * (double)(i + 1);
    }
    memcpy(before, vvi_expression_run(rows, VVI_EXPRESSION_ROW), sizeof before);
    fuzz_expect(memcmp(before, vvi_expression_run(rows, VVI_EXPRESSION_ROW), sizeof before) == 0);
    vvi_expression_rows_free(rows);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    static const char *const names[] = {"a", "b", "c", "x", "y", "i"};
    enum { NAMES = sizeof names / sizeof names[0] };
    vvi_expression *expression;
    char *text = malloc(n + 1);
    fuzz_expect(text != NULL);
    if (n > 0)
        memcpy(text, data, n);
    text[n] = 0;
    const vv_status st = vvi_expression_new(&expression, text, names, NAMES);
    fuzz_expect((st == VV_OK) == (expression != NULL));
    if (st == VV_OK)
        run(expression, NAMES);
    else
        fuzz_expect(vv_error_last()->message[0] && strlen(vv_error_last()->message) < 2000);
    vvi_expression_free(expression);
    free(text);
    return 0;
}
