/* Jobs: progress, cancel, log. */
#include "core/job.h"
#include "core/os.h"
#include "jobs.h"

#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/time.h>
#include <unistd.h>
#include <volvis/sys/registry.h>

#include <cmocka.h>

static vv_runtime *new_runtime(int threads)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = threads;
    vv_runtime *runtime;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    return runtime;
}

static vv_job *new_job(int threads, vv_progress_fn *progress, void *user)
{
    vv_runtime *runtime = new_runtime(threads);
    vv_job *job;
    assert_int_equal(vv_job_new(&job, runtime, progress, user), VV_OK);
    assert_ptr_equal(vv_job_runtime(job), runtime);
    vv_runtime_release(runtime);
    return job;
}

/* Progress ------------------------------------------------------------------------------------------------------- */

typedef struct listener {
    atomic_int inside;
    int calls, overlaps, falls;
    uint64_t done, total;
    double first_s, last_s, least_gap_s, eta_s, elapsed_s;
    char stage[32];
    uint64_t cancel_at; /* 0: never */
} listener;

static bool listen_to(void *user, const vv_progress *progress)
{
    listener *l = user;
    const double now_s = vvi_os_seconds();
    l->overlaps += atomic_fetch_add(&l->inside, 1) != 0;
    if (l->calls++ == 0)
        l->first_s = now_s;
    else if (l->calls == 2 || now_s - l->last_s < l->least_gap_s)
        l->least_gap_s = now_s - l->last_s;
    l->falls += progress->done < l->done;
    l->done = progress->done;
    l->total = progress->total;
    l->eta_s = progress->eta_s;
    l->elapsed_s = progress->elapsed_s;
    l->last_s = now_s;
    snprintf(l->stage, sizeof l->stage, "%s", progress->stage);
    atomic_fetch_sub(&l->inside, 1);
    return !l->cancel_at || progress->done < l->cancel_at;
}

static vv_status doze_item(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    atomic_fetch_add((atomic_int *)shared, 1);
    usleep(1000);
    return VV_OK;
}

static const vvi_work doze_work = {.stage = "doze", .item = doze_item};

static void progress_comes_in_order_one_at_a_time_and_at_most_20_a_second(void **state)
{
    (void)state;
    static const int thread_counts[] = {1, 2, 3, 8};
    for (int c = 0; c < 4; c++) {
        listener l = {0};
        atomic_int ran = 0;
        vv_job *job = new_job(thread_counts[c], listen_to, &l);
        assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, (size_t)thread_counts[c] * 250), VV_OK);
        assert_true(l.calls >= 2);
        assert_true(l.least_gap_s >= 0.0499);
        assert_int_equal(l.overlaps, 0);
        assert_int_equal(l.falls, 0);
        assert_int_equal(l.total, thread_counts[c] * 250);
        assert_true(l.done <= l.total);
        assert_string_equal(l.stage, "doze");
        vv_job_release(job);
    }
}

static void the_time_left_is_estimated_from_the_pace(void **state)
{
    (void)state;
    listener l = {0};
    vv_job *job = new_job(1, listen_to, &l);
    assert_int_equal(vvi_job_progress(job, "read", 0, 100), VV_OK);
    assert_true(l.eta_s < 0); /* unknown */
    usleep(60000);
    assert_int_equal(vvi_job_progress(job, "read", 25, 100), VV_OK);
    assert_int_equal(l.calls, 2);
    assert_true(l.elapsed_s >= 0.06);
    assert_true(l.eta_s > l.elapsed_s * 2.99 && l.eta_s < l.elapsed_s * 3.01);
    vv_job_release(job);
}

static void a_new_stage_begins_again(void **state)
{
    (void)state;
    listener l = {0};
    vv_job *job = new_job(1, listen_to, &l);
    assert_int_equal(vvi_job_progress(job, "read", 50, 100), VV_OK);
    usleep(60000);
    l.done = 0;
    assert_int_equal(vvi_job_progress(job, "render", 1, 100), VV_OK);
    assert_string_equal(l.stage, "render");
    assert_true(l.elapsed_s < 0.05);
    vv_job_release(job);
}

