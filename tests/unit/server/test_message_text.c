/* The JSON of messages: what may be in it, and that it is read once. */
#include "server/session_impl.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static json_t *read_text(const char **flaw, const char *text)
{
    bool no_memory;
    json_t *message = vvi_message_read(flaw, &no_memory, text, strlen(text));
    assert_false(no_memory);
    return message;
}

static void numbers_are_what_they_are(void **state)
{
    (void)state;
    static const struct {
        const char *text; /* of the member v */
        double value;
        bool whole;
        const char *flaw; /* a part of it */
    } rows[] = {{"0", 0, true, NULL},
                {"9223372036854775807", 0x1p63, true, NULL},
                {"-9223372036854775808", -0x1p63, true, NULL},
                {"9223372036854775808", 0x1p63, false, NULL},
                {"-99999999999999999999999", -99999999999999999999999.0, false, NULL},
                {"1e308", 1e308, false, NULL},
                {"1e-400", 0, false, NULL},
                {"0.00000000000000000000000000000000000001", 1e-38, false, NULL},
                {"1e400", 0, true, "too large"},
                {"-1E+999", 0, true, "too large"},
                {"\"1e400\"", 0, false, NULL},
                {"\"\\\"1e400\"", 0, false, NULL},
                {"\"\\u0000\"", 0, false, "U+0000"},
                {"\"\\\\u0000\"", 0, false, NULL}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        char text[200];
        const char *flaw;
        snprintf(text, sizeof text, "{\"type\": \"edit\", \"id\": 7, \"in\": {\"v\": %s, \"three\": 3}}", rows[i].text);
        json_t *message = read_text(&flaw, text);
        const json_t *v = json_object_get(json_object_get(message, "in"), "v");
        if (!message || json_integer_value(json_object_get(message, "id")) != 7 ||
            (rows[i].text[0] != '"' && json_number_value(v) != rows[i].value) || !flaw != !rows[i].flaw ||
            (flaw && !strstr(flaw, rows[i].flaw)))
            fail_msg("%s: %s", rows[i].text, flaw ? flaw : "no flaw");
        if (rows[i].whole && !rows[i].flaw)
            assert_true(json_is_integer(v) &&
                        json_is_integer(json_object_get(json_object_get(message, "in"), "three")));
        json_decref(message);
    }
}

static void what_is_no_json_is_none(void **state)
{
    (void)state;
    static const char *const rows[] = {"",
                                       "{",
                                       "1e",
                                       "{\"a\": 1e}",
                                       "{\"a\": 1, \"a\": 2}",
                                       "\"",
                                       "\"\\",
                                       "{\"a\": 1e400e}",
                                       "{\"a\": --1}",
                                       "{\"a\": 01}",
                                       "[1e400",
                                       "nul"};
    const char *flaw;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (read_text(&flaw, rows[i]))
            fail_msg("%s", rows[i]);
}

static size_t blocks;

static void *count_block(size_t n)
{
    blocks++;
    return malloc(n);
}

/* As many blocks for a number that has to be taken out as for one that has not. */
static void a_message_is_read_once(void **state)
{
    (void)state;
    enum { N = 5000 };
    static const char *const last[] = {"1", "1e400", "99999999999999999999", "\"\\u0000\""};
    static char text[8 * N];
    size_t taken[4];
    json_set_alloc_funcs(count_block, free);
    for (size_t i = 0; i < 4; i++) {
        const char *flaw;
        int n = snprintf(text, sizeof text, "{\"type\": \"edit\", \"v\": [");
        for (int k = 0; k < N; k++)
            n += snprintf(text + n, sizeof text - (size_t)n, "%d.5,", k % 10);
        snprintf(text + n, sizeof text - (size_t)n, "%s]}", last[i]);
        blocks = 0;
        json_t *message = read_text(&flaw, text);
        assert_non_null(message);
        taken[i] = blocks;
        json_decref(message);
    }
    json_set_alloc_funcs(malloc, free);
    for (size_t i = 1; i < 4; i++)
        assert_true(taken[i] < taken[0] + 50);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_what_they_are),
        cmocka_unit_test(what_is_no_json_is_none),
        cmocka_unit_test(a_message_is_read_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
