/* Raw events to a virtual device: bindings, methods, recordings. */
#include "fields.h"
#include "input/input.h"
#include "input/record.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const vv_vec3 up_z = {0, 0, 1};

static vvi_pose start(void)
{
    return (vvi_pose){.eye = {0, -10, 0},
                      .turn = vvi_turn_of_axes(vvi_vec(1, 0, 0), up_z, vvi_vec(0, -1, 0)),
                      .fov = 0.6,
                      .height = 5};
}

static vvi_input *new_input(const char *bindings)
{
    vvi_input *input = vvi_input_new();
    assert_non_null(input);
    assert_int_equal(vvi_input_bind(input, bindings, bindings ? strlen(bindings) : 0), VV_OK);
    for (int s = 0; s < VVI_INPUT_SLOTS; s++) {
        vvi_input_device(input)->slot[s].pose = start();
        vvi_input_device(input)->slot[s].up = up_z;
    }
    return input;
}

static vv_status feed_one(void *user, const vvi_input_event *event)
{
    return vvi_input_feed(user, event);
}

/* Lines of a recording without its first. */
static void feed(vvi_input *input, const char *lines)
{
    vvi_text text = {0};
    vvi_record_begin(&text);
    vvi_text_add(&text, lines);
    const vv_status st = vvi_replay(text.s, text.n, feed_one, input);
    if (st != VV_OK)
        fail_msg("%s", vv_error_last()->message);
    vvi_text_free(&text);
}

static const vvi_pose *pose(vvi_input *input)
{
    return &vvi_input_device(input)->slot[0].pose;
}

static void assert_near(double found, double expected)
{
    if (!(fabs(found - expected) <= 1e-12))
        fail_msg("%.17g is not %.17g", found, expected);
}

static void assert_vec(vv_vec3 found, double x, double y, double z)
{
    assert_near(found.x, x);
    assert_near(found.y, y);
    assert_near(found.z, z);
}

static void assert_same_pose(const vvi_pose *a, const vvi_pose *b)
{
    assert_vec(a->eye, b->eye.x, b->eye.y, b->eye.z);
    assert_vec(a->pivot, b->pivot.x, b->pivot.y, b->pivot.z);
    assert_near(fabs(vvi_turn_dot(a->turn, b->turn)), 1);
}

/* Events ---------------------------------------------------------------------------------------------------------- */

static void events_read_back_as_they_were(void **state)
{
    (void)state;
    static const vvi_input_event events[] = {
        {0, "mouse", "x", VVI_EVENT_AXIS, VVI_PHASE_BEGIN, {-0.1, 0}},
        {999999999999999999, "pad", "wheel-y", VVI_EVENT_AXIS, VVI_PHASE_BEGIN, {1e-300, 0}},
        {1, "mouse", "left", VVI_EVENT_BUTTON, VVI_PHASE_END, {0, 0}},
        {1, "keyboard", "+", VVI_EVENT_KEY, VVI_PHASE_BEGIN, {0, 0}},
        {1, "touch", "12345678901234567890123", VVI_EVENT_TOUCH, VVI_PHASE_CANCEL, {1. / 3, -2}},
        {7, "mouse", "", VVI_EVENT_LOST, VVI_PHASE_BEGIN, {0, 0}},
    };
    for (size_t i = 0; i < sizeof events / sizeof *events; i++) {
        vvi_text text = {0};
        vvi_input_event back;
        assert_int_equal(vvi_event_check(&events[i]), VV_OK);
        vvi_event_print(&text, &events[i]);
        assert_int_equal(text.s[text.n - 1], '\n');
        text.s[text.n - 1] = 0;
        assert_int_equal(vvi_event_parse(&back, text.s), VV_OK);
        assert_memory_equal(&back, &events[i], sizeof back);
        vvi_text_free(&text);
    }
}

