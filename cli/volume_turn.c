#include "volume_turn.h"
#include "core/vec.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define SAME_LINE 1e-6 /* of 1 - |cosine|: files round directions to 32 bits */

/* 1 along, -1 against, 0 neither. */
static int runs(vv_vec3 a, vv_vec3 b)
{
    const double cosine = vvi_dot(a, b) / (vvi_length(a) * vvi_length(b));
    return fabs(cosine) < 1 - SAME_LINE ? 0 : cosine > 0 ? 1 : -1;
}

static bool find_order(char to[8], const vv_grid *a, const vv_grid *b)
{
    for (int i = 0; i < 3; i++) {
        int sign = 0, from = -1;
        while (!sign && ++from < 3)
            sign = runs(a->index_to_world.axis[i], b->index_to_world.axis[from]);
        if (!sign)
            return false;
        to[2 * i] = sign > 0 ? '+' : '-';
        to[2 * i + 1] = "xyz"[from];
    }
    to[6] = 0;
    return true;
}

cli_axes cli_axes_compare(char to[8], const vv_grid *a, const vv_grid *b)
{
    char letters_a[16], letters_b[16];
    strcpy(to, "+x+y+z");
    if (a->space != b->space)
        return CLI_AXES_SAME; /* nobody knows which goes with which */
    if (find_order(to, a, b))
        return strcmp(to, "+x+y+z") == 0 ? CLI_AXES_SAME : CLI_AXES_TURNED;
    strcpy(to, "+x+y+z");
    vv_grid_orientation(letters_a, a);
    vv_grid_orientation(letters_b, b);
    return strcmp(letters_a, letters_b) == 0 ? CLI_AXES_SAME : CLI_AXES_OTHER;
}

vv_status cli_volume_turn(vv_field **field, const char *to, const vv_registry *registry, vv_job *job)
{
    const vv_operation *reorient = vv_registry_operation(registry, "reorient");
    const vv_field *const inputs[] = {*field};
    vv_object *params = NULL;
    vv_field *turned = NULL;
    char json[32];
    const int n = snprintf(json, sizeof json, "{\"order\": \"%s\"}", to);
    vv_status st = vv_object_from_json(&params, reorient->params, json, (size_t)n, NULL);
    if (st == VV_OK)
        st = vv_operation_run(&turned, reorient, inputs, 1, params, job);
    vv_object_release(params);
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = turned;
    return VV_OK;
}
