#include "resuming.h"
#include "batch.h"
#include "output.h"
#include "refusal.h"
#include "render/picture.h"
#include "signals.h"
#include <math.h>
#include <unistd.h>

/* Between two checkpoints; more where writing one takes long, so that it costs a fiftieth at most. STEP_S: how long a
 * signal may have to wait. */
#define SAVE_EVERY_S 5.0
#define SAVE_SHARE 50.0
#define STEP_S 0.2
/* The first one comes as early as costs no more than that: writing takes about 50 ns a pixel. */
#define FIRST_S 1.0
#define WRITE_S_PER_PIXEL 50e-9

vv_status cli_resuming_check(cli_rendering *r)
{
    const char *named = r->options->resume;
    if (!named)
        return VV_OK;
    if (r->options->repeat > 0)
        return cli_refused(r->command, "resume,repeat",
                           vv_fail(VV_E_ARGUMENT, "--repeat times whole pictures, and --resume goes on with parts of "
                                                  "one; omit either"));
    if (r->is_figure)
        return cli_refused(r->command, "resume",
                           vv_fail(VV_E_ARGUMENT, "--resume: an SVG figure is made at once; write an image"));
    if (r->command->watch)
        return cli_refused(r->command, "resume",
                           vv_fail(VV_E_ARGUMENT, "--resume: what is watched is made anew each time; omit --watch"));
    const vv_status st = cli_batch_name(&r->checkpoint, named, r->command->args.words[0]);
    if (st != VV_OK)
        return st;
    return cli_output_is(r->output, r->checkpoint)
               ? cli_refused(r->command, "resume", vv_fail(VV_E_ARGUMENT, "--resume %s is the picture itself", named))
               : VV_OK;
}

/* From the checkpoint; that there is none is how a picture begins. */
static vv_status take_up(cli_rendering *r, vv_picture *picture)
{
    const vv_status st = vv_picture_resume(picture, r->checkpoint, r->command->job);
    r->resumed = st == VV_OK;
    return st == VV_E_NOT_FOUND ? VV_OK : st;
}

static vv_status step(cli_rendering *r, vv_picture *picture)
{
    vv_picture_until until;
    vv_picture_until_init(&until, sizeof until);
    until.seconds = STEP_S;
    return vv_picture_step(picture, &until, r->command->job);
}

static double first_after_s(const cli_rendering *r)
{
    const vv_view *view = cli_rendering_view(r);
    const double pixels = (double)view->width * (double)view->height;
    return fmin(fmax(SAVE_SHARE * WRITE_S_PER_PIXEL * pixels, FIRST_S), SAVE_EVERY_S);
}

static vv_status go_on(cli_rendering *r, vv_picture *picture)
{
    double next_s = cli_now_s() + first_after_s(r);
    vv_status st = VV_OK;
    while (st == VV_OK && !vv_picture_is_whole(picture)) {
        if ((st = step(r, picture)) != VV_OK || vv_picture_is_whole(picture))
            return st;
        const double now_s = cli_now_s();
        r->saved = cli_signals_came();
        if (!r->saved && now_s < next_s)
            continue;
        st = vv_picture_save(picture, r->checkpoint, r->command->job);
        if (r->saved)
            return st;
        next_s = cli_now_s() + fmax(SAVE_EVERY_S, SAVE_SHARE * (cli_now_s() - now_s));
    }
    return st;
}

vv_status cli_resuming_render(cli_rendering *r, vv_render_report *report)
{
    vv_picture *picture;
    vv_status st = vv_picture_new(&picture, r->world, r->recipe.view, false, r->command->job);
    if (st != VV_OK)
        return st;
    if ((st = take_up(r, picture)) == VV_OK) {
        cli_signals_soften();
        st = go_on(r, picture);
    }
    r->done = vv_picture_done(picture);
    if (st == VV_OK && !r->saved)
        st = vvi_picture_take(&r->image, NULL, picture, r->command->job);
    vv_picture_report(report, picture);
    vv_picture_free(picture);
    return st;
}

void cli_resuming_end(const cli_rendering *r)
{
    if (r->checkpoint)
        unlink(r->checkpoint);
}

void cli_resuming_report(cli_rendering *r)
{
    vvi_result *json = &r->command->json;
    vvi_result_string(json, "checkpoint", r->checkpoint);
    vvi_result_number(json, "done", r->done);
    vvi_result_unsigned(json, "rays", r->last.rays);
    vvi_result_number(json, "render_s", r->last.render_s);
    vvi_text_add_clean(&r->command->text, r->checkpoint);
    vvi_text_printf(&r->command->text, ": stopped with %.0f %% of the picture; the same command goes on from there\n",
                    floor(100 * r->done));
    r->command->exit_code = CLI_EXIT_RESUMABLE;
}
