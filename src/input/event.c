#include "input/event.h"
#include "core/units.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const kinds[] = {"axis", "button", "key", "touch", "lost", NULL};
static const char *const phases[] = {"begin", "move", "end", "cancel", NULL};
static const char *const press[] = {"down", NULL, "up", NULL};

static int find(const char *const *names, int n, const char *name)
{
    for (int i = 0; i < n; i++)
        if (names[i] && strcmp(names[i], name) == 0)
            return i;
    return -1;
}

static bool is_name(const char *s)
{
    const size_t n = strnlen(s, VVI_INPUT_NAME);
    if (n == 0 || n == VVI_INPUT_NAME)
        return false;
    for (size_t i = 0; i < n; i++)
        if (s[i] <= ' ' || s[i] > '~')
            return false;
    return true;
}

static int values_of(vvi_event_kind kind)
{
    return kind == VVI_EVENT_AXIS ? 1 : kind == VVI_EVENT_TOUCH ? 2 : 0;
}

vv_status vvi_event_check(const vvi_input_event *e)
{
    const bool pressed = e->kind == VVI_EVENT_BUTTON || e->kind == VVI_EVENT_KEY;
    if ((unsigned)e->kind > VVI_EVENT_LOST || (unsigned)e->phase > VVI_PHASE_CANCEL ||
        (pressed && e->phase != VVI_PHASE_BEGIN && e->phase != VVI_PHASE_END))
        return vv_fail(VV_E_ARGUMENT, "input: an event of kind %d in phase %d does not exist", (int)e->kind,
                       (int)e->phase);
    if (e->t < 0 || !is_name(e->device) || (e->kind != VVI_EVENT_LOST && !is_name(e->id)))
        return vv_fail(
            VV_E_ARGUMENT,
            "input: an event needs a time of at least 0 and names of 1 to %d ASCII characters without blanks",
            VVI_INPUT_NAME - 1);
    for (int i = 0; i < values_of(e->kind); i++)
        if (!isfinite(e->value[i]))
            return vv_fail(VV_E_ARGUMENT, "input: %s %s has a value that is not a finite number", e->device, e->id);
    return VV_OK;
}

void vvi_event_print(vvi_text *out, const vvi_input_event *e)
{
    vvi_text_printf(out, "%" PRId64 " %s %s", e->t, e->device, kinds[e->kind]);
    if (e->kind != VVI_EVENT_LOST)
        vvi_text_printf(out, " %s", e->id);
    if (e->kind == VVI_EVENT_BUTTON || e->kind == VVI_EVENT_KEY)
        vvi_text_printf(out, " %s", press[e->phase]);
    else if (e->kind == VVI_EVENT_TOUCH)
        vvi_text_printf(out, " %s", phases[e->phase]);
    for (int i = 0; i < values_of(e->kind); i++) {
        char number[32];
        vvi_print_number(number, e->value[i]);
        vvi_text_printf(out, " %s", number);
    }
    vvi_text_add(out, "\n");
}

/* The next word; longer ones, and the end of the line, are none. A blank at the end stays, and is no end. */
static bool next_word(char out[32], const char **at)
{
    const size_t n = strcspn(*at, " ");
    if (n == 0 || n >= 32)
        return false;
    memcpy(out, *at, n);
    out[n] = 0;
    *at += n;
    *at += **at == ' ' && (*at)[1];
    return true;
}

static bool next_name(char out[VVI_INPUT_NAME], const char **at)
{
    char word[32];
    if (!next_word(word, at) || strlen(word) >= VVI_INPUT_NAME)
        return false;
    memcpy(out, word, strlen(word) + 1);
    return true;
}

static bool next_time(int64_t *out, const char **at)
{
    char word[32], *end;
    if (!next_word(word, at) || strspn(word, "0123456789") != strlen(word) || strlen(word) > 18)
        return false;
    *out = (int64_t)strtoll(word, &end, 10);
    return true;
}

static bool next_phase(vvi_input_event *e, const char **at)
{
    const bool pressed = e->kind == VVI_EVENT_BUTTON || e->kind == VVI_EVENT_KEY;
    char word[32];
    if (!pressed && e->kind != VVI_EVENT_TOUCH)
        return true;
    if (!next_word(word, at))
        return false;
    const int found = pressed ? find(press, 3, word) : find(phases, 4, word);
    e->phase = found < 0 ? VVI_PHASE_BEGIN : (vvi_event_phase)found;
    return found >= 0;
}

static bool next_values(vvi_input_event *e, const char **at)
{
    char word[32];
    for (int i = 0; i < values_of(e->kind); i++)
        if (!next_word(word, at) || !vvi_parse_number(&e->value[i], word))
            return false;
    return true;
}

static bool parse(vvi_input_event *e, const char *at)
{
    char kind[32];
    if (!next_time(&e->t, &at) || !next_name(e->device, &at) || !next_word(kind, &at))
        return false;
    const int found = find(kinds, 5, kind);
    if (found < 0)
        return false;
    e->kind = (vvi_event_kind)found;
    return (e->kind == VVI_EVENT_LOST || next_name(e->id, &at)) && next_phase(e, &at) && next_values(e, &at) && !*at;
}

vv_status vvi_event_parse(vvi_input_event *out, const char *line)
{
    char shown[48];
    *out = (vvi_input_event){0};
    if (parse(out, line))
        return vvi_event_check(out);
    snprintf(shown, sizeof shown, "%s", line);
    vvi_text_clean(shown);
    return vv_fail(VV_E_FORMAT, "\"%s\" is not an input event; expected one like: 1250000 mouse button left down",
                   shown);
}
