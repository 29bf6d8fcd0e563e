#include "missing.h"
#include "core/job.h"
#include "core/units.h"
#include "io/file_stream.h"
#include "refusal.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

static vv_status fail(const cli_command *command, const char *typed)
{
    return cli_refused(command, "missing",
                       vv_fail(VV_E_ARGUMENT,
                               "--missing: expected numbers with commas between them, as in -9999 or -999,1e20, or "
                               "none; found '%.60s'",
                               typed));
}

vv_status cli_missing_read(cli_missing *out, const cli_command *command)
{
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    const char *typed = reading->missing, *at = typed;
    *out = (cli_missing){.given = typed != NULL};
    if (!typed || strcmp(typed, "none") == 0 || strcmp(typed, "[]") == 0)
        return VV_OK;
    const bool brackets = *at == '[';
    at += brackets;
    for (; out->n < CLI_MISSING_MOST; at++) {
        if (!vvi_scan_number(&out->value[out->n], at, &at) || !isfinite(out->value[out->n]))
            return fail(command, typed);
        out->n++;
        if (*at != ',')
            break;
    }
    return strcmp(at, brackets ? "]" : "") == 0 ? VV_OK : fail(command, typed);
}

vv_status cli_missing_take(cli_input *input, cli_command *command, const vv_volume *volume)
{
    cli_missing missing;
    vv_status st = cli_missing_read(&missing, command);
    const bool of_volume = volume && vv_object_is_set(&volume->base, "missing");
    if (st != VV_OK || (!missing.given && !of_volume))
        return st;
    vvi_job_keep_fills(command->job);
    if (missing.given)
        return cli_refused(command, "missing", vvi_file_leave_out(input->file, missing.value, missing.n));
    const vv_numbers *named = volume->missing;
    st = named ? vvi_file_leave_out(input->file, named->v, named->n) : VV_OK;
    return st == VV_E_ARGUMENT ? VV_OK : st; /* pictures of labels have no use for it either */
}

static vv_status set(vv_world **world, const cli_missing *missing, vv_job *job, size_t *n_set)
{
    vv_object *root = &(*world)->base;
    const size_t n = (*world)->volumes->n;
    vv_status st = VV_OK;
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        char path[160];
        const vv_world *now = (const vv_world *)(const void *)root;
        if (vvi_volume_is_mesh(now, vvi_volume_nth(now, i), job))
            continue;
        snprintf(path, sizeof path, "volumes.%s.missing", now->volumes->entry[i].id);
        st = vv_path_set_numbers(&root, path, missing->value, missing->n, NULL);
        ++*n_set;
    }
    *world = (vv_world *)(void *)root;
    return st;
}

vv_status cli_missing_set(vv_world **world, cli_command *command)
{
    cli_missing missing;
    size_t n_set = 0;
    vv_status st = cli_missing_read(&missing, command);
    if (st != VV_OK || !missing.given)
        return st;
    st = set(world, &missing, command->job, &n_set);
    if (st == VV_OK && n_set == 0 && command->args.n_words == 1)
        st = cli_refused(command, "missing",
                         vv_fail(VV_E_ARGUMENT, "--missing does nothing here: it is about samples of volumes, and "
                                                "this is a mesh"));
    return st;
}
