/* From NRRD to NRRD: what the header of the file says from which the samples come, and the result's info does not. Keys
 * of others go on as long as samples have their values; what is said of axes, as long as these run as they did. */
#include "core/units.h"
#include "io/formats/nifti/nifti.h"
#include "io/formats/nrrd/nrrd_lines.h"
#include "io/placement.h"
#include "io/scan.h"
#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Keeping --------------------------------------------------------------------------------------------------------- */

static void keep_thicknesses(vvi_nrrd *h, const char *at)
{
    for (int a = 0; at && a < h->dimension; a++)
        if (!vvi_scan_real(&h->axis[a].thickness, at, &at))
            return;
}

/* "x" "y" "z"; a label with a quote in it ends what is kept. */
static void keep_labels(vvi_nrrd *h, const char *at)
{
    for (int a = 0; at && a < h->dimension; a++) {
        at += strspn(at, " \t");
        const char *close = *at == '"' ? strchr(at + 1, '"') : NULL;
        if (!close || memchr(at, '\\', (size_t)(close - at)))
            return;
        snprintf(h->axis[a].label, sizeof h->axis[a].label, "%.*s", (int)(close - at - 1), at + 1);
        at = close + 1;
    }
}

/* Its vectors, in the file's space. */
static void keep_frame(vvi_nrrd *h, const char *at)
{
    bool good = at && h->space_dimension == 3;
    for (int i = 0; i < 3 && good; i++) {
        at += strspn(at, " \t");
        good = vvi_nrrd_scan_vector(h->kept.frame[i], 3, at, &at);
    }
    h->kept.has_frame = good;
}

static void keep_text(char *out, size_t room, const char *text)
{
    if (text && strlen(text) < room)
        memcpy(out, text, strlen(text) + 1);
}

void vvi_nrrd_keep_fields(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    for (int a = 0; a < VVI_NRRD_AXES; a++)
        h->axis[a].thickness = NAN;
    keep_thicknesses(h, l->text[F_THICKNESSES]);
    keep_labels(h, l->text[F_LABELS]);
    keep_frame(h, l->text[F_MEASUREMENT_FRAME]);
    keep_text(h->kept.content, sizeof h->kept.content, l->text[F_CONTENT]);
    keep_text(h->kept.sample_units, sizeof h->kept.sample_units, l->text[F_SAMPLE_UNITS]);
    keep_text(h->kept.old_min, sizeof h->kept.old_min, l->text[F_OLD_MIN]);
    keep_text(h->kept.old_max, sizeof h->kept.old_max, l->text[F_OLD_MAX]);
}

/* Vectors that were read with some components reversed have a frame that takes the reversed ones. */
static void turn_frame(vvi_nrrd *h)
{
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++)
            h->kept.frame[i][c] = h->kept.frame[i][c] * h->flip[c] * (h->layout.negate >> i & 1 ? -1 : 1) + 0.0;
}

vv_status vvi_nrrd_keep(vvi_nrrd *h, const vvi_role role[VVI_NRRD_AXES], vv_notes *notes)
{
    vvi_nrrd_kept *k = &h->kept;
    for (int r = 0; r < VVI_ROLES; r++)
        k->thickness[r] = NAN;
    for (int a = 0; a < h->dimension; a++) {
        const vvi_nrrd_axis *axis = &h->axis[a];
        k->thickness[role[a]] = axis->thickness;
        k->centering[role[a]] = axis->centering;
        memcpy(k->label[role[a]], axis->label, sizeof axis->label);
        if (role[a] == VVI_ROLE_COMPONENT)
            memcpy(k->component_kind, axis->kind_text, sizeof axis->kind_text);
    }
    turn_frame(h);
    return vvi_notes_keep(notes, VVI_NRRD_KEPT_FIELDS, k, sizeof *k);
}

vv_status vvi_nrrd_keep_line(vv_notes *notes, const char *line)
{
    const bool comment = line[0] == '#';
    const char *text = line + 1 + (line[1] == ' ');
    if (comment && (strcmp(text, "written by VolVis") == 0 || (text[0] == '.' && strspn(text, ".") == strlen(text))))
        return VV_OK;
    return vvi_notes_keep(notes, comment ? VVI_NRRD_KEPT_COMMENT : VVI_NRRD_KEPT_KEY, line, strlen(line));
}

