/* Parallel loops. */
#include "core/job.h"
#include "core/memory.h"
#include "core/pool.h"
#include "fail_alloc.h"
#include "fields.h"
#include "jobs.h"

#include <fenv.h>
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include <cmocka.h>

static const int thread_counts[] = {1, 2, 3, 8};
enum { N_THREAD_COUNTS = 4, N = 1000 };

/* Every item once ------------------------------------------------------------------------------------------------ */

typedef struct tally {
    atomic_int times[N];
    atomic_int started, finished, workers[256];
    int n_workers;
} tally;

static vv_status start_tally(void **scratch_out, void *shared, int worker)
{
    tally *t = shared;
    atomic_fetch_add(&t->started, 1);
    if (worker < 0 || worker >= t->n_workers || atomic_fetch_add(&t->workers[worker], 1) != 0)
        return vv_fail(VV_E_INTERNAL, "worker %d is out of range or there twice", worker);
    *scratch_out = calloc(1, sizeof(int));
    return *scratch_out ? VV_OK : vv_fail_memory(sizeof(int));
}

static vv_status count_item(void *scratch, void *shared, size_t index)
{
    tally *t = shared;
    ++*(int *)scratch; /* the sanitizers see it if two workers shared it */
    atomic_fetch_add(&t->times[index], 1);
    return VV_OK;
}

static void finish_tally(void *scratch, void *shared)
{
    tally *t = shared;
    atomic_fetch_add(&t->finished, 1);
    free(scratch);
}

static const vvi_work tally_work = {.start = start_tally, .item = count_item, .finish = finish_tally};

static void check_tally(const tally *t, size_t n_items)
{
    for (size_t i = 0; i < N; i++)
        assert_int_equal(t->times[i], i < n_items);
    assert_int_equal(t->started, t->finished);
    assert_in_range(t->started, n_items > 0, t->n_workers);
}

static void every_item_is_done_once_for_any_thread_count(void **state)
{
    (void)state;
    static const size_t sizes[] = {0, 1, 2, 3, 7, 8, 9, N};
    for (int c = 0; c < N_THREAD_COUNTS; c++) {
        vv_job *job = test_job(thread_counts[c], 0);
        assert_int_equal(vvi_job_threads(job), thread_counts[c]);
        for (size_t s = 0; s < sizeof sizes / sizeof *sizes; s++) {
            tally t = {.n_workers = thread_counts[c]};
            assert_int_equal(vvi_parallel_for(job, &tally_work, &t, sizes[s]), VV_OK);
            check_tally(&t, sizes[s]);
        }
        vv_job_release(job);
    }
}

static void without_a_job_the_calling_thread_does_it_alone(void **state)
{
    (void)state;
    tally t = {.n_workers = vvi_job_threads(NULL)};
    assert_int_equal(t.n_workers, 1);
    assert_int_equal(vvi_parallel_for(NULL, &tally_work, &t, N), VV_OK);
    check_tally(&t, N);
}

/* Threads that have come to the same loop; the first waits for the second, so that a busy machine hides nothing. */
typedef struct meeting {
    pthread_mutex_t lock;
    pthread_cond_t came;
    pthread_t first;
    int n_threads; /* 0, 1, or 2: at least two */
} meeting;

static vv_status meet(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    meeting *m = shared;
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += 60;
    pthread_mutex_lock(&m->lock);
    if (m->n_threads == 0) {
        m->first = pthread_self();
        m->n_threads = 1;
    } else if (!pthread_equal(m->first, pthread_self())) {
        m->n_threads = 2;
        pthread_cond_broadcast(&m->came);
    }
    int late = 0;
    while (m->n_threads < 2 && !late)
        late = pthread_cond_timedwait(&m->came, &m->lock, &until);
    pthread_mutex_unlock(&m->lock);
    return late ? vv_fail(VV_E_INTERNAL, "no second thread came in a minute") : VV_OK;
}

