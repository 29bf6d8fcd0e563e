/* What clients may cost, by a clock of ours. */
#include "server/ration.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#define MS INT64_C(1000000)
#define S (1000 * MS)

static void come(vvi_ration *r, vvi_rations *all, const char *address, int64_t now)
{
    assert_true(vvi_ration_begin(r, all, address, now));
    vvi_ration_greeted(r, now);
}

/* One who sends whenever he may, messages of so many seconds each, from `from` to `to`; seconds that he got. */
static double flood(vvi_ration *r, double cost, int64_t from, int64_t to)
{
    double got = 0;
    for (int64_t now = from; now < to;) {
        const int64_t wait = vvi_ration_wait(r, now);
        if (wait == 0) {
            vvi_ration_pay(r, cost, 0, now);
            got += cost;
        }
        now += wait > MS ? wait : MS;
    }
    return got;
}

static void who_is_alone_may_do_as_he_likes(void **state)
{
    (void)state;
    vvi_rations all = {.n = 0};
    vvi_ration r, other;
    come(&r, &all, "a", 0);
    assert_true(flood(&r, 0.01, 0, 10 * S) > 90);
    come(&other, &all, "b", 10 * S);
    const int64_t wait = vvi_ration_wait(&r, 10 * S);
    assert_true(wait > S && wait < 10 * S); /* what he has spent alone is forgotten soon */
    vvi_ration_end(&r, 10 * S);
    vvi_ration_end(&other, 10 * S);
    vvi_rations_clear(&all);
}

static void one_gets_a_tenth_and_an_address_a_fifth(void **state)
{
    (void)state;
    enum { MANY = 20 };
    vvi_rations all = {.n = 0};
    vvi_ration r[MANY], other;
    come(&other, &all, "b", 0);
    come(&r[0], &all, "a", 0);
    const double one = flood(&r[0], 0.02, 0, 60 * S);
    assert_true(one > 5 && one < 6.5);
    for (int i = 1; i < MANY; i++)
        come(&r[i], &all, "a", 60 * S);
    double many = 0;
    for (int64_t now = 60 * S; now < 120 * S; now += 10 * MS) /* all of them in turn */
        for (int i = 0; i < MANY; i++)
            if (vvi_ration_wait(&r[i], now) == 0) {
                vvi_ration_pay(&r[i], 0.005, 0, now);
                many += 0.005;
            }
    assert_true(many > 10 && many < 14.5);
    for (int i = 0; i < MANY; i++)
        vvi_ration_end(&r[i], 120 * S);
    vvi_ration_end(&other, 120 * S);
    vvi_rations_clear(&all);
}

/* Twenty motions a second are 0.2 % of a core: those who flood beside him, from his own address, hold up none. */
static void who_spends_little_is_not_held_up_by_his_address(void **state)
{
    (void)state;
    enum { MANY = 8 };
    vvi_rations all = {.n = 0};
    vvi_ration honest, r[MANY];
    come(&honest, &all, "a", 0);
    assert_int_equal(vvi_ration_wait(&honest, 5 * S), 0);
    for (int i = 0; i < MANY; i++)
        come(&r[i], &all, "a", 5 * S);
    for (int64_t now = 5 * S; now < 65 * S; now += 10 * MS) {
        for (int i = 0; i < MANY; i++)
            if (vvi_ration_wait(&r[i], now) == 0)
                vvi_ration_pay(&r[i], 0.01, 100000, now);
        if (now % (50 * MS) != 0)
            continue;
        assert_int_equal(vvi_ration_wait(&honest, now), 0);
        vvi_ration_pay(&honest, 80e-6, 100, now);
    }
    assert_true(vvi_ration_persists(&r[0], 65 * S));
    assert_false(vvi_ration_persists(&honest, 65 * S));
    vvi_ration_wait(&r[0], 90 * S); /* he rests */
    assert_false(vvi_ration_persists(&r[0], 90 * S));
    for (int i = 0; i < MANY; i++)
        vvi_ration_end(&r[i], 90 * S);
    vvi_ration_end(&honest, 90 * S);
    vvi_rations_clear(&all);
}

/* However many come to his address and say nothing, and bring files. */
static void who_spends_little_is_never_held_up(void **state)
{
    (void)state;
    enum { SILENT = 1000, FILES = 50 };
    static vvi_ration r[SILENT + FILES];
    vvi_rations all = {.n = 0};
    vvi_ration honest;
    come(&honest, &all, "a", 0);
    for (int i = 0; i < SILENT + FILES; i++) {
        assert_true(vvi_ration_begin(&r[i], &all, "a", 0));
        if (i >= SILENT)
            vvi_ration_greeted(&r[i], 0);
    }
    for (int64_t now = 0; now < 900 * S; now += 50 * MS) {
        for (int i = SILENT; i < SILENT + FILES; i++)
            if (vvi_ration_wait(&r[i], now) == 0)
                vvi_ration_pay(&r[i], 0.001, 0, now);
        assert_int_equal(vvi_ration_wait(&honest, now), 0);
        vvi_ration_pay(&honest, 150e-6, 100, now); /* 0.35 % with all that it is charged */
    }
    for (int i = 0; i < SILENT + FILES; i++)
        vvi_ration_end(&r[i], 900 * S);
    vvi_ration_end(&honest, 900 * S);
    vvi_rations_clear(&all);
}