static void what_is_no_event_is_refused(void **state)
{
    (void)state;
    static const char *const lines[] = {"",
                                        " ",
                                        "1",
                                        "1 mouse",
                                        "1 mouse axis",
                                        "1 mouse axis x",
                                        "1 mouse axis x 1 2",
                                        "1 mouse axis x nan",
                                        "1 mouse axis x 1e999",
                                        "-1 mouse axis x 1",
                                        "1 mouse button left begin",
                                        "1 mouse button left down ",
                                        "1 touch touch 3 down 0 0",
                                        "1 touch touch 3 move 0",
                                        "1  mouse lost",
                                        "1 mouse lost x",
                                        "1234567890123456789 mouse lost",
                                        "1.5 mouse lost",
                                        "1 123456789012345678901234 lost",
                                        "1 m\x01use lost",
                                        "1 mouse frown x 1"};
    for (size_t i = 0; i < sizeof lines / sizeof *lines; i++) {
        vvi_input_event e;
        if (vvi_event_parse(&e, lines[i]) == VV_OK)
            fail_msg("\"%s\" was taken", lines[i]);
    }
}

/* Bindings and methods -------------------------------------------------------------------------------------------- */

static void a_drag_with_the_left_button_turns(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    feed(input, "1 mouse axis x -0.25\n2 mouse axis y 0.5\n"); /* nothing is held */
    assert_int_equal(vvi_input_device(input)->slot[0].changes, 0);
    feed(input, "3 mouse button left down\n4 mouse axis x 0.25\n");
    assert_true(vvi_input_moving(input));
    assert_vec(pose(input)->eye, -10, 0, 0); /* a quarter of the smaller side: a quarter turn */
    feed(input, "5 mouse button left up\n6 mouse axis x 1\n");
    assert_vec(pose(input)->eye, -10, 0, 0);
    assert_false(vvi_input_moving(input));
    assert_int_equal(vvi_input_device(input)->slot[0].changes, 1);
    vvi_input_free(input);
}

static void modifiers_choose_and_a_drag_keeps_its_method(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    const double extent = 20 * tan(0.3);
    feed(input, "1 keyboard key Shift down\n2 mouse button left down\n3 keyboard key Shift up\n4 mouse axis x 1\n");
    assert_vec(pose(input)->pivot, -extent / 2, 0, 0); /* half the smaller side */
    feed(input, "5 mouse lost\n6 mouse axis x 0\n");
    assert_vec(pose(input)->pivot, -extent / 2, 0, 0);
    vvi_input_free(input);
}

static void a_wheel_keeps_what_is_under_the_pointer(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    feed(input, "1 mouse axis x 0.5\n2 mouse axis wheel-y 4\n");
    const vvi_pose from = start();
    const vvi_pose to = vvi_zoom(&from, 0.25, (const double[]){0.5, 0});
    assert_same_pose(pose(input), &to);
    vvi_input_free(input);
}

static void keys_step_and_ask(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    vvi_virtual_device *d = vvi_input_device(input);
    feed(input, "1 keyboard key ArrowRight down\n2 keyboard key ArrowRight up\n");
    const vvi_pose from = start();
    const vvi_pose to = vvi_orbit(&from, 5 / 360., 0, up_z);
    assert_same_pose(pose(input), &to);
    feed(input, "3 keyboard key Control down\n4 keyboard key Z down\n5 keyboard key Shift down\n6 keyboard key Z down\n"
                "7 keyboard lost\n8 mouse axis x 0.5\n9 keyboard key R down\n");
    assert_int_equal(d->n_actions, 3);
    assert_string_equal(d->action[0].name, "undo");
    assert_string_equal(d->action[1].name, "redo");
    assert_string_equal(d->action[2].name, "fit");
    assert_near(d->action[2].at[0], 0.5);
    assert_int_equal(d->action[2].t, 9);
    feed(input, "10 keyboard key Shift down\n11 keyboard key + down\n"); /* typed with Shift */
    assert_near(vvi_pose_distance(pose(input)), 10 * exp(-0.1));
    vvi_input_free(input);
}

