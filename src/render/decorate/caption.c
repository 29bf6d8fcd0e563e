/* Title and caption: free text with placeholders, broken into lines that fit the picture. */
#include "core/memory.h"
#include "core/names.h"
#include "core/units.h"
#include "model/contents.h"
#include "render/decorate/round_numbers.h"
#include "render/decorate/sheet.h"
#include "scene/lens.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <volvis/version.h>

#define TITLE_EM 1.3
#define LEADING 1.3
#define MOST_SHARE 0.3 /* of the picture's height */
enum { TITLE_LINES = 2 };
#define TIMES " \xc3\x97 "

/* Placeholders ---------------------------------------------------------------------------------------------------- */

/* Six digits, as people write them. */
static void add_short(vvi_text *out, double value)
{
    char number[32];
    const double power = value != 0 && isfinite(value) ? pow(10, 5 - floor(log10(fabs(value)))) : 1;
    const double rounded = rint(value * power) / power; /* powers of ten below 1 are not exact, their inverses are */
    vvi_print_unsigned_zero(number, power < 1 ? rint(value * power) * rint(1 / power) : rounded);
    vvi_text_add(out, number);
}

static const vv_actor *first(const vv_scene *scene)
{
    return scene->n_actors ? &scene->actors[0] : NULL;
}

static void put_file(vvi_text *out, const vv_scene *scene)
{
    const vv_collection *all = scene->world->datasets;
    const vv_dataset *dataset = all->n ? vvi_dataset_nth(scene->world, 0) : NULL;
    const char *path = dataset ? dataset->path : NULL, *slash = path ? strrchr(path, '/') : NULL;
    vvi_text_add(out, path ? (slash && slash[1] ? slash + 1 : path) : all->n ? all->entry[0].id : "");
}

static void put_title(vvi_text *out, const vv_scene *scene)
{
    vvi_text_add(out, scene->world->title ? scene->world->title : "");
}

static void put_dims(vvi_text *out, const vv_scene *scene)
{
    for (int a = 0; first(scene) && a < 3; a++)
        vvi_text_printf(out, "%s%lld", a ? TIMES : "", (long long)vv_field_get_info(first(scene)->field)->grid.dims[a]);
}

static void put_unit(vvi_text *out, const vv_scene *scene)
{
    vvi_text_add(out, vvi_unit_sign(scene->world->unit ? scene->world->unit : "voxels"));
}

static void put_spacing(vvi_text *out, const vv_scene *scene)
{
    for (int a = 0; first(scene) && a < 3; a++) {
        vvi_text_add(out, a ? TIMES : "");
        add_short(out, vvi_length(first(scene)->index_to_world.axis[a]));
    }
    vvi_text_add(out, " ");
    put_unit(out, scene);
}

static void put_range(vvi_text *out, const vv_scene *scene)
{
    if (!first(scene))
        return;
    const char *unit = vv_field_get_info(first(scene)->field)->value_unit;
    add_short(out, first(scene)->statistics->min);
    vvi_text_add(out, " to ");
    add_short(out, first(scene)->statistics->max);
    vvi_text_printf(out, "%s%s", *unit ? " " : "", unit);
}

static void put_method(vvi_text *out, const vv_scene *scene)
{
    vvi_text_add(out, scene->renderer->name);
}

static void put_iso(vvi_text *out, const vv_scene *scene)
{
    double lo = NAN, hi;
    if (!first(scene))
        return;
    if (!scene->renderer->solid || !scene->renderer->solid(&lo, &hi, scene, first(scene)))
        lo = first(scene)->iso;
    add_short(out, lo);
}

static void put_view(vvi_text *out, const vv_scene *scene)
{
    const vv_collection *all = scene->world->views;
    for (size_t i = 0; i < all->n; i++)
        if (all->entry[i].object == &scene->view->base)
            vvi_text_add(out, scene->view->title ? scene->view->title : all->entry[i].id);
}

