/* Pyramids: the same volume in several sizes, of which one is shown. */
#include "core/limits.h"
#include "core/memory.h"
#include "io/formats/hdf5/hdf5.h"

vv_status vvi_h5_choose_level(vv_field_info *info, vvi_h5_plan *plan, vvi_h5 *h5, int n_levels, vvi_h5_take_level take,
                              vv_notes *notes)
{
    vv_status st = VV_OK;
    for (int level = 0; level < n_levels; level++) {
        uint64_t bytes;
        if ((st = take(info, plan, h5, level)) != VV_OK || (st = vv_field_info_bytes(&bytes, info)) != VV_OK)
            return st;
        if (h5->finest || level + 1 == n_levels || vvi_memory_plan(h5->job, bytes + bytes / 4, "volume") == VV_OK)
            return level == 0
                       ? VV_OK
                       : vvi_notes_warn(notes, "level %d is shown: finer ones need more than the memory limit", level);
    }
    return st;
}
