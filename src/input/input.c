#include "input/input.h"
#include "core/memory.h"
#include "core/status.h"
#include "input/bindings.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A binding, worked out. */
typedef struct bound {
    const vvi_method *method;
    vvi_event_kind kind; /* of the event that it waits for */
    char device[VVI_INPUT_NAME], id[VVI_INPUT_NAME], action[VVI_INPUT_ACTION];
    unsigned modifiers;
    double gain;
    int slot;
    bool held;
    bool armed;     /* of clicks: the button is down */
    double from[2]; /* where the button went down, */
    int64_t since;  /* and when */
} bound;

struct vvi_input {
    vvi_virtual_device device;
    vvi_input_state now;
    bound *bound;
    size_t n;
    unsigned letters; /* that are modifiers of some button or wheel */
};

static const struct {
    const char *name;
    unsigned bit;
} modifiers[] = {
    {"Shift", VVI_WITH_SHIFT}, {"Control", VVI_WITH_CONTROL}, {"Alt", VVI_WITH_ALT}, {"Meta", VVI_WITH_META}};
enum { N_MODIFIERS = sizeof modifiers / sizeof *modifiers };

vvi_input *vvi_input_new(void)
{
    vvi_input *input = vvi_calloc(1, sizeof *input);
    if (!input)
        vv_fail_memory(sizeof *input);
    return input;
}

void vvi_input_free(vvi_input *input)
{
    if (input) {
        free(input->bound);
        free(input->device.action);
    }
    free(input);
}

vvi_virtual_device *vvi_input_device(vvi_input *input)
{
    return &input->device;
}

bool vvi_input_moving(const vvi_input *input)
{
    for (size_t i = 0; i < input->n; i++)
        if (input->bound[i].held)
            return true;
    return *input->now.finger[0].id != 0;
}

/* Bindings -------------------------------------------------------------------------------------------------------- */

const char *vvi_take_modifiers(unsigned *out, const char *when)
{
    bool some = true;
    *out = 0;
    while (some) {
        some = false;
        for (int i = 0; i < N_MODIFIERS; i++) {
            const size_t n = strlen(modifiers[i].name);
            if (strncmp(when, modifiers[i].name, n) == 0 && when[n] == '+' && when[n + 1]) {
                *out |= modifiers[i].bit;
                when += n + 1;
                some = true;
            }
        }
        if (*when >= 'A' && *when <= 'Z' && when[1] == '+' && when[2]) {
            *out |= VVI_WITH_LETTER(*when);
            when += 2;
            some = true;
        }
    }
    return when;
}

static vvi_event_kind kind_of(const bound *b)
{
    if (strcmp(b->device, "touch") == 0)
        return VVI_EVENT_TOUCH;
    if (b->method->kind == VVI_METHOD_AXIS)
        return VVI_EVENT_AXIS;
    return strcmp(b->device, "keyboard") == 0 ? VVI_EVENT_KEY : VVI_EVENT_BUTTON;
}

/* Lengths have been checked. */
static void work_out(bound *out, const vvi_binding *b)
{
    *out = (bound){.method = vvi_method_find(b->method), .gain = b->gain, .slot = (int)b->slot};
    const char *id = b->when ? vvi_take_modifiers(&out->modifiers, b->when) : "";
    snprintf(out->device, sizeof out->device, "%s", b->device);
    snprintf(out->id, sizeof out->id, "%s", id);
    snprintf(out->action, sizeof out->action, "%s", b->action ? b->action : "");
    out->kind = kind_of(out);
}

static vv_status bind(vvi_input *input, const char *json, size_t length)
{
    vv_object *object = NULL;
    vv_status st = vv_object_from_json(&object, &vvi_bindings_class, json, length, NULL);
    if (st != VV_OK)
        return st;
    const vv_collection *all = ((const vvi_bindings *)(const void *)object)->bindings;
    bound *list = vvi_calloc(all->n ? all->n : 1, sizeof *list);
    for (size_t i = 0; i < all->n && list; i++)
        work_out(&list[i], (const vvi_binding *)(const void *)all->entry[i].object);
    if (list) {
        free(input->bound);
        input->bound = list;
        input->n = all->n;
        input->letters = 0;
        for (size_t i = 0; i < all->n; i++)
            input->letters |= list[i].kind == VVI_EVENT_KEY ? 0 : list[i].modifiers & VVI_WITH_LETTERS;
    } else {
        st = vv_fail_memory(all->n * sizeof *list);
    }
    vv_object_release(object);
    return st;
}

vv_status vvi_input_bind(vvi_input *input, const char *json, size_t length)
{
    if (json)
        return bind(input, json, length);
    char *text = vvi_bindings_default();
    const vv_status st = text ? bind(input, text, strlen(text)) : vv_fail_memory(256);
    free(text);
    return st;
}

