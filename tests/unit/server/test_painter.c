/* The thread that renders: which wishes are followed, and which frames come of them. */
#include "fields.h"
#include "jobs.h"
#include "server/painter.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>
#include <volvis/file.h>

enum { LARGE = 2500 }; /* pixels a side of a picture that is not done at once */

typedef struct studio {
    char path[64];
    vv_job *job;
    vv_world *world;
    vvi_painter *painter;
} studio;

static void ok(vv_status st)
{
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void ignore(void *user)
{
    (void)user;
}

static int set_up_with(void **state, uint64_t memory)
{
    static studio s;
    s = (studio){.path = "/tmp/volvis-painter-XXXXXX.nrrd", .job = test_job(1, memory)};
    vv_field *field = test_field_cube(&test_form_sphere, 9, 0, 8, s.job);
    const int fd = mkstemps(s.path, 5);
    assert_true(fd >= 0 && field);
    close(fd);
    ok(vv_field_write(s.path, (const vv_field *const *)&field, 1, NULL, s.job));
    vv_field_release(field);
    ok(vv_world_for_file(&s.world, s.path, NULL, s.job));
    ok(vvi_painter_new(&s.painter, vv_job_runtime(s.job), ignore, NULL));
    *state = &s;
    return 0;
}

static int set_up(void **state)
{
    return set_up_with(state, 0);
}

static int set_up_small(void **state)
{
    return set_up_with(state, (uint64_t)64 << 20);
}

static int tear_down(void **state)
{
    studio *s = *state;
    vvi_painter_free(s->painter);
    vv_object_release(&s->world->base);
    vv_job_release(s->job);
    return unlink(s->path);
}

static void want(studio *s, int slot, uint64_t commit, int32_t side, bool moving)
{
    vvi_wish wish = {.world = s->world,
                     .commit = commit,
                     .view = "main",
                     .width = side,
                     .height = side,
                     .frame_size = {side / 2, side / 2},
                     .moving = moving,
                     .coarse = true};
    vvi_painter_want(s->painter, slot, &wish);
}

/* The next thing of a view that has a picture or an error. */
static vvi_painted next_frame(studio *s, int slot)
{
    vvi_painted painted;
    for (;;) {
        if (!vvi_painter_take(&painted, s->painter, slot))
            usleep(100);
        else if (painted.bytes || painted.error)
            return painted;
        else
            vvi_painted_free(&painted);
    }
}

static void the_newest_wish_is_followed_to_its_end(void **state)
{
    studio *s = *state;
    uint64_t newest = 0;
    for (uint64_t commit = 1; commit <= 30; commit++)
        want(s, 0, commit, 32, false);
    for (bool final = false; !final || newest < 30;) {
        vvi_painted p = next_frame(s, 0);
        assert_null(p.error);
        assert_true(p.commit >= newest);
        assert_true(p.has_stand);
        assert_int_equal(p.full[0], 32);
        assert_int_equal(p.kind, p.final ? VVI_PICTURE_PNG : VVI_PICTURE_JPEG);
        newest = p.commit;
        final = p.final;
        vvi_painted_free(&p);
    }
    vvi_painter_forget(s->painter, 0);
    vvi_painted none;
    assert_false(vvi_painter_take(&none, s->painter, 0));
}

static size_t bytes_at_rest(studio *s, size_t most, vvi_picture_kind kind)
{
    vvi_wish wish = {.world = s->world, .commit = 1, .view = "main", .width = 128, .height = 128, .bytes_most = most};
    vvi_painter_want(s->painter, 0, &wish);
    vvi_painted p = next_frame(s, 0);
    for (; !p.final; p = next_frame(s, 0))
        vvi_painted_free(&p);
    const size_t n = p.n;
    assert_int_equal(p.kind, kind);
    assert_true(p.reduced == (kind == VVI_PICTURE_JPEG));
    assert_true(p.reduced ? p.whole > most : p.whole == n);
    vvi_painted_free(&p);
    return n;
}

/* A quarter of 64 MiB is a picture of some 540 x 540. */
static void a_picture_that_memory_does_not_hold_is_smaller(void **state)
{
    studio *s = *state;
    want(s, 0, 1, LARGE, false);
    for (bool final = false; !final;) {
        vvi_painted p = next_frame(s, 0);
        if (p.error)
            fail_msg("%s", p.error);
        assert_true(p.size[0] > 200 && p.size[0] < 600 && p.size[0] == p.size[1]);
        assert_true(p.full[0] == LARGE && p.full[1] == LARGE);
        final = p.final;
        vvi_painted_free(&p);
    }
}

static void a_thin_line_gets_a_picture_at_rest_that_it_carries(void **state)
{
    studio *s = *state;
    const size_t whole = bytes_at_rest(s, 0, VVI_PICTURE_PNG);
    assert_int_equal(bytes_at_rest(s, SIZE_MAX, VVI_PICTURE_PNG), whole);
    assert_int_equal(bytes_at_rest(s, whole, VVI_PICTURE_PNG), whole);
    const size_t fine = bytes_at_rest(s, whole - 1, VVI_PICTURE_JPEG), rough = bytes_at_rest(s, 100, VVI_PICTURE_JPEG);
    assert_true(rough < fine && fine < whole);
}

/* Else a hand that never rests would see nothing. */
static void a_frame_that_moves_is_not_cancelled_by_the_next_wish(void **state)
{
    studio *s = *state;
    vvi_painted p;
    uint64_t commit = 0;
    for (int n = 0; n < 5;) {
        want(s, 0, ++commit, 200, true);
        usleep(50);
        if (!vvi_painter_take(&p, s->painter, 0))
            continue;
        assert_null(p.error);
        if (p.bytes) {
            assert_true(p.moving && !p.final);
            assert_int_equal(p.kind, VVI_PICTURE_JPEG);
            assert_int_equal(p.size[0], 100);
            n++;
        }
        vvi_painted_free(&p);
    }
}

static void a_picture_at_rest_is_left_for_a_newer_wish(void **state)
{
    studio *s = *state;
    want(s, 0, 1, LARGE, false);
    vvi_painted first = next_frame(s, 0);
    assert_false(first.final);
    vvi_painted_free(&first);
    want(s, 0, 2, 16, false);
    for (bool final = false; !final;) {
        vvi_painted p = next_frame(s, 0);
        final = p.final;
        if (final)
            assert_int_equal(p.commit, 2);
        vvi_painted_free(&p);
    }
}

static vvi_painted last_frame(studio *s, int slot)
{
    for (;;) {
        vvi_painted p = next_frame(s, slot);
        if (p.final)
            return p;
        vvi_painted_free(&p);
    }
}

static vvi_painter_rays rays_of(const studio *s)
{
    vvi_painter_rays rays;
    vvi_painter_count_rays(&rays, s->painter);
    return rays;
}

static void edit(studio *s, const char *path, const char *json)
{
    vv_object *root = &s->world->base;
    ok(vv_path_set(&root, path, json, NULL));
    s->world = (vv_world *)(void *)root;
}

/* The same picture again: after an edit that it does not show, by a page that has connected again, and once the camera
 * has come back. Each is the same file, and casts no ray. */
static void what_a_picture_does_not_depend_on_costs_it_no_ray(void **state)
{
    static const struct {
        const char *path, *json;
        int slot;
        bool other;
    } steps[] = {{"title", "\"another name\"", 0, false},
                 {"views.side", "{\"camera\": {\"azimuth\": 12}}", 0, false},
                 {"volumes.unseen", "{\"visible\": false}", 0, false},
                 {"title", "\"by another page\"", 5, false},
                 {"views.main.camera.azimuth", "12", 5, true},
                 {"views.main.camera.azimuth", "0", 5, false}};
    studio *s = *state;
    edit(s, "views.main.camera.azimuth", "0");
    want(s, 0, 1, 150, false);
    vvi_painted first = last_frame(s, 0);
    const uint64_t each = rays_of(s).cast;
    assert_true(each >= 150 * 150 && rays_of(s).kept == 0);
    for (size_t i = 0; i < sizeof steps / sizeof *steps; i++) {
        const vvi_painter_rays before = rays_of(s);
        if (steps[i].slot)
            vvi_painter_forget(s->painter, 0);
        edit(s, steps[i].path, steps[i].json);
        want(s, steps[i].slot, i + 2, 150, false);
        vvi_painted p = last_frame(s, steps[i].slot);
        const vvi_painter_rays after = rays_of(s);
        if (steps[i].other != (after.cast > before.cast) || steps[i].other == (after.kept == before.kept + each))
            fail_msg("%s: %llu rays", steps[i].path, (unsigned long long)(after.cast - before.cast));
        if (!steps[i].other && (p.n != first.n || memcmp(p.bytes, first.bytes, p.n) != 0))
            fail_msg("%s: another picture", steps[i].path);
        vvi_painted_free(&p);
    }
    vvi_painted_free(&first);
}

/* Left in the middle for a small one. */
static void a_picture_that_was_left_goes_on_from_where_it_was(void **state)
{
    enum { SIDE = 1100 };
    studio *s = *state;
    want(s, 0, 1, SIDE, false);
    vvi_painted p = last_frame(s, 0), first = p;
    vvi_painter_forget(s->painter, 0);
    edit(s, "views.main.camera.azimuth", "25");
    want(s, 0, 2, SIDE, false);
    p = next_frame(s, 0);
    vvi_painted_free(&p);
    edit(s, "views.main.camera.azimuth", "35");
    want(s, 0, 3, 16, false);
    p = last_frame(s, 0);
    vvi_painted_free(&p);
    const vvi_painter_rays before = rays_of(s);
    edit(s, "views.main.camera.azimuth", "25");
    want(s, 0, 4, SIDE, false);
    p = last_frame(s, 0);
    const vvi_painter_rays after = rays_of(s);
    assert_true(after.kept > before.kept);
    assert_int_equal(p.commit, 4);
    vvi_painter_free(s->painter); /* nothing is kept */
    ok(vvi_painter_new(&s->painter, vv_job_runtime(s->job), ignore, NULL));
    want(s, 0, 5, SIDE, false);
    vvi_painted unbroken = last_frame(s, 0);
    assert_true(rays_of(s).kept == 0 && rays_of(s).cast == after.cast - before.cast + after.kept - before.kept);
    assert_true(p.n == unbroken.n && memcmp(p.bytes, unbroken.bytes, p.n) == 0);
    vvi_painted_free(&p);
    vvi_painted_free(&first);
    vvi_painted_free(&unbroken);
}

static void what_is_forgotten_while_it_is_rendered_leaves_nothing(void **state)
{
    studio *s = *state;
    vvi_painted p, none;
    want(s, 0, 1, LARGE, false);
    p = next_frame(s, 0);
    vvi_painted_free(&p);
    vvi_painter_forget(s->painter, 0);
    want(s, VVI_PAINTER_VIEWS - 1, 2, 16, true);
    p = next_frame(s, VVI_PAINTER_VIEWS - 1);
    assert_int_equal(p.commit, 2);
    vvi_painted_free(&p);
    assert_false(vvi_painter_take(&none, s->painter, 0));
    want(s, 0, 3, 16, true); /* the place of the one who left is taken */
    p = next_frame(s, 0);
    assert_int_equal(p.commit, 3);
    vvi_painted_free(&p);
}

static void views_take_turns(void **state)
{
    studio *s = *state;
    for (int slot = 0; slot < 20; slot++)
        want(s, slot, 1, 24, true);
    for (int slot = 0; slot < 20; slot++) {
        vvi_painted p = next_frame(s, slot);
        assert_null(p.error);
        vvi_painted_free(&p);
    }
}

/* Of two who move all the time, the one whose frames take long gets fewer, and as much time. */
static void frames_that_take_long_are_fewer(void **state)
{
    studio *s = *state;
    int frames[2] = {0, 0};
    for (; frames[0] < 8; usleep(200))
        for (int slot = 0; slot < 2; slot++) {
            vvi_painted p;
            want(s, slot, 1, slot == 0 ? LARGE / 2 : 16, true);
            if (vvi_painter_take(&p, s->painter, slot)) {
                frames[slot]++;
                vvi_painted_free(&p);
            }
        }
    if (frames[1] <= 4 * frames[0])
        fail_msg("%d frames of the large one, %d of the small one", frames[0], frames[1]);
}

/* A picture at rest keeps nobody waiting who moves, and is done all the same while he goes on. */
static void a_picture_at_rest_goes_on_beside_views_that_move(void **state)
{
    studio *s = *state;
    vvi_painted p;
    uint64_t commit = 0;
    bool final = false;
    want(s, 0, 1, LARGE / 5, false);
    p = next_frame(s, 0); /* it is being rendered */
    vvi_painted_free(&p);
    while (!final) {
        want(s, 1, ++commit, 16, true);
        p = next_frame(s, 1);
        assert_int_equal(p.commit, commit);
        vvi_painted_free(&p);
        if (vvi_painter_take(&p, s->painter, 0)) {
            final = p.bytes && p.final;
            vvi_painted_free(&p);
        }
    }
}

/* Drafts of all come while the large picture is made, which is not begun anew, and then their pictures. */
static void who_shows_nothing_yet_waits_for_nobody_s_large_picture(void **state)
{
    enum { NEW = 12 };
    studio *s = *state;
    want(s, 0, 1, LARGE, false);
    vvi_painted p = next_frame(s, 0); /* it is being rendered */
    assert_false(p.final);
    vvi_painted_free(&p);
    for (int i = 1; i <= NEW; i++)
        want(s, i, 1, i == 1 ? LARGE : 100 * i, false);
    for (int i = 1; i <= NEW; i++) {
        p = next_frame(s, i);
        assert_null(p.error);
        assert_true(p.has_stand && !p.moving && (!p.final || i > 1)); /* a small one may be whole before we look */
        assert_int_equal(p.full[0], i == 1 ? LARGE : 100 * i);
        assert_true((p.final || p.size[0] <= 512) && p.size[0] == p.size[1]);
        vvi_painted_free(&p);
    }
    for (; vvi_painter_take(&p, s->painter, 0); vvi_painted_free(&p))
        assert_false(p.final); /* still under way */
    vvi_painter_forget(s->painter, 0);
    vvi_painter_forget(s->painter, 1);
    for (int i = 2; i <= 3; i++)
        for (bool final = false; !final;) {
            p = next_frame(s, i);
            final = p.final;
            assert_true(!final || p.size[0] == 100 * i);
            vvi_painted_free(&p);
        }
}

/* Nobody is busy with a picture at rest, but quick frames take the threads; and one of more than screens have, at once.
 */
static void a_newcomer_beside_those_who_move_sees_a_draft_first(void **state)
{
    studio *s = *state;
    vvi_painted p = {.n = 0};
    want(s, 0, 1, LARGE, true);
    want(s, 1, 1, 1000, false);
    while (!p.bytes) {
        vvi_painted_free(&p);
        want(s, 0, 1, LARGE, true);
        usleep(200);
        vvi_painter_take(&p, s->painter, 1);
    }
    assert_true(!p.final && p.size[0] <= 512 && p.full[0] == 1000);
    vvi_painted_free(&p);
    vvi_painter_forget(s->painter, 0);
    vvi_painter_forget(s->painter, 1);
    want(s, 2, 1, LARGE, false);
    p = next_frame(s, 2);
    assert_true(!p.final && p.size[0] <= 512 && p.full[0] == LARGE);
    vvi_painted_free(&p);
}

static void a_view_is_free_when_nothing_is_rendered_for_it(void **state)
{
    studio *s = *state;
    while (!vvi_painter_is_free(s->painter, 0)) /* what others wished ends */
        usleep(1000);
    want(s, 0, 1, LARGE, false);
    vvi_painted p = {.n = 0};
    while (vvi_painter_is_free(s->painter, 0) && !p.final) { /* between the draft and the rest nobody has it */
        vvi_painted_free(&p);
        if (!vvi_painter_take(&p, s->painter, 0))
            usleep(100);
    }
    vvi_painted_free(&p);
    vvi_painter_forget(s->painter, 0);
    while (!vvi_painter_is_free(s->painter, 0))
        usleep(1000);
}

static void what_cannot_be_shown_is_told(void **state)
{
    studio *s = *state;
    vvi_wish wish = {.world = s->world, .view = "nothing", .width = 8, .height = 8, .frame_size = {8, 8}};
    vvi_painter_want(s->painter, 0, &wish);
    vvi_painted p = next_frame(s, 0);
    assert_non_null(p.error);
    assert_null(p.bytes);
    vvi_painted_free(&p);
}

static void the_end_comes_in_the_middle_of_a_picture(void **state)
{
    studio *s = *state;
    want(s, 0, 1, LARGE, false);
    vvi_painted p = next_frame(s, 0); /* it is being rendered, and the next one waits */
    vvi_painted_free(&p);
    want(s, 1, 1, LARGE, false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(the_newest_wish_is_followed_to_its_end, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_picture_that_memory_does_not_hold_is_smaller, set_up_small, tear_down),
        cmocka_unit_test_setup_teardown(a_thin_line_gets_a_picture_at_rest_that_it_carries, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_frame_that_moves_is_not_cancelled_by_the_next_wish, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_picture_at_rest_is_left_for_a_newer_wish, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_a_picture_does_not_depend_on_costs_it_no_ray, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_picture_that_was_left_goes_on_from_where_it_was, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_is_forgotten_while_it_is_rendered_leaves_nothing, set_up, tear_down),
        cmocka_unit_test_setup_teardown(views_take_turns, set_up, tear_down),
        cmocka_unit_test_setup_teardown(frames_that_take_long_are_fewer, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_shows_nothing_yet_waits_for_nobody_s_large_picture, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_picture_at_rest_goes_on_beside_views_that_move, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_newcomer_beside_those_who_move_sees_a_draft_first, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_view_is_free_when_nothing_is_rendered_for_it, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_cannot_be_shown_is_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(the_end_comes_in_the_middle_of_a_picture, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
