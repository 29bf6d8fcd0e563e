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

cli_picture_kind cli_terminal_blocks(void)
{
    const char *colors = getenv("COLORTERM"), *term = getenv("TERM");
    if (has_variable("NO_COLOR") || !term || !*term || strcmp(term, "dumb") == 0)
        return CLI_PICTURE_SHADES;
    const bool full = colors && (strcmp(colors, "truecolor") == 0 || strcmp(colors, "24bit") == 0);
    if (full || strstr(term, "direct"))
        return CLI_PICTURE_BLOCKS;
    return strstr(term, "256color") ? CLI_PICTURE_BLOCKS8 : CLI_PICTURE_SHADES;
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

cli_picture_kind cli_terminal_picture_kind(void)
{
    if (!cli_terminal_color(STDOUT_FILENO))
        return CLI_PICTURE_SHADES;
    return has_sixel() ? CLI_PICTURE_SIXEL : cli_terminal_blocks();
}

void cli_terminal_picture_size(int *width, int *height, double *aspect, cli_picture_kind kind)
{
    struct winsize size = {0};
    const int columns = cli_terminal_width(STDOUT_FILENO);
    const bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 && size.ws_row > 0;
    const int rows = known && size.ws_row > 4 && size.ws_row - 2 < ROWS_MOST ? size.ws_row - 2 : ROWS_MOST;
    const bool measured = known && size.ws_xpixel > 0 && size.ws_ypixel > 0;
    const double cell_width = measured ? (double)size.ws_xpixel / size.ws_col : CELL_WIDTH;
    const double cell_height = measured ? (double)size.ws_ypixel / size.ws_row : CELL_HEIGHT;
    *aspect = 1;
    if (kind == CLI_PICTURE_SIXEL) {
        const int all = (int)(columns * cell_width);
        *width = all < SIXEL_WIDTH_MOST ? all : SIXEL_WIDTH_MOST;
        *height = (int)(rows * cell_height);
        return;
    }
    *width = columns;
    *height = kind == CLI_PICTURE_SHADES ? rows : 2 * rows;
    *aspect = kind == CLI_PICTURE_SHADES ? cell_height / cell_width : cell_height / cell_width / 2;
}

/* Letters ---------------------------------------------------------------------------------------------------------- */

static const float *pixel(const cli_thumbnail *t, int x, int y)
{
    static const float black[3];
    return y < t->height ? t->rgb + 3 * ((size_t)y * (size_t)t->width + (size_t)x) : black;
}

static int level(float v, int most)
{
    return (int)lrintf((v > 0 ? v < 1 ? v : 1 : 0) * (float)most);
}

static double luma(const float rgb[3])
{
    return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2];
}

/* The nearest of xterm's 6 x 6 x 6 colours and 24 greys; the cube's levels are 0, 95, 135, ... 255. */
static int xterm_color(const float rgb[3])
{
    int cube[3];
    double off_cube = 0, off_grey = 0;
    const int grey = (int)lrint(fmin(fmax((luma(rgb) * 255 - 8) / 10, 0), 23));
    for (int k = 0; k < 3; k++) {
        const double v = 255 * rgb[k];
        cube[k] = v < 47.5 ? 0 : v < 115 ? 1 : (int)lrint((v - 55) / 40);
        const double on_cube = cube[k] ? 55 + 40 * cube[k] : 0;
        off_cube += (v - on_cube) * (v - on_cube);
        off_grey += (v - 8 - 10 * grey) * (v - 8 - 10 * grey);
    }
    return off_grey < off_cube ? 232 + grey : 16 + 36 * cube[0] + 6 * cube[1] + cube[2];
}

static void add_color(vvi_text *out, int layer, const float rgb[3], cli_picture_kind kind)
{
    if (kind == CLI_PICTURE_BLOCKS8)
        vvi_text_printf(out, "\033[%d;5;%dm", layer, xterm_color(rgb));
    else
        vvi_text_printf(out, "\033[%d;2;%d;%d;%dm", layer, level(rgb[0], 255), level(rgb[1], 255), level(rgb[2], 255));
}

static bool same_color(const float *a, const float *b)
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The upper half of a cell in the letter's colour, the lower one in the background's. */
static void add_blocks(vvi_text *out, const cli_thumbnail *t, cli_picture_kind kind)
{
    for (int y = 0; y < t->height; y += 2) {
        for (int x = 0; x < t->width; x++) {
            const float *upper = pixel(t, x, y), *lower = pixel(t, x, y + 1);
            if (x == 0 || !same_color(upper, pixel(t, x - 1, y)))
                add_color(out, 38, upper, kind);
            if (x == 0 || !same_color(lower, pixel(t, x - 1, y + 1)))
                add_color(out, 48, lower, kind);
            vvi_text_add(out, "\xe2\x96\x80");
        }
        vvi_text_add(out, "\033[0m\n");
    }
}

