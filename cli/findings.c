#include "findings.h"
#include <stdlib.h>
#include <string.h>

void cli_findings_report(cli_command *command)
{
    vv_finding found;
    bool any = false;
    for (size_t i = 0; vv_job_finding(&found, command->job, i); i++) {
        if (found.json)
            vvi_result_raw(&command->json, found.name, found.json);
        if (found.note)
            cli_command_note(command, "%s: %s", cli_command_word(command, 0), found.note);
        if (found.phrase)
            vvi_text_printf(&command->text, "%s %s", any ? "," : "", found.phrase);
        any = any || found.phrase;
    }
    if (any)
        vvi_text_add(&command->text, ";");
}

void cli_findings_warnings(cli_command *command)
{
    static const char lead[] = "warning: ";
    const size_t n = strlen(lead);
    vvi_result_open(&command->json, "warnings", '[');
    for (const char *line = command->said.s; line && *line; line += strcspn(line, "\n")) {
        line += strspn(line, "\n");
        const size_t length = strcspn(line, "\n");
        char *text = length > n && strncmp(line, lead, n) == 0 ? strndup(line + n, length - n) : NULL;
        if (text)
            vvi_result_string(&command->json, NULL, text);
        free(text);
    }
    vvi_result_close(&command->json, ']');
}