/* State ----------------------------------------------------------------------------------------------------------- */

static void set_finger(vvi_input_state *s, const vvi_input_event *e)
{
    struct vvi_finger *found = NULL, *open = NULL;
    for (int i = VVI_INPUT_FINGERS - 1; i >= 0; i--) {
        if (strcmp(s->finger[i].id, e->id) == 0)
            found = &s->finger[i];
        if (!*s->finger[i].id)
            open = &s->finger[i];
    }
    if (e->phase == VVI_PHASE_BEGIN && !found && open) {
        found = open;
        memcpy(found->id, e->id, sizeof found->id);
    }
    if (!found) /* more fingers than are looked at */
        return;
    memcpy(found->at, e->value, sizeof found->at);
    if (e->phase == VVI_PHASE_BEGIN || e->phase == VVI_PHASE_MOVE)
        return;
    const size_t after = (size_t)(s->finger + VVI_INPUT_FINGERS - (found + 1));
    memmove(found, found + 1, after * sizeof *found);
    s->finger[VVI_INPUT_FINGERS - 1] = (struct vvi_finger){.id = ""};
}

/* Letters are modifiers only where something is bound with them. */
static void set_modifiers(vvi_input *input, const vvi_input_event *e)
{
    vvi_input_state *s = &input->now;
    unsigned bit = !e->id[1] && e->id[0] >= 'A' && e->id[0] <= 'Z' ? VVI_WITH_LETTER(e->id[0]) : 0;
    for (int i = 0; i < N_MODIFIERS; i++)
        if (strcmp(e->id, modifiers[i].name) == 0)
            bit = modifiers[i].bit;
    bit &= input->letters | ~(unsigned)VVI_WITH_LETTERS;
    s->modifiers = e->phase == VVI_PHASE_BEGIN ? s->modifiers | bit : s->modifiers & ~bit;
}

static void lose(vvi_input *input, const char *device)
{
    if (strcmp(device, "keyboard") == 0)
        input->now.modifiers = 0;
    if (strcmp(device, "touch") == 0)
        memset(input->now.finger, 0, sizeof input->now.finger);
}

static void update_state(vvi_input *input, const vvi_input_event *e)
{
    vvi_input_state *s = &input->now;
    if (e->kind == VVI_EVENT_AXIS && strcmp(e->id, "x") == 0)
        s->pointer[0] = e->value[0];
    if (e->kind == VVI_EVENT_AXIS && strcmp(e->id, "y") == 0)
        s->pointer[1] = e->value[0];
    if (e->kind == VVI_EVENT_KEY)
        set_modifiers(input, e);
    if (e->kind == VVI_EVENT_TOUCH)
        set_finger(s, e);
    if (e->kind == VVI_EVENT_LOST)
        lose(input, e->device);
}

/* Events ---------------------------------------------------------------------------------------------------------- */

