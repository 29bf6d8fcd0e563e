#include "segment/label_result.h"

#include <string.h>

vv_field_info vvi_label_result(const vv_field_info *in, vv_type type)
{
    vv_field_info out = *in;
    out.type = type;
    out.components = 1;
    out.meaning = VV_MEANING_LABEL;
    out.value_scale = 1;
    out.value_offset = 0;
    memset(out.value_unit, 0, sizeof out.value_unit);
    memset(out.name, 0, sizeof out.name);
    return out;
}

vv_status vvi_label_need_one_component(const vv_field_info *in, const char *name)
{
    if (in->components == 1)
        return VV_OK;
    return vv_fail(VV_E_UNSUPPORTED, "%s: a voxel has one label but %d channels here; pick one with `volvis channel`",
                   name, in->components);
}
