/** @file
 * render --resume: a picture that is saved on the way, and gone on with by the next run.
 */
#ifndef CLI_RESUMING_H
#define CLI_RESUMING_H
#include "rendering.h"

/** The file that --resume names, {stem} replaced, into r->checkpoint; VV_E_ARGUMENT where it has no meaning. */
vv_status cli_resuming_check(cli_rendering *r);
/** Renders r->image, from the checkpoint where there is one. r->saved: it was stopped, there is no image, and the
 * checkpoint is written. */
vv_status cli_resuming_render(cli_rendering *r, vv_render_report *report);
/** The picture is written: its checkpoint goes. */
void cli_resuming_end(const cli_rendering *r);
/** What a run that was stopped says. */
void cli_resuming_report(cli_rendering *r);
#endif
