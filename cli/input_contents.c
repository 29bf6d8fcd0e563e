/* What an input is: data, a scene, or a picture that VolVis made, by its first bytes and its suffix. */
#include "input.h"
#include "value.h"
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

/* The first bytes of standard input, which stay there to be read; 0 where the system cannot look ahead. */
static size_t peek_standard_input(unsigned char *out, size_t n)
{
    const off_t at = lseek(STDIN_FILENO, 0, SEEK_CUR);
    ssize_t got = at >= 0 ? pread(STDIN_FILENO, out, n, at) : 0;
#ifdef __linux__
    int copy[2];
    struct pollfd input = {.fd = STDIN_FILENO, .events = POLLIN};
    /* poll ends with a signal, tee goes on waiting */
    if (at < 0 && poll(&input, 1, -1) == 1 && pipe2(copy, O_CLOEXEC) == 0) {
        if (tee(STDIN_FILENO, copy[1], n, SPLICE_F_NONBLOCK) > 0)
            got = read(copy[0], out, n);
        close(copy[0]);
        close(copy[1]);
    }
#endif
    return got > 0 ? (size_t)got : 0;
}

static size_t peek_file(unsigned char *out, size_t n, const char *path)
{
    struct stat about;
    if (stat(path, &about) != 0 || !S_ISREG(about.st_mode))
        return 0; /* what a stream gives is gone once it is read */
    FILE *file = fopen(path, "rbe");
    const size_t got = file ? fread(out, 1, n, file) : 0;
    if (file)
        fclose(file);
    return got;
}

size_t cli_input_peek(unsigned char *out, size_t n, const char *path)
{
    return strcmp(path, "-") == 0 ? peek_standard_input(out, n) : peek_file(out, n, path);
}

/* What a format of volumes is certain of: a TIFF, where VolVis did not make a picture of it. */
static bool is_volume(const vv_registry *registry, const unsigned char *head, size_t n, const char *path)
{
    for (const vv_format *const *row = registry->formats; *row; row++)
        if ((*row)->probe && (*row)->probe(head, n, path) == 2)
            return true;
    return false;
}

/* By content; what it leaves in doubt the suffix decides. */
static bool is_picture(const vv_registry *registry, const unsigned char *head, size_t n, const char *path)
{
    for (const vv_image_format *const *row = registry->image_formats; *row; row++) {
        const int sure = n > 0 && (*row)->probe ? (*row)->probe(head, n, path) : 0;
        if (sure == 2)
            return true;
        for (size_t s = 0; sure == 1 && !is_volume(registry, head, n, path) && (*row)->suffixes[s]; s++)
            if (cli_ends_with(path, (*row)->suffixes[s]))
                return true;
    }
    return false;
}

cli_input_kind cli_input_guess(const cli_command *command, const char *path)
{
    static const unsigned char png[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    const cli_reading *reading = cli_command_options(command, &cli_reading_class);
    const bool standard = strcmp(path, "-") == 0;
    unsigned char head[64] = {0};
    size_t blank = 0;
    if (reading->raw || reading->input_format || vv_job_cancelled(command->job))
        return CLI_INPUT_DATA;
    if (cli_ends_with(path, ".vv.json"))
        return CLI_INPUT_SCENE;
    const size_t n = cli_input_peek(head, sizeof head, path);
    while (blank < n && strchr(" \t\r\n", head[blank]))
        blank++;
    if (standard && blank < n && head[blank] == '{')
        return CLI_INPUT_SCENE;
    /* a pipe may give less than the whole mark at first: no data begins with a part of it */
    const bool picture = (n > 0 && memcmp(head, png, n < sizeof png ? n : sizeof png) == 0) ||
                         is_picture(command->registry, head, n, path);
    return picture ? CLI_INPUT_PICTURE : CLI_INPUT_DATA;
}

/* What a stream gave is gone once it was looked into. */
const char *cli_input_pixels(const cli_command *command, const char *path)
{
    unsigned char head[64];
    const size_t n = peek_file(head, sizeof head, path);
    for (const vv_format *const *row = command->registry->formats; n > 0 && *row; row++)
        if ((*row)->probe && (*row)->probe(head, n, path) > 0)
            return (*row)->name;
    return NULL;
}

cli_input_kind cli_input_contents(const cli_command *command, const char *path)
{
    const cli_input_kind kind = cli_input_guess(command, path);
    const bool slice = kind == CLI_INPUT_PICTURE && strcmp(path, "-") != 0 && cli_input_pixels(command, path) &&
                       vvi_recipe_is_missing(path, command->job);
    return slice ? CLI_INPUT_DATA : kind;
}
