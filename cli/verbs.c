/* The table of verbs: hand-written ones here, one a file in cli/verbs, and every operation of the registry. */
#include "verbs.h"
#include "core/names.h"
#include "core/status.h"
#include <string.h>

static const cli_verb *const hand_written[] = {
    &cli_verb_view,    &cli_verb_serve,     &cli_verb_replay,  &cli_verb_info,       &cli_verb_render,
    &cli_verb_pick,    &cli_verb_measure,   &cli_verb_convert, &cli_verb_split,      &cli_verb_pipe,
    &cli_verb_compare, &cli_verb_formats,   &cli_verb_methods, &cli_verb_operations, &cli_verb_presets,
    &cli_verb_schema,  &cli_verb_doctor,    &cli_verb_version, &cli_verb_help,       &cli_verb_completions,
    &cli_verb_man,     &cli_verb_reference,
};
enum { N_HAND_WRITTEN = sizeof hand_written / sizeof hand_written[0], MAX_VERBS = 256 };

bool cli_verb_nth(cli_verb *out, const vv_registry *registry, size_t index)
{
    if (index < N_HAND_WRITTEN) {
        *out = *hand_written[index];
        return true;
    }
    for (size_t i = 0; registry->operations[i]; i++) {
        if (i == index - N_HAND_WRITTEN) {
            *out = cli_verb_of_operation(registry->operations[i]);
            return true;
        }
    }
    return false;
}

vv_status cli_verb_find(cli_verb *out, const vv_registry *registry, const char *name)
{
    const char *names[MAX_VERBS];
    size_t n = 0;
    for (size_t i = 0; cli_verb_nth(out, registry, i); i++) {
        if (strcmp(out->name, name) == 0)
            return VV_OK;
        if (!out->hidden && n < MAX_VERBS)
            names[n++] = out->name;
    }
    *out = (cli_verb){0};
    return vvi_fail_name(VV_E_ARGUMENT, NULL, NULL, name, &(vvi_known){names, n, "volvis help", NULL}, "no verb '%s'",
                         name);
}
