/** @file
 * Simulation methods: each turns raw events into what a virtual device has. A method is a row of a table; nothing else
 * knows it.
 */
#ifndef VVI_INPUT_METHOD_H
#define VVI_INPUT_METHOD_H
#include "input/device.h"

enum { VVI_INPUT_FINGERS = 5 };

/** What is known of the raw devices of one person. */
typedef struct vvi_input_state {
    double pointer[2];
    unsigned modifiers; /**< VVI_WITH_*, VVI_WITH_LETTER() */
    struct vvi_finger {
        char id[VVI_INPUT_NAME]; /**< "" : none */
        double at[2];
    } finger[VVI_INPUT_FINGERS];
} vvi_input_state;

enum { VVI_WITH_SHIFT = 1, VVI_WITH_CONTROL = 2, VVI_WITH_ALT = 4, VVI_WITH_META = 8, VVI_WITH_LETTERS = 0x3ffffff0 };
/** A letter, A to Z, that is held. */
#define VVI_WITH_LETTER(c) (16u << ((c) - 'A'))

/** One binding at work. */
typedef struct vvi_method_call {
    const vvi_input_state *now; /**< after the event */
    const vvi_input_state *was; /**< before it */
    vvi_slot *slot;
    double gain;
} vvi_method_call;

/** When a method is called. */
typedef enum vvi_method_kind {
    VVI_METHOD_DRAG,   /**< while the button or key is held: when the pointer moves */
    VVI_METHOD_CLICK,  /**< when the button comes up where and soon after it went down */
    VVI_METHOD_AXIS,   /**< when the axis moves */
    VVI_METHOD_PRESS,  /**< when the button or key goes down, or a key repeats */
    VVI_METHOD_TOUCHES /**< when fingers move */
} vvi_method_kind;

typedef struct vvi_method {
    const char *name;
    const char *doc; /**< one line */
    vvi_method_kind kind;
    /** The pose that an event leads to; the event's own value where it is an axis. Changes nothing else. */
    vvi_pose (*pose)(const vvi_method_call *call, double value);
    bool asks; /**< it asks for an action, and moves nothing */
} vvi_method;

/** All rows; ends with a name NULL. */
extern const vvi_method *const vvi_methods[];
const vvi_method *vvi_method_find(const char *name);
#endif
