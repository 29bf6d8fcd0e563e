/** @file
 * Volumes whose axes run along the same lines, in another order or direction.
 */
#ifndef CLI_VOLUME_TURN_H
#define CLI_VOLUME_TURN_H
#include <volvis/field.h>
#include <volvis/sys/registry.h>

/** How axes of two grids go together. */
typedef enum cli_axes {
    CLI_AXES_SAME,
    CLI_AXES_TURNED, /**< along the same lines, in another order or direction */
    CLI_AXES_OTHER   /**< each is nearest to another direction of the world, and not along the same lines */
} cli_axes;

/** `to`: what `reorient` calls the order that turns b's axes into a's, as in -x+z+y. */
cli_axes cli_axes_compare(char to[8], const vv_grid *a, const vv_grid *b);
/** The field in that order, in the place of what *field was. */
vv_status cli_volume_turn(vv_field **field, const char *to, const vv_registry *registry, vv_job *job);
#endif
