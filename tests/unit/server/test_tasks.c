/* Tasks of a queue: one after the other, cancelled, dropped. */
#include "core/memory.h"
#include "jobs.h"
#include "server/tasks.h"

#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

enum { MOST = 200 };

/* What became of tasks, in order; the server's thread alone. */
static int done_order[MOST], n_done, n_dropped;
static vv_status done_status[MOST];
static atomic_int n_wakes, n_run;
static atomic_bool gate; /* tasks that wait for it go on */

typedef struct numbered {
    vvi_task task;
    int number;
} numbered;

static void wake(void *user)
{
    (void)user;
    atomic_fetch_add(&n_wakes, 1);
}

static vv_status run_quickly(vvi_task *task, vv_job *job)
{
    (void)job;
    atomic_fetch_add(&n_run, 1);
    return ((numbered *)(void *)task)->number == 3 ? vv_fail(VV_E_FORMAT, "the third is none") : VV_OK;
}

static vv_status run_until_told(vvi_task *task, vv_job *job)
{
    (void)task;
    atomic_fetch_add(&n_run, 1);
    while (!atomic_load(&gate))
        if (vv_job_cancelled(job))
            return vv_fail(VV_E_CANCELLED, "cancelled");
    return VV_OK;
}

static void done(vvi_task *task, vv_status st)
{
    if (st == VV_E_FORMAT)
        assert_string_equal(vv_error_last()->message, "the third is none");
    done_status[n_done] = st;
    done_order[n_done++] = ((numbered *)(void *)task)->number;
}

static void drop(vvi_task *task)
{
    n_dropped++;
    free(task);
}

/* Those that are fresh for ever are as many as may run. */
static vvi_tasks *open_with(size_t at_once, size_t most, int64_t fresh, int64_t kept)
{
    const vvi_tasks_options options = {
        .name = "vv-test", .at_once = at_once, .most = most, .fresh = fresh, .kept = kept, .wake = wake};
    vv_job *job = test_job(1, 0);
    vvi_tasks *tasks = NULL;
    n_done = n_dropped = 0;
    atomic_store(&n_run, 0);
    atomic_store(&gate, false);
    assert_int_equal(vvi_tasks_new(&tasks, vv_job_runtime(job), &options), VV_OK);
    vv_job_release(job);
    return tasks;
}

static vvi_tasks *open_some(size_t at_once)
{
    return open_with(at_once, at_once, INT64_MAX, INT64_MAX);
}

static vvi_tasks *open_tasks(void)
{
    return open_some(1);
}

enum { SHARE = 64 };

static vv_status add_of(uint64_t owner, bool stays, int64_t *number_out, vvi_tasks *tasks, int number,
                        vv_status (*run)(vvi_task *task, vv_job *job))
{
    numbered *task = vvi_calloc(1, sizeof *task);
    assert_non_null(task);
    *task = (numbered){.task = {.name = "test", .run = run, .done = done, .drop = drop, .owner = owner, .stays = stays},
                       .number = number};
    return vvi_tasks_add(number_out, tasks, &task->task, SHARE);
}

static vv_status add(int64_t *number_out, vvi_tasks *tasks, int number, vv_status (*run)(vvi_task *task, vv_job *job))
{
    return add_of(1, false, number_out, tasks, number, run);
}

static void serve_until(vvi_tasks *tasks, int n)
{
    while (n_done < n) {
        vvi_tasks_serve(tasks, NULL, NULL);
        usleep(100);
    }
}

static void wait_until_one_runs(int n)
{
    while (atomic_load(&n_run) < n)
        usleep(100);
}

static void tasks_end_in_order_with_their_errors(void **state)
{
    int64_t number = 0, last = 0;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    for (int i = 0; i < 50; i++) {
        assert_int_equal(add(&number, tasks, i, run_quickly), VV_OK);
        assert_true(number > last);
        last = number;
    }
    serve_until(tasks, 50);
    for (int i = 0; i < 50; i++) {
        assert_int_equal(done_order[i], i);
        assert_int_equal(done_status[i], i == 3 ? VV_E_FORMAT : VV_OK);
    }
    assert_int_equal(n_dropped, 50);
    assert_true(atomic_load(&n_wakes) > 0);
    assert_false(vvi_tasks_cancel(tasks, last, 0));
    vvi_tasks_free(tasks);
    vvi_tasks_free(NULL);
}

