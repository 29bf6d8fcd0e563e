/* What comments of PLY, OBJ and OFF say of a mesh: its unit, its space, which axis points up. */
#include "core/text.h"
#include "core/units.h"
#include "io/meshes/mesh_builder.h"
#include "io/scan.h"
#include <string.h>

/* What follows "unit: ", else NULL; *colon_out: without one these may be words of a sentence. */
static const char *after_key(bool *colon_out, const char *text, const char *key)
{
    const size_t n = strlen(key);
    if (strncmp(text, key, n) != 0 || (text[n] != ':' && text[n] != ' '))
        return NULL;
    *colon_out = text[n] == ':';
    text += n + 1;
    return text + strspn(text, " \t");
}

/* Programs whose files have z up, whatever their format has. */
static bool is_of_upright_program(const char *text)
{
    return strcmp(text, "made by VolVis") == 0 || strcmp(text, "written by VolVis") == 0 ||
           strstr(text, "SPACE=") != NULL; /* 3D Slicer */
}

bool vvi_mesh_builder_comment(vvi_mesh_builder *b, const char *text)
{
    const char *value;
    bool colon;
    text += strspn(text, " \t");
    if (is_of_upright_program(text))
        b->info.up = VV_UP_Z;
    if ((value = after_key(&colon, text, "unit")) && !b->unit_given && (colon || vvi_length_unit_metres(value) > 0)) {
        vvi_unit_name(b->info.unit, value, strlen(value));
        vvi_text_clean(b->info.unit);
        b->unit_given = true;
        return true;
    }
    if ((value = after_key(&colon, text, "space")) && (colon || strcmp(value, "RAS") == 0)) {
        b->info.space = strcmp(value, "RAS") == 0 ? VV_SPACE_RAS : VV_SPACE_PLAIN;
        return true;
    }
    if ((value = after_key(&colon, text, "up")) && (strcmp(value, "y") == 0 || strcmp(value, "z") == 0)) {
        b->info.up = *value == 'y' ? VV_UP_Y : VV_UP_Z;
        return true;
    }
    return false;
}