static void to_come_again_is_no_way_to_more(void **state)
{
    (void)state;
    vvi_rations all = {.n = 0};
    vvi_ration other, r;
    double got = 0;
    assert_true(vvi_ration_begin(&other, &all, "b", 0));
    for (int64_t now = 0; now < 60 * S; now += 10 * MS) {
        assert_true(vvi_ration_begin(&r, &all, "a", now));
        if (vvi_ration_wait(&r, now) == 0) {
            vvi_ration_pay(&r, 0.002, 0, now);
            vvi_ration_greeted(&r, now);
            got += 0.002;
        }
        if (vvi_ration_wait(&r, now) == 0) {
            vvi_ration_pay(&r, 0.008, 0, now);
            got += 0.008;
        }
        vvi_ration_end(&r, now);
    }
    assert_true(got > 10 && got < 13.5);
    assert_true(vvi_ration_begin(&r, &all, "a", 60 * S));
    int hellos = 0;
    for (int64_t now = 60 * S; now < 90 * S; now += MS)
        for (; vvi_ration_wait_hello(&r, now) == 0; hellos++)
            vvi_ration_greeted(&r, now);
    assert_in_range(hellos, 149, 155); /* 5 a second */
    vvi_ration_end(&r, 90 * S);
    assert_non_null(all.first);
    vvi_ration_end(&other, 150 * S);
    assert_null(all.first); /* nobody owes anything */
    vvi_rations_clear(&all);
}

/* Connections that come as fast as they may, of 200 microseconds each, where somebody looks. */
static void connections_get_a_tenth_where_somebody_looks(void **state)
{
    (void)state;
    vvi_rations all = {.n = 0};
    vvi_ration r;
    int before = 0, n = 0;
    for (; before < 10000; before++) {
        assert_int_equal(vvi_rations_wait_coming(&all, 0), 0);
        vvi_rations_pay_coming(&all, 100e-6, 1, 0);
    }
    come(&r, &all, "a", 0);
    assert_in_range(vvi_rations_wait_coming(&all, 0), 1, 2 * S); /* what came before holds up nobody for long */
    for (int64_t now = 10 * S; now < 70 * S; now += MS)
        for (; vvi_rations_wait_coming(&all, now) == 0; n++)
            vvi_rations_pay_coming(&all, 100e-6, 1, now);
    assert_in_range(n, 60 * 500, 60 * 500 + 1500);
    vvi_ration_end(&r, 70 * S);
    assert_int_equal(vvi_rations_wait_coming(&all, 70 * S), 0);
    vvi_rations_clear(&all);
}

/* Two hundred that have rested, of one address, and all that they may spend at once. */
static void what_may_be_spent_at_once_is_the_address_s(void **state)
{
    (void)state;
    enum { MANY = 200 };
    static vvi_ration r[MANY];
    vvi_rations all = {.n = 0};
    double got = 0;
    for (int i = 0; i < MANY; i++)
        come(&r[i], &all, "a", 0);
    for (int64_t now = 200 * S; now < 201 * S; now += 10 * MS)
        for (int i = 0; i < MANY; i++)
            if (vvi_ration_wait(&r[i], now) == 0) {
                vvi_ration_pay(&r[i], 0.005, 0, now);
                got += 0.005;
            }
    assert_true(got > 1 && got < 5);
    for (int i = 0; i < MANY; i++)
        vvi_ration_end(&r[i], 201 * S);
    vvi_rations_clear(&all);
}

static void bytes_and_messages_cost_too(void **state)
{
    (void)state;
    vvi_rations all = {.n = 0};
    vvi_ration other, r;
    size_t bytes = 0, messages = 0;
    come(&other, &all, "b", 0);
    come(&r, &all, "a", 0);
    for (int64_t now = 0; now < 60 * S; now += 10 * MS)
        for (int i = 0; i < 100 && vvi_ration_wait(&r, now) == 0; i++, bytes += 1 << 20)
            vvi_ration_pay(&r, 0, 1 << 20, now);
    assert_in_range(bytes >> 20, 100, 140); /* 2 MB a second */
    for (int64_t now = 100 * S; now < 160 * S; now += 10 * MS)
        for (int i = 0; i < 1000 && vvi_ration_wait(&r, now) == 0; i++, messages++)
            vvi_ration_pay(&r, 0, 0, now);
    assert_in_range(messages, 60 * 4000, 60 * 12000);
    vvi_ration_end(&r, 160 * S);
    vvi_ration_end(&other, 160 * S);
    vvi_rations_clear(&all);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_is_alone_may_do_as_he_likes),
        cmocka_unit_test(one_gets_a_tenth_and_an_address_a_fifth),
        cmocka_unit_test(who_spends_little_is_not_held_up_by_his_address),
        cmocka_unit_test(who_spends_little_is_never_held_up),
        cmocka_unit_test(to_come_again_is_no_way_to_more),
        cmocka_unit_test(connections_get_a_tenth_where_somebody_looks),
        cmocka_unit_test(what_may_be_spent_at_once_is_the_address_s),
        cmocka_unit_test(bytes_and_messages_cost_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
