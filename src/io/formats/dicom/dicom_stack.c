/* A stack of images put in order: by place along the normal of its planes, images at one place told apart as time steps
 * or the like, missing ones found. */
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include "io/notes.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const key_names[VVI_DICOM_KEYS] = {"TemporalPositionIdentifier",
                                                      "TriggerTime",
                                                      "ReferencedSegmentNumber",
                                                      "DiffusionBValue",
                                                      "EchoTime",
                                                      "AcquisitionNumber",
                                                      "AcquisitionTime",
                                                      "ContentTime",
                                                      "InstanceNumber"};

typedef struct order {
    vvi_dicom_plan *plan;
    vvi_dicom_slice *slice; /* of the stack, in order */
    size_t n;
    size_t *place; /* where each place begins in them; n_places + 1 */
    size_t n_places;
    const char *name;
    vv_notes *notes;
    vv_job *job;
} order;

static const vvi_dicom_values *values(const order *o, const vvi_dicom_slice *s)
{
    return vvi_dicom_frame_values(&o->plan->image[s->image], s->frame);
}

/* Several images at one place ------------------------------------------------------------------------------------ */

static size_t most_at_a_place(const order *o)
{
    size_t most = 0;
    for (size_t p = 0; p < o->n_places; p++)
        if (o->place[p + 1] - o->place[p] > most)
            most = o->place[p + 1] - o->place[p];
    return most;
}

/* Whether a key tells all images at each place apart. */
static bool tells_apart(const order *o, int key)
{
    for (size_t p = 0; p < o->n_places; p++)
        for (size_t i = o->place[p]; i < o->place[p + 1]; i++) {
            const double value = values(o, &o->slice[i])->key[key];
            if (isnan(value) || (i > o->place[p] && value == values(o, &o->slice[i - 1])->key[key]))
                return false;
        }
    return true;
}

static vv_status sort_places(order *o, int key)
{
    vv_status st = VV_OK;
    for (size_t p = 0; p < o->n_places && st == VV_OK; p++)
        st = vvi_dicom_sort(o->plan, o->slice + o->place[p], o->place[p + 1] - o->place[p], false, key, o->job);
    return st;
}

/* The first key by which they differ everywhere; -1: none. The places are then sorted by it. */
static vv_status find_key(order *o, int *key_out)
{
    vv_status st = VV_OK;
    *key_out = -1;
    for (int key = 0; key < VVI_DICOM_KEYS && st == VV_OK; key++) {
        if ((st = sort_places(o, key)) == VV_OK && tells_apart(o, key)) {
            *key_out = key;
            return VV_OK;
        }
    }
    return st;
}

static bool same_image(const order *o, const vvi_dicom_slice *a, const vvi_dicom_slice *b)
{
    const vvi_dicom_image *p = &o->plan->image[a->image], *q = &o->plan->image[b->image];
    return a->frame == b->frame && p->text[VVI_DICOM_IMAGE_UID][0] &&
           strcmp(p->text[VVI_DICOM_IMAGE_UID], q->text[VVI_DICOM_IMAGE_UID]) == 0;
}

/* Keeps at most `most` images of each place; with `same`, of each image one. What is left out is counted. */
static size_t leave_out(order *o, size_t most, bool same)
{
    size_t to = 0, out = 0;
    for (size_t p = 0; p < o->n_places; p++) {
        const size_t first = to;
        const size_t from = o->place[p], end = o->place[p + 1];
        o->place[p] = first;
        for (size_t i = from; i < end; i++) {
            bool again = to - first >= most;
            if (same && to > first) /* copies have the same place and number: they are neighbours */
                again = again || same_image(o, &o->slice[to - 1], &o->slice[i]);
            if (again)
                out++;
            else
                o->slice[to++] = o->slice[i];
        }
    }
    o->place[o->n_places] = o->n = to;
    return out;
}

static vv_status warn_left_out(order *o, size_t n)
{
    return n == 0 ? VV_OK
                  : vvi_notes_warn(o->notes, "%zu image%s at the same position as another: left out", n,
                                   n > 1 ? "s lie" : " lies");
}

/* How many places have exactly n images. */
static size_t places_with(const order *o, size_t n)
{
    size_t count = 0;
    for (size_t p = 0; p < o->n_places; p++)
        count += o->place[p + 1] - o->place[p] == n;
    return count;
}

static vv_status note_frames(order *o, int key, size_t n_frames)
{
    char text[128];
    snprintf(text, sizeof text, "%zu images at each position, by %s", n_frames, key_names[key]);
    return vvi_notes_add(o->notes, "frames", text);
}

