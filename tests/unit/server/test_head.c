/* Heads of requests: one way to read them. tests/attack has hundreds that are refused. */
#include "server/head.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static char room[2 * VVI_HEAD_MOST];

static int read_text(vvi_head *out, const char *text, size_t *used)
{
    const char *why;
    snprintf(room, sizeof room, "%s", text);
    const int status = vvi_head_read(out, &why, used, room, strlen(text));
    if (status != 0 && status != 200)
        assert_non_null(why);
    return status;
}

static void what_a_page_sends_is_read(void **state)
{
    (void)state;
    static const char text[] =
        "PUT /files/a%20%C3%A4.nrrd?x=%0a HTTP/1.1\r\nHost: localhost:8080\r\nORIGIN:http://localhost:8080 \t\r\n"
        "Cookie: a=b; volvis-8080=1\r\nX-Empty:\r\nContent-Length: 12\r\n\r\nbody and more";
    vvi_head h;
    size_t used;
    assert_int_equal(read_text(&h, text, &used), 200);
    assert_int_equal(used, strlen(text) - strlen("body and more"));
    assert_int_equal(h.method, VVI_METHOD_PUT);
    assert_string_equal(h.path, "/files/a \xc3\xa4.nrrd");
    assert_true(h.has_query && h.has_length && h.length == 12);
    assert_string_equal(h.host, "localhost:8080");
    assert_string_equal(h.origin, "http://localhost:8080");
    assert_string_equal(h.cookie, "a=b; volvis-8080=1");
    assert_null(h.upgrade);
}

static void a_head_is_waited_for_byte_by_byte(void **state)
{
    (void)state;
    static const char text[] = "GET / HTTP/1.1\r\nHost: x\r\n\r\n";
    const char *why;
    vvi_head h;
    size_t used;
    for (size_t n = 0; n < strlen(text); n++) {
        memcpy(room, text, sizeof text);
        assert_int_equal(vvi_head_read(&h, &why, &used, room, n), 0);
        assert_memory_equal(room, text, sizeof text); /* nothing is changed before */
    }
    assert_int_equal(read_text(&h, text, &used), 200);
}

static void what_can_be_read_in_two_ways_is_refused(void **state)
{
    (void)state;
    static const struct {
        int status;
        const char *text;
    } rows[] = {{400, "GET / HTTP/1.1\r\nHost: a\r\nHost: a\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a\r\nX: a\r\n b\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a\r\nX : a\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a\r\nX\r\n\r\n"},
                {400, "GET / HTTP/1.1\n\n"},
                {400, "GET /%0a HTTP/1.1\r\n\r\n"},
                {400, "GET /%4 HTTP/1.1\r\n\r\n"},
                {400, "GET /%ff HTTP/1.1\r\n\r\n"},
                {400, "GET http://a/ HTTP/1.1\r\n\r\n"},
                {400, "PUT / HTTP/1.1\r\nHost: a\r\nContent-Length: 1\r\nContent-Length: 1\r\n\r\n"},
                {400, "PUT / HTTP/1.1\r\nHost: a\r\nContent-Length: +1\r\n\r\n"},
                {400, "PUT / HTTP/1.1\r\nHost: a\r\nContent-Length:\r\n\r\n"},
                {400, "PUT / HTTP/1.1\r\nHost: a\r\nContent-Length: 1\r\nTransfer-Encoding: chunked\r\n\r\n"},
                {411, "PUT / HTTP/1.1\r\nHost: a\r\nTransfer-Encoding: chunked\r\n\r\n"},
                {505, "GET / HTTP/1.0\r\n\r\n"}};
    vvi_head h;
    size_t used;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (read_text(&h, rows[i].text, &used) != rows[i].status)
            fail_msg("%s", rows[i].text);
}

/* Whether it is a name of this server is for others to say. */
static void a_request_names_its_host(void **state)
{
    (void)state;
    static const struct {
        int status;
        const char *text;
    } rows[] = {{400, "GET / HTTP/1.1\r\n\r\n"},
                {400, "PUT / HTTP/1.1\r\nContent-Length: 0\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a b\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a/\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: a@b\r\n\r\n"},
                {400, "GET / HTTP/1.1\r\nHost: <a>\r\n\r\n"},
                {200, "GET / HTTP/1.1\r\nHost:\r\n\r\n"},
                {200, "GET / HTTP/1.1\r\nHost: [::1]:80\r\n\r\n"}};
    vvi_head h;
    size_t used;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++)
        if (read_text(&h, rows[i].text, &used) != rows[i].status)
            fail_msg("%s", rows[i].text);
}

static void a_head_has_a_size(void **state)
{
    (void)state;
    const char *why;
    vvi_head h;
    size_t used;
    memset(room, 'a', sizeof room);
    memcpy(room, "GET /", 5);
    assert_int_equal(vvi_head_read(&h, &why, &used, room, VVI_HEAD_MOST - 1), 0);
    assert_int_equal(vvi_head_read(&h, &why, &used, room, VVI_HEAD_MOST), 431);
}

static void lists_have_words(void **state)
{
    (void)state;
    assert_true(vvi_head_lists("keep-alive, Upgrade", "upgrade"));
    assert_true(vvi_head_lists("chat , volvis", "volvis"));
    assert_false(vvi_head_lists("xupgrade, upgraded", "upgrade"));
    assert_false(vvi_head_lists("", "upgrade"));
    assert_false(vvi_head_lists(NULL, "upgrade"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_a_page_sends_is_read),
        cmocka_unit_test(a_head_is_waited_for_byte_by_byte),
        cmocka_unit_test(what_can_be_read_in_two_ways_is_refused),
        cmocka_unit_test(a_request_names_its_host),
        cmocka_unit_test(a_head_has_a_size),
        cmocka_unit_test(lists_have_words),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
