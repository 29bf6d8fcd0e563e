/* What is bound to what. */
#include "core/status.h"
#include "input/bindings_impl.h"
#include "input/input.h"

#include <string.h>

static const char *const devices[] = {"mouse", "keyboard", "touch", NULL};
static const char *const buttons[] = {"left", "middle", "right", NULL};
static const char *const axes[] = {"wheel-y", "wheel-x", NULL};
static const char *const prefixes[] = {"operation-", "renderer-", "preset-", NULL};

static size_t count(const char *const *names)
{
    size_t n = 0;
    while (names[n])
        n++;
    return n;
}

static bool is_one_of(const char *name, const char *const *names)
{
    for (size_t i = 0; names[i]; i++)
        if (strcmp(names[i], name) == 0)
            return true;
    return false;
}

/* "device: there is no device "mose"; the nearest is mouse". `names` ends with NULL. */
static vv_status fail_name(const char *property, const char *name, const char *const *names)
{
    const char *near = name ? vv_nearest_name(name, names, count(names)) : NULL;
    if (!name)
        return vv_fail_at(VV_E_ARGUMENT, NULL, property, "is missing");
    return vv_fail_at(VV_E_ARGUMENT, NULL, property, "there is no %s \"%.40s\"%s%s", property, name,
                      near ? "; the nearest is " : "", near ? near : "");
}

static vv_status check_method(const vvi_binding *b)
{
    const char *names[64];
    size_t n = 0;
    for (; vvi_methods[n] && n < 63; n++)
        names[n] = vvi_methods[n]->name;
    names[n] = NULL;
    return b->method && vvi_method_find(b->method) ? VV_OK : fail_name("method", b->method, names);
}

static vv_status check_action(const vvi_binding *b)
{
    if (!vvi_method_find(b->method)->asks)
        return b->action ? vv_fail_at(VV_E_ARGUMENT, NULL, "action", "the method %s takes no action", b->method)
                         : VV_OK;
    if (!b->action)
        return vv_fail_at(VV_E_ARGUMENT, NULL, "action", "the method %s needs the name of an action", b->method);
    if (strlen(b->action) >= VVI_INPUT_ACTION)
        return vv_fail_at(VV_E_ARGUMENT, NULL, "action", "names have at most %d letters", VVI_INPUT_ACTION - 1);
    for (int i = 0; prefixes[i]; i++)
        if (strncmp(b->action, prefixes[i], strlen(prefixes[i])) == 0)
            return VV_OK;
    return is_one_of(b->action, vvi_action_names) ? VV_OK : fail_name("action", b->action, vvi_action_names);
}

/* What is left of `when` without its modifiers. */
static vv_status check_id(const vvi_binding *b, const char *id, unsigned modifiers)
{
    const vvi_method_kind kind = vvi_method_find(b->method)->kind;
    const char *plus = strchr(id, '+');
    if (!*id || strlen(id) >= VVI_INPUT_NAME)
        return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "names have 1 to %d letters", VVI_INPUT_NAME - 1);
    if (plus && plus != id)
        return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "\"%.*s\" is not Shift, Control, Alt, Meta or a letter",
                          (int)(plus - id), id);
    if (strcmp(b->device, "keyboard") == 0 && (modifiers & VVI_WITH_LETTERS))
        return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "letters can be held only with buttons and wheels");
    if (strcmp(b->device, "keyboard") == 0)
        return kind != VVI_METHOD_AXIS
                   ? vvi_key_check(id)
                   : vv_fail_at(VV_E_ARGUMENT, NULL, "method", "%s is for a wheel, and keyboards have none", b->method);
    if (kind == VVI_METHOD_AXIS)
        return is_one_of(id, axes) ? VV_OK : fail_name("axis", id, axes);
    return is_one_of(id, buttons) ? VV_OK : fail_name("button", id, buttons);
}

/* "Shift+Shift+Q": as many signs as there are modifiers, or one is there twice. */
static bool is_repeated(const char *when, const char *id, unsigned modifiers)
{
    int n = 0;
    for (; when < id; when++)
        n += *when == '+';
    return n != __builtin_popcount(modifiers);
}

static vv_status check_when(const vvi_binding *b)
{
    const bool touches = vvi_method_find(b->method)->kind == VVI_METHOD_TOUCHES;
    unsigned modifiers;
    if (touches != (strcmp(b->device, "touch") == 0))
        return vv_fail_at(VV_E_ARGUMENT, NULL, "method", "%s is%s for touch", b->method, touches ? "" : " not");
    if (touches)
        return b->when ? vv_fail_at(VV_E_ARGUMENT, NULL, "when", "touch has no buttons or keys") : VV_OK;
    if (!b->when)
        return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "is missing: a button, key or axis such as Shift+left");
    const char *id = vvi_take_modifiers(&modifiers, b->when);
    if (is_repeated(b->when, id, modifiers))
        return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "\"%.60s\" has a modifier twice", b->when);
    return check_id(b, id, modifiers);
}

bool vvi_binding_meets(const char *when, const char *method, const char *other_when, const char *other_method)
{
    unsigned with, other_with;
    const char *id = vvi_take_modifiers(&with, when), *other_id = vvi_take_modifiers(&other_with, other_when);
    return with == other_with && strcmp(id, other_id) == 0 &&
           vvi_method_find(method)->kind == vvi_method_find(other_method)->kind;
}

static vv_status check(const vv_object *object, const char *path)
{
    const vvi_binding *b = (const vvi_binding *)(const void *)object;
    (void)path;
    vv_status st = b->device && is_one_of(b->device, devices) ? VV_OK : fail_name("device", b->device, devices);
    if (st == VV_OK)
        st = check_method(b);
    if (st == VV_OK)
        st = check_action(b);
    return st == VV_OK ? check_when(b) : st;
}

static const vv_property binding[] = {
    {VV_PROP(vvi_binding, device), .kind = VV_KIND_STRING, .doc = "mouse, keyboard or touch"},
    {VV_PROP(vvi_binding, when), .kind = VV_KIND_STRING, .doc = "button, key or axis, with modifiers: Shift+left"},
    {VV_PROP(vvi_binding, method), .kind = VV_KIND_STRING, .doc = "what it does"},
    {VV_PROP(vvi_binding, action), .kind = VV_KIND_STRING, .doc = "action that the method action asks for"},
    {VV_PROP(vvi_binding, gain), .kind = VV_KIND_F64, .def = 1, .limited = true, .min = -100, .max = 100,
     .doc = "how strongly; below 0: in the opposite direction"},
    {VV_PROP(vvi_binding, slot), .kind = VV_KIND_I64, .limited = true, .min = 0, .max = VVI_INPUT_SLOTS - 1,
     .doc = "what it moves; 0: the camera"},
    {0},
};

const vv_class vvi_binding_class = {
    .name = "binding",
    .doc = "what a button, key, axis or finger does",
    .size = sizeof(vvi_binding),
    .properties = binding,
    .check = check,
};

static const vv_property bindings[] = {
    {VV_PROP(vvi_bindings, bindings), .kind = VV_KIND_MAP, .cls = &vvi_binding_class, .doc = "by name"},
    {0},
};

const vv_class vvi_bindings_class = {
    .name = "bindings",
    .doc = "what input devices do",
    .size = sizeof(vvi_bindings),
    .properties = bindings,
};
