/* One who looks, without a socket: what it is told of the picture, and in which order. */
#include "core/memory.h"
#include "fields.h"
#include "jobs.h"
#include "server/session_impl.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <volvis/file.h>
#include <volvis/image.h>

enum { FINAL = 1 };

typedef struct talk {
    char path[64];
    vv_job *job;
    vvi_session *session;
    vvi_client *client;
    atomic_int wakes;
    char *pose;      /* told last */
    bool is_final;   /* as a page sees it */
    unsigned frame;  /* that was sent last */
    unsigned commit; /* that it shows */
} talk;

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void wake(void *user)
{
    talk *t = user;
    atomic_fetch_add(&t->wakes, 1);
}

static void say(talk *t, const char *text)
{
    ok(vvi_client_message(t->client, text, strlen(text), vvi_now()));
}

static unsigned little(const uint8_t *at)
{
    return at[0] | (unsigned)at[1] << 8 | (unsigned)at[2] << 16 | (unsigned)at[3] << 24;
}

/* The next thing that is sent, and what a page makes of it; yours to free. An empty text: a frame. */
static char *next(talk *t)
{
    vvi_outgoing out;
    while (!vvi_client_next(&out, t->client, vvi_now())) {
        vvi_session_tick(t->session, vvi_now());
        vvi_session_serve(t->session);
        usleep(100);
    }
    if (!out.text) {
        t->is_final = out.head[6] & FINAL;
        t->frame = little(out.head + 8);
        t->commit = little(out.head + 24);
        vv_image_bytes_free(out.bytes);
        return strdup("");
    }
    if (strstr(out.text, "\"type\": \"outdated\""))
        t->is_final = false;
    if (strstr(out.text, "\"pose\"")) {
        free(t->pose);
        t->pose = strdup(out.text);
    }
    return out.text;
}

static void acknowledge(talk *t)
{
    char text[64];
    snprintf(text, sizeof text, "{\"type\": \"ack\", \"frame\": %u}", t->frame);
    say(t, text);
}

/* All that is said until this is, or until a frame is sent (""). */
static void hear(talk *t, const char *wanted)
{
    for (bool found = false; !found;) {
        char *text = next(t);
        found = *wanted ? strstr(text, wanted) != NULL : !*text;
        if (!*text)
            acknowledge(t);
        free(text);
    }
}

/* Until the picture is final and where it is seen from is told. */
static void rest(talk *t)
{
    while (!t->is_final)
        hear(t, "");
    say(t, "{\"type\": \"events\", \"id\": 99, \"lines\": \"\"}");
    hear(t, "\"id\": 99");
    assert_true(t->is_final);
}

static int set_up(void **state)
{
    static talk t;
    t = (talk){.path = "/tmp/volvis-client-XXXXXX.nrrd", .job = test_job(1, 0)};
    vv_field *field = test_field_cube(&test_form_sphere, 9, 0, 8, t.job);
    const int fd = mkstemps(t.path, 5);
    assert_true(fd >= 0 && field);
    close(fd);
    ok(vv_field_write(t.path, (const vv_field *const *)&field, 1, NULL, t.job));
    vv_field_release(field);
    vv_world *world = NULL;
    ok(vv_world_for_file(&world, t.path, NULL, t.job));
    const vvi_session_options options = {
        .runtime = vv_job_runtime(t.job), .root = "/tmp", .clients_most = 4, .wake = wake, .user = &t};
    ok(vvi_session_new(&t.session, &options));
    ok(vvi_session_begin(t.session, world));
    vv_object_release(&world->base);
    ok(vvi_client_join(&t.client, t.session, NULL));
    say(&t, "{\"type\": \"hello\", \"width\": 64, \"height\": 48}");
    rest(&t);
    assert_non_null(t.pose);
    *state = &t;
    return 0;
}

static int tear_down(void **state)
{
    talk *t = *state;
    vvi_session_free(t->session, false);
    free(t->pose);
    vv_job_release(t->job);
    return unlink(t->path);
}

static void a_camera_that_was_worked_out_of_an_older_world_is_not_taken(void **state)
{
    talk *t = *state;
    char *stood = strdup(t->pose);
    for (int i = 0; i < 5; i++) {
        const int wakes = atomic_load(&t->wakes);
        say(t, "{\"type\": \"new\"}");
        while (atomic_load(&t->wakes) == wakes)
            usleep(100); /* the picture of the empty World, with its camera, lies there */
        say(t, "{\"type\": \"undo\"}");
        vvi_session_serve(t->session);
        t->is_final = false;
        rest(t);
        assert_string_equal(t->pose, stood);
    }
    free(stood);
}

