#include "run/label_look.h"
#include "grid/label_color.h"
#include <stdio.h>

bool vvi_label_look_of_file(vv_mesh_part *part, vv_label_id label, bool is_unsigned, void *user)
{
    const vvi_file_labels *labels = user;
    double rgb[3];
    (void)is_unsigned;
    vvi_label_color(rgb, label);
    part->color = (vv_color){rgb[0], rgb[1], rgb[2], 1};
    for (size_t i = 0; i < labels->n; i++) {
        const vv_label *l = &labels->label[i];
        if (l->value != label)
            continue;
        snprintf(part->name, sizeof part->name, "%s", l->name);
        if (l->has_color)
            part->color = (vv_color){l->color.r, l->color.g, l->color.b, 1};
    }
    return true;
}
