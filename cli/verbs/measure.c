#include "measure.h"
#include "core/status.h"
#include "model/classes.h"
#include "verbs.h"
#include <string.h>

enum { WORDS_MOST = 32 };

/* The question; of stored measurements their names. */
typedef struct words {
    cli_question ask;
    bool nothing; /* no kind was said */
    const char *names[WORDS_MOST];
    size_t n_names;
} words;

/* Whether a word says what. */
static bool is_kind(const char *word)
{
    return cli_measure_kind(word) || cli_measure_is_stored(word);
}

/* The first word, or the last, says what, unless a file has that name; the others are files. */
static vv_status split_words(words *out, const cli_command *command)
{
    const size_t n = command->args.n_words;
    const char *const first = cli_command_word(command, 0), *const last = cli_command_word(command, n - 1);
    const size_t from = is_kind(first), end = n - (!from && n > 1 && is_kind(last));
    const char *const what = from ? first : end < n ? last : NULL;
    cli_question *ask = &out->ask;
    *out = (words){.nothing = !what};
    /* names after a scene are of what it has stored */
    const bool stored =
        what ? cli_measure_is_stored(what) : n > 1 && cli_input_guess(command, first) == CLI_INPUT_SCENE;
    if (!stored)
        ask->kind = what ? cli_measure_kind(what) : cli_measure_default_kind();
    for (size_t i = from; i < end; i++) {
        if (i == from || (i == from + 1 && !stored))
            ask->file[i - from] = cli_command_word(command, i);
        else if (stored)
            out->names[out->n_names++] = cli_command_word(command, i);
    }
    ask->edited = ask->file[0];
    if (!ask->file[0])
        return vv_fail(VV_E_ARGUMENT, "measure %s: of which file? as in 'volvis measure %s %s'", first, first,
                       stored ? "study.vv.json" : "head.nrrd");
    if (stored)
        return VV_OK;
    if (ask->file[1] && out->nothing)
        return cli_measure_fail_kind(first);
    const size_t most = cli_measure_most_files(ask->kind);
    if (end - from > most)
        return vv_fail(VV_E_ARGUMENT, "measure %s takes only %s, but '%s' follows; omit it", ask->kind->name,
                       most > 1 ? "one file or two" : "one file", cli_command_word(command, end - 1));
    return VV_OK;
}

/* Options that say what is to be measured now. */
static bool asks(const cli_command *command)
{
    for (size_t i = 0; i < command->args.n_given; i++) {
        const cli_given *given = &command->args.given[i];
        if (given->cls == &vvi_measurement_class || given->cls == &vvi_measured_region_class ||
            (given->cls == &cli_measure_class && strcmp(given->row->name, "csv") != 0 &&
             strcmp(given->row->name, "update") != 0))
            return true;
    }
    return false;
}

static vv_status answer(cli_command *command, const cli_question *q)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    vv_measurement *asked = NULL;
    vv_answer *answer = NULL;
    for (int i = 0; !o->csv && i < 2 && q->file[i]; i++) {
        vvi_text_add(&command->text, i ? ", " : "");
        vvi_text_add_clean(&command->text, q->file[i]);
    }
    if (!o->csv)
        vvi_text_add(&command->text, "\n");
    vv_status st = cli_measure_ask(&answer, &asked, command, q);
    if (st == VV_OK) {
        cli_answer_print(command, answer, o->csv, o->log);
        st = cli_plot_write(command, answer, q->file[0], o->log);
    }
    if (st == VV_OK && o->store)
        st = cli_measure_store(command, q, asked);
    vv_answer_release(answer);
    vv_object_release(asked ? &asked->base : NULL);
    return st;
}

static vv_status run_words(cli_command *command, words *w)
{
    const cli_measure_options *o = cli_command_options(command, &cli_measure_class);
    cli_question *ask = &w->ask;
    const char *file = ask->file[0];
    vv_status st;
    if ((st = cli_measure_output(command, ask->kind)) != VV_OK || (st = cli_measure_check(command, ask)) != VV_OK ||
        (o->store && (st = cli_measure_store_check(command, file)) != VV_OK) ||
        (st = cli_command_start(command)) != VV_OK)
        return st;
    vvi_result_string(&command->json, "measured", ask->kind ? ask->kind->name : CLI_MEASURE_STORED);
    vvi_result_string(&command->json, "file", file);
    if (command->common->dry_run)
        return cli_measure_plan(command, ask);
    return ask->kind ? answer(command, ask) : cli_measure_stored(command, file, w->names, w->n_names);
}

