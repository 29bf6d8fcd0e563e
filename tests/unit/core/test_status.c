/* Statuses and the sentence behind them. */
#include "core/memory.h"
#include "core/status.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static void *look_at_a_fresh_thread(void *user)
{
    const vv_error *e = vv_error_last();
    *(bool *)user = e && e->status == VV_OK && e->message && !*e->message && !e->file && !e->where;
    return NULL;
}

static void a_thread_that_never_failed_has_an_empty_error(void **state)
{
    (void)state;
    pthread_t thread;
    bool fine = false;
    vv_fail(VV_E_READ, "of the main thread");
    assert_int_equal(pthread_create(&thread, NULL, look_at_a_fresh_thread, &fine), 0);
    pthread_join(thread, NULL);
    assert_true(fine);
    assert_string_equal(vv_error_last()->message, "of the main thread");
}

static void a_failure_has_its_status_and_sentence(void **state)
{
    (void)state;
    assert_int_equal(vv_fail(VV_E_ARGUMENT, "'%s' is %d", "n", 3), VV_E_ARGUMENT);
    const vv_error *e = vv_error_last();
    assert_int_equal(e->status, VV_E_ARGUMENT);
    assert_string_equal(e->message, "'n' is 3");
    assert_null(e->file);
    assert_null(e->where);
}

static void a_place_stands_in_front_and_apart(void **state)
{
    (void)state;
    assert_int_equal(vv_fail_at(VV_E_FORMAT, "a.nhdr", "4", "'sizes' has %d numbers", 2), VV_E_FORMAT);
    assert_string_equal(vv_error_last()->message, "a.nhdr:4: 'sizes' has 2 numbers");
    assert_string_equal(vv_error_last()->file, "a.nhdr");
    assert_string_equal(vv_error_last()->where, "4");
    vv_fail_at(VV_E_FORMAT, "a.nhdr", NULL, "x");
    assert_string_equal(vv_error_last()->message, "a.nhdr: x");
    assert_null(vv_error_last()->where);
    vv_fail_at(VV_E_FORMAT, NULL, "lights.key", "x");
    assert_string_equal(vv_error_last()->message, "lights.key: x");
    assert_null(vv_error_last()->file);
    vv_fail_at(VV_E_FORMAT, NULL, NULL, "x");
    assert_string_equal(vv_error_last()->message, "x");
}

static void a_new_failure_leaves_nothing_of_the_one_before(void **state)
{
    (void)state;
    vv_fail_at(VV_E_FORMAT, "a.nhdr", "4", "old");
    vv_fail(VV_E_WRITE, "new");
    assert_string_equal(vv_error_last()->message, "new");
    assert_null(vv_error_last()->file);
    assert_null(vv_error_last()->where);
    assert_int_equal(vv_error_last()->status, VV_E_WRITE);
}

static void callers_texts_stack_in_front_and_the_place_stays(void **state)
{
    (void)state;
    const vv_status st = vv_fail_at(VV_E_FORMAT, "a.nhdr", "4", "no sizes");
    assert_int_equal(vv_fail_in(st, "dataset '%s'", "head"), VV_E_FORMAT);
    vv_fail_in(st, "volume 'v'");
    assert_string_equal(vv_error_last()->message, "volume 'v': dataset 'head': a.nhdr:4: no sizes");
    assert_string_equal(vv_error_last()->file, "a.nhdr");
    assert_string_equal(vv_error_last()->where, "4");
}

static void the_thread_s_own_strings_may_be_arguments(void **state)
{
    (void)state;
    vv_fail_at(VV_E_READ, "file", "12", "first");
    const vv_error *e = vv_error_last();
    vv_fail_at(VV_E_FORMAT, e->file, e->where, "then %s", e->message);
    assert_string_equal(vv_error_last()->message, "file:12: then file:12: first");
    vv_fail_in(VV_E_FORMAT, "%s", vv_error_last()->file);
    assert_string_equal(vv_error_last()->message, "file: file:12: then file:12: first");
    vv_fail(VV_E_FORMAT, "%s!", vv_error_last()->message);
    assert_string_equal(vv_error_last()->message, "file: file:12: then file:12: first!");
}

