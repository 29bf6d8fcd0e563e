#include "command.h"
#include "verbs.h"
#include <string.h>
#include <volvis/version.h>

static void add_isas(cli_command *command)
{
    const char *name, *in_use = vv_runtime_isa(command->runtime);
    bool usable;
    vvi_text list = {0};
    vvi_result_open(&command->json, "isas", '[');
    for (size_t i = 0; vv_isa_nth(&name, &usable, i); i++) {
        const char *note = strcmp(name, in_use) == 0 ? " (in use)" : usable ? "" : " (not on this machine)";
        vvi_result_string(&command->json, NULL, name);
        vvi_text_printf(&list, "%s%s%s", i ? ", " : "", name, note);
    }
    vvi_result_close(&command->json, ']');
    vvi_result_string(&command->json, "isa", in_use);
    cli_command_line(command, "kernels", "%s", list.bad ? "" : list.s);
    vvi_text_free(&list);
}

static void add_libraries(cli_command *command)
{
    vv_library library;
    vvi_text list = {0};
    vvi_result_open(&command->json, "libraries", '{');
    for (size_t i = 0; vv_library_nth(&library, i, false); i++) {
        const bool there = *library.version && !library.problem;
        vvi_result_string(&command->json, library.name, there ? library.version : NULL);
        vvi_text_printf(&list, "%s%s %s", i ? ", " : "", library.name,
                        there              ? library.version
                        : *library.version ? "(not installed)"
                                           : "(without)");
    }
    vvi_result_close(&command->json, '}');
    cli_command_line(command, "libraries", "%s", list.bad ? "" : list.s);
    vvi_text_free(&list);
}

static vv_status run(cli_command *command)
{
    vv_status st;
    if ((st = cli_command_start(command)) != VV_OK)
        return st;
    vvi_result_string(&command->json, "version", vv_version());
    vvi_result_string(&command->json, "compiler", vv_compiler());
    vvi_text_printf(&command->text, "volvis %s\n", vv_version());
    cli_command_line(command, "compiler", "%s", vv_compiler());
    add_isas(command);
    add_libraries(command);
    return VV_OK;
}

static const char *const examples[] = {"volvis version", "volvis version --json", NULL};

const cli_verb cli_verb_version = {
    .name = "version",
    .doc = "release, instruction sets, compiler and libraries",
    .examples = examples,
    .plain = true,
    .run = run,
};
