/* The cache of derived data. */
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

/* What a maker is told, and what it counts. */
typedef struct recipe {
    size_t bytes;
    vv_status fails; /* VV_OK: it does not */
    atomic_int makes;
    int doze_us;
    atomic_bool *waits_for; /* not NULL: it makes until this is so */
    vv_runtime *forgets;    /* not NULL: forgets field 1 while it makes */
} recipe;

static atomic_int dropped;

static void drop(void *value)
{
    atomic_fetch_add(&dropped, 1);
    vvi_free(value);
}

static vv_status make(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    recipe *r = user;
    atomic_fetch_add(&r->makes, 1);
    if (r->doze_us)
        usleep((useconds_t)r->doze_us);
    while (r->waits_for && !atomic_load(r->waits_for))
        usleep(100);
    if (r->forgets)
        vvi_cache_forget(r->forgets, 1);
    if (r->fails != VV_OK)
        return vv_fail(r->fails, "cannot be made");
    *value_out = vvi_alloc_zeroed(job, r->bytes, VVI_MEM_DERIVED);
    *bytes_out = r->bytes;
    return *value_out ? VV_OK : vv_fail_memory(r->bytes);
}

static vvi_cached *get(vv_job *job, const char *what, uint64_t identity, uint64_t parameters, recipe *r)
{
    vvi_cached *cached = NULL;
    assert_int_equal(vvi_cache_get(&cached, &(vvi_cache_key){what, identity, parameters}, make, drop, r, job), VV_OK);
    assert_non_null(cached);
    return cached;
}

static vvi_cache_counts counts_of(vv_job *job)
{
    vvi_cache_counts counts;
    vvi_cache_get_counts(&counts, vv_job_runtime(job));
    return counts;
}

static void what_was_made_is_found_again(void **state)
{
    (void)state;
    recipe r = {.bytes = 100};
    vv_job *job = test_job(1, 0);
    dropped = 0;
    vvi_cached *a = get(job, "minmax", 1, 2, &r), *b = get(job, "minmax", 1, 2, &r);
    assert_ptr_equal(a, b);
    assert_ptr_equal(vvi_cached_value(a), vvi_cached_value(b));
    vvi_cache_release(a);
    vvi_cache_release(b);
    char same_word[] = "minmax"; /* another copy of the literal */
    vvi_cached *c = get(job, same_word, 1, 2, &r);
    vvi_cache_release(c);
    vvi_cache_release(NULL);
    assert_int_equal(r.makes, 1);
    assert_int_equal(dropped, 0);
    const vvi_cache_counts counts = counts_of(job);
    assert_int_equal(counts.hits, 2);
    assert_int_equal(counts.misses, 1);
    assert_int_equal(counts.entries, 1);
    assert_int_equal(counts.bytes, 100);
    vv_job_release(job);
    assert_int_equal(dropped, 1); /* with its runtime */
}

static void any_part_of_the_key_makes_another_value(void **state)
{
    (void)state;
    recipe r = {.bytes = 10};
    vv_job *job = test_job(1, 0);
    vvi_cached *all[4] = {get(job, "minmax", 1, 2, &r), get(job, "gradient", 1, 2, &r), get(job, "minmax", 2, 2, &r),
                          get(job, "minmax", 1, 3, &r)};
    assert_int_equal(r.makes, 4);
    for (int i = 0; i < 4; i++)
        vvi_cache_release(all[i]);
    vv_job_release(job);
}

static void the_least_recently_used_goes_first_and_pinned_ones_stay(void **state)
{
    (void)state;
    recipe r = {.bytes = 1000};
    vv_job *job = test_job(1, 0);
    vv_runtime *runtime = vv_job_runtime(job);
    vvi_cached *pinned = get(job, "x", 1, 0, &r);
    for (uint64_t i = 1; i < 5; i++)
        vvi_cache_release(get(job, "x", 1, i, &r));
    vvi_cache_release(get(job, "x", 1, 1, &r)); /* used again: 2 is now the oldest */
    assert_int_equal(vvi_cache_shed(runtime, 1500), 2000);
    assert_int_equal(r.makes, 5);
    vvi_cache_release(get(job, "x", 1, 1, &r));
    vvi_cache_release(get(job, "x", 1, 4, &r));
    assert_int_equal(r.makes, 5); /* both were still there */
    vvi_cache_release(get(job, "x", 1, 2, &r));
    vvi_cache_release(get(job, "x", 1, 3, &r));
    assert_int_equal(r.makes, 7); /* these two had gone */
    assert_int_equal(vvi_cache_shed(runtime, UINT64_MAX), 4000);
    assert_int_equal(vvi_cache_shed(runtime, 1), 0); /* only the pinned one is left */
    assert_int_equal(counts_of(job).entries, 1);
    assert_int_equal(counts_of(job).drops, 6);
    vvi_cache_release(pinned);
    assert_int_equal(vvi_cache_shed(runtime, 1), 1000);
    assert_int_equal(counts_of(job).bytes, 0);
    vv_job_release(job);
}

