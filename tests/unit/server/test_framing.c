/* What comes through a WebSocket, and what is said to its key. */
#include "server/framing.h"
#include "server/handshake.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

/* The example of RFC 6455, 1.3. */
static void the_key_is_answered(void **state)
{
    (void)state;
    char text[VVI_ACCEPT_TEXT];
    vvi_handshake_accept(text, "dGhlIHNhbXBsZSBub25jZQ==");
    assert_string_equal(text, "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=");
}

/* The examples of RFC 6455, 5.7, masked, whole and in pieces; a ping between the pieces. */
static const uint8_t hello[] = {0x81, 0x85, 0x37, 0xfa, 0x21, 0x3d, 0x7f, 0x9f, 0x4d, 0x51, 0x58};
static const uint8_t pieces[] = {0x01, 0x83, 0,       0,       0,    0,    'H', 'e', 'l', 0x89, 0x82, 1,  1,
                                 1,    1,    'p' ^ 1, 'q' ^ 1, 0x80, 0x82, 0,   0,   0,   0,    'l',  'o'};

static void messages_come_however_they_are_cut(void **state)
{
    (void)state;
    for (size_t step = 1; step <= sizeof pieces; step++) {
        vvi_framing f = {.n_head = 0};
        int pings = 0, messages = 0;
        for (size_t i = 0; i < sizeof pieces; i += step) {
            const uint8_t *at = pieces + i, *end = pieces + (i + step < sizeof pieces ? i + step : sizeof pieces);
            while (at < end) {
                const vvi_framed what = vvi_framing_take(&f, &at, end);
                assert_int_not_equal(what, VVI_FRAMED_BAD);
                pings += what == VVI_FRAMED_PING && f.n_control == 2 && memcmp(f.control, "pq", 2) == 0;
                messages += what == VVI_FRAMED_MESSAGE && strcmp(f.message, "Hello") == 0;
            }
        }
        assert_int_equal(pings, 1);
        assert_int_equal(messages, 1);
        vvi_framing_clear(&f);
    }
}

static void one_message_after_the_other(void **state)
{
    (void)state;
    vvi_framing f = {.n_head = 0};
    for (int i = 0; i < 3; i++) {
        const uint8_t *at = hello;
        assert_int_equal(vvi_framing_take(&f, &at, hello + sizeof hello), VVI_FRAMED_MESSAGE);
        assert_ptr_equal(at, hello + sizeof hello);
        assert_int_equal(f.n_message, 5);
    }
    vvi_framing_clear(&f);
}

static void what_nobody_may_send_is_refused(void **state)
{
    (void)state;
    static const struct {
        int code;
        uint8_t bytes[16];
        size_t n;
    } rows[] = {{VVI_CLOSE_PROTOCOL, {0x81, 0x02, '{', '}'}, 4},
                {VVI_CLOSE_PROTOCOL, {0xc1, 0x80}, 2},
                {VVI_CLOSE_PROTOCOL, {0x83, 0x80}, 2},
                {VVI_CLOSE_PROTOCOL, {0x80, 0x80}, 2},
                {VVI_CLOSE_PROTOCOL, {0x09, 0x80}, 2},
                {VVI_CLOSE_PROTOCOL, {0x89, 0xfe}, 2},
                {VVI_CLOSE_PROTOCOL, {0x81, 0xfe, 0, 5, 0, 0, 0, 0}, 8},
                {VVI_CLOSE_PROTOCOL, {0x81, 0xff, 0x80, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 14},
                {VVI_CLOSE_TOO_LARGE, {0x81, 0xff, 0, 0, 0, 0, 0, 0x10, 0, 1, 0, 0, 0, 0}, 14},
                {VVI_CLOSE_KIND, {0x82, 0x80}, 2},
                {VVI_CLOSE_NO_TEXT, {0x81, 0x81, 0, 0, 0, 0, 0xff}, 7},
                {VVI_CLOSE_PROTOCOL, {0x88, 0x81, 0, 0, 0, 0, 3}, 7},
                {VVI_CLOSE_PROTOCOL, {0x88, 0x82, 0, 0, 0, 0, 3, 0xed}, 8}};
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        vvi_framing f = {.n_head = 0};
        const uint8_t *at = rows[i].bytes;
        if (vvi_framing_take(&f, &at, at + rows[i].n) != VVI_FRAMED_BAD || f.code != rows[i].code || !f.why)
            fail_msg("row %zu", i);
        vvi_framing_clear(&f);
    }
}