vv_status vvi_nrrd_keep_nifti(vv_notes *notes, const vv_field_info *info)
{
    const size_t n_before = strlen(VVI_NRRD_NIFTI);
    vvi_text lines = {0};
    int32_t code;
    size_t n;
    const char *line;
    for (size_t i = 0; (line = vvi_notes_kept(notes, i, &code, &n)) != NULL; i++) {
        const char *value = code == VVI_NRRD_KEPT_KEY ? strstr(line, ":=") : NULL;
        if (!value || strncmp(line, VVI_NRRD_NIFTI, n_before) != 0 || value < line + n_before || strchr(line, '\n'))
            continue;
        vvi_text_add_n(&lines, line + n_before, (size_t)(value - line) - n_before);
        vvi_text_printf(&lines, "=%s\n", value + 2);
    }
    const vv_status st =
        lines.bad ? vv_fail_memory(lines.n) : vvi_nifti_keep_lines(notes, lines.s ? lines.s : "", info);
    vvi_text_free(&lines);
    return st;
}

/* Taking ---------------------------------------------------------------------------------------------------------- */

bool vvi_nrrd_has_origin(const vv_write_options *options)
{
    const char *format = options->origin ? vv_file_format(options->origin) : "";
    return strcmp(format, "nrrd") == 0 || strcmp(format, "seg.nrrd") == 0;
}

static void end_texts(vvi_nrrd_kept *k)
{
    for (int r = 0; r < VVI_ROLES; r++)
        k->label[r][sizeof k->label[r] - 1] = 0;
    k->component_kind[sizeof k->component_kind - 1] = 0;
    k->old_min[sizeof k->old_min - 1] = k->old_max[sizeof k->old_max - 1] = 0;
    k->content[sizeof k->content - 1] = k->sample_units[sizeof k->sample_units - 1] = 0;
}

bool vvi_nrrd_get_kept(vvi_nrrd_kept *out, const vv_write_options *options)
{
    int32_t code;
    size_t n;
    const void *bytes;
    if (!vvi_nrrd_has_origin(options))
        return false;
    for (size_t i = 0; (bytes = vvi_notes_kept(vvi_file_notes(options->origin), i, &code, &n)) != NULL; i++) {
        if (code != VVI_NRRD_KEPT_FIELDS || n != sizeof *out)
            continue;
        memcpy(out, bytes, n);
        end_texts(out);
        return true;
    }
    return false;
}

/* Whether index axis a runs the way that it ran, and as it were in steps of the same length. */
static bool same_way(const vv_grid *now, const vv_grid *then, int a, bool steps)
{
    const vv_vec3 p = now->index_to_world.axis[a], q = then->index_to_world.axis[a];
    const double lp = vvi_length(p), lq = vvi_length(q), along = p.x * q.x + p.y * q.y + p.z * q.z;
    if (strcmp(now->unit, then->unit) != 0 || !(along >= (1 - 1e-9) * lp * lq))
        return false;
    return !steps || fabs(lp - lq) <= 1e-6 * lq;
}

/* Whether what was said of the axis of that role still holds. */
static bool holds(int role, const vv_field_info *info, const vv_field_info *then, bool steps)
{
    if (role == VVI_ROLE_COMPONENT)
        return info->components == then->components && info->components > 1;
    if (role == VVI_ROLE_FRAME)
        return true;
    return same_way(&info->grid, &then->grid, role - VVI_ROLE_X, steps);
}

