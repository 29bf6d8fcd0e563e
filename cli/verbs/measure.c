#include "measure.h"
#include "core/status.h"
#include "measure_meshes.h"
#include "value.h"
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

typedef struct words {
    const char *kind, *file[2]; /* the second file, of distances between surfaces, is NULL mostly */
} words;

static vv_status fail_kind(const char *word)
{
    const char *near = vv_nearest_name(word, kinds, N_KINDS);
    return near ? vv_fail(VV_E_ARGUMENT, "measure: no '%s' can be measured; did you mean '%s'?", word, near)
                : vv_fail(VV_E_ARGUMENT,
                          "measure: no '%s' can be measured; area, volume, box, statistics, histogram, profile, "
                          "distance, angle and labels can",
                          word);
}

/* The first word, or the last, says what, unless a file has that name; the others are files. */
static vv_status split_words(words *out, const cli_command *command)
{
    const size_t n = command->args.n_words;
    const char *const first = cli_command_word(command, 0), *const last = cli_command_word(command, n - 1);
    const size_t from = kind_of(first) != NULL, end = n - (!from && n > 1 && kind_of(last));
    *out = (words){.kind = from ? first : end < n ? last : "summary"};
    for (size_t i = from; i < end && i - from < 2; i++)
        out->file[i - from] = cli_command_word(command, i);
    if (!out->file[0])
        return vv_fail(VV_E_ARGUMENT, "measure %s: of which file? as in 'volvis measure %s head.nrrd'", first, first);
    if (out->file[1] && strcmp(out->kind, "summary") == 0)
        return fail_kind(first);
    if (end - from > 1 && strcmp(out->kind, "distance") != 0)
        return vv_fail(VV_E_ARGUMENT, "measure %s takes one file, found '%s' as well", out->kind, out->file[1]);
    return VV_OK;
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

static vv_status measure_volume(cli_command *command, const words *w)
{
    cli_measuring m;
    vv_status st = VV_OK;
    if (w->file[1])
        return vv_fail(VV_E_ARGUMENT,
                       "distances between two files are those of meshes, and %s is none: --point names "
                       "places of a volume",
                       w->file[0]);
    if ((st = cli_measuring_open(&m, command, w->file[0])) == VV_OK) {
        cli_json_string(&command->json, "region", m.region);
        st = measure(&m, w->kind);
    }
    cli_measuring_close(&m);
    return st;
}

static vv_status from_point(cli_command *command, const char *file, bool csv)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    double p[3];
    if (!o->point || o->point->n != 1)
        return vv_fail(VV_E_ARGUMENT, "distance of %s to what? give --point X,Y,Z once, or another mesh", file);
    if (cli_value_numbers(p, 3, cli_word_nth(o->point, 0), false) != VV_OK)
        return vv_fail_in(VV_E_ARGUMENT, "--point");
    return cli_measure_mesh_point(command, file, (vv_vec3){p[0], p[1], p[2]}, csv);
}

static vv_status measure_mesh(cli_command *command, const words *w, bool csv)
{
    static const char *const of_meshes[] = {"summary", "area", "volume", "box"};
    for (int i = 0; i < 4; i++)
        if (strcmp(w->kind, of_meshes[i]) == 0)
            return cli_measure_mesh(command, w->kind, w->file[0], csv);
    if (strcmp(w->kind, "distance") == 0 && !w->file[1])
        return from_point(command, w->file[0], csv);
    if (strcmp(w->kind, "distance") == 0 && w->file[1] && cli_is_mesh(command, w->file[1]))
        return cli_measure_mesh_distance(command, w->file[0], w->file[1], csv);
    return vv_fail(VV_E_ARGUMENT, "%s is a mesh, which has area, volume and box, and a distance to another mesh; no %s",
                   w->file[0], w->kind);
}

static vv_status run(cli_command *command)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    words w;
    vv_status st = split_words(&w, command);
    if (st != VV_OK || (st = cli_measure_output(command, w.kind)) != VV_OK ||
        (st = cli_measure_check(command, w.kind, w.file[0], w.file[1])) != VV_OK ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    cli_json_string(&command->json, "measured", w.kind);
    cli_json_string(&command->json, "file", w.file[0]);
    if (command->common->dry_run)
        return cli_measure_plan(command, w.kind, w.file[0], w.file[1]);
    if (o->csv && has_figures(w.kind))
        vvi_text_add(&command->text, "quantity,value,error,unit\n");
    else if (!o->csv)
        vvi_text_printf(&command->text, "%s%s%s\n", w.file[0], w.file[1] ? ", " : "", w.file[1] ? w.file[1] : "");
    return cli_is_mesh(command, w.file[0]) ? measure_mesh(command, &w, o->csv) : measure_volume(command, &w);
}

static const char *const examples[] = {
    "volvis measure head.nrrd",
    "volvis measure area head.nrrd --iso 90 --seed 32,32,32",
    "volvis measure volume head.nrrd --threshold 90,200 --method count --json",
    "volvis measure volume head.nrrd --iso 90 --clip x:10mm..40mm --box :,:,8:40",
    "volvis measure histogram head.nrrd --bins 64 --csv -o histogram.csv",
    "volvis measure histogram head.nrrd --log -o histogram.svg",
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
        "Of mesh files there are area, volume, box, and the distance to another mesh (least, mean and "
        "Hausdorff) or to a --point in its space.\n"
        "Areas leave out where the object is cut off, by the volume's border, a box or a plane; --closed adds that.",
    .words = "[WHAT] INPUT [MESH]",
    .choices = "files",
    .min_words = 1,
    .max_words = 3,
    .options = {&cli_measure_class, &cli_reading_class},
    .examples = examples,
    .run = run,
};
