/* --tf, --range, --percentile, --threshold, --window: what of the values is seen. */
#include "choices.h"
#include "core/job.h"
#include "core/units.h"
#include "edits.h"
#include "grid/fill_value.h"
#include "grid/percentile.h"
#include "refusal.h"
#include "value.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>
#include <volvis/image.h>
#include <volvis/render.h>

enum { MAX_FILE = 1 << 20 };

static const char transfer_path[] = "volumes.%s.segmentation.transfer";

/* Nodes ----------------------------------------------------------------------------------------------------------- */

typedef struct nodes {
    vvi_text opacity, color; /* JSON rows */
    bool any_color;
    double last;
} nodes;

static bool hex_digit(double *out, char c)
{
    const char *digits = "0123456789abcdef", *at = strchr(digits, c | 0x20);
    if (!c || !at)
        return false;
    *out = (double)(at - digits);
    return true;
}

/* "#rgb" or "#rrggbb" to linear; how many characters were taken, 0 when it is no colour. */
static size_t scan_color(double rgb[3], const char *text)
{
    double digit[6];
    size_t n = 0;
    if (*text != '#')
        return 0;
    while (n < 6 && hex_digit(&digit[n], text[1 + n]))
        n++;
    if (n != 3 && n != 6)
        return 0;
    for (int c = 0; c < 3; c++)
        rgb[c] = vv_srgb_decode((n == 3 ? 17 * digit[c] : 16 * digit[2 * c] + digit[2 * c + 1]) / 255);
    return n + 1;
}

static void add_row(vvi_text *out, const double *row, size_t n)
{
    vvi_text_add(out, out->n ? ",[" : "[");
    for (size_t i = 0; i < n; i++) {
        char number[32];
        vvi_print_number(number, row[i]);
        vvi_text_printf(out, "%s%s", i ? "," : "", number);
    }
    vvi_text_add(out, "]");
}

static vv_status fail_node(const char *at)
{
    return vv_fail(
        VV_E_ARGUMENT,
        "--tf: expected nodes VALUE:OPACITY[#COLOUR] by rising value, as in '0:0 300:0.1#e0b090', found '%.*s'",
        (int)strcspn(at, " "), at);
}

static vv_status scan_node(nodes *out, const char **at)
{
    double node[2], color[4];
    const char *text = *at;
    if (!vvi_scan_number(&node[0], text, &text) || *text++ != ':' || !vvi_scan_number(&node[1], text, &text) ||
        !(node[0] >= out->last) || !(node[1] >= 0 && node[1] <= 1))
        return fail_node(*at);
    const size_t n = scan_color(color + 1, text);
    if (n) {
        color[0] = node[0];
        add_row(&out->color, color, 4);
        out->any_color = true;
    }
    text += n;
    if (*text && *text != ' ')
        return fail_node(*at);
    add_row(&out->opacity, node, 2);
    out->last = node[0];
    *at = text + strspn(text, " ");
    return VV_OK;
}

static vv_status parse_nodes(nodes *out, const char *text)
{
    vv_status st = VV_OK;
    *out = (nodes){.last = -1e308};
    text += strspn(text, " ");
    while (*text && st == VV_OK)
        st = scan_node(out, &text);
    if (st == VV_OK && (out->opacity.bad || out->color.bad))
        st = vv_fail_memory(out->opacity.n);
    return st;
}

/* Ways to say it -------------------------------------------------------------------------------------------------- */

/* What a transfer function replaces in a volume that has one already. */
static vv_status clear(cli_edits *edits, const char *id, bool opacity_too)
{
    static const char *const replaced[] = {"color", "colormap", "opacity", "preset", "opacity_length"};
    vv_status st = cli_edit_set(edits, "tf", "transfer", "volumes.%s.segmentation.kind", id);
    for (size_t i = 0; i < (opacity_too ? 5u : 2u) && st == VV_OK; i++)
        st = cli_edit_unset(edits, "volumes.%s.segmentation.transfer.%s", id, replaced[i]);
    return st;
}

static vv_status set_part(cli_edits *edits, const char *id, const char *value, const char *property)
{
    return cli_edit_set(edits, "tf", value, "volumes.%s.segmentation.transfer.%s", id, property);
}