static void a_maker_that_fails_leaves_nothing(void **state)
{
    (void)state;
    recipe r = {.bytes = 10, .fails = VV_E_FORMAT};
    vv_job *job = test_job(1, 0);
    vvi_cached *cached = (vvi_cached *)&r;
    const vvi_cache_key key = {"x", 1, 1};
    dropped = 0;
    assert_int_equal(vvi_cache_get(&cached, &key, make, drop, &r, job), VV_E_FORMAT);
    assert_null(cached);
    assert_string_equal(vv_error_last()->message, "cannot be made");
    assert_int_equal(counts_of(job).entries, 0);
    assert_int_equal(dropped, 0);
    r.fails = VV_OK;
    vvi_cache_release(get(job, "x", 1, 1, &r));
    assert_int_equal(r.makes, 2);
    vv_job_release(job);
}

static void forgetting_a_field_takes_all_of_it_and_nothing_else(void **state)
{
    (void)state;
    recipe r = {.bytes = 10};
    vv_job *job = test_job(1, 0);
    vv_runtime *runtime = vv_job_runtime(job);
    dropped = 0;
    for (uint64_t i = 0; i < 1000; i++)
        vvi_cache_release(get(job, "x", i % 4, i, &r));
    vvi_cached *pinned = get(job, "x", 1, 1, &r);
    vvi_cache_forget(runtime, 1);
    assert_int_equal(counts_of(job).entries, 750);
    assert_int_equal(dropped, 249);
    *(char *)vvi_cached_value(pinned) = 1; /* still there */
    vvi_cached *again = get(job, "x", 1, 1, &r);
    assert_ptr_not_equal(again, pinned);
    vvi_cache_release(pinned);
    assert_int_equal(dropped, 250);
    vvi_cache_release(again);
    assert_int_equal(dropped, 250);
    vvi_cache_forget(runtime, 77);
    vvi_cache_forget(NULL, 1);
    vv_job_release(job);
}

static void what_is_forgotten_while_it_is_made_lives_for_its_maker_alone(void **state)
{
    (void)state;
    recipe r = {.bytes = 10};
    vv_job *job = test_job(1, 0);
    r.forgets = vv_job_runtime(job);
    dropped = 0;
    vvi_cached *cached = get(job, "x", 1, 1, &r);
    assert_int_equal(counts_of(job).entries, 0);
    vvi_cache_release(cached);
    assert_int_equal(dropped, 1);
    vv_job_release(job);
}

static void without_a_job_nothing_is_kept(void **state)
{
    (void)state;
    recipe r = {.bytes = 10};
    dropped = 0;
    vvi_cached *a = get(NULL, "x", 1, 1, &r), *b = get(NULL, "x", 1, 1, &r);
    assert_ptr_not_equal(a, b);
    vvi_cache_release(a);
    vvi_cache_release(b);
    assert_int_equal(r.makes, 2);
    assert_int_equal(dropped, 2);
    r.fails = VV_E_FORMAT;
    vvi_cached *none;
    assert_int_equal(vvi_cache_get(&none, &(vvi_cache_key){"x", 1, 1}, make, drop, &r, NULL), VV_E_FORMAT);
    assert_null(none);
}

static void a_pinned_value_outlives_its_runtime(void **state)
{
    (void)state;
    recipe r = {.bytes = 10};
    vv_job *job = test_job(1, 0);
    dropped = 0;
    vvi_cached *cached = get(job, "x", 1, 1, &r);
    vv_job_release(job);
    assert_int_equal(dropped, 0);
    *(char *)vvi_cached_value(cached) = 1;
    vvi_cache_release(cached);
    assert_int_equal(dropped, 1);
}

/* Many threads --------------------------------------------------------------------------------------------------- */

typedef struct kitchen {
    vv_job *job;
    recipe *r;
} kitchen;

static vv_status get_one_of_few(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    const kitchen *s = shared;
    vvi_cached *cached;
    const vvi_cache_key key = {"x", 1, index % 5};
    const vv_status st = vvi_cache_get(&cached, &key, make, drop, s->r, s->job);
    vvi_cache_release(cached);
    return st;
}