static vv_status meet_in_a_loop(vv_job *job)
{
    meeting m = {.lock = PTHREAD_MUTEX_INITIALIZER, .came = PTHREAD_COND_INITIALIZER};
    const vvi_work work = {.item = meet};
    return vvi_parallel_for(job, &work, &m, 30);
}

static void several_threads_do_take_part(void **state)
{
    (void)state;
    vv_job *job = test_job(3, 0);
    for (int i = 0; i < 20; i++)
        assert_int_equal(meet_in_a_loop(job), VV_OK);
    vv_job_release(job);
}

/* Same results --------------------------------------------------------------------------------------------------- */

static vv_status sum_part(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    double sum = 0;
    for (uint64_t i = 0; i < 100; i++)
        sum += 1 / (test_random_unit(index, i) + 1e-3) * 1e-310 / 3; /* rounds, and is denormal */
    ((double *)shared)[index] = sum;
    return VV_OK;
}

static void the_results_do_not_depend_on_the_number_of_threads(void **state)
{
    (void)state;
    double expected[N], got[N];
    const vvi_work work = {.item = sum_part};
    assert_int_equal(vvi_parallel_for(NULL, &work, expected, N), VV_OK);
    for (int c = 0; c < N_THREAD_COUNTS; c++) {
        vv_job *job = test_job(thread_counts[c], 0);
        assert_int_equal(vvi_parallel_for(job, &work, got, N), VV_OK);
        assert_memory_equal(got, expected, sizeof got);
        vv_job_release(job);
    }
}

static void the_caller_s_rounding_mode_reaches_no_item_and_is_kept(void **state)
{
    (void)state;
    double expected[N], got[N];
    const vvi_work work = {.item = sum_part};
    vv_job *job = test_job(2, 0);
    assert_int_equal(vvi_parallel_for(NULL, &work, expected, N), VV_OK);
    fesetround(FE_UPWARD);
    assert_int_equal(vvi_parallel_for(job, &work, got, N), VV_OK);
    assert_int_equal(fegetround(), FE_UPWARD);
    fesetround(FE_TONEAREST);
    assert_memory_equal(got, expected, sizeof got);
    vv_job_release(job);
}

/* Failures ------------------------------------------------------------------------------------------------------- */

typedef struct failures {
    uint64_t seed;
    unsigned one_in; /* one of so many items fails */
    size_t first;    /* the lowest that does; N: none */
} failures;

static bool is_failing(const failures *f, size_t index)
{
    return f->one_in && test_random(f->seed, index) % f->one_in == 0;
}

static vv_status fail_some(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    const failures *f = shared;
    if (test_random(f->seed + 1, index) % 64 == 0)
        usleep(200);
    char where[32];
    snprintf(where, sizeof where, "%zu", index);
    return is_failing(f, index) ? vv_fail_at(VV_E_FORMAT, "item", where, "is bad") : VV_OK;
}

static void the_lowest_failing_item_is_the_one_reported(void **state)
{
    (void)state;
    static const unsigned odds[] = {2, 10, 100, 700, 5000};
    const vvi_work work = {.item = fail_some};
    const uint64_t seed = test_seed();
    for (int c = 0; c < N_THREAD_COUNTS; c++) {
        vv_job *job = test_job(thread_counts[c], 0);
        for (size_t i = 0; i < 40; i++) {
            failures f = {.seed = seed + i, .one_in = odds[i % 5], .first = 0};
            while (f.first < N && !is_failing(&f, f.first))
                f.first++;
            const vv_status st = vvi_parallel_for(job, &work, &f, N);
            assert_int_equal(st, f.first < N ? VV_E_FORMAT : VV_OK);
            char where[32];
            snprintf(where, sizeof where, "%zu", f.first);
            if (st != VV_OK)
                assert_string_equal(vv_error_last()->where, where);
        }
        vv_job_release(job);
    }
}

