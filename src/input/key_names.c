/* Keys as pages name them: what they type, else the names that the standard of browsers' events gives them. */
#include "input/bindings_impl.h"

#include <ctype.h>
#include <stdlib.h>
#include <string.h>

/* clang-format off */
static const char *const names[] = {
    "ArrowDown", "ArrowLeft", "ArrowRight", "ArrowUp", "End", "Home", "PageDown", "PageUp", "Backspace", "Clear", "Copy",
    "Cut", "Delete", "Insert", "Paste", "Redo", "Undo", "Enter", "Escape", "Space", "Tab", "Again", "Cancel",
    "ContextMenu", "Execute", "Find", "Help", "Pause", "Play", "Props", "Select", "ZoomIn", "ZoomOut", "PrintScreen",
    "Alt", "AltGraph", "CapsLock", "Control", "Fn", "Meta", "NumLock", "ScrollLock", "Shift", "Accept", "Convert",
    "ModeChange", "NonConvert", "MediaPlayPause", "MediaStop", "MediaTrackNext", "MediaTrackPrevious",
    "AudioVolumeDown", "AudioVolumeMute", "AudioVolumeUp", "BrowserBack", "BrowserFavorites", "BrowserForward",
    "BrowserHome", "BrowserRefresh", "BrowserSearch", "BrowserStop",
    "Digit0", "Digit1", "Digit2", "Digit3", "Digit4", "Digit5", "Digit6", "Digit7", "Digit8", "Digit9",
    "F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8", "F9", "F10", "F11", "F12", "F13", "F14", "F15", "F16", "F17", "F18",
    "F19", "F20", "F21", "F22", "F23", "F24",
};
/* clang-format on */

/* Of UTF-8, which JSON is. */
static bool is_one_character(const char *id)
{
    size_t n = 0;
    for (; *id; id++)
        n += ((unsigned char)*id & 0xc0) != 0x80;
    return n == 1;
}

vv_status vvi_key_check(const char *id)
{
    enum { COUNT = sizeof names / sizeof *names };
    for (size_t i = 0; i < COUNT; i++)
        if (strcmp(names[i], id) == 0)
            return VV_OK;
    if (is_one_character(id)) {
        if (*id >= 'a' && *id <= 'z')
            return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "letters are written as capitals: \"%c\", not \"%c\"",
                              toupper(*id), *id);
        if (*id >= '0' && *id <= '9')
            return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "digits are written as their key: \"Digit%c\", not \"%c\"",
                              *id, *id);
        return *id == ' ' ? vv_fail_at(VV_E_ARGUMENT, NULL, "when", "this key is written \"Space\"") : VV_OK;
    }
    const char *near = vv_nearest_name(id, names, COUNT);
    return vv_fail_at(VV_E_ARGUMENT, NULL, "when", "there is no key \"%.40s\"%s%s", id, near ? "; the nearest is " : "",
                      near ? near : "");
}