static void a_final_picture_is_outdated_before_an_edit_is_answered(void **state)
{
    talk *t = *state;
    for (int i = 1; i <= 5; i++) {
        const unsigned before = t->commit;
        say(t, i % 2 ? "{\"type\": \"edit\", \"id\": 1, \"edits\": [{\"op\": \"set\", \"path\": \"background\", "
                       "\"value\": \"#102030\"}]}"
                     : "{\"type\": \"undo\", \"id\": 1}");
        assert_true(t->is_final);
        hear(t, "\"id\": 1,");
        assert_false(t->is_final);
        rest(t);
        assert_true(t->commit > before);
    }
}

/* Until nothing more of the picture comes. */
static void wait_for_all_of_it(talk *t)
{
    for (int wakes = -1, quiet = 0; quiet < 30; usleep(1000)) {
        vvi_session_serve(t->session);
        quiet = atomic_load(&t->wakes) == wakes ? quiet + 1 : 0;
        wakes = atomic_load(&t->wakes);
    }
}

static void only_the_picture_before_is_said_to_be_outdated(void **state)
{
    talk *t = *state;
    for (int i = 0; i < 3; i++) {
        say(t, i % 2 ? "{\"type\": \"undo\"}"
                     : "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"background\", \"value\": "
                       "\"#405060\"}]}");
        wait_for_all_of_it(t);
        t->is_final = false;
        rest(t); /* the new picture lay there before anything was said of the old one */
    }
}

static void a_frame_is_not_final_when_something_newer_is_wanted_already(void **state)
{
    talk *t = *state;
    static const char edit[] =
        "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"background\", \"value\": "
        "\"#%02x2030\"}]}";
    char text[sizeof edit + 8];
    const unsigned begun = t->commit;
    for (unsigned i = 1; i <= 20; i++) {
        snprintf(text, sizeof text, edit, i);
        say(t, text);
        if (i % 3 == 0)
            hear(t, ""); /* it may be one of an edit before */
        assert_true(!t->is_final || i % 3 || t->commit == begun + i);
    }
    t->is_final = false;
    rest(t);
    assert_int_equal(t->commit, begun + 20);
}

static void the_world_is_told_with_all_that_changed_since_it_was_told_last(void **state)
{
    talk *t = *state;
    rest(t);
    say(t, "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"title\", \"value\": \"a\"}]}");
    hear(t, "\"type\": \"world\""); /* the next is not due yet */
    for (int i = 0; i < 3; i++)
        say(t,
            "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"background\", \"value\": \"#405060\"}]}");
    say(t, "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"title\", \"value\": \"b\"}]}");
    hear(t, "\"paths\": [\"background\",\"title\"]");
    for (int i = 0; i < 40; i++) {
        say(t, "{\"type\": \"undo\"}");
        say(t, "{\"type\": \"redo\"}");
    }
    hear(t, "\"paths\": null");
}

/* Edits that give n datasets a text of 60000 characters; free() it. */
static char *edits_of(int id, const char *name, int n, bool empty)
{
    enum { TEXT = 60000, ROOM = TEXT + 200 };
    char *text = malloc((size_t)n * ROOM + 200), *at = text;
    at += sprintf(at, "{\"type\": \"edit\", \"id\": %d, \"edits\": [", id);
    for (int i = 0; i < n; i++) {
        at += sprintf(at, "%s{\"op\": \"set\", \"path\": \"datasets.%s%d\", \"value\": {\"parameters\": {\"text\": \"",
                      i ? ", " : "", name, i);
        memset(at, 'x', TEXT);
        at += (empty ? 0 : TEXT) + sprintf(at + (empty ? 0 : TEXT), "\"}}}");
    }
    sprintf(at, "]}");
    return text;
}

static void ask(talk *t, int id, char *text, const char *wanted)
{
    char start[80];
    snprintf(start, sizeof start, "\"type\": \"answer\",\"id\": %d,%s", id, wanted);
    say(t, text);
    free(text);
    hear(t, start);
}

