/* Growing strings and UTF-8. */
#include "core/memory.h"
#include "core/status.h"
#include "core/text.h"
#include "fail_alloc.h"
#include "fields.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <jansson.h>

static void pieces_are_joined(void **state)
{
    (void)state;
    vvi_text text = {0};
    vvi_text_add(&text, "one ");
    vvi_text_add_n(&text, "twofold", 3);
    vvi_text_printf(&text, " %d%s", 3, "!");
    char *s = vvi_text_take(&text);
    assert_string_equal(s, "one two 3!");
    free(s);
    assert_null(text.s);
    assert_int_equal(text.n, 0);
}

static void an_empty_text_is_an_empty_string(void **state)
{
    (void)state;
    vvi_text text = {0};
    char *s = vvi_text_take(&text);
    assert_string_equal(s, "");
    free(s);
    vvi_text_free(&text);
}

static void random_pieces_equal_a_plain_buffer(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    char *plain = calloc(1, 1 << 20);
    vvi_text text = {0};
    size_t n = 0;
    for (uint64_t i = 0; i < 3000; i++) {
        char piece[256];
        const size_t length = test_random(seed, i) % sizeof piece;
        memset(piece, 'a' + (int)(i % 26), length);
        vvi_text_add_n(&text, piece, length);
        vvi_text_printf(&text, "%.*s", (int)(length / 2), piece);
        for (size_t k = 0; k < 2; k++) {
            const size_t bytes = k ? length / 2 : length;
            memcpy(plain + n, piece, bytes);
            n += bytes;
        }
    }
    assert_int_equal(text.n, n);
    char *s = vvi_text_take(&text);
    assert_memory_equal(s, plain, n + 1);
    free(s);
    free(plain);
}

/* What a JSON reader makes of our string. */
static void check_json(const char *s, const char *expected)
{
    vvi_text text = {0};
    vvi_text_json(&text, s);
    char *json = vvi_text_take(&text);
    json_t *read = json_loads(json, JSON_DECODE_ANY, NULL);
    assert_non_null(read);
    assert_string_equal(json_string_value(read), expected);
    json_decref(read);
    free(json);
}

static void json_strings_read_back_equal(void **state)
{
    (void)state;
    char controls[32];
    for (int i = 1; i < 32; i++)
        controls[i - 1] = (char)i;
    controls[31] = 0;
    check_json(controls, controls);
    check_json("plain", "plain");
    check_json("", "");
    check_json("\"quoted\\ \x7f/", "\"quoted\\ \x7f/");
    check_json("\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80", "\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80");
}

static void bytes_that_are_no_utf8_become_the_replacement_character(void **state)
{
    (void)state;
    check_json("a\xff"
               "b",
               "a\xef\xbf\xbd"
               "b");
    check_json("\xc3", "\xef\xbf\xbd");
}