static char *long_text(size_t n, const char *unit)
{
    char *s = malloc(n + 1);
    assert_non_null(s);
    const size_t unit_bytes = strlen(unit);
    for (size_t i = 0; i < n; i++)
        s[i] = unit[i % unit_bytes];
    s[n] = 0;
    return s;
}

static void a_text_that_is_too_long_ends_in_dots(void **state)
{
    (void)state;
    char *s = long_text(100000, "x");
    vv_fail_at(VV_E_FORMAT, s, s, "%s", s);
    const vv_error *e = vv_error_last();
    assert_in_range(strlen(e->message), 4000, 5000);
    assert_string_equal(e->message + strlen(e->message) - 3, "...");
    assert_string_equal(e->where + strlen(e->where) - 3, "...");
    free(s);
}

static void a_text_is_whole_up_to_the_last_byte_there_is_room_for(void **state)
{
    (void)state;
    enum { ROOM = 4096 };
    for (size_t n = ROOM - 8; n < ROOM + 8; n++) {
        char *s = long_text(n, "x");
        vv_fail(VV_E_FORMAT, "%s", s);
        const char *message = vv_error_last()->message;
        assert_int_equal(strlen(message), n < ROOM ? n : ROOM - 1);
        assert_int_equal(strcmp(message, s) == 0, n < ROOM);
        vv_fail_at(VV_E_FORMAT, s, NULL, "y");
        assert_int_equal(strlen(vv_error_last()->file), n < ROOM ? n : ROOM - 1);
        assert_int_equal(strcmp(vv_error_last()->file, s) == 0, n < ROOM);
        s[ROOM / 2] = 0; /* in front of another half, with ": " between */
        vv_fail(VV_E_FORMAT, "%.*s", (int)(n - ROOM / 2 - 2), s);
        vv_fail_in(VV_E_FORMAT, "%s", s);
        const size_t whole = ROOM / 2 + 2 + (n - ROOM / 2 - 2 < ROOM / 2 ? n - ROOM / 2 - 2 : ROOM / 2);
        if (whole < ROOM)
            assert_int_equal(strlen(message), whole);
        else
            assert_non_null(strstr(message, "...: x"));
        free(s);
    }
}

static void an_empty_text_stays_empty(void **state)
{
    (void)state;
    vv_fail(VV_E_FORMAT, "%s", "");
    assert_string_equal(vv_error_last()->message, "");
}

static void a_long_prefix_gives_way_to_the_reason(void **state)
{
    (void)state;
    char *s = long_text(100000, "x");
    vv_fail(VV_E_FORMAT, "the reason");
    vv_fail_in(VV_E_FORMAT, "%s", s);
    assert_non_null(strstr(vv_error_last()->message, "...: the reason"));
    vv_fail_at(VV_E_FORMAT, s, "3", "the reason");
    assert_non_null(strstr(vv_error_last()->message, "...: the reason"));
    free(s);
}

static void long_texts_are_never_cut_inside_a_character(void **state)
{
    (void)state;
    for (size_t lead = 0; lead < 4; lead++) {
        char *s = long_text(9000, "\xe2\x82\xac"); /* the euro sign, 3 bytes */
        vv_fail(VV_E_FORMAT, "%.*s%s", (int)lead, "abc", s);
        assert_null(strchr(vv_error_last()->message, '?')); /* what broken UTF-8 would have become */
        free(s);
    }
}

static void line_ends_and_broken_utf8_cannot_enter_a_message(void **state)
{
    (void)state;
    vv_fail_at(VV_E_READ, "evil\n\033[2Jname\xff\xc3\xa9", NULL, "cannot be opened");
    assert_string_equal(vv_error_last()->message, "evil??[2Jname?\xc3\xa9: cannot be opened");
    assert_string_equal(vv_error_last()->file, "evil\n\033[2Jname\xff\xc3\xa9"); /* the name itself stays true */
}

