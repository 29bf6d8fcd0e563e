/* --clip: cut planes of the World, through everything. */
#include "core/units.h"
#include "edits.h"
#include <ctype.h>
#include <stdio.h>
#include <string.h>

static vv_status fail_clip(const char *typed)
{
    return vv_fail(VV_E_ARGUMENT, "--clip: expected x:10mm..60mm, y:..30, z:5.. or 'plane(n=1,0,1 d=20mm)', found '%s'",
                   typed);
}

/* A plane as JSON text: the offset keeps its unit, the model converts it. */
static vv_status add_plane(cli_edits *edits, const char *normal, const char *offset)
{
    vvi_text json = {0};
    double number;
    vvi_text_printf(&json, "{\"normal\": [%s], \"offset\": ", normal);
    if (vvi_parse_number(&number, offset))
        vvi_text_add(&json, offset);
    else
        vvi_text_json(&json, offset);
    vvi_text_add(&json, "}");
    vv_status st = json.bad ? vv_fail_memory(json.n) : vv_model_add(edits->model, NULL, "cut_planes", NULL, json.s);
    if (st != VV_OK)
        st = vv_fail_in(st, "--clip");
    vvi_text_free(&json);
    return st;
}

static void negate(char out[64], const char *length)
{
    if (*length == '-')
        snprintf(out, 64, "%s", length + 1);
    else
        snprintf(out, 64, "-%s", *length == '+' ? length + 1 : length);
}

/* The two planes that were added last face one another: nothing is between them where the first is beyond the second.
 */
static vv_status check_order(const cli_edits *edits, const char *typed)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_collection *planes = world->cut_planes;
    const vv_cut_plane *lo = (const vv_cut_plane *)(const void *)planes->entry[planes->n - 2].object;
    const vv_cut_plane *hi = (const vv_cut_plane *)(const void *)planes->entry[planes->n - 1].object;
    const bool keeps = lo->offset <= -hi->offset;
    vv_object_release(&world->base);
    return keeps ? VV_OK
                 : vv_fail(VV_E_ARGUMENT,
                           "--clip %s keeps nothing: expected LO..HI with LO below HI, found LO above HI", typed);
}

/* "x:10mm..60mm" */
static vv_status clip_axis(cli_edits *edits, const char *typed)
{
    static const char *const up[] = {"1,0,0", "0,1,0", "0,0,1"}, *const down[] = {"-1,0,0", "0,-1,0", "0,0,-1"};
    const int axis = tolower((unsigned char)typed[0]) - 'x';
    const char *first = typed + 2, *dots = strstr(first, "..");
    char lo[64], hi[64];
    vv_status st = VV_OK;
    if (!dots || (size_t)(dots - first) >= sizeof lo || strlen(dots + 2) + 2 > sizeof hi || (dots == first && !dots[2]))
        return fail_clip(typed);
    snprintf(lo, sizeof lo, "%.*s", (int)(dots - first), first);
    if (*lo)
        st = add_plane(edits, up[axis], lo);
    if (st == VV_OK && dots[2]) {
        negate(hi, dots + 2);
        st = add_plane(edits, down[axis], hi);
    }
    return st == VV_OK && *lo && dots[2] ? check_order(edits, typed) : st;
}

/* "x:10mm..60mm,y:..30" */
static vv_status clip_axes(cli_edits *edits, const char *typed)
{
    vv_status st = VV_OK;
    for (const char *at = typed; at && st == VV_OK;) {
        char one[160];
        const size_t n = strcspn(at, ",");
        const int axis = tolower((unsigned char)at[0]) - 'x';
        if (n >= sizeof one || axis < 0 || axis > 2 || at[1] != ':')
            return fail_clip(typed);
        snprintf(one, sizeof one, "%.*s", (int)n, at);
        st = clip_axis(edits, one);
        at = at[n] ? at + n + 1 : NULL;
    }
    return st;
}

/* "plane(n=1,0,1 d=20mm)" */
static vv_status clip_plane(cli_edits *edits, const char *typed)
{
    char normal[128] = "", offset[64] = "0";
    const char *at = typed + strlen("plane(");
    while (*at && *at != ')') {
        const size_t n = strcspn(at, " )");
        if (n > 2 && strncmp(at, "n=", 2) == 0 && n - 2 < sizeof normal)
            snprintf(normal, sizeof normal, "%.*s", (int)(n - 2), at + 2);
        else if (n > 2 && strncmp(at, "d=", 2) == 0 && n - 2 < sizeof offset)
            snprintf(offset, sizeof offset, "%.*s", (int)(n - 2), at + 2);
        else
            return fail_clip(typed);
        at += n;
        at += strspn(at, " ");
    }
    if (!*normal || strcmp(at, ")") != 0)
        return fail_clip(typed);
    return add_plane(edits, normal, offset);
}

vv_status cli_edit_clip(cli_edits *edits)
{
    const char *typed;
    vv_status st = VV_OK;
    for (size_t i = 0; (typed = cli_word_nth(edits->look->clip, i)) && st == VV_OK; i++) {
        const int axis = tolower((unsigned char)typed[0]);
        if (axis >= 'x' && axis <= 'z' && typed[1] == ':')
            st = clip_axes(edits, typed);
        else if (strncmp(typed, "plane(", 6) == 0)
            st = clip_plane(edits, typed);
        else
            st = fail_clip(typed);
    }
    return st;
}