static vv_status refuse_to_start(void **scratch_out, void *shared, int worker)
{
    (void)scratch_out;
    (void)shared;
    return vv_fail(VV_E_MEMORY, "worker %d has no memory", worker);
}

static vv_status never_run(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    *(bool *)shared = true;
    return VV_OK;
}

static void never_finish(void *scratch, void *shared)
{
    (void)scratch;
    *(bool *)shared = true;
}

static void a_start_that_fails_ends_the_loop_without_item_or_finish(void **state)
{
    (void)state;
    const vvi_work work = {.start = refuse_to_start, .item = never_run, .finish = never_finish};
    for (int c = 0; c < N_THREAD_COUNTS; c++) {
        vv_job *job = test_job(thread_counts[c], 0);
        bool ran = false;
        assert_int_equal(vvi_parallel_for(job, &work, &ran, N), VV_E_MEMORY);
        assert_non_null(strstr(vv_error_last()->message, "has no memory"));
        assert_false(ran);
        vv_job_release(job);
    }
}

/* Loops in loops and beside loops -------------------------------------------------------------------------------- */

typedef struct nest {
    vv_job *job;
    atomic_int inner, moved;
} nest;

typedef struct inner {
    nest *nest;
    pthread_t thread;
} inner;

static vv_status inner_item(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    inner *in = shared;
    atomic_fetch_add(&in->nest->inner, 1);
    if (!pthread_equal(in->thread, pthread_self()))
        atomic_fetch_add(&in->nest->moved, 1);
    usleep(200); /* time enough for an idle thread to come */
    return VV_OK;
}

static vv_status outer_item(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    inner in = {shared, pthread_self()};
    const vvi_work work = {.item = inner_item};
    return vvi_parallel_for(in.nest->job, &work, &in, 50);
}

static void a_nested_loop_runs_on_its_worker_alone(void **state)
{
    (void)state;
    const vvi_work work = {.item = outer_item};
    for (int c = 0; c < N_THREAD_COUNTS; c++) {
        nest n = {.job = test_job(thread_counts[c], 0)};
        assert_int_equal(vvi_parallel_for(n.job, &work, &n, 2), VV_OK); /* the other threads are idle */
        assert_int_equal(n.inner, 2 * 50);
        assert_int_equal(n.moved, 0);
        vv_job_release(n.job);
    }
}

static vv_status meet_inside(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    return meet_in_a_loop(shared);
}

static void a_loop_of_one_item_leaves_the_threads_to_the_loop_inside(void **state)
{
    (void)state;
    const vvi_work work = {.item = meet_inside};
    vv_job *job = test_job(3, 0);
    assert_int_equal(vvi_parallel_for(job, &work, job, 1), VV_OK);
    vv_job_release(job);
}

static void *run_loops(void *user)
{
    vv_runtime *runtime = user;
    vv_job *job;
    if (vv_job_new(&job, runtime, NULL, NULL) != VV_OK)
        return "no job";
    char *trouble = NULL;
    for (int i = 0; i < 50 && !trouble; i++) {
        tally t = {.n_workers = vv_runtime_threads(runtime)};
        if (vvi_parallel_for(job, &tally_work, &t, 100 + (size_t)i) != VV_OK)
            trouble = "a loop failed";
        for (size_t k = 0; k < 100; k++)
            if (t.times[k] != 1)
                trouble = "an item was not done once";
    }
    vv_job_release(job);
    return trouble;
}

static void several_jobs_share_one_runtime(void **state)
{
    (void)state;
    vv_job *job = test_job(3, 0);
    pthread_t threads[6];
    for (int i = 0; i < 6; i++)
        assert_int_equal(pthread_create(&threads[i], NULL, run_loops, vv_job_runtime(job)), 0);
    for (int i = 0; i < 6; i++) {
        void *trouble;
        pthread_join(threads[i], &trouble);
        if (trouble)
            fail_msg("%s", (char *)trouble);
    }
    vv_job_release(job);
}

