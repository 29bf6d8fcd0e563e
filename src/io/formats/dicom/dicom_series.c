/* A folder's images: looked at in parallel, sorted into stacks that can be one volume each, one of them chosen. */
#include "config.h"
#include "core/job.h"
#include "core/memory.h"
#include "io/formats/dicom/dicom.h"
#include "io/notes.h"
#include "io/scan.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define STACKS_MOST 1000

/* The files ------------------------------------------------------------------------------------------------------ */

typedef struct looking {
    vvi_dicom_plan *plan;
    vv_source *folder;
    vv_job *job;
} looking;

/* Whether it may be DICOM at all, by its first bytes. */
static vv_status look_at_head(vvi_dicom_image *image, vv_source *source, vv_job *job)
{
    vvi_dicom_stream s;
    uint8_t head[1024];
    size_t n = 0;
    vv_status st = vvi_dicom_stream_init(&s, source, job);
    if (st == VV_OK)
        st = vvi_dicom_bytes(&s, 0, head, sizeof head, &n);
    vvi_dicom_stream_finish(&s);
    image->foreign = vvi_dicom_probe(head, n) == 0;
    return st;
}

/* A damaged file is left out and noted; a want of memory, or cancel, ends the whole. */
static vv_status look_at(looking *l, vvi_dicom_image *image)
{
    vv_source *source;
    /* without the job: files that are only looked at may be written to */
    vv_status st = vvi_source_open_beside(&source, l->folder, image->name, NULL);
    if (st == VV_OK) {
        vvi_source_use_job(source, l->job);
        st = look_at_head(image, source, l->job);
        if (st == VV_OK && !image->foreign)
            st = vvi_dicom_image_read(image, source, l->job);
        vvi_source_close(source);
    }
    if (st == VV_OK || st == VV_E_MEMORY || st == VV_E_LIMIT || st == VV_E_CANCELLED)
        return st;
    image->problem = vvi_strdup(vv_error_last()->message);
    return image->problem ? VV_OK : vv_fail_memory(strlen(vv_error_last()->message) + 1);
}

static vv_status look_at_item(void *scratch, void *shared, size_t index)
{
    looking *l = shared;
    return look_at(l, &l->plan->image[index]);
}

static vv_status note_skipped(const vvi_dicom_plan *plan, vv_notes *notes)
{
    size_t n_foreign = 0, n_damaged = 0, foreign = 0, damaged = 0;
    for (size_t i = plan->n_images; i-- > 0;) {
        if (plan->image[i].foreign) {
            foreign = i;
            n_foreign++;
        } else if (plan->image[i].problem) {
            damaged = i;
            n_damaged++;
        }
    }
    char text[256];
    vv_status st = VV_OK;
    if (n_foreign > 0) {
        snprintf(text, sizeof text, "%zu (%.120s%s)", n_foreign, plan->image[foreign].name,
                 n_foreign > 1 ? ", ..." : "");
        st = vvi_notes_add(notes, "files that are not DICOM", text);
    }
    if (st == VV_OK && n_damaged > 0)
        st = vvi_notes_warn(notes, "%zu file%s ignored: %.300s", n_damaged, n_damaged > 1 ? "s are" : " is",
                            plan->image[damaged].problem);
    return st;
}

vv_status vvi_dicom_gather(vvi_dicom_plan *plan, vv_source *folder, bool deep, vv_notes *notes, vv_job *job)
{
    looking l = {plan, folder, job};
    const vvi_work work = {.stage = "look", .item = look_at_item};
    vv_status st = vvi_source_list(&plan->names, folder, NULL, deep, job);
    if (st != VV_OK)
        return st;
    if (plan->names.n > 0) {
        plan->image = vvi_alloc_zeroed(job, plan->names.n * sizeof *plan->image, VVI_MEM_MODEL);
        if (!plan->image)
            return vv_fail_memory(plan->names.n * sizeof *plan->image);
    }
    plan->n_images = plan->names.n;
    for (size_t i = 0; i < plan->n_images; i++)
        plan->image[i].name = plan->names.name[i];
    st = vvi_parallel_for(job, &work, &l, plan->n_images);
    return st == VV_OK ? note_skipped(plan, notes) : st;
}

/* Stacks --------------------------------------------------------------------------------------------------------- */

/* Whether numbers agree, or none of both is there. */
static bool near(const double *a, const double *b, size_t n, double tolerance)
{
    for (size_t i = 0; i < n; i++)
        if (isnan(a[i]) != isnan(b[i]) || fabs(a[i] - b[i]) > tolerance)
            return false;
    return true;
}