static void loops_that_make_one_stage_count_together(void **state)
{
    listener l = {0};
    atomic_int ran = 0;
    vv_job *job = new_job(1, listen_to, &l);
    for (uint64_t i = 0; i < 3; i++) {
        const vvi_work work = {.stage = "doze", .item = doze_item, .n_before = 80 * i, .n_after = 80 * (2 - i)};
        assert_int_equal(vvi_parallel_for(job, &work, &ran, 80), VV_OK);
        assert_int_equal(l.total, 240);
        assert_true(l.done > 80 * i && l.done <= 80 * (i + 1));
    }
    assert_int_equal(l.falls, 0);
    assert_true(l.elapsed_s > 0.16);
    vv_job_release(job);
}

static void a_second_loop_of_the_same_stage_counts_its_own_time(void **state)
{
    (void)state;
    listener l = {0};
    atomic_int ran = 0;
    vv_job *job = new_job(1, listen_to, &l);
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 1), VV_OK);
    usleep(60000);
    const double begin_s = vvi_os_seconds();
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 1), VV_OK);
    assert_int_equal(l.calls, 2);
    assert_true(l.elapsed_s <= l.last_s - begin_s); /* the time between the two is of neither */
    vv_job_release(job);
}

static vv_status loop_inside(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    (void)index;
    atomic_int ran = 0;
    const vvi_work work = {.stage = "inside", .item = doze_item};
    return vvi_parallel_for(shared, &work, &ran, 20);
}

static void a_loop_inside_another_does_not_report(void **state)
{
    (void)state;
    listener l = {0};
    vv_job *job = new_job(2, listen_to, &l);
    const vvi_work work = {.stage = "outside", .item = loop_inside};
    assert_int_equal(vvi_parallel_for(job, &work, job, 12), VV_OK);
    assert_true(l.calls >= 1);
    assert_string_equal(l.stage, "outside");
    assert_int_equal(l.falls, 0);
    vv_job_release(job);
}

static void without_a_stage_or_listener_nothing_is_reported(void **state)
{
    (void)state;
    listener l = {0};
    atomic_int ran = 0;
    const vvi_work silent = {.item = doze_item};
    vv_job *job = new_job(2, listen_to, &l);
    assert_int_equal(vvi_parallel_for(job, &silent, &ran, 20), VV_OK);
    assert_int_equal(l.calls, 0);
    vv_job_release(job);
    job = new_job(2, NULL, NULL);
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 20), VV_OK);
    assert_int_equal(vvi_job_progress(job, "read", 1, 2), VV_OK);
    vv_job_release(job);
    assert_int_equal(vvi_job_progress(NULL, "read", 1, 2), VV_OK);
}

/* Cancel --------------------------------------------------------------------------------------------------------- */

static void a_listener_that_says_no_cancels(void **state)
{
    (void)state;
    listener l = {.cancel_at = 1};
    atomic_int ran = 0;
    vv_job *job = new_job(2, listen_to, &l);
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 100000), VV_E_CANCELLED);
    assert_true(ran < 100000);
    assert_int_equal(vvi_job_progress(job, "more", 1, 2), VV_E_CANCELLED);
    vv_job_release(job);
}

/* A loop that somebody else cancels as soon as it is at work. */
typedef struct cancelling {
    vv_job *job;
    atomic_int begun, too_late; /* items; those that began when the job was cancelled */
} cancelling;

static void *cancel_at_work(void *user)
{
    cancelling *c = user;
    while (atomic_load(&c->begun) < 10)
        usleep(100);
    vv_job_cancel(c->job);
    return NULL;
}

static void check_cancel(int threads, const vvi_work *work, size_t n_items)
{
    cancelling c = {.job = new_job(threads, NULL, NULL)};
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, cancel_at_work, &c), 0);
    assert_int_equal(vvi_parallel_for(c.job, work, &c, n_items), VV_E_CANCELLED);
    assert_int_equal(vv_error_last()->status, VV_E_CANCELLED);
    assert_true(vv_job_cancelled(c.job));
    pthread_join(thread, NULL);
    assert_in_range(c.too_late, 0, threads); /* each thread may just have taken one */
    vv_job_release(c.job);
}

static vv_status doze_and_count(void *scratch, void *shared, size_t index)
{
    cancelling *c = shared;
    (void)scratch;
    (void)index;
    atomic_fetch_add(&c->too_late, vv_job_cancelled(c->job));
    atomic_fetch_add(&c->begun, 1);
    usleep(1000);
    return VV_OK;
}

