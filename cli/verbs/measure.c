#include "measure.h"
#include "core/status.h"
#include "verbs.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const char *const kinds[] = {"area",    "volume",   "box",   "statistics", "histogram",
                                    "profile", "distance", "angle", "labels",     "summary"};
enum { N_KINDS = sizeof kinds / sizeof *kinds };

static const char *kind_of(const char *word)
{
    for (size_t i = 0; i < N_KINDS; i++)
        if (strcmp(word, kinds[i]) == 0 && access(word, F_OK) != 0)
            return kinds[i];
    return NULL;
}

/* One word says what, unless a file has that name; the other is the file. */
static vv_status split_words(const char **kind, const char **file, const cli_command *command)
{
    const char *const a = cli_command_word(command, 0), *const b = cli_command_word(command, 1);
    *kind = kind_of(a) ? kind_of(a) : b ? kind_of(b) : "summary";
    *file = !b || !kind_of(a) ? a : b;
    if (!b && kind_of(a))
        return vv_fail(VV_E_ARGUMENT, "measure %s: of which file? as in 'volvis measure %s head.nrrd'", a, a);
    if (*kind)
        return VV_OK;
    const char *near = vv_nearest_name(a, kinds, N_KINDS);
    return near ? vv_fail(VV_E_ARGUMENT, "measure: no '%s' can be measured; did you mean '%s'?", a, near)
                : vv_fail(VV_E_ARGUMENT,
                          "measure: no '%s' can be measured; area, volume, box, statistics, histogram, "
                          "profile, distance, angle and labels can",
                          a);
}

static vv_status summary(cli_measuring *m)
{
    const vv_status st = cli_measure_values(m, false);
    if (st != VV_OK || vv_field_get_info(m->field)->grid.dims[0] < 2 || vv_field_get_info(m->field)->grid.dims[1] < 2 ||
        vv_field_get_info(m->field)->grid.dims[2] < 2)
        return st;
    return cli_measure_object(m, "summary");
}

static vv_status measure(cli_measuring *m, const char *kind)
{
    static const char *const of_object[] = {"area", "volume", "box"};
    for (int i = 0; i < 3; i++)
        if (strcmp(kind, of_object[i]) == 0)
            return cli_measure_object(m, kind);
    if (strcmp(kind, "statistics") == 0 || strcmp(kind, "histogram") == 0)
        return cli_measure_values(m, kind[0] == 'h');
    if (strcmp(kind, "profile") == 0)
        return cli_measure_profile(m);
    if (strcmp(kind, "distance") == 0 || strcmp(kind, "angle") == 0)
        return cli_measure_points(m, kind[0] == 'a');
    if (strcmp(kind, "labels") == 0)
        return cli_measure_labels(m);
    return summary(m);
}

static bool has_figures(const char *kind)
{
    return strcmp(kind, "histogram") != 0 && strcmp(kind, "profile") != 0 && strcmp(kind, "labels") != 0;
}

static vv_status run(cli_command *command)
{
    const char *kind, *file;
    cli_measuring m;
    vv_status st = split_words(&kind, &file, command);
    if (st != VV_OK || (st = cli_command_start(command)) != VV_OK)
        return st;
    if ((st = cli_measuring_open(&m, command, file)) == VV_OK) {
        cli_json_string(&command->json, "measured", kind);
        cli_json_string(&command->json, "file", m.input.path);
        if (m.o->csv && has_figures(kind))
            vvi_text_add(&command->text, "quantity,value,error,unit\n");
        else if (!m.o->csv)
            vvi_text_printf(&command->text, "%s\n", m.input.path);
        st = measure(&m, kind);
    }
    cli_measuring_close(&m);
    return st;
}

static const char *const examples[] = {
    "volvis measure head.nrrd",
    "volvis measure area head.nrrd --iso 90 --seed 32,32,32",
    "volvis measure volume head.nrrd --threshold 90,200 --method count --json",
    "volvis measure volume head.nrrd --iso 90 --clip x:10mm..40mm --box :,:,8:40",
    "volvis measure histogram head.nrrd --bins 64 --csv -o histogram.csv",
    "volvis measure statistics head.nrrd --iso 90",
    "volvis measure profile head.nrrd --point 0,32,32 --point 63,32,32 --samples 64",
    "volvis measure distance head.nrrd --point 0,32,32 --point 63,32,32",
    "volvis measure labels head.nrrd --values head.nrrd --csv",
    NULL,
};

const cli_verb cli_verb_measure = {
    .name = "measure",
    .doc = "area, volume, histogram, statistics, distances, angles, profiles, labels",
    .about =
        "WHAT is area, volume, box (with the centroid), statistics, histogram, profile, distance, angle, labels, or "
        "nothing: then statistics, area and volume. The object is what has the values that --iso or --threshold say, a "
        "label, or a mask; where nothing says it, what lies above the value that best splits the histogram in two, and "
        "the result names it. Every figure comes with its unit and, after \xc2\xb1, its standard error.\n"
        "Areas leave out where the object is cut off, by the volume's border, a box or a plane; --closed adds that.",
    .words = "[WHAT] INPUT",
    .choices = "files",
    .min_words = 1,
    .max_words = 2,
    .options = {&cli_measure_class, &cli_reading_class},
    .examples = examples,
    .run = run,
};