/* 34 such datasets are more than 4 MiB. */
static void a_world_has_a_size(void **state)
{
    static const char refused[] = "\"ok\": false,\"error\": \"the World would be 4.";
    talk *t = *state;
    ask(t, 1, edits_of(1, "d", 66, false), "\"ok\": true");
    ask(t, 2, edits_of(2, "e", 6, false), refused);
    ask(t, 3, edits_of(3, "d", 66, true), "\"ok\": true");
    ask(t, 4, strdup("{\"type\": \"undo\", \"id\": 4}"), "\"ok\": true");
    ask(t, 5, strdup("{\"type\": \"redo\", \"id\": 5}"), "\"ok\": true");
    vvi_client *other = t->client;
    ok(vvi_client_join(&t->client, t->session, NULL)); /* another, with another view */
    say(t, "{\"type\": \"hello\", \"width\": 64, \"height\": 48}");
    ask(t, 6, edits_of(6, "e", 6, false), "\"ok\": true");
    vvi_client_leave(t->client);
    t->client = other;
    ask(t, 7, strdup("{\"type\": \"undo\", \"id\": 7}"), refused); /* what comes back beside what has come */
    ask(t, 8, strdup("{\"type\": \"redo\", \"id\": 8}"), "\"ok\": false,\"error\": \"there is nothing to redo");
    vv_world *world = vvi_session_world(t->session);
    assert_non_null(vv_collection_find(world->datasets, "e5"));
    assert_null(
        strstr(((const vv_dataset *)(const void *)vv_collection_find(world->datasets, "d65"))->parameters, "xx"));
    vv_object_release(&world->base);
}

static void long_paths_are_all_of_it(void **state)
{
    talk *t = *state;
    rest(t);
    say(t, "{\"type\": \"edit\", \"edits\": [{\"op\": \"set\", \"path\": \"title\", \"value\": \"a\"}]}");
    hear(t, "\"type\": \"world\"");
    char *edits = edits_of(9, "d", 1000, true);
    say(t, edits);
    free(edits);
    hear(t, "\"paths\": null");
}

static void input_is_answered_after_the_pose_that_comes_of_it(void **state)
{
    talk *t = *state;
    char *stood = strdup(t->pose);
    say(t, "{\"type\": \"events\", \"id\": 5, \"lines\": \"1 keyboard key ArrowLeft down\\n2 keyboard key ArrowLeft "
           "up\"}");
    hear(t, "\"id\": 5,");
    assert_string_not_equal(t->pose, stood);
    assert_non_null(strstr(t->pose, "\"moving\": true"));
    assert_false(t->is_final);
    rest(t);
    assert_non_null(strstr(t->pose, "\"moving\": false"));
    free(stood);
}

/* The next question is answered, and so is the one before it: questions wait for each other. */
static void a_question_without_memory_is_refused_or_answered(void **state)
{
    static const char *const asked[] = {
        "{\"type\": \"info\", \"id\": 7, \"dataset\": \"nothing\"}",
        "{\"type\": \"histogram\", \"id\": 7, \"volume\": \"nothing\"}",
        "{\"type\": \"thumbnail\", \"id\": 7, \"preset\": \"gray\", \"volume\": \"nothing\"}",
        "{\"type\": \"thumbnail\", \"id\": 7, \"preset\": \"nothing\"}",
    };
    talk *t = *state;
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        bool failed = true;
        for (int64_t n = 1; failed; n++) {
            vvi_alloc_fail_after(n);
            const vv_status st = vvi_client_message(t->client, asked[i], strlen(asked[i]), vvi_now());
            failed = vvi_alloc_has_failed();
            vvi_alloc_fail_after(0);
            assert_true(st == VV_OK || failed);
            say(t, "{\"type\": \"info\", \"id\": 8, \"dataset\": \"nothing\"}");
            hear(t, "\"id\": 8");
        }
    }
}

static void what_there_was_no_memory_to_tell_is_not_null(void **state)
{
    static const char asked[] = "{\"type\": \"browse\", \"id\": 7, \"path\": \"\"}";
    talk *t = *state;
    bool failed = true;
    for (int64_t n = 1; failed; n++) {
        vvi_alloc_fail_once(n);
        vvi_client_message(t->client, asked, strlen(asked), vvi_now());
        failed = vvi_alloc_has_failed();
        vvi_alloc_fail_after(0);
        say(t, "{\"type\": \"cancel\", \"id\": 8, \"job\": -1}");
        for (bool found = false; !found;) {
            char *text = next(t);
            assert_null(strstr(text, "\"id\": 7,\"ok\": true,\"value\": null"));
            found = strstr(text, "\"id\": 8") != NULL;
            if (!*text)
                acknowledge(t);
            free(text);
        }
    }
}