/* Whether two frames can lie in one volume. */
static bool fit_together(const vvi_dicom_image *a, int64_t fa, const vvi_dicom_image *b, int64_t fb)
{
    const vvi_dicom_values *p = vvi_dicom_frame_values(a, fa), *q = vvi_dicom_frame_values(b, fb);
    const bool segments = vvi_dicom_segmentation_of(a) || vvi_dicom_segmentation_of(b);
    return (a == b || !segments) && a->number[VVI_DICOM_ROWS] == b->number[VVI_DICOM_ROWS] &&
           a->number[VVI_DICOM_COLUMNS] == b->number[VVI_DICOM_COLUMNS] && a->type == b->type &&
           a->components == b->components && isnan(p->position[0]) == isnan(q->position[0]) &&
           near(p->row, q->row, 3, 2e-3) && near(p->column, q->column, 3, 2e-3) &&
           near(p->spacing, q->spacing, 2, 1e-3 * fabs(p->spacing[0])) &&
           strcmp(a->text[VVI_DICOM_SERIES_UID], b->text[VVI_DICOM_SERIES_UID]) == 0;
}

static vv_status add_stack(vvi_dicom_plan *plan, const char *name, vv_job *job)
{
    if (plan->n_stacks >= STACKS_MOST)
        return vv_fail_at(VV_E_LIMIT, name, NULL,
                          "has more than %d series, or images in more than %d directions; name one of its folders",
                          STACKS_MOST, STACKS_MOST);
    if ((plan->n_stacks & (plan->n_stacks - 1)) == 0) {
        const size_t bytes = (plan->n_stacks ? plan->n_stacks * 2 : 1) * sizeof *plan->stack;
        void *grown = vvi_realloc(job, plan->stack, bytes, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(bytes);
        plan->stack = grown;
    }
    plan->stack[plan->n_stacks++] = (vvi_dicom_stack){0};
    return VV_OK;
}

static vv_status add_slice(vvi_dicom_stack *stack, vvi_dicom_slice slice, vv_job *job)
{
    if (stack->n == stack->room) {
        const size_t room = stack->room ? stack->room * 2 : 16;
        void *grown = vvi_realloc(job, stack->slice, room * sizeof slice, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(room * sizeof slice);
        stack->slice = grown;
        stack->room = room;
    }
    stack->slice[stack->n++] = slice;
    return VV_OK;
}

/* Neighbours mostly belong together: the last stack is asked first. */
static vv_status sort_frame(vvi_dicom_plan *plan, size_t *last, int32_t image, int32_t frame, const char *name,
                            vv_job *job)
{
    const vvi_dicom_image *images = plan->image;
    for (size_t i = 0; i <= plan->n_stacks; i++) {
        const size_t s = i == 0 ? *last : i - 1;
        if (s >= plan->n_stacks)
            continue;
        const vvi_dicom_slice *first = plan->stack[s].slice;
        if (fit_together(&images[first->image], first->frame, &images[image], frame)) {
            *last = s;
            return add_slice(&plan->stack[s], (vvi_dicom_slice){image, frame, 0}, job);
        }
    }
    vv_status st = add_stack(plan, name, job);
    if (st != VV_OK)
        return st;
    *last = plan->n_stacks - 1;
    return add_slice(&plan->stack[*last], (vvi_dicom_slice){image, frame, 0}, job);
}

static vv_status sort_frames(vvi_dicom_plan *plan, const char *name, vv_job *job)
{
    size_t last = 0;
    vv_status st = VV_OK;
    for (size_t i = 0; i < plan->n_images && st == VV_OK; i++) {
        const vvi_dicom_image *image = &plan->image[i];
        if (image->foreign || image->problem)
            continue;
        for (int64_t f = 0; f < image->n_frames && st == VV_OK; f++)
            st = sort_frame(plan, &last, (int32_t)i, (int32_t)f, name, job);
        if (st == VV_OK)
            st = vvi_job_poll(job);
    }
    return st;
}

static const vvi_dicom_image *image_of(const vvi_dicom_plan *plan, const vvi_dicom_stack *stack)
{
    return &plan->image[stack->slice[0].image];
}

/* Names: the series' number, with ".2", ".3" for further stacks of that number; "0" where there is none. */
static void name_stacks(vvi_dicom_plan *plan)
{
    for (size_t i = 0; i < plan->n_stacks; i++) {
        const double number = image_of(plan, &plan->stack[i])->number[VVI_DICOM_SERIES];
        int before = 1;
        for (size_t j = 0; j < i; j++) {
            const double other = image_of(plan, &plan->stack[j])->number[VVI_DICOM_SERIES];
            before += other == number || (isnan(other) && isnan(number));
        }
        char *name = plan->stack[i].name;
        const size_t n = sizeof plan->stack[i].name;
        const int at = snprintf(name, n, "%.0f", isnan(number) ? 0 : number);
        if (before > 1 && at > 0 && (size_t)at < n)
            snprintf(name + at, n - (size_t)at, ".%d", before);
    }
}

vv_status vvi_dicom_sort_images(vvi_dicom_plan *plan, const char *name, vv_job *job)
{
    const vv_status st = sort_frames(plan, name, job);
    if (st == VV_OK)
        name_stacks(plan);
    return st;
}

void vvi_dicom_describe(char *out, size_t n, const vvi_dicom_plan *plan, const vvi_dicom_stack *stack)
{
    const vvi_dicom_image *image = image_of(plan, stack);
    const char *word = image->text[VVI_DICOM_DESCRIPTION];
    if (vvi_dicom_is_structure_set(image)) {
        snprintf(out, n, "structure set of %zu ROIs%s%s", image->n_segments, word[0] ? ", " : "", word);
        return;
    }
    snprintf(out, n, "%zu image%s of %.0f x %.0f, %s%s%s%s%s", stack->n, stack->n > 1 ? "s" : "",
             image->number[VVI_DICOM_COLUMNS], image->number[VVI_DICOM_ROWS], vv_type_name(image->type),
             image->text[VVI_DICOM_MODALITY][0] ? ", " : "", image->text[VVI_DICOM_MODALITY], word[0] ? ", " : "",
             word);
}

/* Choice --------------------------------------------------------------------------------------------------------- */

static size_t n_samples(const vvi_dicom_plan *plan, const vvi_dicom_stack *stack)
{
    const vvi_dicom_image *image = image_of(plan, stack);
    return (size_t)(image->number[VVI_DICOM_ROWS] * image->number[VVI_DICOM_COLUMNS]) * stack->n;
}

static bool is_segmented(const vvi_dicom_plan *plan, size_t stack)
{
    return vvi_dicom_segmentation_of(image_of(plan, &plan->stack[stack])) != VVI_DICOM_NO_SEGMENTS;
}

/* The one with the most samples: scouts and single images beside a scan are what one seldom wants, and segmentations
 * beside what was segmented. Of equals there is none: it would be a guess, and a measurement of the wrong one. */
static bool find_largest(const vvi_dicom_plan *plan, size_t *out)
{
    size_t most = 0, n = 0;
    bool images = false;
    for (size_t i = 0; i < plan->n_stacks; i++)
        images = images || !is_segmented(plan, i);
    for (size_t i = 0; i < plan->n_stacks; i++) {
        if (images && is_segmented(plan, i))
            continue;
        const size_t samples = n_samples(plan, &plan->stack[i]);
        n = samples > most ? 1 : n + (samples == most);
        *out = samples > most ? i : *out;
        most = samples > most ? samples : most;
    }
    return n == 1;
}

static vv_status warn_of_others(const vvi_dicom_plan *plan, size_t chosen, bool largest, const char *name,
                                vv_notes *notes)
{
    char about[256], others[256] = "";
    vvi_dicom_describe(about, sizeof about, plan, &plan->stack[chosen]);
    for (size_t i = 0, n = 0; i < plan->n_stacks && n < sizeof others - 24; i++)
        if (i != chosen)
            n += (size_t)snprintf(others + n, sizeof others - n, "%s%.20s", n ? ", " : "", plan->stack[i].name);
    if (!largest)
        return vvi_notes_warn(notes,
                              "holds %zu series, and none is named; this is %s (%s), others are %.120s. Elsewhere one "
                              "must be named, as %s:%s",
                              plan->n_stacks, plan->stack[chosen].name, about, others, name, plan->stack[chosen].name);
    return vvi_notes_warn(notes, "holds %zu series; the largest is read, %s (%s); others are %.120s: name one as %s:%s",
                          plan->n_stacks, plan->stack[chosen].name, about, others, name,
                          plan->stack[chosen ? 0 : 1].name);
}

static vv_status fail_choice(const vvi_dicom_plan *plan, const char *part, const char *name)
{
    vvi_text list = {0};
    char about[256];
    for (size_t i = 0; i < plan->n_stacks && i < 40; i++) {
        vvi_dicom_describe(about, sizeof about, plan, &plan->stack[i]);
        vvi_text_printf(&list, "%s%s (%s)", i ? "; " : "", plan->stack[i].name, about);
    }
    if (plan->n_stacks > 40)
        vvi_text_printf(&list, "; and %zu more", plan->n_stacks - 40);
    const char *said = list.s && !list.bad ? list.s : "several";
    vv_status st;
    if (part)
        st = vv_fail_at(VV_E_ARGUMENT, name, NULL, "has no single series '%.80s'; there are: %s", part, said);
    else
        st = vv_fail_at(VV_E_ARGUMENT, name, NULL,
                        "holds %zu series; choose one by its number, description or UID, as in %s:%s: %s",
                        plan->n_stacks, name, plan->stack[0].name, said);
    vvi_text_free(&list);
    return st;
}

/* By name; else by description or UID when that means one of them. */
static bool find_stack(const vvi_dicom_plan *plan, size_t *out, const char *part)
{
    size_t n = 0;
    for (size_t i = 0; i < plan->n_stacks; i++)
        if (strcmp(plan->stack[i].name, part) == 0) {
            *out = i;
            return true;
        }
    for (size_t i = 0; i < plan->n_stacks; i++) {
        const vvi_dicom_image *image = image_of(plan, &plan->stack[i]);
        if (strcasecmp(image->text[VVI_DICOM_DESCRIPTION], part) == 0 ||
            strcmp(image->text[VVI_DICOM_SERIES_UID], part) == 0) {
            *out = i;
            n++;
        }
    }
    return n == 1;
}

/* "5", or "5/layer1" where 5 is a segmentation; of the only one "layer1" is enough. */
static bool find_part(const vvi_dicom_plan *plan, size_t *out, const char **layer_out, const char *part)
{
    char series[VVI_DICOM_TEXT_BYTES + 16];
    const char *slash = strrchr(part, '/');
    *layer_out = NULL;
    if (find_stack(plan, out, part))
        return true;
    *layer_out = slash ? slash + 1 : part;
    *out = 0;
    if (!slash)
        return plan->n_stacks == 1 && is_segmented(plan, 0);
    snprintf(series, sizeof series, "%.*s", (int)(slash - part < 80 ? slash - part : 80), part);
    return find_stack(plan, out, series) && is_segmented(plan, *out);
}

static vv_status note_parts(const vvi_dicom_plan *plan, size_t chosen, vv_notes *notes)
{
    char about[256];
    vv_status st = VV_OK;
    for (size_t i = 0; i < plan->n_stacks && st == VV_OK; i++) {
        vvi_dicom_describe(about, sizeof about, plan, &plan->stack[i]);
        st = vvi_notes_part(notes, plan->stack[i].name, about, i == chosen);
    }
    return st;
}

vv_status vvi_dicom_choose(vvi_dicom_plan *plan, size_t *chosen_out, const char **layer_out,
                           const vv_read_options *options, const char *name, vv_notes *notes, vv_job *job)
{
    const char *part = options->part;
    *chosen_out = 0;
    *layer_out = NULL;
    vv_status st = vvi_dicom_sort_images(plan, name, job);
    if (st != VV_OK)
        return st;
    if (plan->n_stacks == 0) {
        for (size_t i = 0; i < plan->n_images; i++)
            if (plan->image[i].problem)
                return vv_fail_at(VV_E_FORMAT, name, NULL, "holds no image that can be read: %s",
                                  plan->image[i].problem);
        return vv_fail_at(VV_E_FORMAT, name, NULL, "holds no DICOM image");
    }
    if (part && !find_part(plan, chosen_out, layer_out, part))
        return fail_choice(plan, part, name);
    if (!part && plan->n_stacks > 1) {
        const bool largest = find_largest(plan, chosen_out);
        if (!largest && !options->any_part)
            return fail_choice(plan, NULL, name);
        if ((st = warn_of_others(plan, *chosen_out, largest, name, notes)) != VV_OK)
            return st;
    }
    const bool named = part && !*layer_out; /* the only one may be named too */
    return plan->n_stacks > 1 || named ? note_parts(plan, *chosen_out, notes) : VV_OK;
}
