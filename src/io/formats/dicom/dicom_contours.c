/* The contours of a structure set: their points, and what is said of each region of interest. */
#include "io/formats/dicom/dicom_contours.h"
#include "core/memory.h"
#include "io/notes.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CONTOURS_MOST ((size_t)1 << 20)
#define FAR_MM 1e6 /* no body reaches so far */

/* Why a contour is not drawn. */
typedef enum fault { OPEN, ODD, FEW, NO_NUMBERS, FAR, FAULTS } fault;
static const char *const faults[FAULTS] = {
    [OPEN] = "not closed (points, or open lines)",
    [ODD] = "with a number of coordinates that is not a multiple of 3",
    [FEW] = "with fewer than 3 points",
    [NO_NUMBERS] = "with coordinates that are not numbers",
    [FAR] = "a kilometre or more away",
};

typedef struct by_number {
    double number;
    size_t index;
} by_number;

typedef struct reading {
    vvi_dicom_image *image;
    vvi_dicom_structures *to;
    size_t room;
    by_number *roi; /* sorted */
    vv_job *job;
    /* an item of contours */
    int64_t item; /* -1: none yet */
    double number, rgb[3];
    size_t first; /* of its contours that are kept */
    uint32_t n_contours[VVI_DICOM_OUTLINES];
    size_t n_faults[FAULTS];
    /* a contour */
    bool inside;
    uint64_t contour;
    char outline[20];
    double *points, n_said;
    size_t n_points;
    /* an item of observations */
    int64_t observation; /* -1: none yet */
    double observed;
    char kind[20];
    vv_code code;
    /* of all */
    size_t n_left_out[FAULTS], first_with[FAULTS], n_homeless, n_miscounted;
} reading;

void vvi_dicom_structures_free(vvi_dicom_structures *s)
{
    if (!s)
        return;
    for (size_t i = 0; i < s->n_contours; i++)
        vvi_free(s->contour[i].at);
    vvi_free(s->contour);
    vvi_free(s->frame);
    vvi_free(s);
}

