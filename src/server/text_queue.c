#include "server/text_queue.h"
#include "core/memory.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

/* What it costs: a flood of short ones is a flood too. Of others a few wait at most. */
static size_t cost(const vvi_line *line)
{
    return line->kind == VVI_LINE_KEPT ? sizeof *line + line->n : 0;
}

/* One answer, such as a picture, is as long as it is: it ends nobody whose next one is ready before it has left. */
static size_t beside_the_longest(const vvi_text_queue *lines)
{
    size_t all = 0, longest = 0;
    for (const vvi_line *line = lines->first; line; line = line->next) {
        all += cost(line);
        longest = cost(line) > longest ? cost(line) : longest;
    }
    return all - longest;
}

static bool is_urgent(const vvi_line *line)
{
    return line->kind <= VVI_LINE_ENDED;
}

/* How many of a kind wait. */
static size_t most(vvi_line_kind kind)
{
    return kind == VVI_LINE_KEPT ? SIZE_MAX : kind <= VVI_LINE_ENDED ? VVI_LINES_NOTICES : 1;
}

static char *take_at(size_t *n_out, vvi_text_queue *lines, vvi_line **at)
{
    vvi_line *line = *at;
    char *text = line->text;
    *n_out = line->n;
    *at = line->next;
    free(line);
    return text;
}

/* The one that a new one of its kind pushes out; NULL: none. */
static vvi_line **outdated(vvi_text_queue *lines, vvi_line_kind kind)
{
    vvi_line **first = NULL;
    size_t n = 0;
    for (vvi_line **at = &lines->first; *at; at = &(*at)->next) {
        if ((*at)->kind != kind)
            continue;
        first = first ? first : at;
        n++;
    }
    return n >= most(kind) ? first : NULL;
}

static bool fail(vvi_line *line, char *text)
{
    free(line);
    free(text);
    return false;
}

bool vvi_text_queue_put(vvi_text_queue *lines, vvi_line_kind kind, char *text)
{
    vvi_line *line = text ? vvi_calloc(1, sizeof *line) : NULL, **at = line ? outdated(lines, kind) : NULL;
    size_t n;
    if (at)
        free(take_at(&n, lines, at));
    if (!line || (kind == VVI_LINE_KEPT && beside_the_longest(lines) > VVI_LINES_MOST))
        return fail(line, text);
    *line = (vvi_line){.kind = kind, .text = text, .n = strlen(text)};
    for (at = &lines->first; *at; at = &(*at)->next)
        ;
    *at = line;
    return true;
}

char *vvi_text_queue_take(size_t *n_out, vvi_text_queue *lines, bool urgent)
{
    for (vvi_line **at = &lines->first; *at; at = &(*at)->next)
        if (!urgent || is_urgent(*at))
            return take_at(n_out, lines, at);
    return NULL;
}

bool vvi_text_queue_any(const vvi_text_queue *lines, bool urgent)
{
    for (const vvi_line *line = lines->first; line; line = line->next)
        if (!urgent || is_urgent(line))
            return true;
    return false;
}

void vvi_text_queue_clear(vvi_text_queue *lines)
{
    size_t n;
    while (lines->first)
        free(take_at(&n, lines, &lines->first));
}
