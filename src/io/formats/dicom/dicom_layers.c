/* A segmentation put in order: frames of segments become labels of one volume. Segments that overlap cannot: they lie
 * in layers, each a part of the file, as do the segments of which fractions are told. */
#include "io/formats/dicom/dicom_layers.h"
#include "core/memory.h"
#include "io/formats/dicom/dicom_contours.h"
#include "io/notes.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define NUMBERS 65536    /* of segments: 0 is where none is */
#define SLICES_MOST 4096 /* between the first and the last frame, most of them empty */

void *vvi_dicom_layers_room(vvi_dicom_layers *l, size_t n, size_t bytes)
{
    void *out = vvi_alloc_zeroed(l->job, n * bytes + 1, VVI_MEM_SCRATCH);
    if (!out)
        (void)vv_fail_memory(n * bytes + 1);
    return out;
}

/* Segments -------------------------------------------------------------------------------------------------------- */

static vv_status number_of(uint16_t *out, const vvi_dicom_layers *l, int32_t frame)
{
    double number = l->image->structures ? l->image->structures->frame[frame].label
                                         : vvi_dicom_frame_values(l->image, frame)->key[VVI_DICOM_KEY_SEGMENT];
    if (isnan(number) && l->image->n_segments == 1)
        number = l->image->segment[0].number;
    if (!(number >= 1 && number < NUMBERS) || number != floor(number))
        return vv_fail_at(VV_E_FORMAT, l->name, NULL,
                          "frame %d does not say which segment it is of (ReferencedSegmentNumber from 1 to 65535)",
                          (int)frame + 1);
    *out = (uint16_t)number;
    return VV_OK;
}

/* Those that are described and those that frames refer to. */
static vv_status find_segments(vvi_dicom_layers *l)
{
    vv_status st = VV_OK;
    const bool frames = vvi_dicom_segmentation_of(l->image) != VVI_DICOM_LABELMAP;
    uint8_t *there = vvi_dicom_layers_room(l, NUMBERS, 1);
    l->index = vvi_dicom_layers_room(l, NUMBERS, sizeof *l->index);
    l->described = vvi_dicom_layers_room(l, NUMBERS, sizeof(void *));
    if (!there || !l->index || !l->described) {
        vvi_free(there);
        return VV_E_MEMORY;
    }
    for (size_t i = 0; i < l->image->n_segments; i++) {
        const double number = l->image->segment[i].number;
        if (number >= 1 && number < NUMBERS && !l->described[(size_t)number]) {
            there[(size_t)number] = 1;
            l->described[(size_t)number] = &l->image->segment[i];
        }
    }
    for (size_t i = 0; frames && i < l->n && st == VV_OK; i++) {
        uint16_t number = 0;
        st = number_of(&number, l, l->slice[i].frame);
        there[number] = 1;
    }
    for (size_t v = 1; v < NUMBERS; v++)
        l->n_segments += there[v];
    if (st == VV_OK && (!(l->number = vvi_dicom_layers_room(l, l->n_segments, sizeof *l->number)) ||
                        !(l->layer = vvi_dicom_layers_room(l, l->n_segments, sizeof *l->layer)) ||
                        !(l->n_frames = vvi_dicom_layers_room(l, l->n_segments, sizeof *l->n_frames))))
        st = VV_E_MEMORY;
    for (size_t v = 1, n = 0; v < NUMBERS && st == VV_OK; v++)
        if (there[v]) {
            l->index[v] = (uint16_t)n;
            l->number[n++] = (uint16_t)v;
        }
    vvi_free(there);
    return st;
}

size_t vvi_dicom_segment_of(const vvi_dicom_layers *l, int32_t frame)
{
    uint16_t number = l->n_segments ? l->number[0] : 0;
    (void)number_of(&number, l, frame); /* was asked of all */
    return l->index[number];
}

/* Places ---------------------------------------------------------------------------------------------------------- */