static vv_status run(cli_command *command)
{
    words w;
    vv_status st = split_words(&w, command);
    if (st != VV_OK)
        return st;
    if (w.nothing && !asks(command) && cli_measure_has_stored(command, w.ask.file[0]))
        w.ask.kind = NULL;
    w.ask.typed = true;
    if ((st = cli_measure_take(&w.ask.asked, command, w.ask.kind)) == VV_OK)
        st = run_words(command, &w);
    vv_object_release(w.ask.asked ? &w.ask.asked->base : NULL);
    return st;
}

static const char *const examples[] = {
    "volvis measure head.nrrd",
    "volvis measure area head.nrrd --iso 90 --seed 32,32,32",
    "volvis measure volume head.nrrd --threshold 90..200 --method count --json",
    "volvis measure volume head.nrrd --iso 90 --clip x:10mm..40mm --box ..,..,8..39",
    "volvis measure histogram head.nrrd --bins 64 --csv -o histogram.csv",
    "volvis measure histogram head.nrrd --log -o histogram.svg",
    "volvis measure joint head.nrrd -o joint.png",
    "volvis measure statistics head.nrrd --iso 90",
    "volvis measure statistics head.nrrd --region ellipse --center 32,32,30 --size 24,16,0",
    "volvis measure volume head.nrrd --region ellipsoid --center 32,32,32 --size 40,30,20 --iso 90",
    "volvis measure profile head.nrrd --point 0,32,32 --point 63,32,32 --samples 64",
    "volvis measure distance head.nrrd --point 0,32,32 --point 63,32,32",
    "volvis measure distance head.nrrd --iso 90 --point 2,32,32",
    "volvis measure distance head.nrrd head.nrrd --iso 90 --other-iso 120",
    "volvis measure geodesic head.nrrd --iso 90 --point 2,32,32 --point 60,32,32",
    "volvis measure labels head.nrrd --values head.nrrd --csv",
    "volvis measure area head.nrrd --iso 90 --store study.vv.json:skull",
    NULL,
};

const cli_verb cli_verb_measure = {
    .name = "measure",
    .doc = "area, volume, histogram, statistics, distances, angles, profiles, labels",
    .about =
        "WHAT is area, volume, box (with the centroid), statistics, histogram, joint (of values and gradients), "
        "profile, distance, geodesic, angle, labels, or nothing: then statistics, area and volume. The object is "
        "given by --iso or --threshold, a label, or a mask; if none is given, it is the part above the value that "
        "best splits the histogram in two, or below it where larger values surround the object, and the result names "
        "that value. Every figure comes with its unit and, "
        "after \xc2\xb1, its error.\ndistance is the distance between two points, from one --point to a surface, "
        "or between two surfaces (smallest, mean and Hausdorff); geodesic is the path between two points along a "
        "surface. Surfaces are mesh files, or volumes at --iso. For mesh files area, volume and box can be "
        "measured too; points are in their own space. Meshes of scenes are measured as the "
        "scene places them.\nAreas do not include the faces where the object is cut off by the volume's border, a "
        "box or a plane; --closed adds them.\n--store stores the measurement and its results in a scene; WHAT "
        "stored, or just a scene that has measurements, repeats all of them, or those named after the scene, and "
        "reports changes: the exit code is then 6. --update stores the new figures, and what --set "
        "changed: the new place of a file, for example.",
    .world = true,
    .words = "[WHAT] INPUT [SURFACE | NAME...]",
    .choices = "measures",
    .files_too = true,
    .min_words = 1,
    .max_words = WORDS_MOST,
    .options = {&vvi_measurement_class, &vvi_measured_region_class, &cli_measure_class, &cli_reading_class},
    .own = &vvi_measurement_class,
    .examples = examples,
    .draws = "name a measurement that has a plot",
    .run = run,
};
