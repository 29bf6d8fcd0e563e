/* Pictures in steps: where one is broken off, by a deadline, a cancel or the end of its process, is seen nowhere. */
#include "fields.h"
#include "jobs.h"
#include "model/context.h"
#include "render/checkpoint.h"
#include "render/picture.h"
#include "render/picture_depends.h"
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include <volvis/volvis.h>

#include <cmocka.h>

typedef struct look {
    const char *path, *json;
} look;

/* Ways to make a picture: the stages that there are, alone and one after the other. */
typedef struct manner {
    const char *name;
    bool coarse;
    look looks[5];
} manner;

static const manner ways[] = {
    {"one pass", false, {{"render.samples", "1"}}},
    {"coarse pictures first", true, {{"render.samples", "3"}}},
    {"squares", false, {{"render.adaptive", "true"}, {"render.samples", "1"}}},
    {"passes with layers",
     false,
     {{"render.samples", "4"}, {"render.layers.normal", "true"}, {"render.layers.samples", "true"}}},
    {"noise", true, {{"render.noise", "0.004"}, {"render.samples", "20"}}},
    {"triangles", false, {{"render.method", "\"surface\""}, {"render.surface.iso", "0.5"}}},
};
enum { N_WAYS = sizeof ways / sizeof *ways, WIDTH = 101, HEIGHT = 75 };

typedef struct setup {
    vv_job *job;
    vv_object *world;
} setup;