static vv_status set_nodes(cli_edits *edits, const char *id, const nodes *n)
{
    vvi_text opacity = {0}, color = {0};
    vv_status st = clear(edits, id, true);
    vvi_text_printf(&opacity, "[%s]", n->opacity.s);
    vvi_text_printf(&color, "[%s]", n->any_color ? n->color.s : "");
    if (st == VV_OK && (opacity.bad || color.bad))
        st = vv_fail_memory(opacity.n);
    if (st == VV_OK && (st = set_part(edits, id, opacity.s, "opacity")) == VV_OK && n->any_color)
        st = set_part(edits, id, color.s, "color");
    if (st == VV_OK)
        st = set_part(edits, id, "1", "opacity_length"); /* one unit of length, whatever the spacing */
    vvi_text_free(&opacity);
    vvi_text_free(&color);
    return st;
}

static vv_status edit_nodes(cli_edits *edits, const char *typed, const char *id)
{
    nodes n;
    vv_status st = parse_nodes(&n, typed);
    if (st == VV_OK)
        st = set_nodes(edits, id, &n);
    vvi_text_free(&n.opacity);
    vvi_text_free(&n.color);
    return st;
}

/* "map:bone" is the colour map where a transfer function has the same name. */
static const char map_mark[] = "map:";

static const vv_preset *find_preset(const char *name, bool any_case)
{
    const bool map = strncmp(name, map_mark, sizeof map_mark - 1) == 0;
    const vv_preset *preset;
    int (*const differ)(const char *, const char *) = any_case ? strcasecmp : strcmp;
    name += map ? sizeof map_mark - 1 : 0;
    for (size_t i = 0; (preset = vv_preset_nth(i)); i++) {
        if ((differ(preset->name, name) == 0 || (preset->alias && differ(preset->alias, name) == 0)) &&
            (!map || strcmp(preset->kind, "colormap") == 0))
            return preset;
    }
    return NULL;
}

/* Slices show a colour map over their window, and other transfer functions by their colours. */
static vv_status edit_slice(cli_edits *edits, const char *id, const char *map)
{
    if (!cli_edit_is_slice(edits))
        return VV_OK;
    const vv_status st = cli_edit_set(edits, "tf", map ? "window" : "transfer", "volumes.%s.slices.colors", id);
    return st == VV_OK ? cli_edit_set(edits, "tf", map, "volumes.%s.slices.colormap", id) : st;
}

static vv_status edit_preset(cli_edits *edits, const vv_preset *preset, const char *id)
{
    const bool transfer = strcmp(preset->kind, "colormap") != 0;
    vv_status st = clear(edits, id, transfer);
    if (st == VV_OK)
        st = set_part(edits, id, preset->name, transfer ? "preset" : "colormap");
    return st == VV_OK ? edit_slice(edits, id, transfer ? NULL : preset->name) : st;
}

static vv_status read_text(char **out, const char *path)
{
    FILE *file = fopen(path, "rbe");
    char *text = file ? malloc(MAX_FILE + 1) : NULL;
    const size_t n = text ? fread(text, 1, MAX_FILE, file) : 0;
    const bool whole = file && text && feof(file) && !ferror(file);
    if (file)
        fclose(file);
    *out = text;
    if (whole) {
        text[n] = 0;
        return VV_OK;
    }
    free(text);
    *out = NULL;
    return vv_fail_at(VV_E_READ, path, NULL,
                      "cannot be read as a transfer function: JSON of at most 1 MiB was expected");
}

static vv_status edit_file(cli_edits *edits, const char *typed, const char *id)
{
    char *json = NULL;
    vv_status st;
    vvi_job_tell_read(edits->command->job, typed);
    if ((st = read_text(&json, typed)) != VV_OK)
        return st;
    if (cli_edit_set(edits, "tf", json, transfer_path, id) != VV_OK)
        st = vv_fail_at(VV_E_FORMAT, typed, NULL, "%s", vv_error_last()->message);
    else
        st = cli_edit_set(edits, "tf", "transfer", "volumes.%s.segmentation.kind", id);
    free(json);
    return st;
}