/* Of keys such as "+" the Shift that types them is no modifier. */
static bool modifiers_fit(const bound *b, unsigned now)
{
    const char c = b->id[0];
    const bool letter = (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    if (b->kind == VVI_EVENT_KEY) /* it holds itself */
        now &= ~(unsigned)VVI_WITH_LETTERS;
    if (b->kind == VVI_EVENT_KEY && !b->id[1] && !letter)
        now &= ~(unsigned)VVI_WITH_SHIFT, now |= b->modifiers & VVI_WITH_SHIFT;
    return now == b->modifiers;
}

static bool is_for(const bound *b, const vvi_input_event *e)
{
    return b->kind == e->kind && strcmp(b->device, e->device) == 0 && strcmp(b->id, e->id) == 0;
}

static bool is_pointer(const vvi_input_event *e)
{
    return e->kind == VVI_EVENT_AXIS && (strcmp(e->id, "x") == 0 || strcmp(e->id, "y") == 0);
}

static void hold(bound *b, const vvi_input_event *e, unsigned now)
{
    if (e->kind == VVI_EVENT_LOST && strcmp(b->device, e->device) == 0)
        b->held = b->armed = false;
    if (b->method->kind == VVI_METHOD_DRAG && is_for(b, e))
        b->held = e->phase == VVI_PHASE_BEGIN && (b->held || modifiers_fit(b, now));
}

static void note_press(bound *b, const vvi_input_state *now, const vvi_input_event *e)
{
    b->armed = b->method->kind == VVI_METHOD_CLICK && modifiers_fit(b, now->modifiers);
    memcpy(b->from, now->pointer, sizeof b->from);
    b->since = e->t;
}

/* A hand that clicks is not quite still: 4 pixels of a picture that is 600 high. */
static bool is_click(const bound *b, const vvi_input_state *now, const vvi_input_event *e)
{
    const double most = 0.0134;
    const int64_t soon = INT64_C(400) * 1000000;
    return b->armed && is_for(b, e) && e->phase == VVI_PHASE_END && e->t - b->since <= soon &&
           hypot(now->pointer[0] - b->from[0], now->pointer[1] - b->from[1]) <= most;
}

static bool is_due(const bound *b, const vvi_input_event *e, const vvi_input_state *now)
{
    switch (b->method->kind) {
    case VVI_METHOD_DRAG:
        return b->held && is_pointer(e);
    case VVI_METHOD_CLICK:
        return is_click(b, now, e);
    case VVI_METHOD_AXIS:
        return is_for(b, e) && modifiers_fit(b, now->modifiers);
    case VVI_METHOD_PRESS:
        return is_for(b, e) && e->phase == VVI_PHASE_BEGIN && modifiers_fit(b, now->modifiers);
    default:
        return e->kind == VVI_EVENT_TOUCH && e->phase == VVI_PHASE_MOVE && strcmp(b->device, e->device) == 0;
    }
}

static bool is_sound(const vvi_pose *p)
{
    return vvi_finite(p->eye) && vvi_finite(p->pivot) && isfinite(p->turn.w) && isfinite(p->turn.x) &&
           isfinite(p->turn.y) && isfinite(p->turn.z) && isfinite(p->height);
}

static void move(vvi_slot *slot, const vvi_pose *to)
{
    if (!is_sound(to) || vvi_pose_equal(&slot->pose, to))
        return;
    slot->pose = *to;
    slot->changes++;
}

/* Of the moves of a drag that nobody has taken yet the last counts. */
static vvi_action *next_action(vvi_input *input, const bound *b, vvi_event_phase phase)
{
    vvi_virtual_device *d = &input->device;
    vvi_action *last = d->n_actions ? &d->action[d->n_actions - 1] : NULL;
    if (last && last->drags && phase == VVI_PHASE_MOVE && last->phase == phase && strcmp(last->name, b->action) == 0)
        return last;
    return &d->action[d->n_actions++];
}

static void ask(vvi_input *input, const bound *b, int64_t t, vvi_event_phase phase)
{
    vvi_action *a = next_action(input, b, phase);
    *a = (vvi_action){.t = t,
                      .at = {input->now.pointer[0], input->now.pointer[1]},
                      .drags = b->method->kind == VVI_METHOD_DRAG,
                      .phase = phase,
                      .from = {b->from[0], b->from[1]}};
    memcpy(a->name, b->action, sizeof a->name);
}

static void call(vvi_input *input, const bound *b, const vvi_input_event *e, const vvi_input_state *was)
{
    vvi_slot *slot = &input->device.slot[b->slot];
    const vvi_method_call c = {&input->now, was, slot, b->gain};
    const vvi_pose to = b->method->pose(&c, b->method->kind == VVI_METHOD_AXIS ? e->value[0] : 1);
    move(slot, &to);
    if (b->method->asks)
        ask(input, b, e->t, VVI_PHASE_MOVE);
}

/* How many actions an event may ask for, at most. */
static int count_actions(const vvi_input *input, const vvi_input_event *e)
{
    int n = 0;
    for (size_t i = 0; i < input->n; i++)
        n += input->bound[i].method->asks && (is_for(&input->bound[i], e) || input->bound[i].held);
    return n;
}

/* Most devices that look never ask for anything. */
static bool has_room(vvi_virtual_device *d)
{
    if (!d->action)
        d->action = vvi_calloc(VVI_INPUT_ACTIONS, sizeof *d->action);
    return d->action != NULL;
}

static void feed(vvi_input *input, bound *b, const vvi_input_event *e, const vvi_input_state *was)
{
    const bool held = b->held;
    hold(b, e, input->now.modifiers);
    if (is_for(b, e) && e->phase == VVI_PHASE_BEGIN && !held)
        note_press(b, &input->now, e);
    if (b->method->asks && b->held != held)
        ask(input, b, e->t, held ? VVI_PHASE_END : VVI_PHASE_BEGIN);
    if (is_due(b, e, &input->now))
        call(input, b, e, was);
}

vv_status vvi_input_feed(vvi_input *input, const vvi_input_event *event)
{
    const vvi_input_state was = input->now;
    const vv_status st = vvi_event_check(event);
    if (st != VV_OK)
        return st;
    const int asked = count_actions(input, event);
    if (input->device.n_actions + asked > VVI_INPUT_ACTIONS)
        return vv_fail(VV_E_LIMIT, "input: more than %d actions are waiting to be taken", VVI_INPUT_ACTIONS);
    if (asked && !has_room(&input->device))
        return vv_fail_memory(VVI_INPUT_ACTIONS * sizeof(vvi_action));
    update_state(input, event);
    for (size_t i = 0; i < input->n; i++)
        feed(input, &input->bound[i], event, &was);
    return VV_OK;
}
