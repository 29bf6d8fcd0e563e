/* Decorations of one picture: first what stands in the World, by depth, then what stands on the picture. */
#include "render/decorate/decorate.h"
#include "core/allowed_places.h"
#include "core/cache.h"
#include "core/job.h"
#include "core/memory.h"
#include "core/vec.h"
#include "render/decorate/sheet.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* How bad it is to stand on one of these, beside the share of data that is hidden. */
#define EDGE_MARK 0.005
#define AXIS_MARK 0.02
enum { EDGE_MARKS = 24 };

static const vv_decorations *wanted_by(const vv_scene *scene)
{
    return (const vv_decorations *)(const void *)scene->view->decorations;
}

static bool has_text(const char *text)
{
    return text && *text;
}

bool vvi_decorate_wanted(const vv_scene *scene)
{
    const vv_decorations *d = wanted_by(scene);
    return d->cube || d->axes || d->scale_bar || d->box || d->cut_planes || d->legend || d->sides || d->cross_hair ||
           has_text(d->title) || has_text(d->caption) || (d->measurements && vvi_sheet_has_measurements(scene));
}

/* The view's id, as errors name it. */
static const char *view_of(const vv_scene *scene)
{
    const vv_collection *all = scene->world->views;
    for (size_t i = 0; i < all->n; i++)
        if (all->entry[i].object == &scene->view->base)
            return all->entry[i].id;
    return "";
}

static vv_status check_text(const char *text, const vv_scene *scene, const char *name)
{
    char *filled = NULL, property[256];
    snprintf(property, sizeof property, "views.%s.decorations.%s", view_of(scene), name);
    const vv_status st = has_text(text) ? vvi_caption_fill(&filled, text, scene, property) : VV_OK;
    free(filled);
    return st;
}

vv_status vvi_decorate_check(const vv_scene *scene)
{
    const vv_decorations *d = wanted_by(scene);
    const vv_status st = check_text(d->title, scene, "title");
    return st == VV_OK ? check_text(d->caption, scene, "caption") : st;
}

/* The font -------------------------------------------------------------------------------------------------------- */

static vv_status make_font(void **value_out, uint64_t *bytes_out, void *user, vv_job *job)
{
    vvi_font *font;
    const vv_status st = vvi_font_open(&font, user);
    (void)job;
    *value_out = font;
    *bytes_out = 1 << 20; /* about, with glyphs */
    return st;
}

/* Fonts are read in this process: where what is read may come from strangers, scenes with it, only those that whoever
 * runs the program named himself. */
static bool is_trusted(const char *path, const vv_job *job)
{
    const char *rest;
    char *real = realpath(path, NULL);
    const bool given = !vvi_job_confined(job) || (real && vvi_job_place(job, real, false, &rest) == -1);
    const bool named = real && vvi_job_trusts(job, real);
    free(real);
    return named || (given && !vvi_job_safe(job) && !vvi_job_distrusts(job, path));
}

/* Kept from picture to picture. A picture without letters is better than none. */
static vvi_cached *open_font(const char *path, vv_job *job)
{
    vvi_cached *font = NULL;
    if (path && *path && !is_trusted(path, job)) {
        vvi_log(job, VV_LOG_WARNING, "io",
                "%s: a font is read here only where it was named on the command line (--set ...font=FILE); letters are "
                "drawn in another one",
                path);
        path = NULL;
    }
    const vvi_cache_key key = {"font", 0, path ? vvi_hash(path, strlen(path), 1) : 0};
    if (vvi_cache_get(&font, &key, make_font, vvi_font_close, (void *)path, job) == VV_OK)
        return font;
    vvi_log(job, VV_LOG_WARNING, "decorations", "the picture has no lettering: %s", vv_error_last()->message);
    return NULL;
}

/* Drawing --------------------------------------------------------------------------------------------------------- */

static vv_status draw_world(vvi_sheet *s)
{
    vv_status st = vvi_gfx_cuts(s->gfx, NULL, 0); /* those of volumes, in a figure, are not of lines */
    vvi_gfx_camera(s->gfx, &s->scene->lens);
    s->in_world = true;
    if (st == VV_OK && s->wanted->box)
        st = vvi_sheet_box(s);
    if (st == VV_OK && s->wanted->cut_planes)
        st = vvi_sheet_cut_planes(s);
    if (st == VV_OK && s->wanted->cross_hair && !s->scene->renderer->plane)
        st = vvi_sheet_cross_hair_in_world(s);
    s->in_world = false;
    vvi_gfx_camera(s->gfx, NULL);
    return st;
}

/* The edges of the box around everything, which cube and legend better leave free. */
static void mark_edges(vvi_sheet *s)
{
    for (size_t i = 0; i < vvi_sheet_things(s); i++) {
        vv_vec3 end[2][24];
        size_t n[2];
        vvi_sheet_edges(end[0], &n[0], end[1], &n[1], s, i);
        for (size_t k = 0; k < (n[0] + n[1]) * EDGE_MARKS / 2; k++) {
            const size_t e = k / EDGE_MARKS * 2, behind = e < n[0];
            const vv_vec3 *p = behind ? end[0] + e : end[1] + e - n[0];
            const double t = (k % EDGE_MARKS + 0.5) / EDGE_MARKS;
            double x, y, depth;
            if (vvi_sheet_project(&x, &y, &depth, s, vvi_add(vvi_scaled(p[0], 1 - t), vvi_scaled(p[1], t))))
                vvi_sheet_mark(s, x, y, EDGE_MARK);
        }
    }
}