/* Urgent loops ---------------------------------------------------------------------------------------------------- */

typedef struct crowd {
    vv_job *job;
    atomic_bool urgent_done, meets; /* meets: two threads were in the urgent loop at once */
    atomic_int inside, here[N], starts, n_after;
} crowd;

static vv_status start_slow(void **scratch_out, void *shared, int worker)
{
    crowd *c = shared;
    *scratch_out = NULL;
    c->starts++;
    return worker < 2 ? VV_OK : vv_fail(VV_E_INTERNAL, "worker %d of 2", worker);
}

/* Goes on until the urgent loop is done: it has to be helped by a thread that leaves this one. */
static vv_status do_slow(void *scratch, void *shared, size_t index)
{
    crowd *c = shared;
    c->here[index]++;
    c->n_after += c->urgent_done ? 1 : 0;
    usleep(1000);
    return VV_OK;
}

static vv_status do_urgent(void *scratch, void *shared, size_t index)
{
    crowd *c = shared;
    c->inside++;
    for (int i = 0; i < 60000 && !c->meets; i++) { /* a minute at most */
        if (c->inside > 1)
            c->meets = true;
        usleep(1000);
    }
    c->inside--;
    return VV_OK;
}

static void *run_urgent(void *user)
{
    static const vvi_work work = {.item = do_urgent};
    crowd *c = user;
    vv_job *job;
    while (c->starts < 2)
        usleep(100);
    if (vv_job_new(&job, vv_job_runtime(c->job), NULL, NULL) != VV_OK)
        return "no job";
    vvi_job_set_urgent(job);
    const vv_status st = vvi_parallel_for(job, &work, c, 2);
    c->urgent_done = true;
    vv_job_release(job);
    return st == VV_OK ? NULL : "the urgent loop failed";
}

/* Of two threads one is the urgent loop's own: without the helper of the other loop it stays alone. */
static void helpers_leave(bool modest)
{
    const vvi_work work = {.start = start_slow, .item = do_slow, .yields = !modest};
    static crowd c;
    pthread_t thread;
    void *trouble;
    c = (crowd){.job = test_job(2, 0)};
    if (modest)
        vvi_job_set_modest(c.job);
    assert_int_equal(pthread_create(&thread, NULL, run_urgent, &c), 0);
    assert_int_equal(vvi_parallel_for(c.job, &work, &c, N), VV_OK);
    pthread_join(thread, &trouble);
    if (trouble)
        fail_msg("%s", (char *)trouble);
    assert_true(c.meets);
    for (int i = 0; i < N; i++)
        assert_int_equal(c.here[i], 1);
    if (c.n_after > 100) /* it had time to come back */
        assert_true(c.starts > 2);
    vv_job_release(c.job);
}

static void helpers_leave_a_loop_that_yields_for_an_urgent_one_and_come_back(void **state)
{
    helpers_leave(false);
}

static void helpers_leave_all_loops_of_a_modest_job_for_an_urgent_one(void **state)
{
    helpers_leave(true);
}

/* Often: a busy machine may take this thread away for as long as that. */
static void it_is_calm_a_while_after_what_is_urgent(void **state)
{
    vvi_pool pool;
    bool was_not = false;
    assert_int_equal(vvi_pool_init(&pool), VV_OK);
    assert_true(vvi_pool_is_calm(&pool));
    for (int i = 0; i < 1000 && !was_not; i++) {
        vvi_pool_note_urgent(&pool);
        was_not = !vvi_pool_is_calm(&pool);
    }
    assert_true(was_not);
    for (int i = 0; i < 60000 && !vvi_pool_is_calm(&pool); i++)
        usleep(1000);
    assert_true(vvi_pool_is_calm(&pool));
    vvi_pool_finish(&pool);
}

/* Too little memory ---------------------------------------------------------------------------------------------- */