static vv_status fail_unknown(const cli_edits *edits, const char *typed)
{
    return cli_choice_fail(VV_E_ARGUMENT, edits->command->registry, "presets", "--tf: no preset or file", typed);
}

static vv_status edit_tf(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    const vv_preset *preset = find_preset(typed, access(typed, R_OK) != 0);
    double value;
    const char *end;
    vv_status st;
    (void)volume;
    if (preset)
        return edit_preset(edits, preset, id);
    if (vvi_scan_number(&value, typed, &end) && *end == ':')
        st = edit_nodes(edits, typed, id);
    else if (access(typed, R_OK) == 0)
        st = edit_file(edits, typed, id);
    else
        return fail_unknown(edits, typed);
    return st == VV_OK ? edit_slice(edits, id, NULL) : st;
}

/* Ranges ---------------------------------------------------------------------------------------------------------- */

/* "slices.window": its window_lo and window_hi. */
static vv_status set_ends(cli_edits *edits, const char *option, const char *id, const char *property,
                          const double range[2])
{
    char number[32];
    vvi_print_number(number, range[0]);
    const vv_status st = cli_edit_set(edits, option, number, "volumes.%s.%s_lo", id, property);
    vvi_print_number(number, range[1]);
    return st == VV_OK ? cli_edit_set(edits, option, number, "volumes.%s.%s_hi", id, property) : st;
}

static vv_status set_range(cli_edits *edits, const char *option, const char *id, const double range[2])
{
    const vv_status st = set_ends(edits, option, id, "segmentation.transfer.range", range);
    return st == VV_OK && cli_edit_is_slice(edits) ? set_ends(edits, option, id, "slices.window", range) : st;
}

/* Two rising numbers. */
static bool read_rising(double out[2], const char *typed)
{
    return cli_value_numbers(out, 2, typed, false) == VV_OK && out[0] < out[1];
}

static vv_status edit_range(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    double range[2];
    (void)volume;
    if (!read_rising(range, typed))
        return vv_fail(VV_E_ARGUMENT, "--range: expected two rising values LO..HI, found '%s'", typed);
    return set_range(edits, "range", id, range);
}

static vv_status edit_window(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    double window[2];
    (void)volume;
    if (!read_rising(window, typed))
        return vv_fail(VV_E_ARGUMENT, "--window: expected two rising values LO..HI, found '%s'", typed);
    return set_ends(edits, "window", id, "slices.window", window);
}

/* Both percentiles are one value (most samples are the background): the other end is that of all samples then. */
static vv_status open_window(double range[2], const vv_field *field, int component, vv_job *job)
{
    vv_statistics *statistics = malloc(sizeof *statistics);
    if (!statistics)
        return vv_fail_memory(sizeof *statistics);
    const vv_status st = vv_field_statistics(statistics, field, component, job);
    if (st == VV_OK) {
        range[0] = range[0] < statistics->max ? range[0] : statistics->min;
        range[1] = statistics->max;
    }
    free(statistics);
    return st;
}

/* What pictures leave out is none of the samples. */
static vv_status leave_missing_out(vv_field **field, int *component, const vv_volume *volume, vv_job *job)
{
    const vv_numbers *named = vv_object_is_set(&volume->base, "missing") ? volume->missing : NULL;
    vvi_fills fills = {0};
    vv_field *rest = NULL;
    vv_status st = VV_OK;
    if (!vv_object_is_set(&volume->base, "missing") && vv_field_get_info(*field)->meaning == VV_MEANING_SCALAR)
        st = vvi_fills_of(&fills, *field, *component, job);
    if (st != VV_OK || (fills.n == 0 && (!named || named->n == 0)))
        return st;
    st = named ? vvi_field_without(&rest, *field, *component, named->v, named->n, job)
               : vvi_field_without_fills(&rest, *field, *component, &fills, job);
    if (st != VV_OK)
        return st;
    vv_field_release(*field);
    *field = rest;
    *component = 0;
    return VV_OK;
}