/* One finger as the mouse; two: what was under them stays under them. */
static void fingers_hold_what_they_touch(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    feed(input, "1 touch touch 1 begin 0 0\n2 touch touch 1 move 0.5 0\n");
    assert_vec(pose(input)->eye, -10, 0, 0);
    vvi_input_device(input)->slot[0].pose = start();
    feed(input, "3 touch touch 2 begin -0.2 0.1\n");
    const double a[2] = {0.5, 0}, b[2] = {-0.2, 0.1}, c[2] = {0.1, 0.7}, d[2] = {-0.6, -0.3};
    const double half = 10 * tan(0.3);
    const vv_vec3 first = {a[0] * half, 0, a[1] * half}, second = {b[0] * half, 0, b[1] * half};
    feed(input, "4 touch touch 1 move 0.1 0.7\n5 touch touch 2 move -0.6 -0.3\n");
    const vv_vec3 points[2] = {first, second};
    const double *const places[2] = {c, d};
    for (int i = 0; i < 2; i++) {
        const vv_vec3 way = vvi_sub(points[i], pose(input)->eye);
        const double depth = vvi_dot(way, vvi_pose_forward(pose(input))) * tan(0.3);
        assert_near(vvi_dot(way, vvi_pose_right(pose(input))) / depth, places[i][0]);
        assert_near(vvi_dot(way, vvi_pose_up(pose(input))) / depth, places[i][1]);
    }
    feed(input, "6 touch touch 2 end 0 0\n7 touch touch 1 cancel 0 0\n");
    assert_false(vvi_input_moving(input));
    vvi_input_free(input);
}

/* The application, which knows slots and actions alone, is led to one pose by mouse, by keys and by a script. */
static void another_device_leads_to_the_same_pose(void **state)
{
    (void)state;
    static const char arcball[] = "{\"bindings\": {\"turn\": {\"device\": \"mouse\", \"when\": \"right\", "
                                  "\"method\": \"arcball\", \"slot\": 2}}}";
    static const char keys[] = "{\"bindings\": {\"a\": {\"device\": \"keyboard\", \"when\": \"Q\", \"method\": "
                               "\"step-azimuth\", \"gain\": 9, \"slot\": 2}}}";
    vvi_input *mouse = new_input(arcball), *board = new_input(keys);
    const double r = sin(M_PI / 8); /* from the middle: 22.5 degrees on the ball, 45 of the camera */
    char line[160];
    snprintf(line, sizeof line, "1 mouse axis x 0\n2 mouse button right down\n3 mouse axis x %.17g\n", r);
    feed(mouse, line);
    feed(board, "1 keyboard key Q down\n");
    assert_same_pose(&vvi_input_device(mouse)->slot[2].pose, &vvi_input_device(board)->slot[2].pose);
    const vvi_pose unmoved = start();
    assert_same_pose(pose(mouse), &unmoved);
    vvi_input_free(mouse);
    vvi_input_free(board);
}