static void put_angle(vvi_text *out, double radians)
{
    add_short(out, rint(radians * 180 / 3.14159265358979323846 * 100) / 100);
    vvi_text_add(out, "\xc2\xb0");
}

static void put_azimuth(vvi_text *out, const vv_scene *scene)
{
    put_angle(out, ((const vv_camera *)(const void *)scene->view->camera)->azimuth);
}

static void put_elevation(vvi_text *out, const vv_scene *scene)
{
    put_angle(out, ((const vv_camera *)(const void *)scene->view->camera)->elevation);
}

static void put_version(vvi_text *out, const vv_scene *scene)
{
    (void)scene;
    vvi_text_add(out, "VolVis " VV_VERSION_STRING);
}

static const struct {
    const char *name;
    void (*put)(vvi_text *out, const vv_scene *scene);
} placeholders[] = {
    {"file", put_file}, {"title", put_title},     {"dims", put_dims},           {"spacing", put_spacing},
    {"unit", put_unit}, {"range", put_range},     {"method", put_method},       {"iso", put_iso},
    {"view", put_view}, {"azimuth", put_azimuth}, {"elevation", put_elevation}, {"version", put_version},
};
enum { N_PLACEHOLDERS = sizeof placeholders / sizeof *placeholders };

static vv_status fail_placeholder(const char *typed, size_t n, const char *property)
{
    const char *names[N_PLACEHOLDERS];
    char name[64];
    for (size_t i = 0; i < N_PLACEHOLDERS; i++)
        names[i] = placeholders[i].name;
    snprintf(name, sizeof name, "%.*s", (int)(n < 60 ? n : 60), typed);
    return vvi_fail_name(VV_E_ARGUMENT, NULL, property, name, &(vvi_known){names, N_PLACEHOLDERS, NULL, NULL},
                         "there is no placeholder {%s} ({{ gives a brace)", name);
}

static vv_status fill_one(vvi_text *out, const char *name, size_t n, const vv_scene *scene, const char *property)
{
    for (size_t i = 0; i < N_PLACEHOLDERS; i++)
        if (strlen(placeholders[i].name) == n && memcmp(placeholders[i].name, name, n) == 0) {
            placeholders[i].put(out, scene);
            return VV_OK;
        }
    return fail_placeholder(name, n, property);
}

vv_status vvi_caption_fill(char **out, const char *text, const vv_scene *scene, const char *property)
{
    vvi_text filled = {0};
    vv_status st = VV_OK;
    *out = NULL;
    while (*text && st == VV_OK) {
        const size_t plain = strcspn(text, "{}");
        vvi_text_add_n(&filled, text, plain);
        text += plain;
        if (!*text)
            break;
        const size_t n = *text == '{' && text[1] != '{' ? strcspn(text, "}") : 0;
        if (n && text[n]) {
            st = fill_one(&filled, text + 1, n - 1, scene, property);
            text += n + 1;
        } else if (n) {
            st = vv_fail_at(VV_E_ARGUMENT, NULL, property,
                            "'%.40s' has no closing brace; {name} is a placeholder, {{ gives a brace", text);
        } else { /* {{ and }} are braces, and so is a } that nothing opened */
            vvi_text_add_n(&filled, text, 1);
            text += text[1] == *text ? 2 : 1;
        }
    }
    if (st == VV_OK && !(*out = filled.n ? vvi_text_take(&filled) : vvi_strdup("")))
        st = vv_fail_memory(filled.n);
    vvi_text_free(&filled);
    return st;
}

/* Lines ----------------------------------------------------------------------------------------------------------- */

/* How many bytes of a text make one line: up to a line end, else as many words as fit; of a word that is longer than a
 * line, as much as fits. */
static size_t line_of(const vvi_sheet *s, const char *text, double size, double room)
{
    const size_t whole = strcspn(text, "\n"), fits = vvi_sheet_fitting(s, text, size, room);
    if (fits >= whole)
        return whole;
    size_t n = fits;
    while (n && text[n] != ' ')
        n--;
    return n ? n : fits ? fits : whole;
}

