/** @file
 * Places of values in the table of a classification. For kernels only.
 */
#ifndef VVI_RENDER_MARCH_CLASSIFY_H
#define VVI_RENDER_MARCH_CLASSIFY_H
#include "core/simd.h"
#include "render/march/kernels.h"

/** Its whole part is the entry. */
VV_INLINE vf entry_place(const vvi_march_volume *f, vf value)
{
    const vf place = vf_fma(value, vf_set1(f->classifier.entry_scale),
                            vf_set1(f->classifier.entry_shift)); /* may be beyond integers */
    return vf_clamp(place, vf_set1(0.0f), vf_set1(f->classifier.last_place));
}

/** In place of entries that are split (those of `split`, by their alpha) the one of theirs that holds. */
VV_INLINE vi split_entry(const vvi_march_volume *f, vf place, vi entry, vf alpha, vm split)
{
    const vf parts = vf_gather4(f->classifier.color, vi_shl(entry, 2), split);
    const vi part = vi_trunc((place - vf_from_vi(entry)) * parts);
    return vi_select(split, vi_trunc(alpha) - vi_set1(VVI_ENTRY_SPLIT) + part, entry);
}

VV_INLINE vi find_entry(const vvi_march_volume *f, vf value, vm m)
{
    const vf place = entry_place(f, value);
    const vi entry = vi_trunc(place);
    const vf alpha = vf_gather4(f->classifier.alpha, entry, m);
    const vm split = vf_lt(vf_set1(1.0f), alpha);
    return vm_any(split) ? split_entry(f, place, entry, alpha, split) : entry;
}

#endif
