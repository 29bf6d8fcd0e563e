/* JSON from and to text: what jansson makes of it, and whole or nothing where memory is short. */
#include "core/json_text.h"
#include "core/memory.h"
#include "core/text.h"
#include "fields.h"

#include <malloc.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

/* Beside jansson's own reader ------------------------------------------------------------------------------------- */

static const size_t flag_sets[] = {0, JSON_DECODE_ANY, JSON_REJECT_DUPLICATES, JSON_DECODE_ANY | JSON_ALLOW_NUL,
                                   JSON_DECODE_INT_AS_REAL | JSON_REJECT_DUPLICATES | JSON_ALLOW_NUL};

/* From a block of its own size, so that a byte behind it that is read is seen. */
static void compare(const char *text, size_t n)
{
    char *own = malloc(n ? n : 1);
    memcpy(own, text, n);
    for (size_t i = 0; i < sizeof flag_sets / sizeof *flag_sets; i++) {
        json_error_t error;
        vvi_json_flaw flaw;
        json_t *theirs = json_loadb(own, n, flag_sets[i], &error);
        json_t *ours = vvi_json_decode(own, n, flag_sets[i], &flaw);
        if (!theirs != !ours || (theirs && !json_equal(theirs, ours)))
            fail_msg("'%.*s' (%zu): jansson has %s (%s), we have %s (%s)", (int)n, own, i, theirs ? "a tree" : "none",
                     theirs ? "" : error.text, ours ? "a tree" : "none", flaw.text);
        if (!ours)
            assert_true(flaw.fault != VVI_JSON_MEMORY && flaw.text[0] && flaw.line >= 1);
        if (!ours && (flag_sets[i] & JSON_DECODE_ANY) &&
            (json_error_code(&error) == json_error_numeric_overflow) != (flaw.fault == VVI_JSON_LARGE))
            fail_msg("'%.*s': %s, %s", (int)n, own, error.text, flaw.text);
        json_decref(theirs);
        json_decref(ours);
    }
    free(own);
}

