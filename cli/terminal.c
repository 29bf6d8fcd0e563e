#include "terminal.h"
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

int cli_terminal_width(int descriptor)
{
    const char *columns = getenv("COLUMNS");
    struct winsize size;
    long width = columns ? strtol(columns, NULL, 10) : 0;
    if (width <= 0 && ioctl(descriptor, TIOCGWINSZ, &size) == 0)
        width = size.ws_col;
    if (width <= 0)
        width = 80;
    return width < 40 ? 40 : width > 120 ? 120 : (int)width;
}

bool cli_terminal_color(int descriptor)
{
    const char *no_color = getenv("NO_COLOR");
    const char *term = getenv("TERM");
    if (no_color && *no_color)
        return false;
    return isatty(descriptor) && term && *term && strcmp(term, "dumb") != 0;
}

static size_t columns_of(const char *s, size_t bytes)
{
    size_t columns = 0;
    for (size_t i = 0; i < bytes; i++)
        columns += ((unsigned char)s[i] & 0xc0) != 0x80; /* bytes that continue a character take no column */
    return columns;
}

size_t cli_text_columns(const char *s)
{
    return columns_of(s, strlen(s));
}

static void break_line(vvi_text *out, size_t indent)
{
    vvi_text_printf(out, "\n%*s", (int)indent, "");
}

void cli_text_wrap(vvi_text *out, const char *s, size_t column, size_t indent, size_t width)
{
    bool first = true;
    while (*s) {
        const size_t bytes = strcspn(s, " \n");
        const size_t columns = columns_of(s, bytes);
        if (!first && bytes && column + 1 + columns > width) {
            break_line(out, indent);
            column = indent;
        } else if (!first && bytes) {
            vvi_text_add(out, " ");
            column++;
        }
        vvi_text_add_n(out, s, bytes);
        column += columns;
        first = first && bytes == 0;
        s += bytes;
        if (*s == '\n') {
            break_line(out, indent);
            column = indent;
            first = true;
        }
        s += *s != 0;
    }
    vvi_text_add(out, "\n");
}