static void every_status_has_its_word(void **state)
{
    (void)state;
    static const char *const words[] = {"ok",    "argument",    "memory",    "limit",     "read",    "format",
                                        "write", "unsupported", "cancelled", "not_found", "internal"};
    for (int i = 0; i <= 10; i++)
        assert_string_equal(vv_status_name((vv_status)-i), words[i]);
    assert_string_equal(vv_status_name((vv_status)-11), "unknown");
    assert_string_equal(vv_status_name((vv_status)1), "unknown");
    assert_string_equal(vv_status_name((vv_status)-2147483647 - 1), "unknown");
}

static void *fail_and_hand_over(void *user)
{
    vv_fail_at(VV_E_FORMAT, "b.nrrd", "9", "from a worker");
    vvi_error_take(user);
    return NULL;
}

static void an_error_can_be_carried_to_another_thread(void **state)
{
    (void)state;
    pthread_t thread;
    vvi_error_copy copy;
    vv_fail(VV_E_READ, "own");
    assert_int_equal(pthread_create(&thread, NULL, fail_and_hand_over, &copy), 0);
    pthread_join(thread, NULL);
    assert_string_equal(vv_error_last()->message, "own");
    assert_int_equal(vvi_error_put(&copy), VV_E_FORMAT);
    assert_string_equal(vv_error_last()->message, "b.nrrd:9: from a worker");
    assert_string_equal(vv_error_last()->file, "b.nrrd");
    assert_string_equal(vv_error_last()->where, "9");
    assert_null(copy.message);
    vvi_error_copy_free(&copy); /* nothing is left to free, and that is fine */
}

static void an_error_that_memory_cannot_carry_keeps_its_status(void **state)
{
    (void)state;
    vvi_error_copy copy;
    vv_fail_at(VV_E_FORMAT, "b.nrrd", "9", "text");
    vvi_alloc_fail_after(1);
    vvi_error_take(&copy);
    vv_fail(VV_E_READ, "other");
    assert_int_equal(vvi_error_put(&copy), VV_E_FORMAT);
    vvi_alloc_fail_after(0);
    assert_int_equal(vv_error_last()->status, VV_E_FORMAT);
    assert_non_null(strstr(vv_error_last()->message, "no memory"));
}

static void making_an_error_needs_no_memory(void **state)
{
    (void)state;
    vvi_alloc_fail_after(1);
    vv_fail_at(VV_E_FORMAT, "f", "w", "text %d", 1);
    vv_fail_in(VV_E_FORMAT, "more");
    assert_false(vvi_alloc_has_failed());
    vvi_alloc_fail_after(0);
    assert_string_equal(vv_error_last()->message, "more: f:w: text 1");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_thread_that_never_failed_has_an_empty_error),
        cmocka_unit_test(a_failure_has_its_status_and_sentence),
        cmocka_unit_test(a_place_stands_in_front_and_apart),
        cmocka_unit_test(a_new_failure_leaves_nothing_of_the_one_before),
        cmocka_unit_test(callers_texts_stack_in_front_and_the_place_stays),
        cmocka_unit_test(the_thread_s_own_strings_may_be_arguments),
        cmocka_unit_test(a_text_that_is_too_long_ends_in_dots),
        cmocka_unit_test(a_text_is_whole_up_to_the_last_byte_there_is_room_for),
        cmocka_unit_test(an_empty_text_stays_empty),
        cmocka_unit_test(a_long_prefix_gives_way_to_the_reason),
        cmocka_unit_test(long_texts_are_never_cut_inside_a_character),
        cmocka_unit_test(line_ends_and_broken_utf8_cannot_enter_a_message),
        cmocka_unit_test(every_status_has_its_word),
        cmocka_unit_test(an_error_can_be_carried_to_another_thread),
        cmocka_unit_test(an_error_that_memory_cannot_carry_keeps_its_status),
        cmocka_unit_test(making_an_error_needs_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
