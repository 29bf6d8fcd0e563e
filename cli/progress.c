#include "progress.h"
#include "core/result.h"
#include "core/text.h"
#include "terminal.h"
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double bar_after_s = 0.3;  /* short work shows no bar */
static const double line_after_s = 5.0; /* and no line in a log */
static const double line_every_s = 10.0;
static const double json_every_s = 0.25;

void cli_progress_init(cli_progress *progress, cli_progress_kind kind, bool quiet)
{
    *progress = (cli_progress){.kind = kind, .next_s = line_after_s};
    if (kind == CLI_PROGRESS_AUTO) {
        progress->kind = quiet ? CLI_PROGRESS_NONE : CLI_PROGRESS_BAR;
        progress->log_lines = !isatty(STDERR_FILENO);
    }
}

static double share(const vv_progress *report)
{
    return report->total ? (double)report->done / (double)report->total : 0.0;
}

static void print_eta(char *out, size_t room, double eta_s)
{
    const long seconds = eta_s >= 0 && eta_s < 1e9 ? (long)(eta_s + 0.5) : -1;
    if (seconds < 0)
        snprintf(out, room, "%s", "");
    else if (seconds < 60)
        snprintf(out, room, ", %ld s left", seconds);
    else
        snprintf(out, room, ", %ld:%02ld min left", seconds / 60, seconds % 60);
}

static void print_json(const vv_progress *report)
{
    vvi_text line = {0};
    vvi_text_add(&line, "{\"stage\": ");
    vvi_text_json(&line, report->stage);
    vvi_text_printf(&line, ", \"done\": %llu, \"total\": %llu, \"elapsed_s\": %.3f, \"eta_s\": ",
                    (unsigned long long)report->done, (unsigned long long)report->total, report->elapsed_s);
    if (report->eta_s >= 0)
        vvi_text_printf(&line, "%.3f}\n", report->eta_s);
    else
        vvi_text_add(&line, "null}\n");
    if (!line.bad)
        fputs(line.s, stderr);
    vvi_text_free(&line);
}

/* What was told of a stage ends at its total: the library tells now and then, and not of the end of each stage. */
static void end_stage(cli_progress *progress)
{
    vv_progress last = progress->last;
    if (last.stage && last.done < last.total) {
        last.done = last.total;
        last.eta_s = 0;
        print_json(&last);
    }
    progress->last = (vv_progress){0};
}

/* The first and the last report of a stage, and some between them. */
static void show_json(cli_progress *progress, const vv_progress *report)
{
    const vv_progress *last = &progress->last;
    if (last->stage && (strcmp(last->stage, report->stage) != 0 || report->done < last->done))
        end_stage(progress);
    if (!last->stage || report->elapsed_s >= progress->told_s + json_every_s ||
        (report->done >= report->total && last->done < last->total)) {
        print_json(report);
        progress->told_s = report->elapsed_s;
    }
    progress->last = *report;
}

static void show_line(cli_progress *progress, const vv_progress *report)
{
    char eta[48];
    if (report->elapsed_s < progress->next_s)
        return;
    print_eta(eta, sizeof eta, report->eta_s);
    fprintf(stderr, "volvis: %s %.0f %%%s\n", report->stage, 100 * share(report), eta);
    progress->next_s = report->elapsed_s + line_every_s;
}

static void show_bar(cli_progress *progress, const vv_progress *report)
{
    char eta[48];
    if (report->elapsed_s < bar_after_s)
        return;
    print_eta(eta, sizeof eta, report->eta_s);
    const int width = cli_terminal_width(STDERR_FILENO) - 40;
    const int full = (int)(width * share(report) + 0.5);
    fprintf(stderr, "\r\033[K%-10.10s [", report->stage);
    for (int i = 0; i < width; i++)
        fputc(i < full ? '#' : '.', stderr);
    fprintf(stderr, "] %3.0f %%%s", 100 * share(report), eta);
    fflush(stderr);
    progress->drawn = true;
}

bool cli_progress_show(void *user, const vv_progress *report)
{
    cli_progress *progress = user;
    if (progress->kind == CLI_PROGRESS_JSON)
        show_json(progress, report);
    else if (progress->kind == CLI_PROGRESS_BAR && progress->log_lines)
        show_line(progress, report);
    else if (progress->kind == CLI_PROGRESS_BAR)
        show_bar(progress, report);
    return true;
}

void cli_progress_end(cli_progress *progress)
{
    end_stage(progress);
}

void cli_progress_clear(cli_progress *progress)
{
    if (progress->drawn)
        fputs("\r\033[K", stderr);
    progress->drawn = false;
}
