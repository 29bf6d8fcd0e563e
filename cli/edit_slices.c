/* --slice, --cross-hair, --window. */
#include "core/units.h"
#include "edits.h"
#include "value.h"
#include <string.h>

/* Lengths with units. */
static vv_status edit_cross_hair(cli_edits *edits, const char *typed)
{
    vvi_text json = {0};
    vv_status st = cli_value_point(&json, "cross-hair", typed);
    if (st == VV_OK)
        st = cli_edit_set(edits, "cross-hair", json.s, "cross_hair");
    vvi_text_free(&json);
    return st;
}

static vv_status edit_window(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    double window[2];
    char number[32];
    vv_status st = cli_value_numbers(window, 2, typed, false);
    (void)volume;
    if (st != VV_OK || !(window[0] < window[1]))
        return vv_fail(VV_E_ARGUMENT, "--window: expected two rising values LO..HI, found '%s'", typed);
    vvi_print_number(number, window[0]);
    if ((st = cli_edit_set(edits, "window", number, "volumes.%s.slices.window_lo", id)) != VV_OK)
        return st;
    vvi_print_number(number, window[1]);
    return cli_edit_set(edits, "window", number, "volumes.%s.slices.window_hi", id);
}

vv_status cli_edit_slices(cli_edits *edits)
{
    const cli_look *o = edits->look;
    vv_status st = cli_edit_set(edits, "slice", o->slice, "views.%s.render.slice.orientation", edits->view);
    if (st == VV_OK && o->cross_hair)
        st = edit_cross_hair(edits, o->cross_hair);
    return st == VV_OK && o->window ? cli_edit_each(edits, "window", edit_window) : st;
}
