/* What a run says: lines of its result, notes, and the library's log. */
#include "command.h"
#include "signals.h"
#include "terminal.h"
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What printf makes, as it may be shown: names of files are in most of it, and may hold anything, so what a terminal
 * would obey becomes '?', ends of lines too; yours to free(), NULL without memory. */
static char *format_text(const char *format, va_list arguments)
{
    char *text = NULL;
    if (vasprintf(&text, format, arguments) < 0)
        return NULL;
    vvi_text_clean(text);
    return text;
}

void cli_command_log(void *user, vv_log_level level, const char *component, const char *text)
{
    static const char *const names[] = {"error: ", "warning: ", "", ""};
    cli_command *command = user;
    vvi_text line = {0};
    vvi_text_printf(&line, "\n%s%s: ", names[level], component);
    vvi_text_add_clean(&line, text);
    vvi_text_add(&line, "\n");
    if (line.bad || (command->said.s && strstr(command->said.s, line.s))) {
        vvi_text_free(&line);
        return;
    }
    cli_progress_clear(&command->progress);
    fprintf(stderr, "volvis: %s", line.s + 1);
    vvi_text_add(&command->said, line.s);
    vvi_text_free(&line);
}

void cli_command_note(cli_command *command, const char *format, ...)
{
    va_list arguments;
    if (command->common->quiet)
        return;
    cli_progress_clear(&command->progress);
    va_start(arguments, format);
    char *text = format_text(format, arguments);
    va_end(arguments);
    fprintf(stderr, "volvis: %s\n", text ? text : "not enough memory for a note");
    free(text);
}

void cli_command_title(cli_command *command, const char *name)
{
    vvi_text_add_clean(&command->text, name);
    vvi_text_add(&command->text, "\n");
}

void cli_command_line(cli_command *command, const char *label, const char *format, ...)
{
    enum { COLUMN = 14 };
    va_list arguments;
    va_start(arguments, format);
    char *text = format_text(format, arguments);
    va_end(arguments);
    vvi_text_printf(&command->text, "%-*s", COLUMN, label);
    cli_text_wrap(&command->text, text ? text : "not enough memory for a line", COLUMN, COLUMN,
                  (size_t)cli_terminal_width(STDOUT_FILENO));
    free(text);
}