static void cancel_from_another_thread_stops_a_loop_at_its_next_item(void **state)
{
    (void)state;
    static const int thread_counts[] = {1, 2, 3, 8};
    const vvi_work work = {.item = doze_and_count};
    for (int i = 0; i < 4; i++)
        check_cancel(thread_counts[i], &work, 1000000);
}

static vv_job *signalled_job; /* a handler has no other way to know it */

static void cancel_on_signal(int number)
{
    (void)number;
    vv_job_cancel(signalled_job);
}

static void cancel_from_a_signal_handler_stops_a_loop(void **state)
{
    (void)state;
    const struct sigaction action = {.sa_handler = cancel_on_signal};
    const struct itimerval soon = {.it_value = {.tv_usec = 30000}};
    struct sigaction before;
    atomic_int ran = 0;
    signalled_job = new_job(3, NULL, NULL);
    assert_int_equal(vvi_parallel_for(signalled_job, &doze_work, &ran, 10), VV_OK); /* the threads exist now */
    assert_int_equal(sigaction(SIGALRM, &action, &before), 0);
    assert_int_equal(setitimer(ITIMER_REAL, &soon, NULL), 0);
    assert_int_equal(vvi_parallel_for(signalled_job, &doze_work, &ran, 1000000), VV_E_CANCELLED);
    assert_int_equal(sigaction(SIGALRM, &before, NULL), 0);
    vv_job_release(signalled_job);
    signalled_job = NULL;
}

static vv_status poll_for_long(void *scratch, void *shared, size_t index)
{
    cancelling *c = shared;
    (void)scratch;
    (void)index;
    for (int i = 0; i < 1000000; i++) {
        const vv_status st = vvi_job_poll(c->job);
        if (st != VV_OK)
            return st;
        atomic_fetch_add(&c->begun, 1);
        usleep(1000);
    }
    return VV_OK;
}

static void an_item_that_polls_stops_in_its_middle(void **state)
{
    (void)state;
    const vvi_work work = {.item = poll_for_long};
    check_cancel(2, &work, 4);
}

static void a_cancelled_job_starts_nothing(void **state)
{
    (void)state;
    vv_job *job = new_job(2, NULL, NULL);
    atomic_int ran = 0;
    assert_false(vv_job_cancelled(job));
    assert_int_equal(vvi_job_poll(job), VV_OK);
    vv_job_cancel(job);
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 100), VV_E_CANCELLED);
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 0), VV_E_CANCELLED);
    assert_int_equal(vvi_job_poll(job), VV_E_CANCELLED);
    assert_int_equal(ran, 0);
    vv_job_cancel(NULL);
    assert_false(vv_job_cancelled(NULL));
    assert_int_equal(vvi_job_poll(NULL), VV_OK);
    vv_job_release(job);
    vv_job_release(NULL);
}

static vv_status cancel_in_the_last(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    if (index == 9)
        vv_job_cancel(shared);
    return VV_OK;
}

static void work_that_was_done_before_the_cancel_counts(void **state)
{
    (void)state;
    vv_job *job = new_job(1, NULL, NULL);
    const vvi_work work = {.item = cancel_in_the_last};
    assert_int_equal(vvi_parallel_for(job, &work, job, 10), VV_OK);
    assert_int_equal(vvi_parallel_for(job, &work, job, 10), VV_E_CANCELLED);
    vv_job_release(job);
}

static void a_job_without_a_runtime_is_this_thread_with_progress_and_cancel(void **state)
{
    (void)state;
    listener l = {.cancel_at = 1};
    atomic_int ran = 0;
    vv_job *job;
    assert_int_equal(vv_job_new(&job, NULL, listen_to, &l), VV_OK);
    assert_null(vv_job_runtime(job));
    assert_int_equal(vvi_job_threads(job), 1);
    assert_ptr_equal(vvi_job_registry(job), vv_registry_builtin());
    assert_false(vvi_job_allow_outside(job));
    assert_int_equal(vvi_parallel_for(job, &doze_work, &ran, 1000), VV_E_CANCELLED);
    vv_job_release(job);
}

/* Log ------------------------------------------------------------------------------------------------------------ */

typedef struct logbook {
    atomic_int inside, overlaps;
    int lines, by_level[4];
    char last[256], component[32];
} logbook;