static void bad_bindings_are_refused_and_change_nothing(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    static const char *const bad[] = {
        "{",
        "{\"bindings\": 3}",
        "{\"bindings\": {\"a\": {}}}",
        "{\"bindings\": {\"a\": {\"device\": \"glove\", \"when\": \"x\", \"method\": \"pan\"}}}",
        "{\"bindings\": {\"a\": {\"device\": \"mouse\", \"when\": \"left\", \"method\": \"turntabel\"}}}",
        "{\"bindings\": {\"a\": {\"device\": \"mouse\", \"method\": \"pan\"}}}",
        "{\"bindings\": {\"a\": {\"device\": \"mouse\", \"when\": \"left\", \"method\": \"action\"}}}",
        "{\"bindings\": {\"a\": {\"device\": \"mouse\", \"when\": \"left\", \"method\": \"pan\", \"slot\": 9}}}",
        "{\"bindings\": {\"a\": {\"device\": \"mouse\", \"when\": \"123456789012345678901234\", \"method\": \"pan\"}}}",
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        if (vvi_input_bind(input, bad[i], strlen(bad[i])) == VV_OK)
            fail_msg("%s was taken", bad[i]);
    assert_int_equal(vvi_input_bind(input, bad[4], strlen(bad[4])), VV_E_ARGUMENT);
    assert_non_null(strstr(vv_error_last()->message, "turntable"));
    feed(input, "1 mouse button left down\n2 mouse axis x 0.5\n");
    assert_vec(pose(input)->eye, -10, 0, 0);
    vvi_input_free(input);
}

static void a_click_is_asked_for_where_the_button_did_not_move(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    vvi_virtual_device *d = vvi_input_device(input);
    feed(input, "0 mouse axis x 0.5\n1 mouse button middle down\n2 mouse axis x 0.505\n9 mouse button middle up\n");
    assert_int_equal(d->n_actions, 1);
    assert_string_equal(d->action[0].name, "center");
    assert_false(d->action[0].drags);
    assert_near(d->action[0].at[0], 0.505);
    feed(input,
         "10 mouse button middle down\n11 mouse axis x 0.6\n12 mouse button middle up\n" /* a drag */
         "20 mouse button middle down\n500000021 mouse button middle up\n"               /* late */
         "500000022 mouse button middle down\n500000023 mouse lost\n500000024 mouse button middle up\n"
         "500000030 keyboard key Shift down\n500000031 mouse button middle down\n500000032 mouse button middle up\n");
    assert_int_equal(d->n_actions, 1);
    vvi_input_free(input);
}

static void a_drag_with_a_letter_held_asks_and_turns_nothing(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    vvi_virtual_device *d = vvi_input_device(input);
    feed(input,
         "1 keyboard key W down\n2 mouse axis x 0.25\n3 mouse button left down\n"
         "4 mouse axis x 0.5\n5 mouse axis y -0.5\n6 keyboard key W up\n7 mouse axis x 0.75\n8 mouse button left up\n");
    assert_int_equal(d->n_actions, 3); /* of moves that wait the last counts */
    assert_int_equal(d->slot[0].changes, 0);
    static const vvi_event_phase phases[] = {VVI_PHASE_BEGIN, VVI_PHASE_MOVE, VVI_PHASE_END};
    for (int i = 0; i < 3; i++) {
        assert_string_equal(d->action[i].name, "window");
        assert_true(d->action[i].drags);
        assert_int_equal(d->action[i].phase, phases[i]);
        assert_near(d->action[i].from[0], 0.25);
    }
    assert_near(d->action[1].at[0], 0.75);
    d->n_actions = 0;
    feed(input, "9 keyboard key Q down\n10 mouse button left down\n11 mouse axis x 1\n12 mouse button left up\n");
    assert_int_equal(d->n_actions, 0); /* Q is bound with nothing */
    assert_int_equal(d->slot[0].changes, 1);
    feed(input, "13 keyboard key W down\n14 mouse button left down\n15 mouse lost\n");
    assert_int_equal(d->n_actions, 2);
    assert_int_equal(d->action[1].phase, VVI_PHASE_END);
    assert_false(vvi_input_moving(input));
    vvi_input_free(input);
}

static void actions_that_nobody_takes_are_refused_not_lost(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    const vvi_input_event press = {1, "keyboard", "R", VVI_EVENT_KEY, VVI_PHASE_BEGIN, {0, 0}};
    for (int i = 0; i < VVI_INPUT_ACTIONS; i++)
        assert_int_equal(vvi_input_feed(input, &press), VV_OK);
    assert_int_equal(vvi_input_feed(input, &press), VV_E_LIMIT);
    vvi_input_device(input)->n_actions = 0;
    assert_int_equal(vvi_input_feed(input, &press), VV_OK);
    vvi_input_free(input);
}

/* Recordings ------------------------------------------------------------------------------------------------------ */

static void any_events(vvi_text *out, uint64_t seed, int n)
{
    static const char *const buttons[] = {"left", "middle", "right"};
    static const char *const keys[] = {"Shift", "Control", "ArrowUp", "R", "Z", "Digit1", "+"};
    vvi_record_begin(out);
    for (uint64_t i = 0; i < (uint64_t)n; i++) {
        const uint64_t r = test_random(seed, i);
        const double v = (double)(r >> 20 & 0xffff) / 32768 - 1;
        switch (r % 6) {
        case 0:
            vvi_text_printf(out, "%d mouse button %s %s\n", (int)i, buttons[r / 7 % 3], r >> 60 & 1 ? "up" : "down");
            break;
        case 1:
            vvi_text_printf(out, "%d keyboard key %s %s\n", (int)i, keys[r / 7 % 7], r >> 60 & 1 ? "up" : "down");
            break;
        case 2:
            vvi_text_printf(out, "%d touch touch %d %s %.9g %.9g\n", (int)i, (int)(r / 7 % 7),
                            ((const char *[]){"begin", "move", "end", "cancel"})[r >> 60 & 3], v, -v / 2);
            break;
        case 3:
            vvi_text_printf(out, "%d mouse axis wheel-y %.9g\n", (int)i, v);
            break;
        default:
            vvi_text_printf(out, "%d mouse axis %s %.9g\n", (int)i, r >> 60 & 1 ? "x" : "y", v);
        }
    }
}

typedef struct recorder {
    vvi_input *input;
    vvi_text text, actions;
} recorder;

static vv_status record(void *user, const vvi_input_event *event)
{
    recorder *r = user;
    vvi_event_print(&r->text, event);
    const vv_status st = vvi_input_feed(r->input, event);
    vvi_virtual_device *d = vvi_input_device(r->input);
    for (int i = 0; i < d->n_actions; i++)
        vvi_text_printf(&r->actions, "%lld %s %a %a\n", (long long)d->action[i].t, d->action[i].name,
                        d->action[i].at[0], d->action[i].at[1]);
    d->n_actions = 0;
    return st;
}

static void a_recording_leads_to_the_same_bytes_again(void **state)
{
    (void)state;
    vvi_text text = {0};
    any_events(&text, 3, 20000);
    recorder one = {.input = new_input(NULL)}, two = {.input = new_input(NULL)};
    vvi_record_begin(&one.text);
    vvi_record_begin(&two.text);
    assert_int_equal(vvi_replay(text.s, text.n, record, &one), VV_OK);
    assert_int_equal(vvi_replay(one.text.s, one.text.n, record, &two), VV_OK);
    assert_true(one.actions.n > 1000);
    assert_string_equal(one.actions.s, two.actions.s);
    assert_string_equal(one.text.s, two.text.s);
    assert_true(vvi_pose_equal(pose(one.input), pose(two.input)));
    assert_true(vvi_input_device(one.input)->slot[0].changes > 1000);
    recorder *const both[] = {&one, &two};
    for (int i = 0; i < 2; i++) {
        vvi_text_free(&both[i]->text);
        vvi_text_free(&both[i]->actions);
        vvi_input_free(both[i]->input);
    }
    vvi_text_free(&text);
}

static void damaged_recordings_end_with_a_sentence_and_the_line(void **state)
{
    (void)state;
    vvi_input *input = new_input(NULL);
    static const char *const bad[] = {"", "volvis input 2\n", "volvis input 1\n2 mouse lost\n1 mouse lost\n",
                                      "volvis input 1\n# a remark\n\n1 mouse axis q\n"};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++)
        assert_int_equal(vvi_replay(bad[i], strlen(bad[i]), feed_one, input), VV_E_FORMAT);
    assert_non_null(strstr(vv_error_last()->message, "line 4"));
    vvi_text text = {0};
    any_events(&text, 9, 400);
    for (uint64_t i = 0; i < 20000; i++) { /* one byte changed: no crash, and what is taken is sound */
        const size_t at = test_random(10, i) % text.n;
        const char was = text.s[at];
        text.s[at] = (char)(test_random(11, i) & 127);
        (void)vvi_replay(text.s, text.n, feed_one, input);
        vvi_input_device(input)->n_actions = 0;
        text.s[at] = was;
    }
    assert_true(vvi_finite(pose(input)->eye));
    vvi_text_free(&text);
    vvi_input_free(input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(events_read_back_as_they_were),
        cmocka_unit_test(what_is_no_event_is_refused),
        cmocka_unit_test(a_drag_with_the_left_button_turns),
        cmocka_unit_test(modifiers_choose_and_a_drag_keeps_its_method),
        cmocka_unit_test(a_wheel_keeps_what_is_under_the_pointer),
        cmocka_unit_test(keys_step_and_ask),
        cmocka_unit_test(fingers_hold_what_they_touch),
        cmocka_unit_test(another_device_leads_to_the_same_pose),
        cmocka_unit_test(bad_bindings_are_refused_and_change_nothing),
        cmocka_unit_test(a_click_is_asked_for_where_the_button_did_not_move),
        cmocka_unit_test(a_drag_with_a_letter_held_asks_and_turns_nothing),
        cmocka_unit_test(actions_that_nobody_takes_are_refused_not_lost),
        cmocka_unit_test(a_recording_leads_to_the_same_bytes_again),
        cmocka_unit_test(damaged_recordings_end_with_a_sentence_and_the_line),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