/* Frames that do not say where they lie: the k-th of each segment is slice k, where all have as many. */
static vv_status find_unplaced(vvi_dicom_layers *l, bool labels)
{
    size_t *count = vvi_dicom_layers_room(l, l->n_segments + 1, sizeof *count);
    vvi_dicom_slice *sorted = vvi_dicom_layers_room(l, l->n, sizeof *sorted);
    if (!(l->place = vvi_dicom_layers_room(l, l->n + 1, sizeof *l->place)) || !count || !sorted) {
        vvi_free(sorted);
        vvi_free(count);
        return VV_E_MEMORY;
    }
    const size_t each = labels ? 1 : l->n_segments;
    size_t n_used = 0;
    for (size_t i = 0; i < l->n; i++)
        n_used += count[labels ? 0 : vvi_dicom_segment_of(l, l->slice[i].frame)]++ == 0;
    l->n_places = n_used ? l->n / n_used : 0;
    bool even = true;
    for (size_t s = 0; s < each; s++)
        even = even && (count[s] == 0 || count[s] == l->n_places);
    memset(count, 0, l->n_segments * sizeof *count);
    for (size_t p = 0; p <= l->n_places; p++)
        l->place[p] = p * n_used;
    size_t *next = l->place; /* a frame of each segment goes to each place: places fill up evenly */
    for (size_t i = 0; i < l->n && even; i++) {
        const size_t k = count[labels ? 0 : vvi_dicom_segment_of(l, l->slice[i].frame)]++;
        sorted[next[k]++] = l->slice[i];
    }
    for (size_t p = 0; p <= l->n_places; p++)
        l->place[p] = p * n_used;
    if (even)
        memcpy(l->slice, sorted, l->n * sizeof *sorted);
    vvi_free(sorted);
    vvi_free(count);
    return even ? VV_OK
                : vv_fail_at(VV_E_UNSUPPORTED, l->name, NULL,
                             "its frames do not give their positions (ImagePositionPatient), and its segments have "
                             "different numbers of them; they cannot be put in order");
}

/* Of frames of one segment at one place the first is kept. */
static vv_status leave_out_copies(vvi_dicom_layers *l, bool labels)
{
    size_t *seen = vvi_dicom_layers_room(l, l->n_segments + 1, sizeof *seen),
           to = 0; /* the place, counted from 1, of the last frame */
    if (!seen)
        return VV_E_MEMORY;
    const size_t n = l->n;
    for (size_t p = 0; p < l->n_places; p++) {
        const size_t from = l->place[p], end = l->place[p + 1];
        l->place[p] = to;
        for (size_t i = from; i < end; i++) {
            size_t *last = &seen[labels ? 0 : vvi_dicom_segment_of(l, l->slice[i].frame)];
            if (*last != p + 1)
                l->slice[to++] = l->slice[i];
            *last = p + 1;
        }
    }
    l->place[l->n_places] = l->n = to;
    vvi_free(seen);
    return to == n
               ? VV_OK
               : vvi_notes_warn(l->notes, "%zu frame%s at the same position as another of the same segment: left out",
                                n - to, n - to > 1 ? "s lie" : " lies");
}

static double step_after(const vvi_dicom_layers *l, size_t p)
{
    return l->slice[l->place[p + 1]].depth - l->slice[l->place[p]].depth;
}

/* How many slices places take when slices lie so far apart; 0: they do not lie on such slices. */
static size_t slices_by_step(const vvi_dicom_layers *l, double step)
{
    size_t n = 1;
    if (!isfinite(step) || step <= 2e-3)
        return 0;
    for (size_t p = 0; p + 1 < l->n_places; p++) {
        const double times = step_after(l, p) / step, whole = floor(times + 0.5);
        if (whole < 1 || whole > SLICES_MOST || fabs(times - whole) > 0.05)
            return 0;
        n += (size_t)whole;
    }
    return n <= 2 * l->n_places || n <= SLICES_MOST ? n : 0;
}

/* Slices without a frame are empty, which is no fault: the step is what the file says, else the smallest there is. */
static vv_status find_slices(vvi_dicom_layers *l)
{
    double step = fabs(vvi_dicom_frame_values(l->image, l->slice[0].frame)->between), least = INFINITY, most = 0;
    for (size_t p = 0; p + 1 < l->n_places; p++) {
        least = fmin(least, step_after(l, p));
        most = fmax(most, step_after(l, p));
    }
    l->n_slices = slices_by_step(l, step);
    if (l->n_slices == 0)
        l->n_slices = slices_by_step(l, step = least);
    const bool even = l->n_slices > 0;
    if (!even)
        l->n_slices = l->n_places;
    l->slice_of = vvi_dicom_layers_room(l, l->n_places, sizeof *l->slice_of);
    if (!l->slice_of)
        return VV_E_MEMORY;
    for (size_t p = 1; p < l->n_places; p++)
        l->slice_of[p] = l->slice_of[p - 1] + (even ? (size_t)(step_after(l, p - 1) / step + 0.5) : 1);
    if (even || l->n_places < 2 || most - least <= fmax(0.02 * least, 2e-3))
        return VV_OK;
    return vvi_notes_warn(l->notes, "slices are %g to %g mm apart; they are shown evenly spaced", least, most);
}

