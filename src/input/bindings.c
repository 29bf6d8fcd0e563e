/* What is bound to what. */
#include "core/status.h"
#include "input/input.h"

#include <string.h>

static const char *const devices[] = {"mouse", "keyboard", "touch", NULL};

static vv_status check(const vv_object *object, const char *path)
{
    const vvi_binding *b = (const vvi_binding *)(const void *)object;
    const char *names[64];
    size_t n = 0;
    bool known = false;
    for (int i = 0; devices[i]; i++)
        known |= b->device && strcmp(devices[i], b->device) == 0;
    if (!known)
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "device is mouse, keyboard or touch");
    for (; vvi_methods[n] && n < 64; n++)
        names[n] = vvi_methods[n]->name;
    if (!b->method || !vvi_method_find(b->method)) {
        const char *near = b->method ? vv_nearest_name(b->method, names, n) : NULL;
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "there is no method \"%s\"%s%s", b->method ? b->method : "",
                          near ? "; the nearest is " : "", near ? near : "");
    }
    if (strcmp(b->method, "action") == 0 && (!b->action || !*b->action || strlen(b->action) >= VVI_INPUT_NAME))
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "the method action needs an action: its name");
    if (!b->when && vvi_method_find(b->method)->kind != VVI_METHOD_TOUCHES)
        return vv_fail_at(VV_E_ARGUMENT, NULL, path, "when is missing: a button, key or axis such as Shift+left");
    return VV_OK;
}

static const vv_property binding[] = {
    {VV_PROP(vvi_binding, device), .kind = VV_KIND_STRING, .doc = "mouse, keyboard or touch"},
    {VV_PROP(vvi_binding, when), .kind = VV_KIND_STRING, .doc = "button, key or axis, with modifiers: Shift+left"},
    {VV_PROP(vvi_binding, method), .kind = VV_KIND_STRING, .doc = "what it does"},
    {VV_PROP(vvi_binding, action), .kind = VV_KIND_STRING, .doc = "what the method action asks for"},
    {VV_PROP(vvi_binding, gain), .kind = VV_KIND_F64, .def = 1, .limited = true, .min = -100, .max = 100,
     .doc = "how strongly; below 0: the other way"},
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

#define MOUSE(name, when, method)                                                                                      \
    "\"" name "\": {\"device\": \"mouse\", \"when\": \"" when "\", \"method\": \"" method "\"},"
#define STEP(name, when, method, gain)                                                                                 \
    "\"" name "\": {\"device\": \"keyboard\", \"when\": \"" when "\", \"method\": \"" method "\", \"gain\": " gain "}" \
    ","
#define ACTION(name, when, action)                                                                                     \
    "\"" name "\": {\"device\": \"keyboard\", \"when\": \"" when "\", \"method\": \"action\", \"action\": \"" action   \
    "\"},"

const char vvi_default_bindings[] = "{\"bindings\": {" MOUSE("turn", "left", "turntable") MOUSE("pan", "middle", "pan")
    MOUSE("pan-shift", "Shift+left", "pan") MOUSE("zoom", "right", "zoom") MOUSE("roll", "Control+left", "roll") MOUSE(
        "wheel", "wheel-y", "wheel-zoom") STEP("left", "ArrowLeft", "step-azimuth", "-1")
        STEP("right", "ArrowRight", "step-azimuth", "1") STEP("up", "ArrowUp", "step-elevation", "1") STEP(
            "down", "ArrowDown", "step-elevation", "-1") STEP("left-fine", "Shift+ArrowLeft", "step-azimuth", "-0.2")
            STEP("right-fine", "Shift+ArrowRight", "step-azimuth", "0.2") STEP(
                "up-fine", "Shift+ArrowUp", "step-elevation", "0.2") STEP("down-fine",
                                                                          "Shift+ArrowDown", "step-elevation", "-0.2")
                STEP("pan-left", "Control+ArrowLeft", "step-right",
                     "-1") STEP("pan-right", "Control+ArrowRight", "step-right",
                                "1") STEP("pan-up", "Control+ArrowUp", "step-up", "1")
                    STEP("pan-down", "Control+ArrowDown", "step-up", "-1") STEP("nearer", "+", "step-nearer", "1")
                        STEP("nearer-plain", "=", "step-nearer", "1") STEP("farther", "-", "step-nearer", "-1") ACTION(
                            "fit", "R", "fit") ACTION("fit-home", "Home", "fit")
                            ACTION("front", "Digit1", "front") ACTION("right-side", "Digit3", "right")
                                ACTION("top", "Digit7", "top") ACTION("back", "Shift+Digit1", "back") ACTION(
                                    "left-side", "Shift+Digit3", "left") ACTION("bottom", "Shift+Digit7", "bottom")
                                    ACTION("projection", "Digit5", "projection")
                                        ACTION("isometric", "Digit9", "isometric") ACTION("undo", "Control+Z", "undo")
                                            ACTION("redo", "Control+Shift+Z", "redo") ACTION(
                                                "redo-y", "Control+Y",
                                                "redo") "\"touch\": {\"device\": \"touch\", \"method\": \"touch\"}"
                                                        "}}";
