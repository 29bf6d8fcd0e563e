#include "info_preview.h"
#include "preview.h"
#include "terminal_picture.h"
#include "value.h"
#include <math.h>
#include <stdlib.h>

enum { WIDTH = 1024, HEIGHT = 512, SIDE_MOST = 16384 };

static vv_status parse_size(int *width, int *height, const char *typed)
{
    double size[2];
    if (cli_value_numbers(size, 2, typed, true) != VV_OK || !(size[0] >= 1 && size[0] <= SIDE_MOST) ||
        !(size[1] >= 1 && size[1] <= SIDE_MOST) || size[0] != floor(size[0]) || size[1] != floor(size[1]))
        return vv_fail(VV_E_ARGUMENT, "--size: expected WIDTHxHEIGHT in pixels, as in 1024x768, found '%s'", typed);
    *width = (int)size[0];
    *height = (int)size[1];
    return VV_OK;
}

static vv_status write_file(cli_command *command, const cli_slice *slices, int n, const char *size)
{
    cli_thumbnail picture = {0};
    vv_image *image = NULL;
    int width = WIDTH, height = HEIGHT;
    const char *output = command->common->output;
    vv_status st = size ? parse_size(&width, &height, size) : VV_OK;
    if (st == VV_OK)
        st = cli_thumbnail_make(&picture, slices, n, width, height, size != NULL, 1);
    if (st == VV_OK)
        st = cli_thumbnail_image(&image, &picture, command->job);
    if (st == VV_OK)
        st = vv_image_write(output, image, NULL, command->job);
    if (st == VV_OK) {
        vvi_result_string(&command->json, "preview", output);
        cli_command_line(command, "preview", "%s: %d x %d", output, picture.width, picture.height);
    }
    vv_image_release(image);
    free(picture.rgb);
    return st;
}

static vv_status show(cli_command *command, const cli_slice *slices, int n, cli_preview_kind kind)
{
    cli_thumbnail picture = {0};
    int width, height;
    double aspect;
    const cli_picture_kind how = kind == CLI_PREVIEW_SIXEL    ? CLI_PICTURE_SIXEL
                                 : kind == CLI_PREVIEW_BLOCKS ? cli_terminal_blocks()
                                                              : cli_terminal_picture_kind();
    cli_terminal_picture_size(&width, &height, &aspect, how);
    const vv_status st = cli_thumbnail_make(&picture, slices, n, width, height, false, aspect);
    if (st == VV_OK)
        cli_terminal_picture(&command->text, &picture, how);
    free(picture.rgb);
    return st;
}

vv_status cli_info_preview(cli_command *command, const cli_input *input, const vv_field *field, cli_preview_kind kind,
                           const char *size)
{
    cli_slice slices[CLI_SLICES];
    int n = 0, width = WIDTH, height = HEIGHT;
    vv_status st = size && command->common->output ? parse_size(&width, &height, size) : VV_OK;
    if (st != VV_OK)
        return st;
    st = cli_slices_read(slices, &n, input, field, input->frame < 0 ? 0 : input->frame, width > height ? width : height,
                         command->job);
    if (st == VV_OK)
        st = command->common->output ? write_file(command, slices, n, size) : show(command, slices, n, kind);
    cli_slices_finish(slices);
    return st;
}
