/** @file
 * Raw events of input devices, as readers send them and recordings keep them: plain data, no pointers.
 *
 * As text an event is one line: nanoseconds, device, kind, id, then values:
 *
 *     1250000 mouse axis x -0.25
 *     1250000 mouse button left down
 *     2000000 keyboard key ArrowLeft up
 *     2100000 touch touch 3 move 0.5 -0.125
 *     2200000 mouse lost
 *
 * Places are in the viewport's frame of <manipulate/navigate.h>: from the middle, in half of the smaller side, x right
 * and y up, so that a recording does not depend on the size of a window.
 */
#ifndef VVI_INPUT_EVENT_H
#define VVI_INPUT_EVENT_H
#include "core/status.h"
#include "core/text.h"

enum { VVI_INPUT_NAME = 24 /* bytes of a name, with its end */ };

typedef enum vvi_event_kind {
    VVI_EVENT_AXIS,   /**< value: mouse "x", "y" (a place), "wheel-x", "wheel-y" (notches since the last) */
    VVI_EVENT_BUTTON, /**< phase BEGIN or END: "left", "middle", "right" */
    VVI_EVENT_KEY,    /**< the same: letters as "A", others as browsers name them: "ArrowLeft", "Shift", "Digit1" */
    VVI_EVENT_TOUCH,  /**< id: number of the finger; phase, place */
    VVI_EVENT_LOST    /**< the device is gone, or its window no longer has it: nothing is held any more */
} vvi_event_kind;

typedef enum vvi_event_phase { VVI_PHASE_BEGIN, VVI_PHASE_MOVE, VVI_PHASE_END, VVI_PHASE_CANCEL } vvi_event_phase;

typedef struct vvi_input_event {
    int64_t t; /**< nanoseconds of a clock that does not run back */
    char device[VVI_INPUT_NAME], id[VVI_INPUT_NAME];
    vvi_event_kind kind;
    vvi_event_phase phase;
    double value[2];
} vvi_input_event;

/** VV_E_ARGUMENT, with a sentence: names that are empty, too long or have blanks, values that are not finite. */
vv_status vvi_event_check(const vvi_input_event *event);
/** Appends the line, with its end; numbers read back equal. The event has been checked. */
void vvi_event_print(vvi_text *out, const vvi_input_event *event);
/** A line without its end. VV_E_FORMAT with what is expected. */
vv_status vvi_event_parse(vvi_input_event *out, const char *line);
#endif
