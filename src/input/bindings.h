/** @file
 * Bindings as text: those that VolVis has by itself, and files that change them.
 *
 * A file is JSON. Its rows are laid over those of VolVis: a row of a name that is there takes its place, null takes it
 * away, and other names are further rows; whatever else was bound to the same button, key or axis is so no more.
 *
 *     {"bindings": {"turn": {"device": "mouse", "when": "left", "method": "arcball"}, "cut": null}}
 */
#ifndef VVI_INPUT_BINDINGS_H
#define VVI_INPUT_BINDINGS_H
#include "core/status.h"
#include <volvis/property.h>
#include <volvis/runtime.h>
#include <volvis/sys/registry.h>

/** A binding as bindings files have it. */
typedef struct vvi_binding {
    vv_object base;
    char *device; /**< "mouse", "keyboard", "touch" */
    char *when;   /**< "left", "Shift+left", "wheel-y", "Control+Z"; NULL: always, of touches */
    char *method; /**< a row of vvi_methods */
    char *action; /**< what the method "action" asks for */
    double gain;
    int64_t slot;
} vvi_binding;

/** All bindings: { "bindings": { "turn": { "device": "mouse", "when": "left", "method": "turntable" } } }. */
typedef struct vvi_bindings {
    vv_object base;
    vv_collection *bindings;
} vvi_bindings;

extern const vv_class vvi_bindings_class, vvi_binding_class;
/** A row that VolVis has by itself; gain 0 stands for 1. The last has no name. */
typedef struct vvi_default_binding {
    const char *name, *device, *when, *method, *action;
    double gain;
} vvi_default_binding;

extern const vvi_default_binding vvi_default_rows[];
/** What the method action may ask for; besides "operation-", "renderer-" and "preset-" with a name. Ends with NULL. */
extern const char *const vvi_action_names[];

/** What is bound where nobody has changed it, as JSON, a row a line. Yours to free(); NULL without memory. */
char *vvi_bindings_default(void);
/** The same with n bytes of a file laid over; `name` stands in errors, what actions name is of the registry.
 * VV_E_FORMAT with the line. */
vv_status vvi_bindings_lay_over(char **out, const char *text, size_t n, const char *name, const vv_registry *registry);
/** The same of a file. VV_E_READ. */
vv_status vvi_bindings_read(char **out, const char *path, vv_job *job);
#endif