/* Frames that are drawn know their slice, and are in order; slices may have none. */
static vv_status find_drawn(vvi_dicom_layers *l)
{
    const vvi_dicom_structures *s = l->image->structures;
    l->n_slices = l->n_places = (size_t)s->grid.dims[2];
    l->place = vvi_dicom_layers_room(l, l->n_places + 1, sizeof *l->place);
    l->slice_of = vvi_dicom_layers_room(l, l->n_places, sizeof *l->slice_of);
    if (!l->place || !l->slice_of)
        return VV_E_MEMORY;
    for (size_t k = 0, i = 0; k < l->n_places; k++) {
        l->slice_of[k] = k;
        l->place[k] = i;
        while (i < l->n && s->frame[i].slice == (int32_t)k)
            i++;
    }
    l->place[l->n_places] = l->n;
    return VV_OK;
}

static vv_status find_places(vvi_dicom_layers *l)
{
    if (l->image->structures)
        return find_drawn(l);
    const bool labels = vvi_dicom_segmentation_of(l->image) == VVI_DICOM_LABELMAP;
    const bool placed = vvi_dicom_is_placed(vvi_dicom_frame_values(l->image, l->slice[0].frame));
    vv_status st = placed ? vvi_dicom_find_places(&l->place, &l->n_places, l->plan, l->slice, l->n, l->job)
                          : find_unplaced(l, labels);
    if (st == VV_OK)
        st = leave_out_copies(l, labels);
    if (st == VV_OK && placed)
        return find_slices(l);
    l->n_slices = l->n_places;
    l->slice_of = st == VV_OK ? vvi_dicom_layers_room(l, l->n_places, sizeof *l->slice_of) : NULL;
    if (st == VV_OK && !l->slice_of)
        return VV_E_MEMORY;
    for (size_t p = 0; st == VV_OK && p < l->n_places; p++)
        l->slice_of[p] = p;
    return st;
}

/* The plan -------------------------------------------------------------------------------------------------------- */

static bool is_wanted(const vvi_dicom_layers *l, size_t segment, size_t chosen)
{
    if (vvi_dicom_segmentation_of(l->image) == VVI_DICOM_FRACTIONAL)
        return segment == chosen;
    return l->alone == SIZE_MAX ? l->layer[segment] == chosen : segment == l->alone;
}

/* plan->slice, any frame of each slice, is for the placement; what is seen there is painted. */
static vv_status fill_plan(vvi_dicom_layers *l, size_t chosen)
{
    vvi_dicom_plan *plan = l->plan;
    const bool labels = vvi_dicom_segmentation_of(l->image) == VVI_DICOM_LABELMAP;
    size_t n = 0, k = 0;
    plan->slice = vvi_alloc(l->job, l->n_slices * sizeof *plan->slice, VVI_MEM_MODEL);
    plan->painted = vvi_alloc(l->job, (l->n + 1) * sizeof *plan->painted, VVI_MEM_MODEL);
    plan->first_painted = vvi_alloc(l->job, (l->n_slices + 1) * sizeof *plan->first_painted, VVI_MEM_MODEL);
    if (!plan->slice || !plan->painted || !plan->first_painted)
        return vv_fail_memory(l->n * sizeof *plan->painted);
    for (size_t p = 0; p < l->n_places; p++) {
        for (; k < l->slice_of[p]; k++) {
            plan->slice[k] = (vvi_dicom_slice){-1, 0, 0};
            plan->first_painted[k] = n;
        }
        plan->slice[k] = l->slice[l->place[p] < l->n ? l->place[p] : 0];
        plan->first_painted[k++] = n;
        for (size_t i = l->place[p]; i < l->place[p + 1]; i++) {
            const int32_t frame = l->slice[i].frame;
            const size_t s = labels ? 0 : vvi_dicom_segment_of(l, frame);
            if (labels || is_wanted(l, s, chosen))
                plan->painted[n++] = (vvi_dicom_painted){frame, labels ? 0 : l->number[s]};
        }
    }
    plan->first_painted[k] = n;
    return VV_OK;
}

/* Layers are of one type, whatever numbers are in each. */
static void describe_labels(vv_field_info *info, const vvi_dicom_layers *l)
{
    info->meaning = VV_MEANING_LABEL;
    info->type = l->n_segments > 0 && l->number[l->n_segments - 1] > 255 ? VV_TYPE_U16 : VV_TYPE_U8;
    if (vvi_dicom_segmentation_of(l->image) == VVI_DICOM_LABELMAP)
        info->type = l->image->type;
}

