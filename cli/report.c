#include "report.h"
#include "io/sink.h"
#include "terminal.h"
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

int cli_report_exit_code(vv_status status, const char *output)
{
    const char *file = vv_error_last()->file;
    switch (status) {
    case VV_OK:
        return CLI_EXIT_DONE;
    case VV_E_ARGUMENT:
    case VV_E_NOT_FOUND:
        return CLI_EXIT_WORDS;
    case VV_E_READ:
    case VV_E_FORMAT:
        return CLI_EXIT_INPUT;
    case VV_E_MEMORY:
        return CLI_EXIT_LIMIT;
    case VV_E_LIMIT: /* of a file: a scene that is larger or deeper than any honest one; memory is of no file */
        return file ? CLI_EXIT_INPUT : CLI_EXIT_LIMIT;
    case VV_E_WRITE:
        return CLI_EXIT_OUTPUT;
    case VV_E_CANCELLED:
        return CLI_EXIT_INTERRUPTED;
    case VV_E_UNSUPPORTED:
        if (!file)
            return CLI_EXIT_FAILED;
        return output && strcmp(file, output) == 0 ? CLI_EXIT_OUTPUT : CLI_EXIT_INPUT;
    case VV_E_INTERNAL:
        break;
    }
    return CLI_EXIT_FAILED;
}

static void print_error_json(const vv_error *error)
{
    vvi_result json = {0};
    vvi_result_open(&json, NULL, '{');
    vvi_result_open(&json, "error", '{');
    vvi_result_string(&json, "code", vv_status_name(error->status));
    vvi_result_string(&json, "message", error->message);
    vvi_result_string(&json, "file", error->file);
    vvi_result_string(&json, "where", error->where);
    vvi_result_close(&json, '}');
    vvi_result_close(&json, '}');
    if (!json.text.bad)
        puts(json.text.s);
    vvi_text_free(&json.text);
}

/* What asked for memory knows its own part, not what comes after it: an amount that it names may not be enough. */
static void leave_amount_out(void)
{
    char text[1024];
    const char *message = vv_error_last()->message, *advice = strstr(message, "; give --memory ");
    if (!advice || vv_error_last()->status != VV_E_LIMIT)
        return;
    const char *other = strstr(advice, "make it smaller") ? "make it smaller" : "use less data";
    snprintf(text, sizeof text, "%.*s", (int)(advice - message), message);
    vv_fail(VV_E_LIMIT, "%s; give more with --memory, or %s", text, other);
}

int cli_report_error(vv_status status, const char *output, bool json, bool quiet)
{
    leave_amount_out();
    const vv_error *error = vv_error_last();
    const int code = cli_report_exit_code(status, output);
    const bool color = cli_terminal_color(STDERR_FILENO);
    if (json)
        print_error_json(error);
    if (!(json && quiet))
        fprintf(stderr, "%svolvis:%s %s\n", color ? "\033[1;31m" : "", color ? "\033[0m" : "", error->message);
    fflush(stdout);
    return code;
}

static vv_status write_out(const char *text, size_t n)
{
    if (fwrite(text, 1, n, stdout) == n && fflush(stdout) == 0)
        return VV_OK;
    return vv_fail(VV_E_WRITE, "standard output: %s", strerror(errno));
}

vv_status cli_report_file(cli_command *command, const char *path, const char *text, size_t n)
{
    vv_sink *sink = NULL;
    vv_status st;
    if ((st = vvi_sink_open(&sink, path, command->job)) != VV_OK)
        return st;
    if (!command->common->overwrite)
        vvi_sink_spare_inputs(sink);
    if ((st = vvi_sink_write(sink, text, n)) != VV_OK) {
        vvi_sink_abandon(sink);
        return st;
    }
    return vvi_sink_commit(sink);
}

/* The text that leaves: JSON with its line end, or what run() wrote. */
static vv_status choose_text(const vvi_text **out, cli_command *command)
{
    *out = &command->text;
    if (command->common->json && !command->verbatim) {
        if (!command->json.filled && command->text.n)
            vvi_result_string(&command->json, "text", command->text.s);
        vvi_result_close(&command->json, command->several ? ']' : '}');
        vvi_text_add(&command->json.text, "\n");
        *out = &command->json.text;
    }
    return (*out)->bad ? vv_fail(VV_E_MEMORY, "not enough memory for the result's text") : VV_OK;
}

vv_status cli_report_result(cli_command *command)
{
    const vvi_text *text;
    vv_status st;
    const char *output = command->common->output;
    const bool summary = command->verb.makes_file && !command->common->json && !command->common->dry_run;
    if (summary && command->common->quiet)
        return VV_OK;
    if ((st = choose_text(&text, command)) != VV_OK || text->n == 0)
        return st;
    if (output && !command->verb.makes_file && !command->common->help && strcmp(output, "-") != 0) {
        if ((st = cli_report_file(command, output, text->s, text->n)) == VV_OK)
            cli_command_note(command, "written to %s", output);
        return st;
    }
    if (output && command->verb.makes_file && strcmp(output, "-") == 0) {
        fputs(text->s, stderr); /* standard output carries the file itself */
        return VV_OK;
    }
    return write_out(text->s, text->n);
}