/* Regions by number ----------------------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b)
{
    const by_number *p = a, *q = b;
    if (isnan(p->number) || isnan(q->number))
        return isnan(p->number) - isnan(q->number);
    if (p->number != q->number)
        return p->number < q->number ? -1 : 1;
    return (p->index > q->index) - (p->index < q->index);
}

static vv_status sort_regions(reading *r)
{
    const size_t n = r->image->n_segments, bytes = (n + 1) * sizeof *r->roi;
    r->roi = vvi_alloc(r->job, bytes, VVI_MEM_SCRATCH);
    if (!r->roi)
        return vv_fail_memory(bytes);
    for (size_t i = 0; i < n; i++)
        r->roi[i] = (by_number){r->image->segment[i].number, i};
    qsort(r->roi, n, sizeof *r->roi, compare);
    return VV_OK;
}

/* The first of that number; NULL: none has it. */
static vvi_dicom_segment *region_of(const reading *r, double number)
{
    size_t lo = 0, hi = r->image->n_segments;
    while (lo < hi) {
        const size_t middle = (lo + hi) / 2;
        if (r->roi[middle].number < number)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo < r->image->n_segments && r->roi[lo].number == number ? &r->image->segment[r->roi[lo].index] : NULL;
}

/* Labels are numbers of 16 bits. Regions of other numbers have their order as theirs. */
static vv_status number_regions(const reading *r, vv_notes *notes)
{
    vvi_dicom_image *image = r->image;
    bool fit = true;
    size_t again = SIZE_MAX;
    for (size_t i = 0; i < image->n_segments; i++) {
        const double number = r->roi[i].number;
        fit = fit && number >= 1 && number <= 65535 && number == floor(number);
        if (again == SIZE_MAX && i > 0 && number == r->roi[i - 1].number)
            again = i;
    }
    vv_status st = VV_OK;
    if (again != SIZE_MAX)
        st = vvi_notes_warn(notes,
                            "has more than one ROI with number %g; all contours of that number belong to the first",
                            r->roi[again].number);
    if (fit || st != VV_OK)
        return st;
    for (size_t i = 0; i < image->n_segments; i++)
        image->segment[i].number = (double)(i + 1);
    return vvi_notes_warn(
        notes,
        "the numbers of its ROIs are not all from 1 to 65535, as labels are: labels are the order of the ROIs, from 1");
}

/* Contours -------------------------------------------------------------------------------------------------------- */

static size_t outline_of(const char *name)
{
    size_t i = 0;
    while (i + 1 < VVI_DICOM_OUTLINES && strcmp(vvi_dicom_outlines[i], name) != 0)
        i++;
    return i;
}

static fault fault_of(const reading *r, size_t outline)
{
    bool numbers = true, near = true;
    if (outline >= VVI_DICOM_CLOSED)
        return OPEN;
    if (r->n_points % 3 != 0)
        return ODD;
    if (r->n_points < 9)
        return FEW;
    for (size_t i = 0; i < r->n_points; i++) {
        numbers = numbers && !isnan(r->points[i]);
        near = near && !(fabs(r->points[i]) > FAR_MM);
    }
    return !numbers ? NO_NUMBERS : !near ? FAR : FAULTS;
}

/* Takes the points, from LPS to RAS. */
static vv_status keep_contour(reading *r)
{
    vvi_dicom_structures *to = r->to;
    if (to->n_contours >= CONTOURS_MOST)
        return vv_fail(VV_E_LIMIT, "has more than %zu contours", CONTOURS_MOST);
    if (to->n_contours == r->room) {
        const size_t room = r->room ? 2 * r->room : 64;
        void *grown = vvi_realloc(r->job, to->contour, room * sizeof *to->contour, VVI_MEM_MODEL);
        if (!grown)
            return vv_fail_memory(room * sizeof *to->contour);
        to->contour = grown;
        r->room = room;
    }
    for (size_t i = 0; i < r->n_points; i++)
        if (i % 3 != 2)
            r->points[i] = -r->points[i];
    to->contour[to->n_contours] =
        (vvi_dicom_contour){.at = r->points, .n_points = r->n_points / 3, .number = to->n_contours};
    to->n_contours++;
    r->points = NULL;
    return VV_OK;
}

static vv_status end_contour(reading *r)
{
    if (!r->inside)
        return VV_OK;
    const size_t outline = outline_of(r->outline);
    const fault wrong = fault_of(r, outline);
    vv_status st = VV_OK;
    r->n_contours[outline]++;
    const size_t n_places = r->n_points / 3;
    r->n_miscounted += !isnan(r->n_said) && r->n_points % 3 == 0 && r->n_said != (double)n_places;
    if (wrong == FAULTS)
        st = keep_contour(r);
    else
        r->n_faults[wrong]++;
    vvi_free(r->points);
    r->points = NULL;
    r->n_points = 0;
    r->n_said = NAN;
    r->outline[0] = 0;
    r->inside = false;
    return st;
}

/* The number of the region stands behind its contours. */
static vv_status end_item(reading *r)
{
    vv_status st = end_contour(r);
    vvi_dicom_segment *region = r->item >= 0 ? region_of(r, r->number) : NULL;
    if (st != VV_OK || r->item < 0)
        return st;
    for (size_t i = r->first; i < r->to->n_contours; i++) {
        if (region)
            r->to->contour[i].roi = (size_t)(region - r->image->segment);
        else
            vvi_free(r->to->contour[i].at);
    }
    if (!region) {
        for (size_t o = 0; o < VVI_DICOM_OUTLINES; o++)
            r->n_homeless += r->n_contours[o];
        r->to->n_contours = r->first;
        return VV_OK;
    }
    if (!isnan(r->rgb[0] + r->rgb[1] + r->rgb[2]))
        memcpy(region->rgb, r->rgb, sizeof region->rgb);
    for (size_t o = 0; o < VVI_DICOM_OUTLINES; o++)
        region->n_contours[o] += r->n_contours[o];
    for (int f = 0; f < FAULTS; f++) {
        if (r->n_left_out[f] == 0)
            r->first_with[f] = (size_t)(region - r->image->segment);
        r->n_left_out[f] += r->n_faults[f];
    }
    return VV_OK;
}

static vv_status begin_item(reading *r, int64_t item)
{
    const vv_status st = end_item(r);
    r->item = item;
    r->number = r->rgb[0] = r->rgb[1] = r->rgb[2] = NAN;
    r->first = r->to->n_contours;
    memset(r->n_contours, 0, sizeof r->n_contours);
    memset(r->n_faults, 0, sizeof r->n_faults);
    return st;
}

static vv_status contour_element(reading *r, vvi_dicom_stream *s, const vvi_dicom_element *e)
{
    vv_status st = r->inside && r->contour != e->item ? end_contour(r) : VV_OK;
    if (st != VV_OK)
        return st;
    r->inside = true;
    r->contour = e->item;
    switch (e->tag) {
    case 0x30060042:
        return vvi_dicom_value(s, e, r->outline, sizeof r->outline);
    case 0x30060044:
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('D', 'S'), &r->to->thickness, 1);
    case 0x30060046:
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('I', 'S'), &r->n_said, 1);
    case 0x30060050:
        return r->points ? VV_OK : vvi_dicom_list(&r->points, &r->n_points, s, e);
    default:
        return VV_OK;
    }
}

/* Observations ---------------------------------------------------------------------------------------------------- */