static void what_runs_and_what_waits_can_be_cancelled(void **state)
{
    int64_t first, second, third;
    vvi_task_state now;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add(&first, tasks, 1, run_until_told), VV_OK);
    wait_until_one_runs(1);
    assert_int_equal(add(&second, tasks, 2, run_quickly), VV_OK);
    assert_int_equal(add(&third, tasks, 4, run_quickly), VV_OK);
    vvi_tasks_state(&now, tasks, 0);
    assert_int_equal(now.number, first);
    assert_int_equal(now.n_waiting, 2);
    assert_string_equal(now.name, "test");
    assert_true(vvi_tasks_cancel(tasks, third, 0)); /* the last of the queue */
    assert_int_equal(add(&third, tasks, 5, run_quickly), VV_OK);
    assert_true(vvi_tasks_cancel(tasks, second, 0));
    assert_false(vvi_tasks_cancel(tasks, second, 0));
    assert_true(vvi_tasks_cancel(tasks, first, 0));
    serve_until(tasks, 4);
    assert_int_equal(atomic_load(&n_run), 2);
    for (int i = 0; i < 4; i++)
        assert_int_equal(done_status[i], done_order[i] == 5 ? VV_OK : VV_E_CANCELLED);
    assert_int_equal(n_dropped, 4);
    vvi_tasks_free(tasks);
}

static void at_the_end_all_are_dropped_and_none_is_done(void **state)
{
    int64_t number;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add(&number, tasks, 1, run_until_told), VV_OK);
    wait_until_one_runs(1);
    for (int i = 0; i < 5; i++)
        assert_int_equal(add(&number, tasks, i, run_quickly), VV_OK);
    vvi_tasks_free(tasks);
    assert_int_equal(n_done, 0);
    assert_int_equal(n_dropped, 6);
    assert_int_equal(atomic_load(&n_run), 1);
}

static void too_many_are_refused(void **state)
{
    int64_t number;
    int n = 0;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add(&number, tasks, 0, run_until_told), VV_OK);
    wait_until_one_runs(1);
    while (n < MOST / 2 && add(&number, tasks, 10 + n, run_quickly) == VV_OK)
        n++;
    assert_int_equal(n, SHARE);
    assert_int_equal(vv_error_last()->status, VV_E_LIMIT);
    assert_non_null(strstr(vv_error_last()->message, "64 jobs of yours are already waiting"));
    assert_int_equal(n_dropped, 1);
    assert_int_equal(add_of(2, false, &number, tasks, 3000, run_quickly), VV_OK); /* another has a share of his own */
    n++;
    atomic_store(&gate, true);
    serve_until(tasks, n + 1);
    assert_int_equal(add(&number, tasks, 1, run_quickly), VV_OK);
    serve_until(tasks, n + 2);
    vvi_tasks_free(tasks);
}

/* 1 has many, 2 comes later with some, 3 with one: nobody waits for more than one of each of the others. The first
 * runs, at turn 0; then 20 and 30 are at turn 0 too, 11 and 21 at 1, 12 and 22 at 2. */
static void those_who_ask_take_turns(void **state)
{
    static const int expected[] = {10, 20, 30, 11, 21, 12, 22, 13, 14, 15};
    int64_t number;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add_of(1, false, &number, tasks, 10, run_until_told), VV_OK);
    wait_until_one_runs(1);
    for (int i = 1; i < 6; i++)
        assert_int_equal(add_of(1, false, &number, tasks, 10 + i, run_quickly), VV_OK);
    for (int i = 0; i < 3; i++)
        assert_int_equal(add_of(2, false, &number, tasks, 20 + i, run_quickly), VV_OK);
    assert_int_equal(add_of(3, false, &number, tasks, 30, run_quickly), VV_OK);
    atomic_store(&gate, true);
    serve_until(tasks, 10);
    for (int i = 0; i < 10; i++)
        assert_int_equal(done_order[i], expected[i]);
    vvi_tasks_free(tasks);
}

