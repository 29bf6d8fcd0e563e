/* --aov: the layers that a picture holds beside its colours. */
#include "core/names.h"
#include "edits.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <volvis/image.h>

unsigned cli_layers_of(const vv_view *view)
{
    const vv_render_choice *choice = (const vv_render_choice *)(const void *)view->render;
    const vv_layer_choice *layers = (const vv_layer_choice *)(const void *)choice->layers;
    const bool on[VV_LAYER_COUNT] = {layers->depth, layers->normal, layers->id, layers->samples, layers->value};
    unsigned bits = 0;
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        bits |= on[i] ? 1u << i : 0;
    return bits;
}

static vv_status fail_layer(const char *word, size_t n)
{
    const char *names[VV_LAYER_COUNT];
    char typed[32];
    for (size_t i = 0; i < VV_LAYER_COUNT; i++)
        names[i] = vv_layer_name(i);
    snprintf(typed, sizeof typed, "%.*s", (int)n, word);
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, typed, &(vvi_known){names, VV_LAYER_COUNT, NULL, NULL},
                         "--aov: no layer '%s'", typed);
}

/* Those that are named, and no others: "none" takes away what a scene asks for. */
static vv_status parse(unsigned *out, const char *typed)
{
    *out = 0;
    if (strcasecmp(typed, "none") == 0)
        return VV_OK;
    for (const char *word = typed;; word++) {
        const size_t n = strcspn(word, ",");
        size_t i = 0;
        while (i < VV_LAYER_COUNT && (strlen(vv_layer_name(i)) != n || strncasecmp(vv_layer_name(i), word, n) != 0))
            i++;
        if (i == VV_LAYER_COUNT)
            return fail_layer(word, n);
        *out |= 1u << i;
        word += n;
        if (!*word)
            return VV_OK;
    }
}

vv_status cli_edit_layers(cli_edits *edits)
{
    unsigned layers = 0;
    const char *typed = edits->look->aov;
    vv_status st = typed ? parse(&layers, typed) : VV_OK;
    for (size_t i = 0; typed && i < VV_LAYER_COUNT && st == VV_OK; i++) {
        const char *name = vv_layer_name(i);
        st = layers >> i & 1 ? cli_edit_set(edits, "aov", "true", "views.%s.render.layers.%s", edits->view, name)
                             : cli_edit_unset(edits, "views.%s.render.layers.%s", edits->view, name);
    }
    return st;
}
