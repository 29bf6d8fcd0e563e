#include "info_preview.h"
#include "terminal_picture.h"
#include "value.h"
#include <math.h>
#include <stdlib.h>
#include <volvis/preview.h>

static vv_status parse_size(vv_preview_options *out, const char *typed)
{
    double size[2];
    if (cli_value_numbers(size, 2, typed, true) != VV_OK || !(size[0] >= 1 && size[0] <= VV_PREVIEW_SIDE_MOST) ||
        !(size[1] >= 1 && size[1] <= VV_PREVIEW_SIDE_MOST) || size[0] != floor(size[0]) || size[1] != floor(size[1]))
        return vv_fail(VV_E_ARGUMENT, "--size: expected WIDTHxHEIGHT in pixels, as in 1024x768, found '%s'", typed);
    out->width = (int)size[0];
    out->height = (int)size[1];
    out->exact = true;
    return VV_OK;
}

static vv_status write_file(cli_command *command, vv_file *file, const vv_preview_options *options)
{
    vv_image *image = NULL;
    const char *output = command->common->output;
    vv_status st = vv_preview_new(&image, file, options, command->job);
    if (st == VV_OK && (st = vv_image_write(output, image, NULL, command->job)) == VV_OK) {
        vvi_result_string(&command->json, "preview", output);
        cli_command_line(command, "preview", "%s: %d x %d", output, image->width, image->height);
    }
    vv_image_release(image);
    return st;
}

static vv_status show(cli_command *command, vv_file *file, vv_preview_options *options, cli_preview_kind kind)
{
    vv_image *image = NULL;
    char *text = NULL;
    const vv_letters letters = kind == CLI_PREVIEW_SIXEL    ? VV_LETTERS_SIXEL
                               : kind == CLI_PREVIEW_BLOCKS ? cli_terminal_blocks()
                                                            : cli_terminal_letters();
    options->detail = options->width; /* letters are few: each is the mean of many samples */
    cli_terminal_picture_size(&options->width, &options->height, &options->aspect, letters);
    vv_status st = vv_preview_new(&image, file, options, command->job);
    if (st == VV_OK && (st = vv_image_letters(&text, image, letters)) == VV_OK)
        vvi_text_add(&command->text, text);
    vv_image_release(image);
    free(text);
    return st;
}

vv_status cli_info_preview(cli_command *command, const cli_input *input, const vv_field *field, cli_preview_kind kind,
                           const char *size)
{
    vv_preview_options options;
    vv_preview_options_init(&options, sizeof options);
    options.frame = input->frame < 0 ? 0 : input->frame;
    options.field = field;
    const vv_status st = size ? parse_size(&options, size) : VV_OK;
    if (st != VV_OK)
        return st;
    return command->common->output ? write_file(command, input->file, &options)
                                   : show(command, input->file, &options, kind);
}