static vv_status start_counted(void **scratch_out, void *shared, int worker)
{
    (void)worker;
    *scratch_out = vvi_alloc(shared, 1000, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory(1000);
}

static vv_status use_scratch(void *scratch, void *shared, size_t index)
{
    (void)shared;
    memset(scratch, (int)index, 1000);
    return VV_OK;
}

static void free_counted(void *scratch, void *shared)
{
    (void)shared;
    vvi_free(scratch);
}

static vv_status run_in_new_runtime(void *user)
{
    (void)user;
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 3;
    vv_runtime *runtime = NULL;
    vv_job *job = NULL;
    vv_status st = vv_runtime_new(&runtime, &options);
    if (st == VV_OK)
        st = vv_job_new(&job, runtime, NULL, NULL);
    const vvi_work work = {.start = start_counted, .item = use_scratch, .finish = free_counted};
    if (st == VV_OK)
        st = vvi_parallel_for(job, &work, job, 100);
    if (runtime)
        assert_int_equal(vv_runtime_memory_used(runtime), 0);
    vv_job_release(job);
    vv_runtime_release(runtime);
    return st;
}

static void every_allocation_of_a_runtime_and_its_loops_can_fail(void **state)
{
    (void)state;
    for (int i = 0; i < 10; i++) /* how many workers come differs from run to run */
        assert_true(test_fail_each_alloc(run_in_new_runtime, NULL) >= 4);
}

/* More than half of the limit each: helpers that come while another is there find no room. */
static vv_status start_large(void **scratch_out, void *shared, int worker)
{
    *scratch_out = vvi_alloc(*(vv_job **)shared, (size_t)600 << 10, VVI_MEM_SCRATCH);
    return *scratch_out ? VV_OK : vv_fail_memory((size_t)600 << 10);
}

static vv_status wait_a_little(void *scratch, void *shared, size_t index)
{
    nanosleep(&(struct timespec){.tv_nsec = 200000}, NULL);
    return VV_OK;
}

static void finish_large(void *scratch, void *shared)
{
    vvi_free(scratch);
}

static void threads_that_the_limit_has_no_room_for_stay_away(void **state)
{
    (void)state;
    static const vvi_work work = {.start = start_large, .item = wait_a_little, .finish = finish_large};
    vv_job *job = test_job(4, (uint64_t)1 << 20), *little = test_job(4, (uint64_t)256 << 10);
    assert_int_equal(vvi_parallel_for(job, &work, &job, 100), VV_OK);
    assert_int_equal(vvi_parallel_for(little, &work, &little, 100), VV_E_LIMIT); /* its own has none */
    vv_job_release(job);
    vv_job_release(little);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_item_is_done_once_for_any_thread_count),
        cmocka_unit_test(without_a_job_the_calling_thread_does_it_alone),
        cmocka_unit_test(several_threads_do_take_part),
        cmocka_unit_test(threads_that_the_limit_has_no_room_for_stay_away),
        cmocka_unit_test(the_results_do_not_depend_on_the_number_of_threads),
        cmocka_unit_test(the_caller_s_rounding_mode_reaches_no_item_and_is_kept),
        cmocka_unit_test(the_lowest_failing_item_is_the_one_reported),
        cmocka_unit_test(a_start_that_fails_ends_the_loop_without_item_or_finish),
        cmocka_unit_test(a_nested_loop_runs_on_its_worker_alone),
        cmocka_unit_test(a_loop_of_one_item_leaves_the_threads_to_the_loop_inside),
        cmocka_unit_test(several_jobs_share_one_runtime),
        cmocka_unit_test(helpers_leave_a_loop_that_yields_for_an_urgent_one_and_come_back),
        cmocka_unit_test(helpers_leave_all_loops_of_a_modest_job_for_an_urgent_one),
        cmocka_unit_test(it_is_calm_a_while_after_what_is_urgent),
        cmocka_unit_test(every_allocation_of_a_runtime_and_its_loops_can_fail),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
