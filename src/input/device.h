/** @file
 * The virtual input device: all that an application sees of input, whatever the hand holds (He & Kaufman 1993).
 */
#ifndef VVI_INPUT_DEVICE_H
#define VVI_INPUT_DEVICE_H
#include "input/event.h"
#include "manipulate/navigate.h"

enum { VVI_INPUT_SLOTS = 4, VVI_INPUT_ACTIONS = 256, VVI_INPUT_ACTION = 64 /* bytes of a name */ };

/** A position and an orientation that methods move: of a camera, or of an object. */
typedef struct vvi_slot {
    vvi_pose pose;
    vv_vec3 up;       /**< of the World, length 1 */
    uint64_t changes; /**< grows with each change of the pose */
} vvi_slot;

/** Something that was asked for by name: at once ("fit", "undo"), or for as long as a drag takes ("window"). */
typedef struct vvi_action {
    char name[VVI_INPUT_ACTION];
    int64_t t;
    double at[2]; /**< where the pointer was */
    bool drags;   /**< a drag: it has a phase, and began at `from` */
    vvi_event_phase phase;
    double from[2];
} vvi_action;

typedef struct vvi_virtual_device {
    vvi_slot slot[VVI_INPUT_SLOTS];
    vvi_action *action; /**< in the order they came; the application takes them all. NULL: there was none yet */
    int n_actions;
} vvi_virtual_device;
#endif