static void one_thread_makes_while_the_others_wait(void **state)
{
    (void)state;
    recipe r = {.bytes = 10, .doze_us = 5000};
    kitchen shared = {test_job(8, 0), &r};
    const vvi_work work = {.item = get_one_of_few};
    assert_int_equal(vvi_parallel_for(shared.job, &work, &shared, 400), VV_OK);
    assert_int_equal(r.makes, 5);
    assert_int_equal(counts_of(shared.job).misses, 5);
    assert_int_equal(counts_of(shared.job).hits, 395);
    vv_job_release(shared.job);
}

static void a_waiting_thread_makes_what_the_maker_could_not(void **state)
{
    (void)state;
    recipe r = {.bytes = 10, .doze_us = 1000, .fails = VV_E_FORMAT};
    kitchen shared = {test_job(8, 0), &r};
    const vvi_work work = {.item = get_one_of_few};
    assert_int_equal(vvi_parallel_for(shared.job, &work, &shared, 400), VV_E_FORMAT);
    assert_in_range(r.makes, 1, 400);
    assert_int_equal(counts_of(shared.job).entries, 0);
    vv_job_release(shared.job);
}

typedef struct slow_maker {
    vv_runtime *runtime;
    recipe r;
} slow_maker;

static void *make_slowly(void *user)
{
    slow_maker *s = user;
    vv_job *job;
    if (vv_job_new(&job, s->runtime, NULL, NULL) != VV_OK)
        return NULL;
    vvi_cached *cached;
    vvi_cache_get(&cached, &(vvi_cache_key){"x", 1, 1}, make, drop, &s->r, job);
    vvi_cache_release(cached);
    vv_job_release(job);
    return NULL;
}

static void a_waiting_thread_can_be_cancelled(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    atomic_bool given_up = false;
    slow_maker slow = {.runtime = vv_job_runtime(job), .r = {.bytes = 10, .waits_for = &given_up}};
    recipe mine = {.bytes = 10};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, make_slowly, &slow), 0);
    while (atomic_load(&slow.r.makes) == 0)
        usleep(100);
    vv_job_cancel(job);
    vvi_cached *cached;
    assert_int_equal(vvi_cache_get(&cached, &(vvi_cache_key){"x", 1, 1}, make, drop, &mine, job), VV_E_CANCELLED);
    assert_null(cached);
    assert_int_equal(mine.makes, 0);
    atomic_store(&given_up, true);
    pthread_join(thread, NULL);
    assert_int_equal(counts_of(job).entries, 1);
    vv_job_release(job);
}

static vv_status make_from_itself(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    (void)value_out;
    (void)bytes_out;
    vvi_cached *cached;
    return vvi_cache_get(&cached, user, make_from_itself, drop, user, job);
}

static void a_value_that_needs_itself_is_an_error_not_a_wait(void **state)
{
    (void)state;
    vvi_cache_key key = {"loop", 1, 1};
    vvi_cached *cached;
    vv_job *job = test_job(2, 0);
    assert_int_equal(vvi_cache_get(&cached, &key, make_from_itself, drop, &key, job), VV_E_INTERNAL);
    assert_int_equal(counts_of(job).entries, 0);
    vv_job_release(job);
}

static vv_status stir(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    vv_job *job = shared;
    for (uint64_t i = 0; i < 40; i++) {
        const uint64_t dice = test_random(index, i);
        recipe r = {.bytes = dice % 30000 + 1};
        vvi_cached *cached;
        const vvi_cache_key key = {"x", dice % 3, dice / 3 % 20};
        const vv_status st = vvi_cache_get(&cached, &key, make, drop, &r, job);
        if (st != VV_OK && st != VV_E_LIMIT)
            return st;
        if (st == VV_OK)
            (void)*(volatile char *)vvi_cached_value(cached);
        vvi_cache_release(cached);
        if (dice % 50 == 0)
            vvi_cache_forget(vv_job_runtime(job), dice % 3);
        if (dice % 71 == 0)
            vvi_cache_shed(vv_job_runtime(job), 50000);
    }
    return VV_OK;
}