static void end_observation(reading *r)
{
    vvi_dicom_segment *region = r->observation >= 0 ? region_of(r, r->observed) : NULL;
    if (region && r->kind[0])
        snprintf(region->kind, sizeof region->kind, "%s", r->kind);
    if (region && (r->code.value[0] || r->code.meaning[0]))
        region->code[VV_LABEL_TYPE] = r->code;
    r->observed = NAN;
    r->kind[0] = 0;
    r->code = (vv_code){0};
}

static vv_status observation_element(reading *r, vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where,
                                     int64_t item)
{
    if (item != r->observation)
        end_observation(r);
    r->observation = item;
    if (where == VVI_DICOM_OBSERVATION_CODE)
        return vvi_dicom_code_element(&r->code, s, e);
    if (e->tag == 0x30060084)
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('I', 'S'), &r->observed, 1);
    return e->tag == 0x300600a4 ? vvi_dicom_value(s, e, r->kind, sizeof r->kind) : VV_OK;
}

static vv_status visit(void *user, vvi_dicom_stream *s, const vvi_dicom_element *e, vvi_dicom_where where, int64_t item)
{
    reading *r = user;
    vv_status st = VV_OK;
    if (where == VVI_DICOM_OBSERVATION || where == VVI_DICOM_OBSERVATION_CODE)
        return observation_element(r, s, e, where, item);
    if (where != VVI_DICOM_IN_ROI_CONTOURS && where != VVI_DICOM_CONTOUR)
        return VV_OK;
    if (item != r->item && (st = begin_item(r, item)) != VV_OK)
        return st;
    if (where == VVI_DICOM_CONTOUR)
        return contour_element(r, s, e);
    if (e->tag == 0x3006002a)
        return vvi_dicom_numbers(s, e, VVI_DICOM_VR('I', 'S'), r->rgb, 3);
    return e->tag == 0x30060084 ? vvi_dicom_numbers(s, e, VVI_DICOM_VR('I', 'S'), &r->number, 1) : VV_OK;
}

/* All ------------------------------------------------------------------------------------------------------------- */

static vv_status walk(reading *r, vv_source *source)
{
    vvi_dicom_file file;
    vvi_dicom_stream s = {0};
    vvi_dicom_image again = {0};
    vvi_dicom_element pixels;
    vv_status st = vvi_dicom_open(&file, r->image, source, r->job);
    if (st != VV_OK)
        return st;
    st = vvi_dicom_stream_init(&s, file.source, r->job);
    if (st == VV_OK && !r->image->deflated)
        st = vvi_dicom_begin(&s, &again);
    s.contours = true;
    if (st == VV_OK)
        st = vvi_dicom_walk(&s, &pixels, visit, r);
    if (st == VV_OK)
        st = end_item(r);
    end_observation(r);
    vvi_dicom_stream_finish(&s);
    vvi_dicom_close(&file);
    vvi_free(r->points);
    return st == VV_E_LIMIT ? vv_fail_in(st, "%s", vvi_source_name(source)) : st;
}

static vv_status tell_left_out(const reading *r, vv_notes *notes)
{
    vv_status st = VV_OK;
    for (int f = 0; f < FAULTS && st == VV_OK; f++) {
        const size_t n = r->n_left_out[f];
        const vvi_dicom_segment *region = n > 0 ? &r->image->segment[r->first_with[f]] : NULL;
        if (region)
            st = vvi_notes_warn(notes, "%zu contour%s, first of ROI %.0f (%s), %s %s: left out", n, n > 1 ? "s" : "",
                                region->number, region->label, n > 1 ? "are" : "is", faults[f]);
    }
    if (st == VV_OK && r->n_homeless > 0)
        st = vvi_notes_warn(notes, "%zu contours belong to ROIs that the file does not describe: left out",
                            r->n_homeless);
    if (st == VV_OK && r->n_miscounted > 0)
        st = vvi_notes_warn(notes,
                            "%zu contours have a number of points other than they state; all that are there are used",
                            r->n_miscounted);
    return st;
}

vv_status vvi_dicom_contours_read(vvi_dicom_image *image, vv_source *source, vv_notes *notes, vv_job *job)
{
    reading r = {.image = image, .job = job, .item = -1, .observation = -1, .observed = NAN, .n_said = NAN};
    r.to = vvi_alloc_zeroed(job, sizeof *r.to, VVI_MEM_MODEL);
    vv_status st = r.to ? sort_regions(&r) : vv_fail_memory(sizeof *r.to);
    if (st == VV_OK)
        st = walk(&r, source);
    if (st == VV_OK)
        st = number_regions(&r, notes);
    if (st == VV_OK)
        st = tell_left_out(&r, notes);
    vvi_free(r.roi);
    image->structures = r.to; /* which goes with the image, whatever happened */
    return st;
}
