#include "terminal_picture.h"
#include "terminal.h"
#include <fcntl.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

enum { REPLY_MS = 300, ROWS_MOST = 32, CELL_WIDTH = 8, CELL_HEIGHT = 16, SIXEL_WIDTH_MOST = 1200 };

/* What it can --------------------------------------------------------------------------------------------------- */

static bool has_variable(const char *name)
{
    const char *value = getenv(name);
    return value && *value;
}

vv_letters cli_terminal_blocks(void)
{
    const char *colors = getenv("COLORTERM"), *term = getenv("TERM");
    if (has_variable("NO_COLOR") || !term || !*term || strcmp(term, "dumb") == 0)
        return VV_LETTERS_SHADES;
    const bool full = colors && (strcmp(colors, "truecolor") == 0 || strcmp(colors, "24bit") == 0);
    if (full || strstr(term, "direct"))
        return VV_LETTERS_BLOCKS;
    return strstr(term, "256color") ? VV_LETTERS_BLOCKS8 : VV_LETTERS_SHADES;
}

/* "ESC [ ? 62 ; 4 ; 6 c": whether 4, sixels, is among the primary device attributes. */
static bool says_sixel(const char *reply)
{
    const char *at = strstr(reply, "\033[?");
    for (at = at ? at + 2 : NULL; at && *at && *at != 'c'; at = strpbrk(at, ";c")) {
        at++;
        if (at[0] == '4' && (at[1] == ';' || at[1] == 'c'))
            return true;
    }
    return false;
}

/* The answer to "what are you?", or as much as came in time. */
static void ask(char *reply, size_t room, int terminal)
{
    size_t n = 0;
    struct pollfd input = {.fd = terminal, .events = POLLIN};
    if (write(terminal, "\033[c", 3) != 3)
        return;
    while (n + 1 < room && poll(&input, 1, REPLY_MS) == 1) {
        const ssize_t got = read(terminal, reply + n, room - 1 - n);
        if (got <= 0)
            break;
        n += (size_t)got;
        reply[n] = 0;
        if (strchr(reply, 'c'))
            break;
    }
}

static bool has_sixel(void)
{
    char reply[128] = "";
    struct termios before, raw;
    const int terminal = open("/dev/tty", O_RDWR | O_NOCTTY | O_CLOEXEC);
    if (terminal < 0)
        return false;
    if (tcgetattr(terminal, &before) == 0 && tcgetpgrp(terminal) == getpgrp()) { /* one in the background would stop */
        raw = before;
        raw.c_lflag &= (tcflag_t) ~(ICANON | ECHO);
        raw.c_cc[VMIN] = 0;
        raw.c_cc[VTIME] = 0;
        if (tcsetattr(terminal, TCSAFLUSH, &raw) == 0) {
            ask(reply, sizeof reply, terminal);
            tcsetattr(terminal, TCSAFLUSH, &before);
        }
    }
    close(terminal);
    return says_sixel(reply);
}

vv_letters cli_terminal_letters(void)
{
    if (!cli_terminal_color(STDOUT_FILENO))
        return VV_LETTERS_SHADES;
    return has_sixel() ? VV_LETTERS_SIXEL : cli_terminal_blocks();
}

void cli_terminal_picture_size(int *width, int *height, double *aspect, vv_letters kind)
{
    struct winsize size = {0};
    const int columns = cli_terminal_width(STDOUT_FILENO);
    const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0;
    const int rows = known && size.ws_row > 4 && size.ws_row - 2 < ROWS_MOST ? size.ws_row - 2 : ROWS_MOST;
    const bool measured = known && size.ws_xpixel > 0 && size.ws_ypixel > 0;
    const double cell_width = measured ? (double)size.ws_xpixel / size.ws_col : CELL_WIDTH;
    const double cell_height = measured ? (double)size.ws_ypixel / size.ws_row : CELL_HEIGHT;
    *aspect = 1;
    if (kind == VV_LETTERS_SIXEL) {
        const int all = (int)(columns * cell_width);
        *width = all < SIXEL_WIDTH_MOST ? all : SIXEL_WIDTH_MOST;
        *height = (int)(rows * cell_height);
        return;
    }
    *width = columns;
    *height = kind == VV_LETTERS_SHADES ? rows : 2 * rows;
    *aspect = kind == VV_LETTERS_SHADES ? cell_height / cell_width : cell_height / cell_width / 2;
}