/* Frames where all places, but a few, have the same number of images; else one image of each place is kept. */
static vv_status find_frames(order *o, size_t *n_frames, int *key_out)
{
    int key = -1;
    *key_out = -1;
    *n_frames = 1;
    vv_status st = warn_left_out(o, leave_out(o, SIZE_MAX, true));
    const size_t most = most_at_a_place(o);
    if (st != VV_OK || most == 1)
        return st;
    if (places_with(o, most) > o->n_places / 2 && (st = find_key(o, &key)) == VV_OK && key >= 0) {
        *n_frames = most;
        *key_out = key;
        return note_frames(o, key, most);
    }
    if (st == VV_OK)
        st = sort_places(o, VVI_DICOM_KEY_INSTANCE);
    return st == VV_OK ? warn_left_out(o, leave_out(o, 1, false)) : st;
}

/* Gaps ----------------------------------------------------------------------------------------------------------- */

static double step_after(const order *o, size_t p)
{
    return o->slice[o->place[p + 1]].depth - o->slice[o->place[p]].depth;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* The middle one of the steps from place to place. */
static vv_status usual_step(order *o, double *out)
{
    const size_t n = o->n_places - 1;
    double *steps = vvi_alloc(o->job, n * sizeof *steps, VVI_MEM_SCRATCH);
    if (!steps)
        return vv_fail_memory(n * sizeof *steps);
    for (size_t p = 0; p < n; p++)
        steps[p] = step_after(o, p);
    qsort(steps, n, sizeof *steps, by_value);
    *out = steps[n / 2];
    vvi_free(steps);
    return VV_OK;
}

/* Slices that a volume of even steps has: more than there are places when some are missing. What does not fit even
 * steps is warned of, and keeps its order. */
static vv_status find_gaps(order *o, size_t *n_slices)
{
    double usual, least = INFINITY, most = 0;
    size_t n = 1;
    bool multiples = true;
    *n_slices = o->n_places;
    if (o->n_places < 3)
        return VV_OK;
    vv_status st = usual_step(o, &usual);
    for (size_t p = 0; p + 1 < o->n_places && st == VV_OK; p++) {
        const double step = step_after(o, p), times = step / usual;
        least = fmin(least, step);
        most = fmax(most, step);
        multiples = multiples && times > 0.5 && times < 1e5 && fabs(times - floor(times + 0.5)) < 0.05;
        n += multiples ? (size_t)(times + 0.5) : 0;
    }
    if (st != VV_OK || most - least <= fmax(0.02 * usual, 2e-3))
        return st;
    if (!multiples || n > 2 * o->n_places)
        return vvi_notes_warn(o->notes,
                              "slices are %g to %g mm apart; they are shown with the mean distance between all of them",
                              least, most);
    if (n == o->n_places)
        return vvi_notes_warn(o->notes, "slices are %g to %g mm apart; they are shown evenly spaced", least, most);
    *n_slices = n;
    return vvi_notes_warn(o->notes, "%zu of %zu slices are missing; they are filled", n - o->n_places, n);
}

/* The volume: for each frame its slices, upwards. Where a place has fewer images than others the last are missing. */
static vv_status fill_plan(order *o, vv_field_info *info, size_t n_frames, size_t n_slices)
{
    vvi_dicom_plan *plan = o->plan;
    const size_t n = n_frames * n_slices;
    double usual = 1;
    vv_status st = o->n_places > 1 && n_slices > o->n_places ? usual_step(o, &usual) : VV_OK;
    if (st != VV_OK)
        return st;
    plan->slice = vvi_alloc(o->job, n * sizeof *plan->slice, VVI_MEM_MODEL);
    if (!plan->slice)
        return vv_fail_memory(n * sizeof *plan->slice);
    for (size_t i = 0; i < n; i++)
        plan->slice[i] = (vvi_dicom_slice){-1, 0, 0};
    size_t k = 0;
    for (size_t p = 0; p < o->n_places; p++) {
        for (size_t i = o->place[p]; i < o->place[p + 1] && k < n_slices; i++)
            plan->slice[(i - o->place[p]) * n_slices + k] = o->slice[i];
        if (p + 1 < o->n_places)
            k += n_slices > o->n_places ? (size_t)(step_after(o, p) / usual + 0.5) : 1;
    }
    info->grid.dims[2] = (int64_t)n_slices;
    info->n_frames = (int64_t)n_frames;
    return VV_OK;
}

/* From the first to the second image at the first place. */
static double step_of_key(const order *o, int key)
{
    if (!o->place || o->place[1] - o->place[0] < 2)
        return NAN;
    return values(o, &o->slice[1])->key[key] - values(o, &o->slice[0])->key[key];
}

/* Positions in time are mere numbers: how long one lasts stands elsewhere, or is what times differ by. */
static double step_of_positions(const order *o, const char **unit_out)
{
    static const struct {
        int key;
        const char *unit;
    } times[] = {
        {VVI_DICOM_KEY_TRIGGER, "ms"}, {VVI_DICOM_KEY_ACQUISITION_TIME, "s"}, {VVI_DICOM_KEY_CONTENT_TIME, "s"}};
    const double said = o->plan->image[o->slice[0].image].number[VVI_DICOM_TEMPORAL_RESOLUTION];
    *unit_out = "ms";
    if (said > 0)
        return said;
    for (size_t i = 0; i < sizeof times / sizeof *times; i++) {
        const double step = step_of_key(o, times[i].key);
        *unit_out = times[i].unit;
        if (step > 0)
            return step;
    }
    return NAN;
}

static void note_time(const order *o, vv_field_info *info, int key)
{
    static const char *const units[VVI_DICOM_KEYS] = {"", "ms", "", "s/mm2", "ms", "", "s", "s", ""};
    const double lasts = o->plan->image[o->slice[0].image].number[VVI_DICOM_FRAME_TIME];
    const char *unit = key >= 0 ? units[key] : "ms";
    double step = NAN;
    if (info->n_frames < 2)
        return;
    if (key < 0)
        step = lasts > 0 ? lasts : NAN;
    else if (key == VVI_DICOM_KEY_TEMPORAL)
        step = step_of_positions(o, &unit);
    else if (unit[0])
        step = step_of_key(o, key);
    info->frame_step = step > 0 ? step : 0;
    if (!isnan(step))
        snprintf(info->frame_unit, sizeof info->frame_unit, "%s", unit);
}

/* Without places: by number, one behind the other; frames of one file that says how long one lasts are time steps. */
static vv_status arrange_unplaced(order *o, vv_field_info *info, bool one_file)
{
    vv_status st = vvi_dicom_sort(o->plan, o->slice, o->n, false, VVI_DICOM_KEY_INSTANCE, o->job);
    if (st != VV_OK)
        return st;
    const vvi_dicom_image *image = &o->plan->image[o->slice[0].image];
    const bool cine = one_file && image->n_frames > 1 && !image->offset && image->number[VVI_DICOM_FRAME_TIME] > 0;
    o->plan->slice = vvi_alloc(o->job, o->n * sizeof *o->slice, VVI_MEM_MODEL);
    if (!o->plan->slice)
        return vv_fail_memory(o->n * sizeof *o->slice);
    memcpy(o->plan->slice, o->slice, o->n * sizeof *o->slice);
    info->n_frames = cine ? (int64_t)o->n : 1;
    info->grid.dims[2] = cine ? 1 : (int64_t)o->n;
    note_time(o, info, -1);
    if (o->n > 1 && !one_file)
        return vvi_notes_warn(o->notes,
                              "its images do not give their positions; they are in the order of their numbers");
    return VV_OK;
}

vv_status vvi_dicom_arrange(vv_field_info *info, vvi_dicom_plan *plan, vvi_dicom_stack *stack, const char *name,
                            vv_notes *notes, vv_job *job)
{
    order o = {.plan = plan, .slice = stack->slice, .n = stack->n, .name = name, .notes = notes, .job = job};
    const vvi_dicom_image *image = &plan->image[stack->slice[0].image];
    const bool one_file = plan->n_images == 1;
    size_t n_frames, n_slices;
    int key;
    /* frames of a file of old share one place, which is not theirs; those of a dose have offsets */
    const bool shared_place = image->n_frames > 1 && !image->frame && !image->offset;
    if (!vvi_dicom_is_placed(values(&o, &o.slice[0])) || shared_place)
        return arrange_unplaced(&o, info, one_file);
    vv_status st = vvi_dicom_find_places(&o.place, &o.n_places, plan, o.slice, o.n, job);
    if (st == VV_OK)
        st = find_frames(&o, &n_frames, &key);
    if (st == VV_OK)
        st = find_gaps(&o, &n_slices);
    if (st == VV_OK)
        st = fill_plan(&o, info, n_frames, n_slices);
    if (st == VV_OK)
        note_time(&o, info, key);
    stack->n = o.n;
    vvi_free(o.place);
    return st;
}