static void who_leaves_takes_what_nobody_else_wants_along(void **state)
{
    int64_t number;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add_of(1, false, &number, tasks, 1, run_until_told), VV_OK);
    wait_until_one_runs(1);
    for (int i = 2; i < 20; i++)
        assert_int_equal(add_of(1, i % 2, &number, tasks, i, run_quickly), VV_OK);
    assert_int_equal(add_of(2, false, &number, tasks, 100, run_quickly), VV_OK);
    vvi_tasks_leave(tasks, 1, SHARE);
    assert_int_equal(n_dropped, 9); /* those that wait are not even told */
    serve_until(tasks, 11);         /* that which ran, nine that stay, the other's */
    assert_int_equal(done_order[0], 1);
    assert_int_equal(done_status[0], VV_E_CANCELLED);
    int others = 0;
    for (int i = 1; i < 11; i++) {
        assert_int_equal(done_status[i], done_order[i] == 3 ? VV_E_FORMAT : VV_OK);
        assert_true(done_order[i] == 100 || done_order[i] % 2 == 1);
        others += done_order[i] == 100;
    }
    assert_int_equal(others, 1);
    assert_int_equal(add_of(3, true, &number, tasks, 5, run_until_told), VV_OK);
    wait_until_one_runs(12); /* it runs, and goes on */
    vvi_tasks_leave(tasks, 3, SHARE);
    atomic_store(&gate, true);
    serve_until(tasks, 12);
    assert_int_equal(done_status[11], VV_OK);
    vvi_tasks_free(tasks);
}

/* Who comes again and again leaves no more behind than one may have. */
static void nobodys_tasks_have_one_share(void **state)
{
    int64_t number;
    vvi_task_state now;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add_of(1, true, &number, tasks, 0, run_until_told), VV_OK);
    wait_until_one_runs(1);
    for (uint64_t owner = 2; owner < 12; owner++) {
        for (int i = 0; i < 10; i++)
            assert_int_equal(add_of(owner, true, &number, tasks, 10, run_quickly), VV_OK);
        vvi_tasks_leave(tasks, owner, 16);
    }
    vvi_tasks_state(&now, tasks, 0);
    assert_int_equal(now.n_waiting, 16);
    atomic_store(&gate, true);
    serve_until(tasks, 101);
    assert_int_equal(atomic_load(&n_run), 17);
    vvi_tasks_free(tasks);
}

static void what_is_anothers_is_not_cancelled(void **state)
{
    int64_t first, second;
    (void)state;
    vvi_tasks *tasks = open_tasks();
    assert_int_equal(add_of(1, false, &first, tasks, 1, run_until_told), VV_OK);
    wait_until_one_runs(1);
    assert_int_equal(add_of(1, false, &second, tasks, 2, run_quickly), VV_OK);
    assert_false(vvi_tasks_cancel(tasks, first, 2));
    assert_false(vvi_tasks_cancel(tasks, second, 2));
    assert_true(vvi_tasks_cancel(tasks, second, 1));
    assert_true(vvi_tasks_cancel(tasks, first, 1));
    serve_until(tasks, 2);
    assert_int_equal(done_status[1], VV_E_CANCELLED);
    vvi_tasks_free(tasks);
}