/* From 0 to 1, as bytes. */
static vv_status describe_fractions(vv_field_info *info, const vvi_dicom_layers *l, size_t chosen)
{
    const vv_label label = vvi_dicom_label_of(l, chosen);
    const double most = l->image->number[VVI_DICOM_FRACTION_MOST];
    vv_channel channel = {.has_color = label.has_color, .color = label.color, .lo = 0, .hi = 1};
    snprintf(channel.name, sizeof channel.name, "%s", label.name);
    info->meaning = VV_MEANING_SCALAR;
    info->type = l->image->type;
    info->value_scale = 1 / (isfinite(most) && most >= 1 ? most : 255);
    return vvi_notes_channel(l->notes, &channel);
}

static vv_status note_segments(const vvi_dicom_layers *l, size_t chosen)
{
    const bool labels = vvi_dicom_segmentation_of(l->image) != VVI_DICOM_FRACTIONAL;
    vv_status st = vvi_dicom_note_regions(l->image, l->notes);
    for (size_t s = 0; s < l->n_segments && st == VV_OK; s++) {
        if (!is_wanted(l, s, chosen))
            continue;
        const vvi_dicom_segment *segment = l->described[l->number[s]];
        vv_label label = vvi_dicom_segment_label(segment, l->number[s]);
        label.layer = (int)l->layer[s];
        if (labels)
            st = vvi_notes_label(l->notes, &label);
        if (st == VV_OK && segment)
            st = vvi_dicom_note_segment(segment, vvi_dicom_word(l->image), l->notes);
    }
    return st;
}

static vv_status check_samples(const vvi_dicom_layers *l)
{
    const vvi_dicom_segmentation kind = vvi_dicom_segmentation_of(l->image);
    const vv_type type = l->image->type;
    if (l->image->components == 1 && (type == VV_TYPE_U8 || (type == VV_TYPE_U16 && kind == VVI_DICOM_LABELMAP)))
        return VV_OK;
    return vv_fail_at(VV_E_UNSUPPORTED, l->name, NULL, "is a segmentation of %s; u8, and u16 of a LABELMAP, are read",
                      vv_type_name(type));
}

static vv_status arrange(vv_field_info *info, vvi_dicom_layers *l, const vvi_dicom_stack *stack, const char *part)
{
    const bool fractions = vvi_dicom_segmentation_of(l->image) == VVI_DICOM_FRACTIONAL;
    size_t chosen = 0;
    vv_status st = check_samples(l);
    if (st != VV_OK || (st = find_segments(l)) != VV_OK || (st = find_places(l)) != VV_OK ||
        (st = vvi_dicom_find_layers(l)) != VV_OK)
        return st;
    for (size_t i = 0; i < l->n && vvi_dicom_segmentation_of(l->image) != VVI_DICOM_LABELMAP; i++)
        l->n_frames[vvi_dicom_segment_of(l, l->slice[i].frame)]++;
    st =
        fractions ? vvi_dicom_choose_segment(&chosen, l, stack, part) : vvi_dicom_choose_layer(&chosen, l, stack, part);
    if (st != VV_OK || (st = fill_plan(l, chosen)) != VV_OK)
        return st;
    info->grid.dims[2] = (int64_t)l->n_slices;
    info->n_frames = 1;
    info->components = 1;
    if (fractions)
        st = describe_fractions(info, l, chosen);
    else
        describe_labels(info, l);
    return st == VV_OK ? note_segments(l, chosen) : st;
}

vv_status vvi_dicom_arrange_segments(vv_field_info *info, vvi_dicom_plan *plan, vvi_dicom_stack *stack,
                                     const char *layer, vv_source *source, vv_notes *notes, vv_job *job)
{
    vvi_dicom_layers l = {.plan = plan,
                          .image = &plan->image[stack->slice[0].image],
                          .slice = stack->slice,
                          .n = stack->n,
                          .alone = SIZE_MAX,
                          .name = vvi_source_name(source),
                          .source = source,
                          .notes = notes,
                          .job = job};
    const vv_status st = arrange(info, &l, stack, layer);
    stack->n = l.n;
    vvi_free(l.place);
    vvi_free(l.slice_of);
    vvi_free(l.number);
    vvi_free(l.index);
    vvi_free(l.described);
    vvi_free(l.n_frames);
    vvi_free(l.layer);
    vvi_free(l.overlap);
    return st;
}