static void utf8_characters_are_measured_strictly(void **state)
{
    (void)state;
    static const struct {
        const char *s;
        size_t n;
    } cases[] = {
        {"", 0},
        {"a", 1},
        {"\x7f", 1},
        {"\x80", 0},             /* a continuation alone */
        {"\xc1\xbf", 0},         /* overlong */
        {"\xc2\x80", 2},         /* the first of two bytes */
        {"\xc3", 0},             /* cut */
        {"\xe0\x9f\xbf", 0},     /* overlong */
        {"\xe0\xa0\x80", 3},     /* the first of three */
        {"\xed\x9f\xbf", 3},     /* before the surrogates */
        {"\xed\xa0\x80", 0},     /* a surrogate */
        {"\xee\x80\x80", 3},     /* after them */
        {"\xe2\x82", 0},         /* cut */
        {"\xf0\x8f\xbf\xbf", 0}, /* overlong */
        {"\xf0\x90\x80\x80", 4}, /* the first of four */
        {"\xf4\x8f\xbf\xbf", 4}, /* the last there is */
        {"\xf4\x90\x80\x80", 0}, /* beyond it */
        {"\xf5\x80\x80\x80", 0}, /* no first byte */
        {"\xf0\x90\x80", 0},     /* cut */
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        assert_int_equal(vvi_utf8_length(cases[i].s), cases[i].n);
}

static void cleaning_takes_what_terminals_obey(void **state)
{
    (void)state;
    char s[] = "a\xc2\x9b"
               "31m \xe2\x80\xae"
               "b\xe2\x81\xa6 \xe2\x80\xa8 \xc2\xa0\xc3\xa9 \xe2\x80\x93 \xe2\x81\xaf";
    vvi_text_clean(s);
    assert_string_equal(s, "a??31m ???b??? ??? \xc2\xa0\xc3\xa9 \xe2\x80\x93 \xe2\x81\xaf");
}

/* Any bytes but 0, what looks like a byte that was written and halves of it among them. */
static void paths_of_any_bytes_are_text_and_come_back(void **state)
{
    static const char *const pieces[] = {"/data/",          "h\xc3\xa9",    "\xe9", "\x80",     "\xff",
                                         "\xee\xbe\x80",    "\xee\xbf\xbf", "\xee", "\xee\xbf", "\xbf",
                                         "\xf0\x9f\x98\x80"};
    (void)state;
    for (size_t i = 0; i < 11 * 11 * 11; i++) {
        char path[64];
        snprintf(path, sizeof path, "%s%s%s", pieces[i % 11], pieces[i / 11 % 11], pieces[i / 121]);
        vvi_text text = {0};
        vvi_text_path(&text, path);
        json_t *json = json_string(text.s); /* NULL of what is no UTF-8 */
        assert_non_null(json);
        json_decref(json);
        vvi_path_of_text(text.s);
        assert_string_equal(text.s, path);
        vvi_text_free(&text);
    }
    vvi_text text = {0};
    vvi_text_json_path(&text, "h\xe9.nrrd");
    assert_string_equal(text.s, "\"h\xee\xbf\xa9.nrrd\"");
    vvi_text_free(&text);
}

static void cleaning_makes_one_line_that_any_reader_takes(void **state)
{
    (void)state;
    char s[] = "a\tb\nc\x7f\xff\xe2\x82\xac\xe2\x82";
    vvi_text_clean(s);
    assert_string_equal(s, "a?b?c??\xe2\x82\xac??");
}

static vv_status write_much(void *user)
{
    (void)user;
    vvi_text text = {0};
    for (int i = 0; i < 200; i++) {
        vvi_text_printf(&text, "%d", i);
        vvi_text_add(&text, ", ");
        vvi_text_json(&text, "\n");
    }
    char *s = vvi_text_take(&text);
    const bool whole = s && strlen(s) == 10 + 180 + 300 + 200 * 6;
    free(s);
    if (s)
        assert_true(whole);
    return s ? VV_OK : vv_fail_memory(1);
}

static void a_failed_allocation_makes_the_text_bad_once_and_for_all(void **state)
{
    (void)state;
    assert_true(test_fail_each_alloc(write_much, NULL) > 2);
    vvi_text text = {0};
    vvi_alloc_fail_after(1);
    vvi_text_add(&text, "lost");
    vvi_alloc_fail_after(0);
    vvi_text_add(&text, "later");
    assert_true(text.bad);
    assert_null(vvi_text_take(&text));
    assert_false(text.bad);
    vvi_text_add(&text, "again");
    assert_string_equal(text.s, "again");
    vvi_text_free(&text);
}

static vv_status make_strings(void *user)
{
    (void)user;
    char *a = vvi_strdup("a"), *b = vvi_asprintf("%s%d", "b", 2);
    const bool whole = a && b;
    if (whole)
        assert_string_equal(b, "b2");
    free(a);
    free(b);
    return whole ? VV_OK : vv_fail_memory(1);
}

static void small_strings_fail_when_told_to(void **state)
{
    (void)state;
    assert_int_equal(test_fail_each_alloc(make_strings, NULL), 2);
    char *empty = vvi_asprintf("%s", "");
    assert_string_equal(empty, "");
    free(empty);
}

/* What the parser holds, as malloc() has it. */
static size_t held, most_held;

static void *hold(size_t n)
{
    void *memory = malloc(n);
    held += memory ? malloc_usable_size(memory) : 0;
    most_held = held > most_held ? held : most_held;
    return memory;
}

static void drop(void *memory)
{
    held -= memory ? malloc_usable_size(memory) : 0;
    free(memory);
}

/* Documents of one thing over and over, which take the most for their length, and a mixed one. */
static void what_a_json_tree_takes_is_known_before_it_is_parsed(void **state)
{
    (void)state;
    enum { TIMES = 20000 };
    static const char *const pieces[] = {
        "{}", "[]", "1", "1.5", "true", "\"\"", "[[],{}]", "{\"a\":{}}", "[1,2,{\"b\":[3]}]"};
    json_set_alloc_funcs(hold, drop);
    for (size_t i = 0; i < sizeof pieces / sizeof *pieces; i++) {
        vvi_text text = {0};
        vvi_text_add(&text, "[");
        for (int k = 0; k < TIMES; k++)
            vvi_text_printf(&text, "%s%s", k ? "," : "", pieces[i]);
        vvi_text_add(&text, "]");
        held = most_held = 0;
        json_t *tree = json_loadb(text.s, text.n, 0, NULL);
        assert_non_null(tree);
        const uint64_t said = vvi_json_tree_bytes(text.s, text.n) + 2 * text.n;
        if (most_held > said || said > 8 * most_held)
            fail_msg("%s: %zu bytes are held, %llu were said", pieces[i], most_held, (unsigned long long)said);
        json_decref(tree);
        vvi_text_free(&text);
    }
    json_set_alloc_funcs(malloc, free);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_are_joined),
        cmocka_unit_test(an_empty_text_is_an_empty_string),
        cmocka_unit_test(random_pieces_equal_a_plain_buffer),
        cmocka_unit_test(json_strings_read_back_equal),
        cmocka_unit_test(bytes_that_are_no_utf8_become_the_replacement_character),
        cmocka_unit_test(utf8_characters_are_measured_strictly),
        cmocka_unit_test(paths_of_any_bytes_are_text_and_come_back),
        cmocka_unit_test(cleaning_makes_one_line_that_any_reader_takes),
        cmocka_unit_test(cleaning_takes_what_terminals_obey),
        cmocka_unit_test(a_failed_allocation_makes_the_text_bad_once_and_for_all),
        cmocka_unit_test(small_strings_fail_when_told_to),
        cmocka_unit_test(what_a_json_tree_takes_is_known_before_it_is_parsed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