/* Percents become values of the time step that is shown. */
static vv_status measure(double range[2], cli_edits *edits, const vv_volume *volume)
{
    vv_world *world = vv_model_snapshot(edits->model);
    const vv_dataset *dataset = vvi_volume_dataset(world, volume);
    const char *data = vvi_volume_dataset_id(world, volume);
    const double percents[2] = {range[0], range[1]};
    vv_job *job = edits->command->job;
    vv_field *field = NULL;
    int component = (int)volume->component;
    vv_status st = VV_OK;
    if (!dataset)
        st = vv_fail(VV_E_NOT_FOUND, "no dataset '%s'", data ? data : "");
    else if (vv_dataset_is_mesh(dataset, job))
        st = cli_refused(
            edits->command, "percentile",
            vv_fail(VV_E_ARGUMENT,
                    "is of the samples of volumes, and '%s' is a mesh; --range LO..HI is for values at vertices",
                    data));
    else if ((st = vv_dataset_field(&field, world, dataset, volume->attribute, volume->frame, job)) == VV_OK)
        st = leave_missing_out(&field, &component, volume, job);
    if (st == VV_OK && field)
        st = vvi_field_percentiles(range, percents, field, component, job);
    if (st == VV_OK && !(range[0] < range[1]))
        st = open_window(range, field, component, job);
    vv_field_release(field);
    vv_object_release(&world->base);
    return st;
}

static vv_status edit_percentile(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    double range[2];
    if (!read_rising(range, typed) || range[0] < 0 || range[1] > 100)
        return vv_fail(VV_E_ARGUMENT,
                       "--percentile: expected two rising numbers from 0 to 100, as in 1..99.8, found '%s'", typed);
    const vv_status st = measure(range, edits, volume);
    if (st != VV_OK)
        return vv_fail_in(st, "--percentile");
    return set_range(edits, "percentile", id, range);
}

static vv_status edit_threshold(cli_edits *edits, const char *typed, const char *id, const vv_volume *volume)
{
    char lo[64], hi[64];
    vv_status st;
    (void)volume;
    if (!cli_value_split_range(lo, hi, typed))
        return vv_fail(VV_E_ARGUMENT,
                       "--threshold: expected LO..HI with either left out if it has no limit, found '%s'", typed);
    if ((st = cli_edit_set(edits, "threshold", "threshold", "volumes.%s.segmentation.kind", id)) != VV_OK ||
        (st = cli_edit_set(edits, "threshold", *lo ? lo : "-1e308", "volumes.%s.segmentation.threshold.lo", id)) !=
            VV_OK)
        return st;
    return cli_edit_set(edits, "threshold", *hi ? hi : "1e308", "volumes.%s.segmentation.threshold.hi", id);
}

vv_status cli_edit_transfer(cli_edits *edits)
{
    static const struct {
        const char *option;
        cli_edit_value_fn *edit;
    } values[] = {{"window", edit_window},
                  {"tf", edit_tf},
                  {"range", edit_range},
                  {"percentile", edit_percentile},
                  {"threshold", edit_threshold}};
    const cli_look *o = edits->look;
    vv_status st = VV_OK;
    const char *other = o->range ? "range" : o->percentile ? "percentile" : o->opacity ? "opacity" : NULL;
    if (!edits->ends && o->threshold && other)
        return cli_refused(edits->command, "threshold,range,percentile,opacity",
                           vv_fail(VV_E_ARGUMENT,
                                   "--%s is of transfer functions, and --threshold shows a solid: give one of them",
                                   other));
    if (o->range && o->percentile)
        return cli_refused(edits->command, "range,percentile",
                           vv_fail(VV_E_ARGUMENT, "--range and --percentile say the same thing: give one of them"));
    if (!edits->ends && o->window && (o->range || o->percentile) && cli_edit_is_slice(edits))
        return cli_refused(edits->command, "range,percentile,window",
                           vv_fail(VV_E_ARGUMENT, "--%s sets the window of slices, as --window does: give one of them",
                                   o->range ? "range" : "percentile"));
    if (!edits->ends && o->tf && o->threshold)
        return cli_refused(
            edits->command, "tf,threshold",
            vv_fail(VV_E_ARGUMENT, "--tf and --threshold are two ways to say what is seen: give one of them"));
    for (size_t i = 0; i < sizeof values / sizeof *values && st == VV_OK; i++)
        if (cli_look_text(o, values[i].option))
            st = cli_edit_each(edits, values[i].option, true, values[i].edit);
    return st;
}
