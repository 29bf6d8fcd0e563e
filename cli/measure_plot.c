/* Plots of what was measured, as files. */
#include "measure.h"
#include "output.h"
#include "report.h"

bool cli_plot_wanted(const cli_command *command)
{
    const char *output = command->common->output;
    return output && (cli_output_is_figure(output) || cli_output_picture(command->registry, output));
}

vv_status cli_plot_check(cli_command *command)
{
    const char *output = command->common->output;
    command->verb.makes_file = true;
    return cli_output_check(command, output, cli_output_is_figure(output) ? CLI_OUTPUT_TEXT : CLI_OUTPUT_IMAGE, NULL);
}

static vv_status write_svg(cli_command *command, const vvi_plot *plot)
{
    vvi_text document = {0};
    vv_status st = vvi_plot_svg(&document, plot, command->job);
    if (st == VV_OK)
        st = cli_report_file(command, command->common->output, document.s, document.n);
    vvi_text_free(&document);
    return st;
}

static vv_status write_image(cli_command *command, const vvi_plot *plot)
{
    vv_image *image = NULL;
    vv_image_options options;
    bool lettered;
    vv_image_options_init(&options, sizeof options);
    vv_status st = vvi_plot_image(&image, &lettered, plot, command->job);
    if (st == VV_OK && !lettered)
        cli_command_note(command, "the plot has no lettering: %s", vv_error_last()->message);
    if (st == VV_OK)
        st = vv_image_write(command->common->output, image, &options, command->job);
    vv_image_release(image);
    return st;
}

vv_status cli_plot_write(cli_command *command, const vv_answer *answer, const char *file, bool logarithmic)
{
    const char *output = command->common->output;
    char title[256], subtitle[256];
    if (!cli_plot_wanted(command))
        return VV_OK;
    if (!answer->plot)
        return vv_fail(VV_E_ARGUMENT, "-o %s: no sample of %s %s: there is nothing to plot", output, file,
                       answer->no_plot ? answer->no_plot : "is known");
    vvi_plot shown = *answer->plot;
    shown.title = vvi_plot_words(title, sizeof title, shown.title);
    shown.subtitle = vvi_plot_words(subtitle, sizeof subtitle, shown.subtitle);
    shown.log_y = logarithmic && shown.steps;
    const vv_status st = cli_output_is_figure(output) ? write_svg(command, &shown) : write_image(command, &shown);
    if (st != VV_OK)
        return st;
    vvi_result_string(&command->json, "output", output);
    cli_command_line(command, "plot", "%s", output);
    return VV_OK;
}
