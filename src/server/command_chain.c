/* Operations one after the other as one text, for `volvis pipe` and --apply. */
#include "core/memory.h"
#include "server/command.h"

#include <stdlib.h>
#include <string.h>

/* A word of a chain: quotation marks of both kinds keep what stands in them, and nothing escapes them. */
static void put_word(vvi_text *out, const char *word)
{
    if (*word && !strpbrk(word, " \t\n'\"|")) {
        vvi_text_add(out, word);
        return;
    }
    vvi_text_add(out, "\"");
    for (; *word; word++)
        vvi_text_add(out, *word == '"' ? "\"'\"'\"" : (char[2]){*word, 0});
    vvi_text_add(out, "\"");
}

/* What a step takes beside what the one before it makes: files, by their names or, where people name inputs as they
 * like, in their order. */
static vv_status put_others(vvi_text *out, const vvi_made *made, bool lines, vv_job *job)
{
    vv_status st = VV_OK;
    for (size_t i = 1; i < made->n && st == VV_OK; i++) {
        const vv_dataset *dataset = made->input[i];
        vvi_made other;
        if (!dataset)
            continue;
        const bool by_steps = vvi_command_open_made(&other, made->world, dataset, job);
        vvi_made_close(&other);
        if (!lines && (by_steps || !dataset->path || !vvi_command_is_plain(dataset)))
            return vv_fail(VV_E_ARGUMENT,
                           "'%.64s' also works on '%.64s', which a chain cannot name as a file: copy the command lines "
                           "instead, or save the scene",
                           made->id, made->input_id[i]);
        vvi_text_add(out, " ");
        if (!made->operation->inputs[0].names)
            vvi_text_printf(out, "%s=", vv_operation_operand(made->operation, i)->name);
        st = vvi_command_file(out, made->world, made->input_id[i], false, put_word, job);
    }
    return st;
}

/* What is piped in is called a, unless --names says otherwise. */
vv_status vvi_command_chain_step(vvi_text *out, const vvi_made *made, bool lines, vv_job *job)
{
    const char *names = made->operation->inputs[0].names;
    vv_object *params = NULL;
    vv_status st = vvi_made_params(&params, made, job);
    if (st == VV_OK && names && vvi_made_is_named(made, params) && strcmp(made->names, "a") == 0)
        st = vv_path_unset(&params, names, NULL);
    vvi_text_printf(out, "%s%s", out->n ? " | " : "", made->operation->name);
    if (st == VV_OK && (st = put_others(out, made, lines, job)) == VV_OK)
        st = vvi_command_parameters(out, made, params, put_word);
    vv_object_release(params);
    return st;
}

static vv_status put_steps(vvi_text *out, const char **source, const vv_world *world, const char *id, int depth,
                           vv_job *job)
{
    vvi_made made;
    const vv_dataset *dataset;
    vv_status st = vvi_command_behind(&dataset, &id, world, job);
    if (st != VV_OK)
        return st;
    if (depth == VVI_MADE_DEEPEST)
        return vv_fail(VV_E_LIMIT, "'%.64s' was made by more than %d operations", id, VVI_MADE_DEEPEST);
    *source = id;
    if (!vvi_command_open_made(&made, world, dataset, job) || !made.input[0])
        st = dataset->path ? VV_OK : vv_error_last()->status;
    else if ((st = put_steps(out, source, world, made.input_id[0], depth + 1, job)) == VV_OK)
        st = vvi_command_chain_step(out, &made, false, job);
    vvi_made_close(&made);
    return st;
}

vv_status vvi_command_chain(vvi_text *out, const char **source_out, const vv_world *world, const char *id, vv_job *job)
{
    const vv_status st = put_steps(out, source_out, world, id, 0, job);
    return st == VV_OK && !out->n ? vv_fail(VV_E_ARGUMENT, "no operation is applied: there is no chain") : st;
}

vv_status vvi_command_pipe(vvi_text *out, const vv_world *world, const char *id, vv_job *job)
{
    const vv_dataset *dataset;
    const char *behind = id, *source;
    vvi_text chain = {0};
    vv_status st = vvi_command_behind(&dataset, &behind, world, job);
    if (st == VV_OK)
        st = vvi_command_chain(&chain, &source, world, id, job);
    vvi_text_add(out, "volvis pipe ");
    if (st == VV_OK)
        st = vvi_command_input(out, world, source, job);
    if (st == VV_OK) {
        vvi_text_add(out, " ");
        vvi_command_quote(out, chain.s ? chain.s : "");
        vvi_text_add(out, " -o ");
        vvi_command_made(out, id, vvi_command_suffix(world, dataset, job));
    }
    out->bad |= chain.bad;
    vvi_text_free(&chain);
    return st;
}