static void add_axes(vvi_text *t, const vvi_nrrd_kept *k, const vv_field_info *info, const vv_field_info *then,
                     const int *roles, int n)
{
    bool thick = false, labelled = false, centered = false;
    vvi_text thicknesses = {0}, labels = {0}, centerings = {0};
    for (int a = 0; a < n; a++) {
        const int r = roles[a];
        const bool way = holds(r, info, then, false), steps = holds(r, info, then, true);
        char number[32] = "nan";
        if (steps && !isnan(k->thickness[r]))
            vvi_print_number(number, k->thickness[r]);
        thick |= steps && !isnan(k->thickness[r]);
        labelled |= way && k->label[r][0];
        centered |= steps && k->centering[r];
        vvi_text_printf(&thicknesses, " %s", number);
        vvi_text_printf(&labels, " \"%s\"", way ? k->label[r] : "");
        vvi_text_add(&centerings, !steps || !k->centering[r] ? " none" : k->centering[r] == 'c' ? " cell" : " node");
    }
    if (thick)
        vvi_text_printf(t, "thicknesses:%s\n", thicknesses.s ? thicknesses.s : "");
    if (centered)
        vvi_text_printf(t, "centerings:%s\n", centerings.s ? centerings.s : "");
    if (labelled)
        vvi_text_printf(t, "labels:%s\n", labels.s ? labels.s : "");
    t->bad |= thicknesses.bad || labels.bad || centerings.bad;
    vvi_text_free(&thicknesses);
    vvi_text_free(&labels);
    vvi_text_free(&centerings);
}

static void add_frame(vvi_text *t, const vvi_nrrd_kept *k)
{
    char number[32];
    vvi_text_add(t, "measurement frame:");
    for (int i = 0; i < 3; i++)
        for (int c = 0; c < 3; c++) {
            vvi_print_unsigned_zero(number, k->frame[i][c]);
            vvi_text_printf(t, "%s%s%s", c ? "," : " (", number, c == 2 ? ")" : "");
        }
    vvi_text_add(t, "\n");
}

void vvi_nrrd_take_fields(vvi_text *t, const vv_field_info *info, const vv_write_options *options, const int *roles,
                          int n)
{
    vvi_nrrd_kept k;
    if (!vvi_nrrd_get_kept(&k, options))
        return;
    const vv_field_info *then = vv_file_info(options->origin);
    add_axes(t, &k, info, then, roles, n);
    if (k.has_frame && vvi_nrrd_is_placed(&info->grid) && strcmp(info->grid.unit, then->grid.unit) == 0)
        add_frame(t, &k);
    if (options->new_values || info->type != then->type || info->value_scale != then->value_scale ||
        info->value_offset != then->value_offset)
        return;
    if (k.old_min[0])
        vvi_text_printf(t, "old min: %s\n", k.old_min);
    if (k.old_max[0])
        vvi_text_printf(t, "old max: %s\n", k.old_max);
}

const char *vvi_nrrd_take_kind(vvi_nrrd_kept *k, const vv_field_info *info, const vv_write_options *options)
{
    if (options->new_values || !vvi_nrrd_get_kept(k, options) || !k->component_kind[0])
        return NULL;
    const vv_field_info *then = vv_file_info(options->origin);
    return info->components == then->components && info->meaning == then->meaning ? k->component_kind : NULL;
}

/* Keys ------------------------------------------------------------------------------------------------------------ */

/* Segments are told anew; gradients of a diffusion series are one for each component. */
static bool goes_on(const char *line, const vv_field_info *info, const vv_write_options *options)
{
    const bool segment = strncmp(line, "Segment", 7) == 0 && isdigit((unsigned char)line[7]);
    if (strncmp(line, "volvis ", 7) == 0 || strncmp(line, VVI_NRRD_NIFTI, strlen(VVI_NRRD_NIFTI)) == 0 || segment ||
        strncmp(line, "Segmentation_", 13) == 0 || options->new_values)
        return false;
    return strncmp(line, "DWMRI_", 6) != 0 || info->components == vv_file_info(options->origin)->components;
}

void vvi_nrrd_take_lines(vvi_text *t, int32_t wanted, const vv_field_info *info, const vv_write_options *options)
{
    int32_t code;
    size_t n;
    const char *line;
    if (!vvi_nrrd_has_origin(options))
        return;
    for (size_t i = 0; (line = vvi_notes_kept(vvi_file_notes(options->origin), i, &code, &n)) != NULL; i++) {
        if (code != wanted || memchr(line, '\n', n))
            continue;
        char start[16] = "";
        snprintf(start, sizeof start, "%.*s", (int)(n < 15 ? n : 15), line);
        if (code != VVI_NRRD_KEPT_KEY || goes_on(start, info, options)) {
            vvi_text_add_n(t, line, n);
            vvi_text_add(t, "\n");
        }
    }
}