static void what_asks_for_an_answer_has_one(void **state)
{
    static const char *const asked[] = {
        "{\"type\": \"events\", \"id\": 7, \"lines\": \"\"}",
        "{\"type\": \"size\", \"id\": 7, \"width\": 24, \"height\": 16}",
        "{\"type\": \"ack\", \"id\": 7, \"frame\": 1}",
        "{\"type\": \"edit\", \"id\": 7, \"edits\": []}",
        "{\"type\": \"undo\", \"id\": 7}",
        "{\"type\": \"action\", \"id\": 7, \"name\": \"none of them\"}",
        "{\"type\": \"camera\", \"id\": 7, \"eye\": [9, 9, 9], \"at\": [0, 0, 0], \"up\": [0, 1, 0]}",
        "{\"type\": \"browse\", \"id\": 7, \"path\": \"\"}",
        "{\"type\": \"cancel\", \"id\": 7, \"job\": -1}",
        "{\"type\": \"world\", \"id\": 7}",
    };
    talk *t = *state;
    for (size_t i = 0; i < sizeof asked / sizeof *asked; i++) {
        int n = 0;
        say(t, asked[i]);
        say(t, "{\"type\": \"cancel\", \"id\": 8, \"job\": -1}");
        for (bool found = false; !found;) {
            char *text = next(t);
            n += strstr(text, "\"id\": 7") != NULL;
            found = strstr(text, "\"id\": 8") != NULL;
            if (!*text)
                acknowledge(t);
            free(text);
        }
        if (n != 1)
            fail_msg("%d answers to %s", n, asked[i]);
    }
}

static char *long_text(size_t n)
{
    char *text = vvi_calloc(n + 1, 1);
    assert_non_null(text);
    memset(text, 'x', n);
    return text;
}

/* Whatever fails of telling it: what comes is whole, and the World comes in the end. */
static void a_world_that_cannot_be_told_now_is_told_later(void **state)
{
    talk *t = *state;
    bool failed = true;
    for (int64_t n = 1; failed; n++) {
        vvi_outgoing out;
        rest(t); /* nobody else takes memory now */
        t->client->tells_world = true;
        t->client->world_told = 0;
        free(t->session->told);
        t->session->told = NULL;
        vvi_alloc_fail_once(n);
        const bool any = vvi_client_next(&out, t->client, vvi_now());
        failed = vvi_alloc_has_failed();
        vvi_alloc_fail_once(0);
        if (any && !(out.text && strncmp(out.text, "{\"type\": \"world\"", 16) == 0 && strchr(out.text, '\n')))
            fail_msg("'%s'", out.text ? out.text : "a frame");
        assert_true(any || failed);
        if (any)
            free(out.text);
        else
            hear(t, "\"type\": \"world\"");
    }
}

/* A World that is as long as hundreds of views are waits while the page is behind: what it says of its frame is read.
 */
static void news_that_wait_hinder_no_page_to_be_heard(void **state)
{
    talk *t = *state;
    vvi_client_tell(t->client, VVI_LINE_RESOLVED, long_text(200000));
    assert_false(vvi_client_is_full(t->client));
    vvi_client_say(t->client, long_text(100000));
    assert_true(vvi_client_is_full(t->client)); /* answers that are not read are not asked for */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_that_was_worked_out_of_an_older_world_is_not_taken),
        cmocka_unit_test(a_world_that_cannot_be_told_now_is_told_later),
        cmocka_unit_test(a_final_picture_is_outdated_before_an_edit_is_answered),
        cmocka_unit_test(only_the_picture_before_is_said_to_be_outdated),
        cmocka_unit_test(a_frame_is_not_final_when_something_newer_is_wanted_already),
        cmocka_unit_test(the_world_is_told_with_all_that_changed_since_it_was_told_last),
        cmocka_unit_test(a_world_has_a_size),
        cmocka_unit_test(long_paths_are_all_of_it),
        cmocka_unit_test(input_is_answered_after_the_pose_that_comes_of_it),
        cmocka_unit_test(a_question_without_memory_is_refused_or_answered),
        cmocka_unit_test(what_there_was_no_memory_to_tell_is_not_null),
        cmocka_unit_test(what_asks_for_an_answer_has_one),
        cmocka_unit_test(news_that_wait_hinder_no_page_to_be_heard),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