static void random_use_under_memory_pressure_stays_within_the_limit(void **state)
{
    (void)state;
    vv_job *job = test_job(8, 200000);
    vv_runtime *runtime = vv_job_runtime(job);
    const vvi_work work = {.item = stir};
    dropped = 0;
    assert_int_equal(vvi_parallel_for(job, &work, job, 300), VV_OK);
    assert_in_range(vv_runtime_memory_peak(runtime), 100000, 200000);
    assert_true(dropped > 0);
    const vvi_cache_counts counts = counts_of(job);
    assert_int_equal(vvi_cache_shed(runtime, UINT64_MAX), counts.bytes); /* all are unpinned again */
    assert_int_equal(counts_of(job).entries, 0);
    assert_int_equal(counts_of(job).bytes, 0);
    assert_int_equal(vv_runtime_memory_used(runtime), 0);
    vv_job_release(job);
}

/* A plain list beside the cache says what must be there, for any order of gets and sheds. */
static void the_order_of_dropping_equals_a_plain_list(void **state)
{
    (void)state;
    const uint64_t seed = test_seed();
    uint64_t model[64];
    size_t n = 0; /* oldest first */
    vv_job *job = test_job(1, 0);
    for (uint64_t i = 0; i < 5000; i++) {
        const uint64_t dice = test_random(seed, i), k = dice % 32;
        recipe r = {.bytes = 100};
        if (dice / 32 % 6 == 0) {
            const uint64_t wanted = dice / 256 % 5;
            const size_t gone = wanted < n ? (size_t)wanted : n;
            assert_int_equal(vvi_cache_shed(vv_job_runtime(job), wanted * 100), gone * 100);
            memmove(model, model + gone, (n - gone) * sizeof *model);
            n -= gone;
            continue;
        }
        size_t at = 0;
        while (at < n && model[at] != k)
            at++;
        vvi_cache_release(get(job, "x", 1, k, &r));
        assert_int_equal(r.makes, at == n);
        if (at < n)
            memmove(model + at, model + at + 1, (--n - at) * sizeof *model);
        model[n++] = k;
        assert_int_equal(counts_of(job).entries, n);
    }
    vv_job_release(job);
}

/* Failing allocations -------------------------------------------------------------------------------------------- */

static vv_status get_some(void *user)
{
    vv_job *job = user;
    recipe r = {.bytes = 1000};
    vv_status st = VV_OK;
    for (uint64_t i = 0; i < 3 && st == VV_OK; i++) {
        vvi_cached *cached;
        st = vvi_cache_get(&cached, &(vvi_cache_key){"x", 1, i}, make, drop, &r, job);
        assert_int_equal(cached == NULL, st != VV_OK);
        vvi_cache_release(cached);
    }
    vvi_cache_forget(vv_job_runtime(job), 1);
    assert_int_equal(vv_runtime_memory_used(vv_job_runtime(job)), 0);
    return st;
}

static void every_allocation_can_fail(void **state)
{
    (void)state;
    vv_job *job = test_job(1, 0);
    assert_int_equal(test_fail_each_alloc(get_some, job), 6);
    vv_job_release(job);
}

static void the_hash_is_fnv_1a(void **state)
{
    (void)state;
    assert_true(vvi_hash("", 0, 0) == UINT64_C(0xcbf29ce484222325));
    assert_true(vvi_hash("a", 1, 0) == UINT64_C(0xaf63dc4c8601ec8c)); /* published test values */
    assert_true(vvi_hash("foobar", 6, 0) == UINT64_C(0x85944171f73967e8));
    assert_true(vvi_hash("foobar", 6, 1) != vvi_hash("foobar", 6, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_was_made_is_found_again),
        cmocka_unit_test(any_part_of_the_key_makes_another_value),
        cmocka_unit_test(the_least_recently_used_goes_first_and_pinned_ones_stay),
        cmocka_unit_test(a_maker_that_fails_leaves_nothing),
        cmocka_unit_test(forgetting_a_field_takes_all_of_it_and_nothing_else),
        cmocka_unit_test(what_is_forgotten_while_it_is_made_lives_for_its_maker_alone),
        cmocka_unit_test(without_a_job_nothing_is_kept),
        cmocka_unit_test(a_pinned_value_outlives_its_runtime),
        cmocka_unit_test(one_thread_makes_while_the_others_wait),
        cmocka_unit_test(a_waiting_thread_makes_what_the_maker_could_not),
        cmocka_unit_test(a_waiting_thread_can_be_cancelled),
        cmocka_unit_test(a_value_that_needs_itself_is_an_error_not_a_wait),
        cmocka_unit_test(random_use_under_memory_pressure_stays_within_the_limit),
        cmocka_unit_test(the_order_of_dropping_equals_a_plain_list),
        cmocka_unit_test(every_allocation_can_fail),
        cmocka_unit_test(the_hash_is_fnv_1a),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