static void set(setup *s, const char *path, const char *json)
{
    const vv_property_context context = vvi_registry_context(vv_runtime_registry(vv_job_runtime(s->job)));
    if (vv_path_set(&s->world, path, json, &context) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

static void begin(setup *s, const manner *way, int threads)
{
    vv_world *world;
    char number[16];
    s->job = test_job(threads, 0);
    vv_field *field = test_field_cube(&test_form_marschner_lobb, 24, -1, 1, s->job);
    assert_int_equal(vv_world_for_field(&world, "a", field, s->job), VV_OK);
    vv_field_release(field);
    s->world = &world->base;
    snprintf(number, sizeof number, "%d", WIDTH);
    set(s, "views.main.width", number);
    snprintf(number, sizeof number, "%d", HEIGHT);
    set(s, "views.main.height", number);
    set(s, "views.main.decorations.scale_bar", "true");
    for (size_t i = 0; i < sizeof way->looks / sizeof *way->looks && way->looks[i].path; i++) {
        char path[64];
        snprintf(path, sizeof path, "views.main.%s", way->looks[i].path);
        set(s, path, way->looks[i].json);
    }
}

static void end(setup *s)
{
    vv_object_release(s->world);
    vv_job_release(s->job);
}

static vv_picture *new_picture(setup *s, bool coarse)
{
    vv_picture *picture;
    if (vv_picture_new(&picture, (vv_world *)s->world, NULL, coarse, s->job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    return picture;
}

static void step(vv_picture *picture, double seconds, vv_job *job)
{
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.seconds = seconds;
    if (vv_picture_step(picture, &until, job) != VV_OK)
        fail_msg("%s", vv_error_last()->message);
}

/* What vv_render() makes of it. */
typedef struct expected {
    vv_image *image;
    vv_render_report report;
} expected;

static expected render(const manner *way)
{
    setup s;
    expected e;
    begin(&s, way, 2);
    assert_int_equal(vv_render(&e.image, &e.report, (vv_world *)s.world, NULL, NULL, s.job), VV_OK);
    end(&s);
    return e;
}

static void check(vv_picture *picture, const expected *e, const char *name, vv_job *job)
{
    const size_t n = (size_t)WIDTH * HEIGHT;
    vv_render_report report;
    vv_image *image;
    assert_true(vv_picture_is_whole(picture));
    assert_int_equal(vv_picture_look(&image, picture, job), VV_OK);
    vv_picture_report(&report, picture);
    if (memcmp(image->rgba, e->image->rgba, 4 * n * sizeof(float)) != 0 ||
        memcmp(image->depth, e->image->depth, n * sizeof(float)) != 0 ||
        (image->samples && memcmp(image->samples, e->image->samples, n * sizeof(uint32_t)) != 0) ||
        (image->normal && memcmp(image->normal, e->image->normal, 3 * n * sizeof(float)) != 0))
        fail_msg("%s: other bytes", name);
    if (report.rays < e->report.rays || report.passes != e->report.passes || report.ended_by != e->report.ended_by)
        fail_msg("%s: %llu rays, %lld passes", name, (unsigned long long)report.rays, (long long)report.passes);
    vv_image_release(image);
}

static void deadlines_change_no_byte(void **state)
{
    (void)state;
    for (int w = 0; w < N_WAYS; w++) {
        const expected e = render(&ways[w]);
        for (int threads = 1; threads <= 3; threads++) {
            setup s;
            begin(&s, &ways[w], threads);
            vv_picture *picture = new_picture(&s, ways[w].coarse);
            for (unsigned i = 0; !vv_picture_is_whole(picture); i++)
                step(picture, i % 3 ? 1e-9 : 1e-3 * test_random_unit(test_seed(), i), s.job);
            check(picture, &e, ways[w].name, s.job);
            vv_picture_free(picture);
            end(&s);
        }
        vv_image_release(e.image);
    }
}

/* Cancelled by another thread ------------------------------------------------------------------------------------- */

static void *cancel_soon(void *user)
{
    static unsigned number;
    usleep((unsigned)(1500 * test_random_unit(test_seed(), number++)));
    vv_job_cancel(user);
    return NULL;
}

static void a_cancelled_step_loses_nothing_that_was_whole(void **state)
{
    (void)state;
    for (int w = 0; w < N_WAYS; w++) {
        const expected e = render(&ways[w]);
        setup s;
        begin(&s, &ways[w], 2);
        vv_picture *picture = new_picture(&s, ways[w].coarse);
        for (int i = 0; i < 12 && !vv_picture_is_whole(picture); i++) {
            pthread_t thread;
            vv_job *job;
            assert_int_equal(vv_job_new(&job, vv_job_runtime(s.job), NULL, NULL), VV_OK);
            assert_int_equal(pthread_create(&thread, NULL, cancel_soon, job), 0);
            const vv_status st = vv_picture_step(picture, NULL, job);
            pthread_join(thread, NULL);
            assert_true(st == VV_OK || st == VV_E_CANCELLED);
            vv_job_release(job);
        }
        step(picture, 0, s.job);
        check(picture, &e, ways[w].name, s.job);
        vv_picture_free(picture);
        end(&s);
        vv_image_release(e.image);
    }
}

/* Saved and resumed ----------------------------------------------------------------------------------------------- */

static const char file[] = "picture.part";

/* In a runtime of its own, as another process has it. */
static vv_picture *resume(setup *s, const manner *way, int threads)
{
    begin(s, way, threads);
    vv_picture *picture = new_picture(s, way->coarse);
    if (vv_picture_resume(picture, file, s->job) != VV_OK)
        fail_msg("%s: %s", way->name, vv_error_last()->message);
    return picture;
}

static void a_picture_resumed_after_every_step_has_the_same_bytes(void **state)
{
    (void)state;
    for (int w = 0; w < N_WAYS; w++) {
        const expected e = render(&ways[w]);
        setup s;
        begin(&s, &ways[w], 1);
        vv_picture *picture = new_picture(&s, ways[w].coarse);
        for (int i = 1; !vv_picture_is_whole(picture); i++) {
            assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
            vv_picture_free(picture);
            end(&s);
            picture = resume(&s, &ways[w], i % 3 + 1);
            for (int k = 0; k < 1 + i; k++)
                step(picture, 1e-9, s.job);
        }
        check(picture, &e, ways[w].name, s.job);
        assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
        vv_picture_free(picture);
        end(&s);
        picture = resume(&s, &ways[w], 1);
        check(picture, &e, ways[w].name, s.job);
        vv_picture_free(picture);
        end(&s);
        vv_image_release(e.image);
    }
    unlink(file);
}

/* A process that steps and saves until it is killed: mostly while it saves. */
static void step_and_save(const manner *way, bool resumes)
{
    setup s;
    begin(&s, way, 2);
    vv_picture *picture = new_picture(&s, way->coarse);
    if (resumes && vv_picture_resume(picture, file, s.job) != VV_OK)
        _exit(1);
    while (!vv_picture_is_whole(picture)) {
        step(picture, 1e-4, s.job);
        if (vv_picture_save(picture, file, s.job) != VV_OK)
            _exit(2);
    }
    _exit(0);
}

static void a_picture_whose_process_was_killed_goes_on_with_the_same_bytes(void **state)
{
    const manner *way = &ways[4];
    const expected e = render(way);
    setup s;
    int killed = 0;
    (void)state;
    unlink(file);
    for (unsigned i = 0; i < 10; i++) {
        int status;
        const bool there = access(file, F_OK) == 0;
        const pid_t child = fork();
        if (child == 0)
            step_and_save(way, there);
        usleep(20000 + (unsigned)(30000 * test_random_unit(test_seed(), i)));
        kill(child, SIGKILL);
        assert_int_equal(waitpid(child, &status, 0), child);
        killed += WIFSIGNALED(status);
        assert_true(WIFSIGNALED(status) || WEXITSTATUS(status) == 0);
    }
    assert_true(killed > 0);
    begin(&s, way, 3);
    vv_picture *picture = new_picture(&s, way->coarse);
    const vv_status st = vv_picture_resume(picture, file, s.job);
    assert_true(st == VV_OK || st == VV_E_NOT_FOUND); /* none had come so far */
    step(picture, 0, s.job);
    check(picture, &e, "killed", s.job);
    vv_picture_free(picture);
    end(&s);
    vv_image_release(e.image);
    unlink(file);
}

static vv_status try_file(vv_picture *picture, const uint8_t *bytes, size_t n, vv_job *job)
{
    FILE *out = fopen(file, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(bytes, 1, n, out), n);
    fclose(out);
    return vv_picture_resume(picture, file, job);
}

static uint8_t *read_file(size_t *n_out)
{
    FILE *in = fopen(file, "rb");
    assert_non_null(in);
    fseek(in, 0, SEEK_END);
    *n_out = (size_t)ftell(in);
    rewind(in);
    uint8_t *bytes = malloc(*n_out + 1);
    assert_int_equal(fread(bytes, 1, *n_out, in), *n_out);
    fclose(in);
    return bytes;
}

/* Any byte that changes, any length that is not the whole. */
static void a_damaged_or_cut_checkpoint_is_refused_and_the_picture_stays(void **state)
{
    const manner *way = &ways[4];
    const expected e = render(way);
    setup s;
    size_t n;
    (void)state;
    begin(&s, way, 1);
    vv_picture *picture = new_picture(&s, way->coarse);
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.passes = 2;
    assert_int_equal(vv_picture_step(picture, &until, s.job), VV_OK);
    step(picture, 1e-9, s.job);
    assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
    uint8_t *bytes = read_file(&n);
    for (unsigned i = 0; i < 200; i++) {
        const size_t at = i < 128 ? i : (size_t)(test_random(test_seed(), i) % n);
        bytes[at] ^= (uint8_t)(1u << i % 8);
        const vv_status st = try_file(picture, bytes, n, s.job);
        if (st == VV_OK || !*vv_error_last()->message)
            fail_msg("byte %zu may change", at);
        bytes[at] ^= (uint8_t)(1u << i % 8);
        const size_t cut = i < 4 ? (size_t)i * 50 : (size_t)(test_random(test_seed(), 1000 + i) % n);
        assert_int_equal(try_file(picture, bytes, cut, s.job), VV_E_FORMAT);
    }
    bytes[n] = 0;
    assert_int_equal(try_file(picture, bytes, n + 1, s.job), VV_E_FORMAT);
    unlink(file);
    assert_int_equal(vv_picture_resume(picture, file, s.job), VV_E_NOT_FOUND);
    step(picture, 0, s.job);
    check(picture, &e, "after damaged files", s.job);
    free(bytes);
    vv_picture_free(picture);
    end(&s);
    vv_image_release(e.image);
}

/* What it depends on ---------------------------------------------------------------------------------------------- */

static void a_checkpoint_is_taken_for_what_its_picture_depends_on_alone(void **state)
{
    static const struct {
        look look;
        bool other;
    } edits[] = {
        {{"title", "\"another name\""}, false},
        {{"volumes.a.title", "\"another name\""}, false},
        {{"views.main.decorations.caption", "\"drawn over it\""}, false},
        {{"background", "\"#204060\""}, false},
        {{"views.side", "{\"camera\": {\"azimuth\": 12}}"}, false},
        {{"lights.off", "{\"on\": false, \"intensity\": 3}"}, false},
        {{"cross_hair", "[0, 0, 0]"}, false},
        {{"views.main.camera.azimuth", "12"}, true},
        {{"views.main.width", "100"}, true},
        {{"views.main.render.samples", "5"}, true},
        {{"views.main.render.raycast.step", "0.5"}, true},
        {{"volumes.a.color", "\"red\""}, true},
        {{"lights.key.intensity", "3"}, true},
        {{"views.main.decorations.box", "true"}, true}, /* which is framed */
    };
    setup s;
    (void)state;
    begin(&s, &ways[0], 1);
    set(&s, "lights.key.intensity", "1");
    vv_picture *picture = new_picture(&s, false);
    step(picture, 1e-9, s.job);
    assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
    vv_picture_free(picture);
    for (size_t i = 0; i < sizeof edits / sizeof *edits; i++) {
        vv_object *before = vv_object_retain(s.world);
        set(&s, edits[i].look.path, edits[i].look.json);
        picture = new_picture(&s, false);
        const vv_status st = vv_picture_resume(picture, file, s.job);
        if (st != (edits[i].other ? VV_E_ARGUMENT : VV_OK))
            fail_msg("%s: %s", edits[i].look.path, st == VV_OK ? "taken" : vv_error_last()->message);
        vv_picture_free(picture);
        vv_object_release(s.world);
        s.world = before;
    }
    end(&s);
    unlink(file);
}

/* From nothing to the first of its kind, and back. */
static void what_is_drawn_over_a_picture_comes_and_goes(void **state)
{
    static const look edits[] = {
        {"views.main.decorations", "{\"title\": \"over it\"}"},
        {"views.main.decorations", "{\"caption\": \"{file}\"}"},
        {"views.main.decorations", "{\"scale_bar\": true}"},
        {"views.main.decorations", "{\"scale_bar\": false, \"legend\": true}"},
    };
    for (size_t i = 0; i < 2 * (sizeof edits / sizeof *edits); i++) {
        setup s;
        begin(&s, &ways[0], 1);
        assert_int_equal(vv_path_unset(&s.world, "views.main.decorations", NULL), VV_OK);
        vv_object *bare = vv_object_retain(s.world);
        set(&s, edits[i / 2].path, edits[i / 2].json);
        vv_object *one = i % 2 ? s.world : bare, *other = i % 2 ? bare : s.world;
        s.world = one;
        vv_picture *picture = new_picture(&s, false);
        step(picture, 1e-9, s.job);
        assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
        vv_picture_free(picture);
        s.world = other;
        picture = new_picture(&s, false);
        if (vv_picture_resume(picture, file, s.job) != VV_OK)
            fail_msg("%s, %s: %s", edits[i / 2].json, i % 2 ? "gone" : "come", vv_error_last()->message);
        vv_picture_free(picture);
        vv_object_release(one);
        end(&s);
    }
    unlink(file);
}

static void other_samples_make_another_picture(void **state)
{
    setup s;
    vv_world *world;
    (void)state;
    begin(&s, &ways[0], 1);
    vv_picture *picture = new_picture(&s, false);
    assert_int_equal(vv_picture_save(picture, file, s.job), VV_OK);
    vv_picture_free(picture);
    vv_object_release(s.world);
    vv_field *field = test_field_cube(&test_form_sphere, 24, -1, 1, s.job);
    assert_int_equal(vv_world_for_field(&world, "a", field, s.job), VV_OK);
    vv_field_release(field);
    s.world = &world->base;
    set(&s, "views.main.width", "101");
    set(&s, "views.main.height", "75");
    set(&s, "views.main.render.samples", "1");
    set(&s, "views.main.decorations.scale_bar", "true");
    picture = new_picture(&s, false);
    assert_int_equal(vv_picture_resume(picture, file, s.job), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "data"));
    vv_picture_free(picture);
    end(&s);
    unlink(file);
}

static void a_step_ends_where_it_is_told_to(void **state)
{
    setup s;
    vv_picture_until until;
    (void)state;
    begin(&s, &ways[4], 2);
    vv_picture *picture = new_picture(&s, true);
    vv_picture_until_init(&until, sizeof until);
    until.better = true;
    assert_int_equal(vv_picture_level(picture), -1);
    for (int level = 0; level <= 2; level++) {
        assert_int_equal(vv_picture_step(picture, &until, s.job), VV_OK);
        assert_int_equal(vv_picture_level(picture), level);
    }
    until.better = false;
    until.passes = 3;
    vv_render_report report;
    assert_int_equal(vv_picture_step(picture, &until, s.job), VV_OK);
    vv_picture_report(&report, picture);
    assert_int_equal(report.passes, 3);
    until.passes = 0;
    until.noise = 0.5; /* of a third of which there is none */
    assert_int_equal(vv_picture_step(picture, &until, s.job), VV_OK);
    assert_false(vv_picture_is_whole(picture));
    vv_picture_free(picture);
    end(&s);
    begin(&s, &ways[0], 1);
    picture = new_picture(&s, false);
    assert_int_equal(vv_picture_step(picture, &until, s.job), VV_E_ARGUMENT);
    vv_picture_free(picture);
    end(&s);
}

static void begin_in_parts(setup *s, const manner *way)
{
    begin(s, way, 2);
    set(s, "views.main.decorations.scale_bar", "false");
}

static void check_part(const vv_image *part, const vv_image *whole, int32_t top, const char *name)
{
    const size_t n = (size_t)part->width * (size_t)part->height, at = (size_t)part->width * (size_t)top;
    if (memcmp(part->rgba, whole->rgba + 4 * at, 4 * n * sizeof(float)) != 0 ||
        memcmp(part->depth, whole->depth + at, n * sizeof(float)) != 0 ||
        (part->samples && memcmp(part->samples, whole->samples + at, n * sizeof(uint32_t)) != 0) ||
        (part->normal && memcmp(part->normal, whole->normal + 3 * at, 3 * n * sizeof(float)) != 0))
        fail_msg("%s: other bytes in the part from row %d on", name, top);
}

/* The last one has a few rows only. */
static void parts_of_a_picture_are_the_whole(void **state)
{
    static const int32_t tops[] = {0, 32, 64}, rows[] = {32, 32, HEIGHT - 64};
    static const manner more[] = {
        {"slices", false, {{"render.method", "\"slice\""}}},
        {"solids", false, {{"render.raycast.mode", "\"isosurface\""}, {"render.raycast.iso", "0.5"}}},
        {"jitter", false, {{"render.raycast.jitter", "true"}, {"render.samples", "5"}, {"camera.zoom", "3"}}},
    };
    const manner all[] = {ways[0], ways[3], more[0], more[1], more[2]};
    (void)state;
    for (size_t w = 0; w < sizeof all / sizeof *all; w++) {
        setup s;
        vv_image *whole, *part;
        begin_in_parts(&s, &all[w]);
        assert_int_equal(vv_render(&whole, NULL, (vv_world *)s.world, NULL, NULL, s.job), VV_OK);
        for (size_t i = 0; i < 3; i++) {
            vv_picture *picture;
            assert_int_equal(vvi_picture_new_rows(&picture, (vv_world *)s.world, NULL, tops[i], rows[i], s.job), VV_OK);
            step(picture, 0, s.job);
            assert_int_equal(vvi_picture_take(&part, NULL, picture, s.job), VV_OK);
            assert_int_equal(part->height, rows[i]);
            check_part(part, whole, tops[i], all[w].name);
            vv_image_release(part);
            vv_picture_free(picture);
        }
        vv_image_release(whole);
        end(&s);
    }
}

/* What looks at all of it, and rows that are none. */
static void what_has_no_parts_is_refused(void **state)
{
    static const look looks[] = {{"render.noise", "0.01"},
                                 {"render.budget", "1"},
                                 {"decorations.scale_bar", "true"},
                                 {"render.method", "\"surface\""}};
    (void)state;
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        setup s;
        char path[64];
        begin_in_parts(&s, &ways[0]);
        snprintf(path, sizeof path, "views.main.%s", looks[i].path);
        set(&s, path, looks[i].json);
        assert_int_equal(vv_render_to_file(NULL, "parts.png", (vv_world *)s.world, NULL, NULL, s.job),
                         VV_E_UNSUPPORTED);
        assert_int_not_equal(access("parts.png", F_OK), 0);
        end(&s);
    }
    setup s;
    vv_picture *picture;
    begin_in_parts(&s, &ways[0]);
    assert_int_equal(vvi_picture_new_rows(&picture, (vv_world *)s.world, NULL, 16, 8, s.job), VV_E_ARGUMENT);
    assert_int_equal(vvi_picture_new_rows(&picture, (vv_world *)s.world, NULL, 64, 12, s.job), VV_E_ARGUMENT);
    assert_int_equal(vv_render_to_file(NULL, "parts.jpg", (vv_world *)s.world, NULL, NULL, s.job), VV_E_UNSUPPORTED);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(deadlines_change_no_byte),
        cmocka_unit_test(a_cancelled_step_loses_nothing_that_was_whole),
        cmocka_unit_test(a_picture_resumed_after_every_step_has_the_same_bytes),
        cmocka_unit_test(a_picture_whose_process_was_killed_goes_on_with_the_same_bytes),
        cmocka_unit_test(a_damaged_or_cut_checkpoint_is_refused_and_the_picture_stays),
        cmocka_unit_test(a_checkpoint_is_taken_for_what_its_picture_depends_on_alone),
        cmocka_unit_test(what_is_drawn_over_a_picture_comes_and_goes),
        cmocka_unit_test(other_samples_make_another_picture),
        cmocka_unit_test(a_step_ends_where_it_is_told_to),
        cmocka_unit_test(parts_of_a_picture_are_the_whole),
        cmocka_unit_test(what_has_no_parts_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
