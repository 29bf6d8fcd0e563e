/* ParaView's collections: a list of files with the time of each. */
#include "core/job.h"
#include "core/memory.h"
#include "core/units.h"
#include "io/formats/steps/steps.h"
#include "io/xml.h"
#include "registry.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int probe(const uint8_t *head, size_t n, const char *path)
{
    (void)path;
    return memmem(head, n, "<VTKFile", 8) && memmem(head, n, "Collection", 10) ? 2 : 0;
}

typedef struct reading {
    vvi_steps *steps;
    const char *name;
    vv_job *job;
} reading;

static vv_status fail_set(const reading *r, const vvi_xml *xml, const char *text)
{
    char line[32];
    snprintf(line, sizeof line, "%lu", vvi_xml_line(xml));
    return vv_fail_at(VV_E_FORMAT, r->name, line, "%s", text);
}

static vv_status on_open(void *user, vvi_xml *xml, const char *name, const char *const *attributes)
{
    reading *r = user;
    const char *file = vvi_xml_attribute(attributes, "file"), *time = vvi_xml_attribute(attributes, "timestep");
    vvi_steps_file one = {.number = r->steps->n, .timed = true};
    if (strcmp(name, "DataSet") != 0)
        return VV_OK;
    if (r->steps->n >= vvi_job_limits(r->job)->files)
        return fail_set(r, xml, "it names more files than a collection may have; --limit files=N allows more");
    if (!file || !*file)
        return fail_set(r, xml, "DataSet has no 'file'");
    if (time && (!vvi_parse_number(&one.time, time) || !isfinite(one.time)))
        return fail_set(r, xml, "the 'timestep' of DataSet is no number");
    return vvi_steps_add(r->steps, file, &one, r->job);
}

static int by_time(const void *a, const void *b)
{
    const vvi_steps_file *x = a, *y = b;
    return x->time != y->time ? (x->time > y->time) - (x->time < y->time)
                              : (x->number > y->number) - (x->number < y->number);
}

/* By their times, in whatever order the collection lists them. */
static vv_status sort_steps(vvi_steps *steps, const char *name)
{
    vvi_steps_file *const f = steps->file;
    qsort(f, steps->n, sizeof *f, by_time);
    for (size_t i = 0; i < steps->n; i++) {
        if (i && f[i - 1].time == f[i].time)
            return vv_fail_at(VV_E_UNSUPPORTED, name, NULL,
                              "has several files, '%.80s' and '%.80s', for the time step %g; one volume can be shown "
                              "at a time: open a file by itself",
                              f[i - 1].name, f[i].name, f[i].time);
        f[i].number = i;
    }
    return VV_OK;
}

static vv_status read_list(vvi_steps *steps, vv_source *source, vv_job *job)
{
    static const vvi_xml_events events = {.open = on_open};
    reading r = {steps, vvi_source_name(source), job};
    bool cut = false;
    const vv_status st = vvi_xml_parse(&cut, source, &events, &r, job);
    if (st != VV_OK)
        return st;
    if (cut)
        return vv_fail_at(VV_E_FORMAT, r.name, NULL, "is cut short; get a whole copy");
    if (steps->n == 0)
        return vv_fail_at(VV_E_FORMAT, r.name, NULL, "is a collection without files");
    return sort_steps(steps, r.name);
}

static vv_status read_header(vv_field_info *info, void **plan_out, vv_source *source, const vv_read_options *options,
                             vv_notes *notes, vv_job *job)
{
    vvi_steps *steps = NULL;
    *plan_out = NULL;
    vv_status st = vvi_steps_new(&steps, options, options->part, job);
    if (st == VV_OK && !(steps->key = vvi_strdup("collection")))
        st = vv_fail_memory(1);
    if (st == VV_OK && (st = read_list(steps, source, job)) == VV_OK)
        st = vvi_steps_open(info, steps, source, notes, job);
    if (st != VV_OK) {
        vvi_steps_free(steps);
        return st;
    }
    *plan_out = steps;
    return VV_OK;
}

static const char *const suffixes[] = {".pvd", NULL};

const vv_format vvi_format_pvd = {
    .api = VV_FORMAT_API,
    .name = "pvd",
    .doc = "ParaView's collections: files of image data, or of any format, with the time of each",
    .suffixes = suffixes,
    .probe = probe,
    .read_header = read_header,
    .free_plan = vvi_steps_free,
    .read = vvi_steps_read,
    .mappable = vvi_steps_mappable,
    .beside = true,
};
