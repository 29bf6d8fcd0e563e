/* Who is let in. */
#include "server/gate.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#define SECOND INT64_C(1000000000)
static const char token[] = "a-token-that-somebody-chose";

static vvi_gate open_gate(bool tls)
{
    vvi_gate gate;
    assert_int_equal(vvi_gate_open(&gate, 8080, token, tls), VV_OK);
    return gate;
}

static vvi_request from_page(void)
{
    return (vvi_request){.host = "localhost:8080",
                         .origin = "http://localhost:8080",
                         .fetch_site = "same-origin",
                         .address = "127.0.0.1"};
}

static void tokens_are_long_and_never_the_same(void **state)
{
    (void)state;
    char a[VVI_TOKEN_TEXT], b[VVI_TOKEN_TEXT];
    assert_int_equal(vvi_token_make(a), VV_OK);
    assert_int_equal(vvi_token_make(b), VV_OK);
    assert_int_equal(strlen(a), 64);
    assert_int_equal(strspn(a, "0123456789abcdef"), 64);
    assert_string_not_equal(a, b);
    vvi_gate gate;
    static const char *const bad[] = {"",
                                      "short",
                                      "with a blank in the middle",
                                      "no\tcontrol-characters",
                                      "0123456789012345678901234567890123456789012345678901234567890123x",
                                      "aaaaaaaaaaaaaaaa",
                                      "12345678901234567890",
                                      "abcdefghabcdefghabcdefgh",
                                      "aabbccaabbddaaee"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(vvi_gate_open(&gate, 1, bad[i], false), VV_E_ARGUMENT);
    assert_int_equal(vvi_gate_open(&gate, 1, NULL, false), VV_OK);
    assert_int_equal(strlen(gate.token), 64);
    assert_string_not_equal(gate.token, gate.cookie);
}

static void a_token_has_128_bits_by_its_length_and_its_kinds_of_characters(void **state)
{
    (void)state;
    static const char *const bad[] = {
        "0123456789abcdef",                       /* a sequence */
        "b7f09c2ae5d1836f",                       /* 16 hex digits: 64 bits */
        "b7f09c2ae5d1836fb7f09c2ae5d1836f",       /* and again */
        "74920174920583619274018365027491836501", /* 38 decimal digits: 126.2 bits */
        "Zx8qLm2Pw9RtYk4Vb7Nc",                   /* 20 of 62 letters and digits: 119 bits */
        "abcdefghijklmnopqrstuvwxyz0123456789",   /* two sequences */
        "zyxwvutsrqponmlkjihgfedcba9876543210",   /* backwards */
        "changemechangemechangeme12",             /* a word again and again, and an end */
        "ChangeMechangemeCHANGEME!2",
        "qwertyuiopasdfghjklzxcvbnmqwerty",                 /* rows of the keyboard */
        "00112233445566778899aabbccddeeff",                 /* pairs in order */
        "aaaaaabbbbbbccccccddddddeeeeeeffffffgggggghhhhhh", /* repeated letters */
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        if (vvi_token_check(bad[i]) != VV_E_ARGUMENT)
            fail_msg("%s is fine", bad[i]);
        assert_non_null(strstr(vv_error_last()->message, "can be guessed"));
    }
    static const char *const good[] = {
        "b7f09c2ae5d1836f4e08a17cd9352b6e",
        "B7F09C2AE5D1836F4E08A17CD9352B6E",
        "Zx8qLm2Pw9RtYk4Vb7NcQh",
        "749201749205836192740183650274918365017",
        "u7Vd-2kR_x9QzLmA4cTw0",
        "b7f09c2ae5d1836f4e08a17cd93567eb", /* begins and ends alike, and has a short sequence, as one of a million has
                                             */
    };
    for (size_t i = 0; i < sizeof good / sizeof *good; i++)
        if (vvi_token_check(good[i]) != VV_OK)
            fail_msg("%s: %s", good[i], vv_error_last()->message);
}

static void only_this_servers_own_names_are_hosts(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(false);
    static const struct {
        const char *host;
        vvi_pass pass;
    } cases[] = {
        {"localhost:8080", VVI_PASS_PAGE},      {"LocalHost:8080", VVI_PASS_PAGE},   {"127.0.0.1:8080", VVI_PASS_PAGE},
        {"[::1]:8080", VVI_PASS_PAGE},          {"localhost", VVI_PASS_NONE},        {"localhost:8081", VVI_PASS_NONE},
        {"evil.example:8080", VVI_PASS_NONE},   {"127.0.0.2:8080", VVI_PASS_NONE},   {"", VVI_PASS_NONE},
        {"localhost:8080.evil", VVI_PASS_NONE}, {"localhost:8080@x", VVI_PASS_NONE}, {NULL, VVI_PASS_NONE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        vvi_request r = from_page();
        r.host = cases[i].host;
        if (vvi_gate_check(&gate, &r, 0) != cases[i].pass)
            fail_msg("host %s", cases[i].host ? cases[i].host : "none");
    }
    assert_int_equal(vvi_gate_add_host(&gate, "viewer.example.org", 443), VV_OK);
    gate.tls = true;
    vvi_request r = {.host = "viewer.example.org", .origin = "https://viewer.example.org"};
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_PAGE);
    assert_int_equal(vvi_gate_add_host(&gate, "a/b", 1), VV_E_ARGUMENT);
}

static void pages_of_others_are_refused(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(false);
    static const char *const origins[] = {
        "http://evil.example",   "https://localhost:8080", "null", "", "http://localhost:8080.evil.example",
        "http://localhost:80801"};
    for (size_t i = 0; i < sizeof origins / sizeof *origins; i++) {
        vvi_request r = from_page();
        r.origin = origins[i];
        r.bearer = token; /* though it knows the token */
        assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_NONE);
    }
    static const char *const sites[] = {"cross-site", "same-site", ""};
    for (size_t i = 0; i < 3; i++) {
        vvi_request r = from_page();
        r.fetch_site = sites[i];
        assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_NONE);
    }
}

