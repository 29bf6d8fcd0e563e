/* Layers and segments of a segmentation as parts of its file. */
#include "io/formats/dicom/dicom_layers.h"
#include "io/notes.h"
#include <stdio.h>
#include <string.h>
#include <strings.h>

vv_label vvi_dicom_label_of(const vvi_dicom_layers *l, size_t segment)
{
    return vvi_dicom_segment_label(l->described[l->number[segment]], l->number[segment]);
}

/* Parts of a series among others have its name in front. */
static void name_part(char *out, size_t n, const vvi_dicom_layers *l, const vvi_dicom_stack *stack, const char *word,
                      size_t i)
{
    if (l->plan->n_stacks > 1)
        snprintf(out, n, "%s/%s%zu", stack->name, word, i);
    else
        snprintf(out, n, "%s%zu", word, i);
}

/* "2 segments: liver, spleen" */
static void describe_layer(char *out, size_t n, const vvi_dicom_layers *l, size_t layer)
{
    size_t count = 0, at = 0;
    for (size_t s = 0; s < l->n_segments; s++)
        count += l->layer[s] == layer;
    at = (size_t)snprintf(out, n, "%zu %s%s", count, vvi_dicom_word(l->image), count == 1 ? "" : "s");
    for (size_t s = 0, k = 0; s < l->n_segments && at + 72 < n; s++) {
        if (l->layer[s] != layer)
            continue;
        const vv_label label = vvi_dicom_label_of(l, s);
        if (label.name[0])
            at += (size_t)snprintf(out + at, n - at, "%s%s", k++ ? ", " : ": ", label.name);
    }
}

static vv_status fail_part(const vvi_dicom_layers *l, const char *part, const char *first, const char *last)
{
    const char *word = vvi_dicom_word(l->image);
    if (strcmp(first, last) == 0)
        return vv_fail_at(VV_E_NOT_FOUND, l->name, NULL, "has no part '%.60s'; 'volvis info' lists its %ss", part,
                          word);
    return vv_fail_at(VV_E_NOT_FOUND, l->name, NULL,
                      "has no part '%.60s'; its %ss lie in %s to %s, and 'volvis info' lists their names", part, word,
                      first, last);
}

/* "segment2", or its name. */
static bool is_called(const vvi_dicom_layers *l, size_t segment, const char *part)
{
    char name[32];
    snprintf(name, sizeof name, "segment%u", (unsigned)l->number[segment]);
    return strcmp(part, name) == 0 || strcasecmp(part, vvi_dicom_label_of(l, segment).name) == 0;
}

/* The samples of a label map hold all segments, and none can be read alone. */
static bool find_alone(vvi_dicom_layers *l, const char *part)
{
    for (size_t s = 0; s < l->n_segments && vvi_dicom_segmentation_of(l->image) != VVI_DICOM_LABELMAP; s++)
        if (is_called(l, s, part)) {
            l->alone = s;
            return true;
        }
    return false;
}

vv_status vvi_dicom_choose_layer(size_t *out, vvi_dicom_layers *l, const vvi_dicom_stack *stack, const char *part)
{
    char name[128], about[256], first[128] = "", last[128] = "";
    vv_status st = VV_OK;
    bool found = !part;
    *out = 0;
    for (size_t i = 0; part && i < l->n_layers; i++) {
        snprintf(name, sizeof name, "layer%zu", i);
        if (strcmp(part, name) == 0) {
            *out = i;
            found = true;
        }
    }
    name_part(first, sizeof first, l, stack, "layer", 0);
    name_part(last, sizeof last, l, stack, "layer", l->n_layers - 1);
    if (!found && find_alone(l, part))
        *out = l->layer[l->alone];
    else if (!found)
        return fail_part(l, part, first, last);
    for (size_t i = 0; l->n_layers > 1 && i < l->n_layers && st == VV_OK; i++) {
        name_part(name, sizeof name, l, stack, "layer", i);
        describe_layer(about, sizeof about, l, i);
        st = vvi_notes_part(l->notes, name, about, i == *out && l->alone == SIZE_MAX);
    }
    if (st == VV_OK && l->alone != SIZE_MAX) {
        name_part(name, sizeof name, l, stack, "segment", l->number[l->alone]);
        st = vvi_notes_part(l->notes, name, vvi_dicom_label_of(l, l->alone).name, true);
    }
    if (st == VV_OK && !part && l->n_layers > 1)
        st = vvi_notes_warn(l->notes,
                            "its %ss overlap and lie in %zu layers; %s is read, FILE:%s and so on are the others",
                            vvi_dicom_word(l->image), l->n_layers, first, l->n_layers > 2 ? "layer1" : last);
    return st;
}

vv_status vvi_dicom_choose_segment(size_t *out, const vvi_dicom_layers *l, const vvi_dicom_stack *stack,
                                   const char *part)
{
    char name[128], first[128], last[128];
    vv_status st = VV_OK;
    size_t n = 0;
    *out = SIZE_MAX;
    for (size_t s = 0; s < l->n_segments; s++) {
        if (l->n_frames[s] == 0)
            continue;
        n++;
        if (*out == SIZE_MAX && (!part || is_called(l, s, part)))
            *out = s;
    }
    name_part(first, sizeof first, l, stack, "segment", l->number[0]);
    name_part(last, sizeof last, l, stack, "segment", l->number[l->n_segments - 1]);
    if (*out == SIZE_MAX)
        return fail_part(l, part ? part : "", first, last);
    for (size_t s = 0; n > 1 && s < l->n_segments && st == VV_OK; s++) {
        if (l->n_frames[s] == 0)
            continue;
        const vv_label label = vvi_dicom_label_of(l, s);
        name_part(name, sizeof name, l, stack, "segment", l->number[s]);
        st = vvi_notes_part(l->notes, name, label.name, s == *out);
    }
    if (st == VV_OK && !part && n > 1)
        st = vvi_notes_warn(l->notes,
                            "holds fractions of %zu segments; segment%u is read, FILE:%s and so on are the others", n,
                            (unsigned)l->number[*out], last);
    return st;
}