static void what_jansson_reads_is_read_equal_and_nothing_else(void **state)
{
    (void)state;
    static const char *const texts[] = {
        "",
        " ",
        "{",
        "}",
        "[",
        "]",
        "{}",
        "[]",
        " {} ",
        "[]]",
        "{},",
        "[1]",
        "[1,]",
        "[,1]",
        "[1 2]",
        "[1,2,[3,[4]]]",
        "{\"a\":1}",
        "{\"a\" 1}",
        "{\"a\":}",
        "{\"a\":1,}",
        "{,}",
        "{a:1}",
        "{'a':1}",
        "{\"a\":1,\"a\":2}",
        "{\"\":0}",
        "{\"a\":{\"a\":{\"a\":[]}}}",
        "1",
        "-1",
        "-",
        "+1",
        "01",
        "-01",
        "0",
        "-0",
        "0.0",
        "-0.0",
        "1.",
        ".5",
        "1.5",
        "1e5",
        "1E+5",
        "1e-5",
        "1e",
        "1e+",
        "1.5e3.",
        "1e400",
        "-1e400",
        "1e-400",
        "4.9e-324",
        "9223372036854775807",
        "9223372036854775808",
        "-9223372036854775808",
        "-9223372036854775809",
        "99999999999999999999999999",
        "123456789012345678901234567890.5",
        "0x10",
        "1a",
        "NaN",
        "Infinity",
        "true",
        "false",
        "null",
        "nul",
        "nulls",
        "TRUE",
        "\"\"",
        "\"a\"",
        "\"",
        "\"\\\"",
        "\"\\\\\"",
        "\"\\",
        "\"a",
        "\"\\\"\\\\\\/\\b\\f\\n\\r\\t\"",
        "\"\\x\"",
        "\"\\u00e4\\u20AC\"",
        "\"\\u12\"",
        "\"\\u123g\"",
        "\"\\u\"",
        "\"\\ud83d\\ude00\"",
        "\"\\ud83d\"",
        "\"\\ude00\"",
        "\"\\ud83dx\"",
        "\"\\ud83d\\n\"",
        "\"\\ud83d\\u0041\"",
        "\"\\ud83d\\",
        "\"\\ud83d\\u",
        "\"\\ud83d\\ude0",
        "\"\\u\x12\x13\x14\x15\"",
        "\"\\u0000\"",
        "{\"\\u0000\":1}",
        "{\"a\\u0000b\":1}",
        "\"a\nb\"",
        "\"a\x01\"",
        "\"\x7f\"",
        "\"\xc3\xa4\"",
        "\"\xc3\"",
        "\"\xc3",
        "\"\xe2\x82\"",
        "\"\xe2\x82\xac\"",
        "\"\xf0\x9f\x98\x80\"",
        "\"\xf0\x9f\x98",
        "\"\xc0\x80\"",
        "\"\xed\xa0\x80\"",
        "\"\xf4\x90\x80\x80\"",
        "\"\xff\"",
        "\xc3\xa4",
        "\xff",
        "[1,\xe2\x82\xac]",
        "// x\n1",
        "[1] // x",
        "\xef\xbb\xbf[]",
        "[\"a longer text than sixteen bytes, so that what is kept must grow more than once, and a name too\"]",
        "{\"a name that is longer than thirty-two bytes of text\": \"and a value of sixty-four or more bytes, say\"}"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        for (size_t n = strlen(texts[i]), cut = 0; cut <= n; cut++)
            compare(texts[i], n - cut);
    static const char *const with_nul[] = {"[1\0]", "\"a\0\"", "[1]\0"}; /* jansson passes over one behind a number */
    for (size_t i = 0; i < 3; i++)
        assert_null(vvi_json_decode(with_nul[i], 4, JSON_DECODE_ANY | JSON_ALLOW_NUL, NULL));
}

/* Pieces of JSON at random, among them such as fit nowhere. */
static void random_texts_are_read_as_jansson_does(void **state)
{
    (void)state;
    static const char *const pieces[] = {"{",  "}",      "[",    "]",    ",",        ":",  "\"a\"",          "\"b\"",
                                         "1",  "-2.5e1", "true", "null", " ",        "\n", "\"\\u00e4\\n\"", "\"a\":",
                                         "[]", "{}",     "\\",   "\"",   "\xc3\xa4", "0"};
    enum { N = sizeof pieces / sizeof *pieces };
    const uint64_t seed = test_seed();
    uint64_t at = 0;
    for (int i = 0; i < 20000; i++) {
        vvi_text text = {0};
        const size_t n = test_random(seed, at++) % 12;
        vvi_text_add(&text, i % 2 ? "[" : "{\"k\":");
        for (size_t k = 0; k < n; k++)
            vvi_text_add(&text, pieces[test_random(seed, at++) % N]);
        vvi_text_add(&text, i % 4 < 2 ? "" : i % 2 ? "]" : "}");
        compare(text.s, text.n);
        vvi_text_free(&text);
    }
}

static void depth_has_an_end(void **state)
{
    (void)state;
    enum { DEEP = 3000 };
    char text[2 * DEEP];
    for (int n = 2040; n < 2056; n++) {
        memset(text, '[', (size_t)n);
        memset(text + n, ']', (size_t)n);
        compare(text, 2 * (size_t)n);
    }
    memset(text, '[', sizeof text);
    compare(text, sizeof text);
}

static void a_flaw_has_its_place(void **state)
{
    (void)state;
    static const struct {
        const char *text, *what;
        int line, column;
    } rows[] = {{"{\"a\": 1, \"a\": 2}", "duplicate object key near '\"a\"'", 1, 12},
                {"{\n  \"a\": tru\n}", "a value was expected near 'tru'", 2, 10},
                {"[1\n,\n2", "',' or ']' was expected near its end", 3, 1},
                {"{\"\xc3\xa4\": 01}", "this is no number near '01'", 1, 8},
                {"[\"a\\qb\"]", "a text has an escape that there is not near '\\qb'", 1, 6},
                {"[1] x", "its end was expected near 'x'", 1, 5},
                {"", "'{' or '[' was expected near its end", 1, 0}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        vvi_json_flaw flaw;
        assert_null(vvi_json_decode(rows[i].text, strlen(rows[i].text), JSON_REJECT_DUPLICATES, &flaw));
        assert_string_equal(flaw.text, rows[i].what);
        assert_int_equal(flaw.line, rows[i].line);
        assert_int_equal(flaw.column, rows[i].column);
    }
}

/* Without memory --------------------------------------------------------------------------------------------------- */

/* With texts, names and numbers that grow past 16, 32 and 64 bytes, where jansson's own reader goes on without them. */
static const char sample[] =
    "{\"a name of more than sixteen bytes\": \"a text of more than thirty-two bytes \\u00e4\\n, and of sixty-four\", "
    "\"numbers\": [1234567890123456789, 0.1234567890123456789012345678901234567890, -1.5e-300, true, null, \"x\"], "
    "\"many\": {\"a\": 1, \"b\": 2, \"c\": 3, \"d\": 4, \"e\": 5, \"f\": 6, \"g\": 7, \"h\": 8, \"i\": "
    "[1,2,3,4,5,6,7,8,9]}}";

static long countdown;    /* tests run one after another on one thread; 0: none fails */
static bool once, failed; /* once: those after it do not fail */

static void *count_block(size_t n)
{
    if (failed && !once)
        return NULL;
    if (countdown > 0 && --countdown == 0) {
        failed = true;
        return NULL;
    }
    return malloc(n);
}

typedef struct attempt {
    void (*act)(struct attempt *attempt);
    json_t *tree, *made;
    char *printed;
    size_t flags;
    vvi_json_flaw flaw;
} attempt;

/* The n-th of jansson's blocks fails, or of ours, alone or with all after it. Returns whether one did. */
static bool with_failing(attempt *a, long n, bool ours, bool alone)
{
    json_set_alloc_funcs(count_block, free);
    countdown = ours ? 0 : n;
    once = alone;
    failed = false;
    if (ours && alone)
        vvi_alloc_fail_once(n);
    else if (ours)
        vvi_alloc_fail_after(n);
    a->act(a);
    const bool did = ours ? vvi_alloc_has_failed() : failed;
    vvi_alloc_fail_after(0);
    json_set_alloc_funcs(malloc, free);
    return did;
}

/* Each block fails in its turn; what came of it, nothing or `whole`, is checked. */
static void each_fails(attempt *a, bool (*is_whole)(const attempt *a), long least)
{
    for (int way = 0; way < 4; way++) {
        bool did = true;
        for (long n = 1; did; n++) {
            assert_true(n < 10000);
            did = with_failing(a, n, way & 1, way & 2);
            assert_true(did || n >= least || (way & 1));
            assert_true(a->made || a->printed ? is_whole(a) : did);
            json_decref(a->made);
            free(a->printed);
            a->made = NULL;
            a->printed = NULL;
        }
    }
}

static void decode_sample(attempt *a)
{
    a->made = vvi_json_decode(sample, sizeof sample - 1, 0, &a->flaw);
    assert_true(a->made || a->flaw.fault == VVI_JSON_MEMORY);
}

static bool is_equal(const attempt *a)
{
    return json_equal(a->made, a->tree);
}

static void a_text_is_read_whole_or_for_want_of_memory_not_at_all(void **state)
{
    (void)state;
    attempt a = {.act = decode_sample, .tree = json_loads(sample, 0, NULL)};
    each_fails(&a, is_equal, 40);
    json_decref(a.tree);
}

static void encode_sample(attempt *a)
{
    a->printed = vvi_json_encode(a->tree, a->flags);
}

static bool is_printed_whole(const attempt *a)
{
    char *whole = json_dumps(a->tree, a->flags);
    const bool is = strcmp(whole, a->printed) == 0;
    free(whole);
    return is;
}

static void a_tree_is_printed_as_jansson_does_whole_or_not_at_all(void **state)
{
    (void)state;
    static const size_t flags[] = {0, JSON_COMPACT, JSON_INDENT(2), JSON_SORT_KEYS | JSON_REAL_PRECISION(17)};
    attempt a = {.act = encode_sample, .tree = json_loads(sample, 0, NULL)};
    for (size_t i = 0; i < sizeof flags / sizeof *flags; i++) {
        a.flags = flags[i];
        each_fails(&a, is_printed_whole, 2);
    }
    json_decref(a.tree);
}

static void copy_and_add(attempt *a)
{
    a->made = vvi_json_copy_object(json_object_get(a->tree, "many"));
    vvi_json_put(&a->made, "more", json_string("something"));
    vvi_json_put(&a->made, "list", json_array());
}

static bool has_all_and_more(const attempt *a)
{
    return json_object_size(a->made) == 11;
}

static void a_copy_is_whole_or_none(void **state)
{
    (void)state;
    attempt a = {.act = copy_and_add, .tree = json_loads(sample, 0, NULL)};
    each_fails(&a, has_all_and_more, 12);
    json_decref(a.tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_jansson_reads_is_read_equal_and_nothing_else),
        cmocka_unit_test(random_texts_are_read_as_jansson_does),
        cmocka_unit_test(depth_has_an_end),
        cmocka_unit_test(a_flaw_has_its_place),
        cmocka_unit_test(a_text_is_read_whole_or_for_want_of_memory_not_at_all),
        cmocka_unit_test(a_tree_is_printed_as_jansson_does_whole_or_not_at_all),
        cmocka_unit_test(a_copy_is_whole_or_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