/* Where numbers of axes would stand if nothing else were there. */
static void mark_axes(vvi_sheet_axes *axes, vvi_sheet *s)
{
    const vvi_layout before = s->layout;
    vvi_sheet_axes_place(axes, s);
    s->layout = before;
    for (int a = 0; a < 3; a++)
        for (int i = -1; i < axes->axis[a].n; i++) {
            const vvi_sheet_axis_label *l = i < 0 ? &axes->axis[a].name : &axes->axis[a].tick[i].number;
            for (int k = 0; l->there && k < 3; k++)
                vvi_sheet_mark(s, l->box.x0 + k * (l->box.x1 - l->box.x0) / 2, l->y, AXIS_MARK);
        }
}

vv_status vvi_sheet_place(vvi_sheet_plan *p, vvi_sheet *s)
{
    const vv_decorations *d = s->wanted;
    vv_status st = vvi_sheet_captions_place(&p->captions, s);
    if (d->sides)
        vvi_sheet_sides_place(&p->sides, s);
    if (d->scale_bar)
        vvi_sheet_scale_bar_place(&p->bar, s);
    if (d->box || d->axes)
        mark_edges(s);
    if (d->axes)
        mark_axes(&p->axes, s);
    if (d->cube)
        vvi_sheet_cube_place(&p->cube, s);
    if (st == VV_OK && d->legend)
        st = vvi_sheet_legend_place(&p->legend, s);
    if (d->axes)
        vvi_sheet_axes_place(&p->axes, s);
    if (d->measurements)
        vvi_sheet_measurements_place(&p->measurements, s);
    return st;
}

void vvi_sheet_plan_finish(vvi_sheet_plan *p)
{
    vvi_sheet_captions_finish(&p->captions);
    vvi_sheet_legend_finish(&p->legend);
}

static vv_status draw_placed(const vvi_sheet_plan *p, const vvi_sheet *s)
{
    vv_status st = VV_OK;
    if (s->wanted->cross_hair && s->scene->renderer->plane)
        st = vvi_sheet_cross_hair(s);
    if (st == VV_OK)
        st = vvi_sheet_measurements_draw(&p->measurements, s);
    if (st == VV_OK)
        st = vvi_sheet_axes_draw(&p->axes, s);
    if (st == VV_OK)
        st = vvi_sheet_sides_draw(&p->sides, s);
    if (st == VV_OK)
        st = vvi_sheet_cube_draw(&p->cube, s);
    if (st == VV_OK)
        st = vvi_sheet_scale_bar_draw(&p->bar, s);
    if (st == VV_OK)
        st = vvi_sheet_legend_draw(&p->legend, s);
    return st == VV_OK ? vvi_sheet_captions_draw(&p->captions, s) : st;
}

/* Lines in the World are broken where something has its place, so places are given first. */
static vv_status draw_all(vvi_sheet *s)
{
    vvi_sheet_plan *p = vvi_alloc_zeroed(s->job, sizeof *p, VVI_MEM_SCRATCH);
    if (!p)
        return vv_fail_memory(sizeof *p);
    vv_status st = vvi_sheet_place(p, s);
    if (st == VV_OK)
        st = draw_world(s);
    if (st == VV_OK)
        st = draw_placed(p, s);
    vvi_sheet_plan_finish(p);
    vvi_free(p);
    return st;
}

static vv_status draw(vv_image *image, vvi_sheet *s)
{
    const vvi_gfx_font letters = {.draw = vvi_font_draw, .user = s->font};
    const vvi_gfx_target target = {.image = image, .font = s->font ? &letters : NULL};
    vv_status st = vvi_gfx_begin(&s->gfx, &vvi_gfx_software, &target, s->job);
    if (st == VV_OK)
        st = draw_all(s);
    if (st == VV_OK)
        return vvi_gfx_end(s->gfx);
    vvi_gfx_abandon(s->gfx);
    return st;
}

vv_status vvi_decorate_view(vv_image *view, const vv_image *image, const vv_scene *scene, vv_job *job)
{
    const vvi_sheet s = vvi_sheet_new(scene, job);
    const size_t n = (size_t)image->width * (size_t)image->height, bytes = n * sizeof *view->depth;
    *view = (vv_image){.refs = 1, .width = image->width, .height = image->height, .rgba = image->rgba};
    if (!image->depth)
        return VV_OK;
    view->depth = vvi_alloc(job, bytes, VVI_MEM_SCRATCH);
    if (!view->depth)
        return vv_fail_memory(bytes);
    memcpy(view->depth, image->depth, bytes);
    for (size_t i = 0; s.projects && i < n; i++) /* all that is seen is before edges behind */
        view->depth[i] = image->rgba[4 * i + 3] > 0 ? 0 : INFINITY;
    return VV_OK;
}

vv_status vvi_decorate(vv_image *image, const vv_scene *scene, vv_job *job)
{
    vvi_sheet s = vvi_sheet_new(scene, job);
    vv_image view; /* depth alone takes part, and a copy of it: layers tell of the volumes and not of lines */
    vv_status st = vvi_decorate_view(&view, image, scene, job);
    if (st != VV_OK)
        return st;
    vvi_cached *font = open_font(s.wanted->font, job);
    s.image = image;
    s.font = font ? vvi_cached_value(font) : NULL;
    st = draw(&view, &s);
    vvi_free(view.depth);
    vvi_cache_release(font);
    return st;
}

vv_status vvi_decorate_figure(vvi_gfx *gfx, const vv_image *image, const vv_scene *scene, vv_job *job)
{
    vvi_sheet s = vvi_sheet_new(scene, job);
    vvi_cached *font = open_font(s.wanted->font, job);
    s.image = image;
    s.font = font ? vvi_cached_value(font) : NULL;
    s.gfx = gfx;
    const vv_status st = draw_all(&s);
    vvi_cache_release(font);
    return st;
}