/* So many bytes of a message that says it has `length`, as one frame, to go on or not. */
static vvi_framed begin_message(vvi_framing *f, uint32_t length, size_t n)
{
    static const uint8_t zeros[1 << 16];
    const uint8_t head[14] =
        {0x81,           0xff, 0, 0, 0, 0, (uint8_t)(length >> 24), (uint8_t)(length >> 16), (uint8_t)(length >> 8),
         (uint8_t)length},
                  *at = head;
    vvi_framed what = vvi_framing_take(f, &at, head + sizeof head);
    while (what == VVI_FRAMED_MORE && n > 0) {
        const size_t part = n < sizeof zeros ? n : sizeof zeros;
        at = zeros;
        what = vvi_framing_take(f, &at, zeros + part);
        n -= part;
    }
    return what;
}

static void long_messages_share_what_room_there_is(void **state)
{
    (void)state;
    enum { MANY = 64, LONG = VVI_MESSAGE_MOST };
    static vvi_framing all[MANY];
    size_t shared = 0, room = 0;
    int refused = 0;
    for (int i = 0; i < MANY; i++) {
        all[i] = (vvi_framing){.shared = &shared};
        assert_int_equal(begin_message(&all[i], LONG, VVI_MESSAGE_OWN / 2), VVI_FRAMED_MORE);
        assert_true(all[i].room <= VVI_MESSAGE_OWN);
    }
    assert_int_equal(shared, 0);
    for (int i = 0; i < MANY; i++) {
        vvi_framing_clear(&all[i]);
        all[i] = (vvi_framing){.shared = &shared};
        refused += begin_message(&all[i], LONG, LONG - 1) == VVI_FRAMED_BAD && all[i].code == VVI_CLOSE_TRY_LATER;
        room += all[i].room;
    }
    assert_int_not_equal(refused, 0);
    assert_true(refused < MANY - 16); /* 16 MiB are for more than sixteen */
    assert_true(room <= MANY * (size_t)VVI_MESSAGE_OWN + VVI_MESSAGES_SHARED + MANY);
    for (int i = 0; i < MANY; i++)
        vvi_framing_clear(&all[i]);
    assert_int_equal(shared, 0);
}

static void a_long_message_leaves_no_room_behind(void **state)
{
    (void)state;
    size_t shared = 0;
    vvi_framing f = {.shared = &shared};
    assert_int_equal(begin_message(&f, VVI_MESSAGE_MOST, VVI_MESSAGE_MOST), VVI_FRAMED_MESSAGE);
    assert_int_equal(f.n_message, VVI_MESSAGE_MOST);
    assert_true(shared > 0 && f.room <= VVI_MESSAGE_MOST + 1);
    vvi_framing_forget(&f);
    assert_true(shared == 0 && f.room < 8192);
    assert_int_equal(begin_message(&f, 70000, 70000), VVI_FRAMED_MESSAGE);
    vvi_framing_clear(&f);
}

static void who_has_not_said_hello_says_little(void **state)
{
    (void)state;
    vvi_framing f = {.most = 4096};
    assert_int_equal(begin_message(&f, 70000, 0), VVI_FRAMED_BAD);
    assert_int_equal(f.code, VVI_CLOSE_TOO_LARGE);
    vvi_framing_clear(&f);
}

static void our_frames_say_their_length(void **state)
{
    (void)state;
    uint8_t out[10];
    assert_int_equal(vvi_framing_head(out, VVI_FRAME_TEXT, 125), 2);
    assert_int_equal(out[0] << 8 | out[1], 0x817d);
    assert_int_equal(vvi_framing_head(out, VVI_FRAME_BINARY, 126), 4);
    assert_int_equal(out[1] << 16 | out[2] << 8 | out[3], 0x7e007e);
    assert_int_equal(vvi_framing_head(out, VVI_FRAME_BINARY, 65536), 10);
    assert_int_equal(out[1] << 24 | out[7] << 16 | out[8] << 8 | out[9], 0x7f010000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_key_is_answered),
        cmocka_unit_test(messages_come_however_they_are_cut),
        cmocka_unit_test(one_message_after_the_other),
        cmocka_unit_test(what_nobody_may_send_is_refused),
        cmocka_unit_test(our_frames_say_their_length),
        cmocka_unit_test(long_messages_share_what_room_there_is),
        cmocka_unit_test(a_long_message_leaves_no_room_behind),
        cmocka_unit_test(who_has_not_said_hello_says_little),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