/* 1 has a long one and two behind it; 2 and 3 come later with short ones. */
static void who_has_none_running_does_not_wait_for_anothers_end(void **state)
{
    int64_t number;
    vvi_task_state one, other;
    (void)state;
    vvi_tasks *tasks = open_some(2);
    assert_int_equal(add_of(1, false, &number, tasks, 10, run_until_told), VV_OK);
    wait_until_one_runs(1);
    for (int i = 11; i < 13; i++)
        assert_int_equal(add_of(1, false, &number, tasks, i, run_quickly), VV_OK);
    assert_int_equal(add_of(2, false, &number, tasks, 20, run_quickly), VV_OK);
    assert_int_equal(add_of(3, false, &number, tasks, 30, run_quickly), VV_OK);
    serve_until(tasks, 2); /* while the first one runs, and those of 1 stay in order */
    assert_int_equal(done_order[0], 20);
    assert_int_equal(done_order[1], 30);
    assert_int_equal(atomic_load(&n_run), 3);
    assert_false(vvi_tasks_are_idle(tasks));
    assert_int_equal(add_of(2, false, &number, tasks, 21, run_until_told), VV_OK);
    wait_until_one_runs(4);
    vvi_tasks_state(&one, tasks, 0);
    vvi_tasks_state(&other, tasks, one.number); /* each is told in turn */
    assert_int_equal(one.number, 1);
    assert_int_equal(other.number, number);
    vvi_tasks_state(&one, tasks, other.number);
    assert_int_equal(one.number, 1);
    assert_true(vvi_tasks_cancel(tasks, number, 2));
    serve_until(tasks, 3);
    assert_int_equal(done_order[2], 21);
    assert_int_equal(done_status[2], VV_E_CANCELLED);
    atomic_store(&gate, true);
    serve_until(tasks, 6);
    for (int i = 3; i < 6; i++)
        assert_int_equal(done_order[i], 7 + i);
    vvi_tasks_free(tasks);
}

static void add_alone(vvi_tasks *tasks, uint64_t owner, int number, vv_status (*run)(vvi_task *task, vv_job *job))
{
    int64_t n;
    numbered *task = vvi_calloc(1, sizeof *task);
    assert_non_null(task);
    *task = (numbered){.task = {.name = "test", .run = run, .done = done, .drop = drop, .owner = owner, .alone = true},
                       .number = number};
    assert_int_equal(vvi_tasks_add(&n, tasks, &task->task, SHARE), VV_OK);
}

static void large_ones_run_one_at_a_time(void **state)
{
    int64_t number;
    (void)state;
    vvi_tasks *tasks = open_some(3);
    add_alone(tasks, 1, 10, run_until_told);
    wait_until_one_runs(1);
    add_alone(tasks, 2, 20, run_quickly);
    assert_int_equal(add_of(3, false, &number, tasks, 30, run_quickly), VV_OK);
    serve_until(tasks, 1);
    assert_int_equal(done_order[0], 30);
    usleep(2000);
    assert_int_equal(atomic_load(&n_run), 2);
    atomic_store(&gate, true);
    serve_until(tasks, 3);
    assert_int_equal(done_order[1], 10);
    assert_int_equal(done_order[2], 20);
    vvi_tasks_free(tasks);
}

static bool is_wanted(const void *user, const vvi_task *task)
{
    return task->number == *(const int64_t *)user;
}

static void what_has_ended_can_wait_for_what_ends_later(void **state)
{
    int64_t first, second;
    (void)state;
    vvi_tasks *tasks = open_some(2);
    assert_int_equal(add_of(1, false, &first, tasks, 1, run_until_told), VV_OK);
    wait_until_one_runs(1);
    assert_int_equal(add_of(2, false, &second, tasks, 2, run_quickly), VV_OK);
    wait_until_one_runs(2);
    usleep(2000);
    atomic_store(&gate, true);
    while (n_done < 1)
        vvi_tasks_serve(tasks, is_wanted, &first);
    assert_int_equal(done_order[0], 1);
    serve_until(tasks, 2);
    assert_int_equal(done_order[1], 2);
    vvi_tasks_free(tasks);
}

static void add_at(vvi_tasks *tasks, const char *address, uint64_t owner, int number,
                   vv_status (*run)(vvi_task *task, vv_job *job))
{
    int64_t n;
    numbered *task = vvi_calloc(1, sizeof *task);
    assert_non_null(task);
    *task = (numbered){.task = {.name = "test", .run = run, .done = done, .drop = drop, .owner = owner, .stays = true},
                       .number = number};
    snprintf(task->task.address, sizeof task->task.address, "%s", address);
    assert_int_equal(vvi_tasks_add(&n, tasks, &task->task, SHARE), VV_OK);
}