static void a_token_or_its_cookie_opens_everything(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(false);
    vvi_request r = from_page();
    char header[512], cookie[256];
    assert_int_equal(vvi_gate_exchange(&gate, &r, token, 0), VVI_PASS_ALL);
    assert_int_equal(vvi_gate_exchange(&gate, &r, "a-token-that-somebody-chosf", 0), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, "a-token-that-somebody-chos", 0), VVI_PASS_NONE);
    r.bearer = token;
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_ALL);
    r.bearer = NULL;
    vvi_gate_cookie(cookie, &gate);
    assert_non_null(strstr(cookie, "HttpOnly"));
    assert_non_null(strstr(cookie, "SameSite=Strict"));
    assert_null(strstr(cookie, token));
    snprintf(header, sizeof header, "other=1; volvis-8080=%s; more=2", gate.cookie);
    r.cookie = header;
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_ALL);
    snprintf(header, sizeof header, "xvolvis-8080=%s; volvis-8080=%.63s; volvis-8080=; volvis-8081=%s; volvis=%s",
             gate.cookie, gate.cookie, gate.cookie, gate.cookie);
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_PAGE);
}

static void who_guesses_is_slowed_down_and_nobody_else(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(false);
    vvi_request r = from_page(), other = from_page();
    r.address = "192.0.2.1", other.address = "192.0.2.2";
    for (int i = 0; i < 5; i++)
        assert_int_equal(vvi_gate_exchange(&gate, &r, "wrong-wrong-wrong-wrong", SECOND), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, "wrong-wrong-wrong-wrong", 2 * SECOND - 1), VVI_PASS_SLOWER);
    assert_int_equal(vvi_gate_exchange(&gate, &r, token, 2 * SECOND - 1), VVI_PASS_ALL); /* never locked out */
    assert_int_equal(vvi_gate_exchange(&gate, &other, token, SECOND), VVI_PASS_ALL);
    assert_int_equal(vvi_gate_exchange(&gate, &r, token, 2 * SECOND), VVI_PASS_ALL);
    for (int i = 0; i < 1000; i++) { /* more addresses than are remembered */
        char address[48];
        snprintf(address, sizeof address, "198.51.100.%d", i);
        r.address = address;
        assert_int_equal(vvi_gate_exchange(&gate, &r, "wrong-wrong-wrong-wrong", 3 * SECOND + i), VVI_PASS_NONE);
    }
}

static void a_launch_token_lets_in_once(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(false);
    vvi_request r = from_page();
    char launch[VVI_TOKEN_TEXT];
    assert_int_equal(vvi_gate_exchange(&gate, &r, "", 0), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_launch(&gate), VV_OK);
    memcpy(launch, gate.launch, sizeof launch);
    r.bearer = launch; /* that is a page's way in, and no other */
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_NONE);
    r.bearer = NULL;
    assert_int_equal(vvi_gate_exchange(&gate, &r, launch, 0), VVI_PASS_ALL);
    assert_int_equal(vvi_gate_exchange(&gate, &r, launch, 0), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, token, 0), VVI_PASS_ALL);
}

static void who_was_let_in_is_so_no_more_when_the_gate_is_renewed(void **state)
{
    (void)state;
    vvi_gate gate = open_gate(true);
    vvi_request r = {.host = "localhost:8080", .origin = "https://localhost:8080", .address = "127.0.0.1"};
    char header[256], cookie[256], launch[VVI_TOKEN_TEXT];
    assert_int_equal(vvi_gate_launch(&gate), VV_OK);
    memcpy(launch, gate.launch, sizeof launch);
    vvi_gate_cookie(cookie, &gate);
    assert_non_null(strstr(cookie, "__Host-volvis-8080="));
    snprintf(header, sizeof header, "%.*s", (int)strcspn(cookie, ";"), cookie);
    r.cookie = header;
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_ALL);
    assert_int_equal(vvi_gate_renew(&gate), VV_OK);
    assert_int_equal(vvi_gate_check(&gate, &r, 0), VVI_PASS_PAGE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, token, 0), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, launch, 0), VVI_PASS_NONE);
    assert_int_equal(vvi_gate_exchange(&gate, &r, gate.token, 0), VVI_PASS_ALL);
}

static void loopback_names_are_known(void **state)
{
    (void)state;
    assert_true(vvi_gate_is_loopback("LocalHost:1") && vvi_gate_is_loopback("[::1]") &&
                vvi_gate_is_loopback("127.0.0.1:80"));
    assert_false(vvi_gate_is_loopback("localhost.example:80") || vvi_gate_is_loopback("") ||
                 vvi_gate_is_loopback("::"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tokens_are_long_and_never_the_same),
        cmocka_unit_test(a_token_has_128_bits_by_its_length_and_its_kinds_of_characters),
        cmocka_unit_test(only_this_servers_own_names_are_hosts),
        cmocka_unit_test(pages_of_others_are_refused),
        cmocka_unit_test(a_token_or_its_cookie_opens_everything),
        cmocka_unit_test(a_launch_token_lets_in_once),
        cmocka_unit_test(who_was_let_in_is_so_no_more_when_the_gate_is_renewed),
        cmocka_unit_test(loopback_names_are_known),
        cmocka_unit_test(who_guesses_is_slowed_down_and_nobody_else),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