/* Tabs, and what ends lines beside the line feed, as blanks: fonts have no such signs. What else is no letter, as names
 * of files may have it, is masked. */
static void put_blanks(char *text)
{
    for (char *s = text + strcspn(text, "\t\v\f\r"); *s; s += strcspn(s, "\t\v\f\r"))
        *s = ' ';
    while (*text) {
        char *end = text + strcspn(text, "\n");
        const char ending = *end;
        *end = 0;
        vvi_text_clean(text);
        *end = ending;
        text = end + (ending != 0);
    }
}

/* Lines of one text, below those that there are; its last ends with "..." where more would follow. */
static vv_status add_lines(vvi_sheet_captions *out, const vvi_sheet *s, const char *text, double size, size_t most)
{
    const double room = s->width - 2 * s->margin;
    for (size_t i = 0; *text && i < most; i++) {
        const size_t n = line_of(s, text, size, room), bytes = n + 4;
        char *line = vvi_calloc(bytes, 1);
        if (!line)
            return vv_fail_memory(bytes);
        memcpy(line, text, n);
        text += n;
        text += *text == '\n' || *text == ' ';
        vvi_sheet_shorten(s, line, bytes, size, room, *text && i + 1 == most);
        out->line[out->n].text = line;
        out->line[out->n].size = size;
        out->line[out->n++].base = out->box.y1 + 0.75 * size;
        out->box.x1 = fmax(out->box.x1, out->box.x0 + vvi_sheet_length(s, line, size));
        out->box.y1 += LEADING * size;
    }
    return VV_OK;
}

static vv_status add_text(vvi_sheet_captions *out, const vvi_sheet *s, const char *text, double size, size_t most,
                          const char *property)
{
    char *filled;
    if (!text || !*text || !most)
        return VV_OK;
    vv_status st = vvi_caption_fill(&filled, text, s->scene, property);
    if (st == VV_OK) {
        put_blanks(filled);
        st = add_lines(out, s, filled, size, most);
    }
    free(filled);
    return st;
}

vv_status vvi_sheet_captions_place(vvi_sheet_captions *out, vvi_sheet *s)
{
    const double title = TITLE_EM * s->em, lines = (s->height * MOST_SHARE) / (LEADING * s->em);
    *out = (vvi_sheet_captions){.box = {s->margin, s->margin, s->margin, s->margin}};
    vv_status st = add_text(out, s, s->wanted->title, title, TITLE_LINES, "decorations.title");
    if (out->n)
        out->box.y1 += 0.15 * s->em;
    const double left = fmin(lines - TITLE_EM * (double)out->n, VVI_CAPTION_LINES - TITLE_LINES);
    const bool asked = s->wanted->caption && *s->wanted->caption;
    if (st == VV_OK && (left >= 1 || !out->n))
        st = add_text(out, s, s->wanted->caption, s->em, left >= 1 ? (size_t)left : 1, "decorations.caption");
    else if (asked)
        vvi_sheet_left_out(s, "the caption");
    out->box.x1 = fmin(out->box.x1, s->width);
    if (out->n && !vvi_layout_take(&s->layout, out->box)) {
        vvi_sheet_left_out(s, "title and caption");
        vvi_sheet_captions_finish(out);
    }
    return st;
}

vv_status vvi_sheet_captions_draw(const vvi_sheet_captions *c, const vvi_sheet *s)
{
    vv_status st = VV_OK;
    for (size_t i = 0; i < c->n && st == VV_OK; i++)
        st = vvi_sheet_text(s, c->box.x0, c->line[i].base, c->line[i].size, VVI_GFX_BEGIN, VVI_GFX_BASE_LINE,
                            c->line[i].text);
    return st;
}

void vvi_sheet_captions_finish(vvi_sheet_captions *c)
{
    for (size_t i = 0; i < c->n; i++)
        free(c->line[i].text);
    c->n = 0;
}
