/* Texts that wait: all answers, but of news the newest alone, and never more than a quarter of a mebibyte. */
#include "core/memory.h"
#include "server/text_queue.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static bool put(vvi_text_queue *lines, vvi_line_kind kind, const char *text)
{
    return vvi_text_queue_put(lines, kind, vvi_strdup(text));
}

static void expect(vvi_text_queue *lines, bool urgent, const char *text)
{
    size_t n = 0;
    assert_true(vvi_text_queue_any(lines, urgent));
    char *got = vvi_text_queue_take(&n, lines, urgent);
    assert_string_equal(got, text);
    assert_int_equal(n, strlen(text));
    free(got);
}

static void expect_none(vvi_text_queue *lines)
{
    size_t n;
    assert_false(vvi_text_queue_any(lines, false));
    assert_null(vvi_text_queue_take(&n, lines, false));
}

static void answers_come_in_turn(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    expect_none(&lines);
    put(&lines, VVI_LINE_KEPT, "a");
    put(&lines, VVI_LINE_KEPT, "b");
    expect(&lines, false, "a");
    put(&lines, VVI_LINE_KEPT, "c");
    expect(&lines, false, "b");
    expect(&lines, true, "c");
    expect_none(&lines);
}

static void news_take_the_place_of_older_ones_of_their_kind(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    put(&lines, VVI_LINE_JOB, "job 1");
    put(&lines, VVI_LINE_CLIENTS, "3 look");
    put(&lines, VVI_LINE_KEPT, "job 1 is done");
    put(&lines, VVI_LINE_JOB, "job 2");
    put(&lines, VVI_LINE_CLIENTS, "4 look");
    put(&lines, VVI_LINE_RESOLVED, "a scene");
    expect(&lines, false, "job 1 is done");
    expect(&lines, false, "job 2");
    expect(&lines, false, "4 look");
    expect(&lines, false, "a scene");
    expect_none(&lines);
}

static void urgent_ones_pass_by_what_may_be_old_soon(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    put(&lines, VVI_LINE_RESOLVED, "a scene");
    assert_false(vvi_text_queue_any(&lines, true));
    put(&lines, VVI_LINE_NOTICE, "a notice");
    put(&lines, VVI_LINE_KEPT, "an answer");
    expect(&lines, true, "a notice");
    expect(&lines, true, "an answer");
    assert_false(vvi_text_queue_any(&lines, true));
    expect(&lines, false, "a scene");
    expect_none(&lines);
}

static void of_notices_the_newest_are_kept(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    char text[32];
    for (int i = 0; i < 1000; i++) {
        snprintf(text, sizeof text, "notice %d", i);
        assert_true(put(&lines, VVI_LINE_NOTICE, text));
    }
    for (int i = 1000 - VVI_LINES_NOTICES; i < 1000; i++) {
        snprintf(text, sizeof text, "notice %d", i);
        expect(&lines, false, text);
    }
    expect_none(&lines);
}

static char *text_of(size_t n)
{
    char *text = vvi_calloc(1, n + 1);
    assert_non_null(text);
    return memset(text, 'x', n);
}

static void where_much_waits_nothing_more_is_taken(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    assert_true(vvi_text_queue_put(&lines, VVI_LINE_KEPT, text_of(1 << 20))); /* an answer may be long */
    assert_true(put(&lines, VVI_LINE_KEPT, "a"));                             /* and others ready before it has left */
    assert_true(vvi_text_queue_put(&lines, VVI_LINE_KEPT, text_of(1 << 20)));
    assert_false(put(&lines, VVI_LINE_KEPT, "b"));
    vvi_text_queue_clear(&lines);
    expect_none(&lines);
    size_t n = 0;
    while (put(&lines, VVI_LINE_KEPT, ""))
        n++;
    assert_true(n > 1000 && n * sizeof(vvi_line) <= VVI_LINES_MOST + 2 * sizeof(vvi_line)); /* empty ones cost too */
    assert_false(vvi_text_queue_put(&lines, VVI_LINE_KEPT, NULL));
    vvi_text_queue_clear(&lines);
    expect_none(&lines);
}

/* Worlds of others, ends of their jobs, what is told of them: none of it ends who reads. */
static void what_others_do_fills_nothing(void **state)
{
    (void)state;
    vvi_text_queue lines = {0};
    assert_true(vvi_text_queue_put(&lines, VVI_LINE_RESOLVED, text_of(1 << 20)));
    for (int i = 0; i < 10000; i++) {
        assert_true(put(&lines, VVI_LINE_ENDED, i < 9999 ? "job 1 has failed" : "the last one"));
        assert_true(put(&lines, VVI_LINE_NOTICE, "a notice"));
        assert_true(put(&lines, VVI_LINE_JOB, "job 2"));
    }
    for (int i = 0; i < 16; i++)
        assert_true(vvi_text_queue_put(&lines, VVI_LINE_NOTICE, text_of(1 << 16)));
    assert_true(put(&lines, VVI_LINE_KEPT, "an answer"));
    size_t n, waiting = 0;
    for (char *text; (text = vvi_text_queue_take(&n, &lines, true)) != NULL; waiting++)
        free(text);
    assert_int_equal(waiting, 2 * VVI_LINES_NOTICES + 1);
    vvi_text_queue_clear(&lines);
    expect_none(&lines);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_come_in_turn),
        cmocka_unit_test(news_take_the_place_of_older_ones_of_their_kind),
        cmocka_unit_test(urgent_ones_pass_by_what_may_be_old_soon),
        cmocka_unit_test(of_notices_the_newest_are_kept),
        cmocka_unit_test(where_much_waits_nothing_more_is_taken),
        cmocka_unit_test(what_others_do_fills_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