/* Two at once; each has one that does not end. */
static void what_has_run_for_a_while_keeps_nobody_waiting(void **state)
{
    (void)state;
    vvi_tasks *tasks = open_with(2, VVI_TASKS_MOST, 1000000, INT64_MAX);
    for (int i = 1; i <= VVI_TASKS_MOST / 2; i++) {
        add_at(tasks, "here", (uint64_t)i, i, run_until_told);
        wait_until_one_runs(i);
    }
    add_at(tasks, "here", 20, 20, run_quickly); /* of an address half of them at most */
    add_at(tasks, "there", 21, 21, run_quickly);
    serve_until(tasks, 1);
    assert_int_equal(done_order[0], 21);
    usleep(5000);
    assert_int_equal(atomic_load(&n_run), VVI_TASKS_MOST / 2 + 1);
    atomic_store(&gate, true);
    serve_until(tasks, VVI_TASKS_MOST / 2 + 2);
    vvi_tasks_free(tasks);
}

/* What is fresh holds its place: the next is of another address, though those that ask there came first. */
static void many_of_one_address_are_no_way_to_more(void **state)
{
    (void)state;
    vvi_tasks *tasks = open_some(2);
    add_at(tasks, "here", 1, 1, run_until_told);
    add_at(tasks, "other", 2, 2, run_until_told);
    wait_until_one_runs(2);
    for (uint64_t owner = 10; owner < 30; owner++)
        add_at(tasks, "here", owner, (int)owner, run_quickly);
    add_at(tasks, "there", 30, 30, run_quickly);
    assert_true(vvi_tasks_cancel(tasks, 2, 2));
    serve_until(tasks, 2);
    assert_int_equal(done_order[0], 2);
    assert_int_equal(done_order[1], 30);
    atomic_store(&gate, true);
    serve_until(tasks, 23);
    vvi_tasks_free(tasks);
}

static void who_has_left_gives_way_to_who_is_there_after_a_while(void **state)
{
    (void)state;
    vvi_tasks *tasks = open_with(1, 1, 0, 20000000);
    add_at(tasks, "here", 1, 1, run_until_told);
    wait_until_one_runs(1);
    vvi_tasks_leave(tasks, 1, SHARE);
    usleep(40000); /* nobody waits: it goes on */
    vvi_tasks_serve(tasks, NULL, NULL);
    assert_int_equal(n_done, 0);
    add_at(tasks, "here", 2, 2, run_quickly);
    serve_until(tasks, 2);
    assert_int_equal(done_order[0], 1);
    assert_int_equal(done_status[0], VV_E_CANCELLED);
    assert_int_equal(done_status[1], VV_OK);
    add_at(tasks, "here", 3, 3, run_until_told); /* its owner is there: others wait */
    wait_until_one_runs(3);
    add_at(tasks, "there", 4, 4, run_quickly);
    usleep(40000);
    vvi_tasks_serve(tasks, NULL, NULL);
    assert_int_equal(n_done, 2);
    atomic_store(&gate, true);
    serve_until(tasks, 4);
    vvi_tasks_free(tasks);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tasks_end_in_order_with_their_errors),
        cmocka_unit_test(what_runs_and_what_waits_can_be_cancelled),
        cmocka_unit_test(at_the_end_all_are_dropped_and_none_is_done),
        cmocka_unit_test(too_many_are_refused),
        cmocka_unit_test(those_who_ask_take_turns),
        cmocka_unit_test(who_leaves_takes_what_nobody_else_wants_along),
        cmocka_unit_test(nobodys_tasks_have_one_share),
        cmocka_unit_test(what_is_anothers_is_not_cancelled),
        cmocka_unit_test(who_has_none_running_does_not_wait_for_anothers_end),
        cmocka_unit_test(large_ones_run_one_at_a_time),
        cmocka_unit_test(what_has_ended_can_wait_for_what_ends_later),
        cmocka_unit_test(what_has_run_for_a_while_keeps_nobody_waiting),
        cmocka_unit_test(many_of_one_address_are_no_way_to_more),
        cmocka_unit_test(who_has_left_gives_way_to_who_is_there_after_a_while),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
