/* Options about volumes: which of them a value is for. */
#include "core/names.h"
#include "edits.h"
#include "input.h"
#include "refusal.h"
#include <stdio.h>
#include <string.h>

bool cli_edit_is_each(const cli_given *given)
{
    static const char *const names[] = {"tf", "range", "percentile", "threshold", "color", "opacity", "window"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (given->cls == &cli_look_class && strcmp(given->row->name, names[i]) == 0)
            return true;
    return false;
}

/* One value of an option, and the volumes [lo, hi) that it is for. */
typedef struct target {
    const char *typed;
    size_t lo, hi;
} target;

/* "act=hot": the volume's number and the value; false: no name stands in front. Nodes and files have their own "=". */
static bool named_target(target *out, const vv_collection *volumes, const char *text)
{
    const char *equals = strchr(text, '=');
    for (size_t i = 0; equals && i < volumes->n; i++) {
        const char *id = volumes->entry[i].id;
        if (strlen(id) == (size_t)(equals - text) && memcmp(id, text, strlen(id)) == 0) {
            *out = (target){equals + 1, i, i + 1};
            return true;
        }
    }
    return false;
}

/* A name of no volume in front of a value is a mistake: no value looks like it but that of a path. */
static vv_status check_name(const cli_command *command, const char *option, const vv_collection *volumes,
                            const char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    const size_t n = strspn(text, letters);
    char typed[64];
    const char *names[64];
    size_t n_names = 0;
    if (n == 0 || text[n] != '=' || n >= sizeof typed)
        return VV_OK;
    snprintf(typed, sizeof typed, "%.*s", (int)n, text);
    for (; n_names < volumes->n && n_names < 64; n_names++)
        names[n_names] = volumes->entry[n_names].id;
    return cli_refused(command, option,
                       vvi_fail_name(VV_E_NOT_FOUND, NULL, NULL, typed,
                                     &(vvi_known){names, n_names, "volvis info", NULL}, "--%s: there is no volume '%s'",
                                     option, typed));
}

/* Whether an option about values stands between inputs: then those after the last one are its own, too. */
bool cli_edit_given_between(const cli_args *args, size_t n_inputs)
{
    for (size_t i = 0; i < args->n_given; i++)
        if (cli_edit_is_each(&args->given[i]) && args->given[i].n_before > 0 && args->given[i].n_before < n_inputs)
            return true;
    return false;
}

static vv_status find_target(target *out, const cli_edits *edits, const vv_collection *volumes, const char *option,
                             const cli_given *given)
{
    const size_t at = given->n_before;
    if (named_target(out, volumes, given->text))
        return VV_OK;
    const vv_status st = check_name(edits->command, option, volumes, given->text);
    *out = (target){given->text, 0, volumes->n};
    if (edits->ends && at > 0 && at <= edits->n_inputs &&
        (at < edits->n_inputs || cli_edit_given_between(&edits->command->args, edits->n_inputs))) {
        out->lo = at > 1 ? edits->ends[at - 2] : 0;
        out->hi = edits->ends[at - 1];
    }
    return st;
}

/* After the last of several inputs an option may be meant for that one alone: say for which it is, and how to say so.
 */
static void note_all(const cli_edits *edits, const vv_collection *volumes, const char *option, const cli_given *given,
                     const target *t)
{
    const bool last = edits->ends && edits->n_inputs > 1 && given->n_before == edits->n_inputs;
    if (!last || t->lo > 0 || t->hi < volumes->n || t->typed != given->text)
        return;
    cli_command_note(edits->command, "note: --%s %s is for all %zu volumes; --%s %s=%s is for the last alone", option,
                     t->typed, volumes->n, option, volumes->entry[volumes->n - 1].id, t->typed);
}

/* A mesh without values at its vertices: what is said of the values of all is not for it. */
static bool is_bare_mesh(const cli_edits *edits, const vv_world *world, const vv_volume *volume)
{
    const vv_dataset *dataset = vvi_volume_dataset(world, volume);
    vv_mesh *mesh = NULL;
    if (!dataset || !vv_dataset_is_mesh(dataset, edits->command->job) ||
        vv_dataset_mesh(&mesh, world, dataset, edits->command->job) != VV_OK)
        return false;
    const bool bare = !vv_mesh_get_info(mesh)->values;
    vv_mesh_release(mesh);
    return bare;
}

vv_status cli_edit_each(cli_edits *edits, const char *option, bool of_values, cli_edit_value_fn *fn)
{
    const cli_args *args = &edits->command->args;
    vv_world *world = vv_model_snapshot(edits->model);
    vv_status st = VV_OK;
    for (size_t g = 0; g < args->n_given && st == VV_OK; g++) {
        const cli_given *given = &args->given[g];
        target t;
        if (given->cls != &cli_look_class || strcmp(given->row->name, option) != 0)
            continue;
        st = find_target(&t, edits, world->volumes, option, given);
        const size_t n = world->volumes->n;
        if (st == VV_OK && n && !(of_values && is_bare_mesh(edits, world, vvi_volume_nth(world, n - 1))))
            note_all(edits, world->volumes, option, given, &t);
        for (size_t i = t.lo; i < t.hi && i < n && st == VV_OK; i++) {
            const vv_volume *volume = vvi_volume_nth(world, i);
            if (!(of_values && t.hi - t.lo > 1 && is_bare_mesh(edits, world, volume)))
                st = fn(edits, t.typed, world->volumes->entry[i].id, volume);
        }
    }
    vv_object_release(&world->base);
    return st;
}