static void add_shades(vvi_text *out, const cli_thumbnail *t)
{
    static const char shades[] = " .:-=+*#%@";
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++)
            vvi_text_add_n(out, &shades[level((float)luma(pixel(t, x, y)), (int)sizeof shades - 2)], 1);
        vvi_text_add(out, "\n");
    }
}

/* Sixels ---------------------------------------------------------------------------------------------------------- */

enum { GREYS = 101, RED = 6, GREEN = 8, BLUE = 5, COLORS = RED * GREEN * BLUE };

static bool is_grey(const cli_thumbnail *t)
{
    for (size_t p = 0; p < (size_t)t->width * (size_t)t->height; p++) {
        const float *c = t->rgb + 3 * p;
        if (fabsf(c[0] - c[1]) > 0.005f || fabsf(c[1] - c[2]) > 0.005f)
            return false;
    }
    return true;
}

/* Ordered dithering (Bayer 1973): an offset of less than one level, other at each pixel of a 4 x 4 square. */
static int dithered(float v, int levels, int x, int y)
{
    static const uint8_t order[4][4] = {{0, 8, 2, 10}, {12, 4, 14, 6}, {3, 11, 1, 9}, {15, 7, 13, 5}};
    const float at = (v > 0 ? v < 1 ? v : 1 : 0) * (float)(levels - 1) + ((float)order[y & 3][x & 3] + 0.5f) / 16;
    const int n = (int)at;
    return n < levels ? n : levels - 1;
}

static int color_number(const float *c, int x, int y, bool grey)
{
    if (grey)
        return level(c[1], GREYS - 1);
    return (dithered(c[0], RED, x, y) * GREEN + dithered(c[1], GREEN, x, y)) * BLUE + dithered(c[2], BLUE, x, y);
}

static void add_palette(vvi_text *out, bool grey)
{
    for (int i = 0; grey && i < GREYS; i++)
        vvi_text_printf(out, "#%d;2;%d;%d;%d", i, i, i, i);
    for (int i = 0; !grey && i < COLORS; i++)
        vvi_text_printf(out, "#%d;2;%d;%d;%d", i, i / (GREEN * BLUE) * 100 / (RED - 1),
                        i / BLUE % GREEN * 100 / (GREEN - 1), i % BLUE * 100 / (BLUE - 1));
}

static void add_run(vvi_text *out, int bits, int n)
{
    const char letter = (char)(63 + bits);
    if (n > 3)
        vvi_text_printf(out, "!%d%c", n, letter);
    else
        for (int i = 0; i < n; i++)
            vvi_text_add_n(out, &letter, 1);
}

/* Six rows: for each colour in them one line over the others. */
static void add_band(vvi_text *out, const cli_thumbnail *t, int y0, bool grey, uint8_t *numbers)
{
    bool used[256] = {false};
    const int rows = t->height - y0 < 6 ? t->height - y0 : 6;
    for (int j = 0; j < rows; j++)
        for (int x = 0; x < t->width; x++) {
            const int number = color_number(pixel(t, x, y0 + j), x, y0 + j, grey);
            numbers[j * t->width + x] = (uint8_t)number;
            used[number] = true;
        }
    for (int c = 0; c < 256; c++) {
        if (!used[c])
            continue;
        vvi_text_printf(out, "#%d", c);
        int before = -1, run = 0;
        for (int x = 0; x < t->width; x++) {
            int bits = 0;
            for (int j = 0; j < rows; j++)
                bits |= (numbers[j * t->width + x] == c) << j;
            if (bits != before && run)
                add_run(out, before, run);
            run = bits == before ? run + 1 : 1;
            before = bits;
        }
        if (before > 0)
            add_run(out, before, run);
        vvi_text_add(out, "$");
    }
    vvi_text_add(out, "-");
}

static void add_sixels(vvi_text *out, const cli_thumbnail *t)
{
    const bool grey = is_grey(t);
    uint8_t *numbers = malloc((size_t)t->width * 6);
    if (!numbers) {
        out->bad = true;
        return;
    }
    vvi_text_printf(out, "\033P0;1;0q\"1;1;%d;%d", t->width, t->height);
    add_palette(out, grey);
    for (int y = 0; y < t->height; y += 6)
        add_band(out, t, y, grey, numbers);
    vvi_text_add(out, "\033\\\n");
    free(numbers);
}

void cli_terminal_picture(vvi_text *out, const cli_thumbnail *picture, cli_picture_kind kind)
{
    if (kind == CLI_PICTURE_SIXEL)
        add_sixels(out, picture);
    else if (kind == CLI_PICTURE_SHADES)
        add_shades(out, picture);
    else
        add_blocks(out, picture, kind);
}