static void write_log(void *user, vv_log_level level, const char *component, const char *text)
{
    logbook *book = user;
    if (atomic_fetch_add(&book->inside, 1) != 0)
        atomic_fetch_add(&book->overlaps, 1);
    book->lines++;
    book->by_level[level]++;
    snprintf(book->last, sizeof book->last, "%s", text);
    snprintf(book->component, sizeof book->component, "%s", component);
    atomic_fetch_sub(&book->inside, 1);
}

static vv_job *logging_job(logbook *book, vv_log_level level)
{
    vv_runtime_options options;
    vv_runtime_options_init(&options, sizeof options);
    options.threads = 8;
    options.log = write_log;
    options.log_user = book;
    options.log_level = level;
    vv_runtime *runtime;
    vv_job *job;
    assert_int_equal(vv_runtime_new(&runtime, &options), VV_OK);
    assert_int_equal(vv_job_new(&job, runtime, NULL, NULL), VV_OK);
    vv_runtime_release(runtime);
    return job;
}

static void only_lines_of_the_wanted_levels_are_logged(void **state)
{
    (void)state;
    logbook book = {0};
    vv_job *job = logging_job(&book, VV_LOG_INFO);
    for (int level = VV_LOG_ERROR; level <= VV_LOG_DEBUG; level++)
        vvi_log(job, (vv_log_level)level, "core", "line %d", level);
    assert_int_equal(book.lines, 3);
    assert_int_equal(book.by_level[VV_LOG_DEBUG], 0);
    assert_string_equal(book.last, "line 2");
    assert_string_equal(book.component, "core");
    vv_job_release(job);
    vvi_log(NULL, VV_LOG_ERROR, "core", "to nobody");
}

static void a_log_line_is_one_line(void **state)
{
    (void)state;
    logbook book = {0};
    vv_job *job = logging_job(&book, VV_LOG_WARNING);
    vvi_log(job, VV_LOG_WARNING, "io", "a\nb");
    assert_string_equal(book.last, "a?b");
    char *large = malloc(100001);
    memset(large, 'x', 100000);
    large[100000] = 0;
    vvi_log(job, VV_LOG_WARNING, "io", "%s", large);
    assert_int_equal(book.lines, 2);
    free(large);
    vv_job_release(job);
}

static vv_status log_item(void *scratch, void *shared, size_t index)
{
    (void)scratch;
    vvi_log(shared, VV_LOG_WARNING, "core", "item %zu", index);
    return VV_OK;
}

static void lines_of_many_threads_come_one_at_a_time(void **state)
{
    (void)state;
    logbook book = {0};
    vv_job *job = logging_job(&book, VV_LOG_WARNING);
    const vvi_work work = {.item = log_item};
    assert_int_equal(vvi_parallel_for(job, &work, job, 2000), VV_OK);
    assert_int_equal(book.lines, 2000);
    assert_int_equal(book.overlaps, 0);
    vv_job_release(job);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(progress_comes_in_order_one_at_a_time_and_at_most_20_a_second),
        cmocka_unit_test(the_time_left_is_estimated_from_the_pace),
        cmocka_unit_test(a_new_stage_begins_again),
        cmocka_unit_test(loops_that_make_one_stage_count_together),
        cmocka_unit_test(a_second_loop_of_the_same_stage_counts_its_own_time),
        cmocka_unit_test(a_loop_inside_another_does_not_report),
        cmocka_unit_test(without_a_stage_or_listener_nothing_is_reported),
        cmocka_unit_test(a_listener_that_says_no_cancels),
        cmocka_unit_test(cancel_from_another_thread_stops_a_loop_at_its_next_item),
        cmocka_unit_test(cancel_from_a_signal_handler_stops_a_loop),
        cmocka_unit_test(an_item_that_polls_stops_in_its_middle),
        cmocka_unit_test(a_cancelled_job_starts_nothing),
        cmocka_unit_test(work_that_was_done_before_the_cancel_counts),
        cmocka_unit_test(a_job_without_a_runtime_is_this_thread_with_progress_and_cancel),
        cmocka_unit_test(only_lines_of_the_wanted_levels_are_logged),
        cmocka_unit_test(a_log_line_is_one_line),
        cmocka_unit_test(lines_of_many_threads_come_one_at_a_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
