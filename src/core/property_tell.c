/* Rows as JSON, for programs and for the page. */
#include "core/result.h"

static const char *const kinds[] = {"bool",  "integer", "number", "enum", "string", "path",     "reference", "vector",
                                    "color", "numbers", "object", "list", "map",    "variants", "members"};
_Static_assert(sizeof kinds / sizeof *kinds == VV_KIND_MEMBERS + 1, "a kind of property has no name");
static const char *const quantities[] = {NULL, "length", "angle", "time", "bytes", "ratio", "label"};

void vvi_property_tell(vvi_result *out, const vv_property *row)
{
    vvi_result_string(out, "name", row->name);
    vvi_result_string(out, "kind", kinds[row->kind]);
    vvi_result_string(out, "doc", row->doc);
    if (row->quantity != VV_Q_NONE)
        vvi_result_string(out, "quantity", quantities[row->quantity]);
    if (row->unit)
        vvi_result_string(out, "unit", row->unit);
    if (!row->limited)
        return;
    vvi_result_number(out, "min", row->min);
    vvi_result_number(out, "max", row->max);
}

bool vvi_property_tell_default(vvi_result *out, const vv_property *row)
{
    if (row->kind == VV_KIND_ENUM)
        vvi_result_string(out, "default", row->names[(int)row->def]);
    else if (row->kind == VV_KIND_BOOL)
        vvi_result_bool(out, "default", row->def != 0);
    else if (row->kind == VV_KIND_I64 || row->kind == VV_KIND_F64)
        vvi_result_number(out, "default", row->def);
    else
        return false;
    return true;
}
