/* Axes with ticks at 1, 2 and 5 times powers of ten, and what they measure. */
#include "measure/plot.h"

#include "core/memory.h"
#include "core/vec.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SCALE = 92, SCALE_WIDTH = 18 }; /* room for the scale of colours, right of the plot */
enum { LEFT = 96, RIGHT = 28, TOP = 56, BOTTOM = 76, TEXT = 17, SMALL = 15, RAISED = 11, TICK = 6 };

static const vv_color ink = {0.015, 0.015, 0.02, 1}, faint = {0.75, 0.75, 0.75, 1}, paper = {1, 1, 1, 1};
static const vv_color curve = {0.05, 0.2, 0.5, 1}, area = {0.3, 0.5, 0.75, 1}, strong = {0.6, 0.05, 0.03, 1};

/* What lies where. */
typedef struct frame {
    vvi_gfx *gfx;
    const vvi_plot *plot;
    double x0, x1, y0, y1; /* pixels: left, right, bottom, top */
    double lo[2], hi[2];   /* values; y by its logarithm where that is asked for */
    double y_unit;         /* counts of thousands, millions, ... */
    int y_power;
} frame;

static double x_at(const frame *f, double x)
{
    return f->x0 + (x - f->lo[0]) / (f->hi[0] - f->lo[0]) * (f->x1 - f->x0);
}

static double height_of(const frame *f, double y)
{
    const double v = f->plot->log_y ? y > 0 ? log10(y) : f->lo[1] : y;
    return fmin(fmax((v - f->lo[1]) / (f->hi[1] - f->lo[1]), 0), 1);
}

static double y_at(const frame *f, double y)
{
    return f->y0 + height_of(f, y) * (f->y1 - f->y0);
}

/* 1, 2 or 5 times a power of ten, about `n` of them in a range. */
static double nice_step(double range, int n)
{
    const double raw = range / n, power = pow(10, floor(log10(raw))), part = raw / power;
    return power * (part < 1.5 ? 1 : part < 3.5 ? 2 : part < 7.5 ? 5 : 10);
}

/* As many decimals as the step has; a true minus sign. */
static void print_tick(char out[32], double v, double step)
{
    const int decimals = (int)fmax(0, -floor(log10(step) + 1e-9));
    const double shown = fabs(v) < step / 2 ? 0 : v;
    if (decimals > 6 || fabs(v) >= 1e7)
        snprintf(out, 32, "%s%.4g", shown < 0 ? "\xe2\x88\x92" : "", fabs(shown));
    else
        snprintf(out, 32, "%s%.*f", shown < 0 ? "\xe2\x88\x92" : "", decimals, fabs(shown));
}

static vv_status line(const frame *f, double ax, double ay, double bx, double by, const vvi_gfx_stroke *stroke)
{
    const vv_vec3 p[2] = {{ax, ay, 0}, {bx, by, 0}};
    return vvi_gfx_line(f->gfx, p, 2, VVI_GFX_STRIP, stroke);
}

static vv_status letters(const frame *f, double x, double y, const vvi_gfx_label *label, const char *s)
{
    return f->plot->no_letters ? VV_OK : vvi_gfx_text(f->gfx, vvi_vec(x, y, 0), label, s);
}

static vv_status text(const frame *f, double x, double y, int anchor, int level, double size, const char *s)
{
    const vvi_gfx_label label = {.size = size, .anchor = anchor, .level = level, .color = ink};
    return *s ? letters(f, x, y, &label, s) : VV_OK;
}

/* Axes --------------------------------------------------------------------------------------------------------------
 */

static vv_status x_tick(const frame *f, double v, double step)
{
    char label[32];
    const double x = x_at(f, v);
    vv_status st = line(f, x, f->y0, x, f->y0 + TICK, &(vvi_gfx_stroke){.color = ink, .width = 1.2});
    print_tick(label, v, step);
    return st == VV_OK ? text(f, x, f->y0 + TICK + 5, VVI_GFX_MIDDLE, VVI_GFX_TOP, SMALL, label) : st;
}

/* power: of ten, raised above the label; 0: none. */
static vv_status y_tick(const frame *f, double v, const char *label, int power)
{
    char raised[16] = "";
    const double y = f->y0 + (v - f->lo[1]) / (f->hi[1] - f->lo[1]) * (f->y1 - f->y0);
    vv_status st = VV_OK;
    if (v > f->lo[1] && !f->plot->density)
        st = line(f, f->x0, y, f->x1, y, &(vvi_gfx_stroke){.color = faint, .width = 0.8});
    if (st == VV_OK)
        st = line(f, f->x0 - TICK, y, f->x0, y, &(vvi_gfx_stroke){.color = ink, .width = 1.2});
    if (power)
        snprintf(raised, sizeof raised, "%d", power);
    const double x = f->x0 - TICK - 5, room = 0.56 * RAISED * (double)strlen(raised);
    if (st == VV_OK)
        st = text(f, x, y - 6, VVI_GFX_END, VVI_GFX_CENTRE, RAISED, raised);
    return st == VV_OK ? text(f, x - room - (power ? 1 : 0), y, VVI_GFX_END, VVI_GFX_CENTRE, SMALL, label) : st;
}

static vv_status draw_x_axis(const frame *f)
{
    const double step = nice_step(f->hi[0] - f->lo[0], 8);
    vv_status st = VV_OK;
    for (double i = ceil(f->lo[0] / step - 1e-6); i * step <= f->hi[0] + 1e-6 * step && st == VV_OK; i++)
        st = x_tick(f, i * step, step);
    return st;
}

static vv_status draw_y_axis(const frame *f)
{
    char label[32];
    vv_status st = VV_OK;
    if (f->plot->log_y) {
        const int each = (int)ceil((f->hi[1] - f->lo[1]) / 9);
        for (int p = 0; p <= f->hi[1] + 1e-6 && st == VV_OK; p += each) {
            snprintf(label, sizeof label, "%.0f", p < 4 ? pow(10, p) : 10);
            st = y_tick(f, p, label, p < 4 ? 0 : p);
        }
        return st;
    }
    const double step = nice_step((f->hi[1] - f->lo[1]) / f->y_unit, 6);
    for (double i = ceil(f->lo[1] / f->y_unit / step - 1e-6);
         i * step * f->y_unit <= f->hi[1] * (1 + 1e-9) && st == VV_OK; i++) {
        print_tick(label, i * step, step);
        st = y_tick(f, i * step * f->y_unit, label, 0);
    }
    return st;
}

static vv_status draw_names(const frame *f)
{
    static const char *const units[] = {"", "thousand ", "million ", "billion ", "trillion ", "10^15 "};
    char name[128];
    vv_status st = text(f, (f->x0 + f->x1) / 2, f->y0 + 36, VVI_GFX_MIDDLE, VVI_GFX_TOP, TEXT, f->plot->x_label);
    snprintf(name, sizeof name, "%s%s", units[f->y_power / 3], f->plot->y_label);
    const vvi_gfx_label turned = {
        .size = TEXT, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_TOP, .quarters = 1, .color = ink};
    if (st == VV_OK)
        st = letters(f, 14, (f->y0 + f->y1) / 2, &turned, name);
    if (st == VV_OK)
        st = text(f, f->x0, 16, VVI_GFX_BEGIN, VVI_GFX_TOP, TEXT, f->plot->title);
    return st == VV_OK && f->plot->subtitle
               ? text(f, f->x0, 16 + TEXT + 4, VVI_GFX_BEGIN, VVI_GFX_TOP, SMALL - 1, f->plot->subtitle)
               : st;
}

static vv_status draw_box(const frame *f)
{
    const vv_vec3 p[3] = {{f->x0, f->y1, 0}, {f->x0, f->y0, 0}, {f->x1, f->y0, 0}};
    return vvi_gfx_line(f->gfx, p, 3, VVI_GFX_STRIP, &(vvi_gfx_stroke){.color = ink, .width = 1.4});
}

/* What is measured --------------------------------------------------------------------------------------------------
 */

static vv_status draw_steps(const frame *f, vv_vec3 *p)
{
    const vvi_plot *plot = f->plot;
    size_t n = 0;
    p[n++] = vvi_vec(x_at(f, plot->x[0]), f->y0, 0);
    for (size_t i = 0; i < plot->n; i++) {
        p[n++] = vvi_vec(x_at(f, plot->x[i]), y_at(f, plot->y[i]), 0);
        p[n++] = vvi_vec(x_at(f, plot->x[i + 1]), y_at(f, plot->y[i]), 0);
    }
    p[n++] = vvi_vec(x_at(f, plot->x[plot->n]), f->y0, 0);
    const vv_status st = vvi_gfx_polygon(f->gfx, p, n, &(vvi_gfx_fill){.color = area});
    return st == VV_OK ? vvi_gfx_line(f->gfx, p, n, VVI_GFX_STRIP, &(vvi_gfx_stroke){.color = curve, .width = 1.2})
                       : st;
}

static vv_status draw_curve(const frame *f, vv_vec3 *p)
{
    const vvi_plot *plot = f->plot;
    vv_status st = VV_OK;
    for (size_t i = 0, n = 0; i <= plot->n && st == VV_OK; i++) {
        if (i < plot->n && !isnan(plot->y[i])) {
            p[n++] = vvi_vec(x_at(f, plot->x[i]), y_at(f, plot->y[i]), 0);
        } else if (n) {
            st = vvi_gfx_line(f->gfx, p, n, VVI_GFX_STRIP, &(vvi_gfx_stroke){.color = curve, .width = 2});
            n = 0;
        }
    }
    return st;
}

enum { MARKS_MOST = 16 };

/* A mark whose name stands beside it where another is near. */
typedef struct name {
    const vvi_plot_mark *mark;
    double at, half; /* pixels */
    double to;       /* where the name's middle stands */
} name;

static int by_place(const void *a, const void *b)
{
    const double x = ((const name *)a)->at, y = ((const name *)b)->at;
    return (x > y) - (x < y);
}

static size_t collect_names(name out[MARKS_MOST], const frame *f)
{
    size_t n = 0;
    for (size_t i = 0; i < f->plot->n_marks && n < MARKS_MOST; i++) {
        const vvi_plot_mark *m = &f->plot->marks[i];
        const double x = x_at(f, m->x);
        if (x >= f->x0 - 1 && x <= f->x1 + 1)
            out[n++] = (name){m, x, 3.6 * (double)strlen(m->label) + 5, x};
    }
    qsort(out, n, sizeof *out, by_place);
    return n;
}

/* As near to their marks as they can be without touching: least squares under an order, by pooling neighbours that are
 * too near (Barlow et al. 1972). A name's place less the room of those left of it must not fall. */
static void spread_names(name *names, size_t n, double lo, double hi)
{
    double sum[MARKS_MOST], before[MARKS_MOST];
    size_t count[MARKS_MOST], blocks = 0;
    for (size_t i = 0; i < n; i++) {
        before[i] = i ? before[i - 1] + names[i - 1].half + names[i].half : 0;
        sum[blocks] = names[i].at - before[i];
        count[blocks++] = 1;
        for (; blocks > 1 && sum[blocks - 2] / (double)count[blocks - 2] > sum[blocks - 1] / (double)count[blocks - 1];
             blocks--) {
            sum[blocks - 2] += sum[blocks - 1];
            count[blocks - 2] += count[blocks - 1];
        }
    }
    for (size_t b = 0, i = 0; b < blocks; b++)
        for (size_t k = 0; k < count[b]; k++, i++) {
            const double most = hi - names[n - 1].half - before[n - 1], at = sum[b] / (double)count[b];
            names[i].to = fmax(fmin(at, most), lo + names[0].half) + before[i];
        }
}

/* Lines through the plot; above it they lead to their names, which keep apart. */
static vv_status draw_marks(const frame *f)
{
    enum { LEAD = 14 };
    name names[MARKS_MOST];
    const size_t n = collect_names(names, f);
    vv_status st = VV_OK;
    if (n)
        spread_names(names, n, 4, f->x1 + RIGHT - 4);
    for (size_t i = 0; i < n && st == VV_OK; i++) {
        const vvi_plot_mark *m = names[i].mark;
        const vv_color color = m->strong ? strong : ink;
        const double width = m->strong ? 1.6 : 1.0, top = f->y1 - 2;
        st = line(f, names[i].at, f->y0, names[i].at, top, &(vvi_gfx_stroke){color, width, 5, 4});
        if (st == VV_OK)
            st = line(f, names[i].at, top, names[i].to, top - LEAD, &(vvi_gfx_stroke){.color = color, .width = width});
        const vvi_gfx_label label = {
            .size = SMALL - 2, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_BASE_LINE, .color = color, .halo = paper};
        if (st == VV_OK)
            st = letters(f, names[i].to, top - LEAD - 3, &label, m->label);
    }
    return st;
}

static void find_ranges(frame *f)
{
    const vvi_plot *p = f->plot;
    const size_t n_x = p->n + p->steps;
    double lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < p->n; i++) {
        lo = p->y[i] < lo ? p->y[i] : lo;
        hi = p->y[i] > hi ? p->y[i] : hi;
    }
    f->lo[0] = p->x[0];
    f->hi[0] = p->x[n_x - 1] > p->x[0] ? p->x[n_x - 1] : p->x[0] + 1;
    lo = p->steps ? 0 : lo;
    if (p->log_y) {
        f->lo[1] = -0.3;
        f->hi[1] = fmax(1, log10(fmax(hi, 1)) + 0.1);
    } else {
        const double room = hi > lo ? 0.06 * (hi - lo) : 1;
        f->lo[1] = p->steps ? 0 : isfinite(lo) ? lo - room : 0;
        f->hi[1] = isfinite(hi) ? hi + room : 1;
    }
    f->y_power =
        p->steps && !p->log_y && f->hi[1] >= 1e4 && f->hi[1] < 1e18 ? (int)(floor(log10(f->hi[1]) / 3) * 3) : 0;
    f->y_unit = pow(10, f->y_power);
}

/* Densities ---------------------------------------------------------------------------------------------------------
 */

/* From few to many: one hue, ever darker, so that it reads in print and by everybody. */
static const vvi_gfx_stop ramp[] = {{0, {0.807, 0.888, 0.955, 1}},
                                    {0.25, {0.381, 0.610, 0.815, 1}},
                                    {0.5, {0.098, 0.296, 0.604, 1}},
                                    {0.75, {0.022, 0.105, 0.342, 1}},
                                    {1, {0.004, 0.014, 0.070, 1}}};
enum { STOPS = sizeof ramp / sizeof *ramp };

static uint64_t most_of(const vvi_plot_density *d)
{
    uint64_t most = 1;
    for (size_t i = 0; i < d->n_x * d->n_y; i++)
        most = d->counts[i] > most ? d->counts[i] : most;
    return most;
}

/* The decade of counts at which the scale ends. */
static double top_of(const vvi_plot_density *d)
{
    return fmax(1, log10((double)most_of(d)));
}

static vv_color color_of(double at)
{
    size_t i = 0;
    while (i + 2 < STOPS && at > ramp[i + 1].at)
        i++;
    const vv_color a = ramp[i].color, b = ramp[i + 1].color;
    const float t = (float)((at - ramp[i].at) / (ramp[i + 1].at - ramp[i].at));
    return (vv_color){a.r + (b.r - a.r) * t, a.g + (b.g - a.g) * t, a.b + (b.b - a.b) * t, 1};
}

/* Bins [*lo, *end) that a pixel of `n_pixels` shows of `n`. */
static void bins_of(size_t *lo, size_t *end, size_t pixel, size_t n_pixels, size_t n)
{
    *lo = pixel * n / n_pixels;
    *end = (pixel + 1) * n / n_pixels;
    *end = *end > *lo ? *end : *lo + 1;
}

static frame frame_of(const vvi_plot *plot)
{
    return (frame){.plot = plot,
                   .x0 = LEFT,
                   .x1 = VVI_PLOT_WIDTH - RIGHT - (plot->density ? SCALE : 0),
                   .y0 = VVI_PLOT_HEIGHT - BOTTOM,
                   .y1 = TOP + (plot->n_marks ? 38 : 0)};
}

/* Of several bins in a pixel the fullest is shown, so that what is rare is not lost. */
void vvi_plot_paint(vv_image *image, const vvi_plot *plot)
{
    const vvi_plot_density *d = plot->density;
    const frame f = frame_of(plot);
    const size_t x0 = (size_t)f.x0, width = (size_t)f.x1 - x0, y1 = (size_t)f.y1, height = (size_t)f.y0 - y1;
    const double top = top_of(d);
    for (size_t i = 0; i < 4 * (size_t)image->width * (size_t)image->height; i++)
        image->rgba[i] = 1;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            size_t i0, i1, j0, j1;
            uint64_t count = 0;
            bins_of(&i0, &i1, x, width, d->n_x);
            bins_of(&j0, &j1, height - 1 - y, height, d->n_y);
            for (size_t j = j0; j < j1; j++)
                for (size_t i = i0; i < i1; i++)
                    count = d->counts[j * d->n_x + i] > count ? d->counts[j * d->n_x + i] : count;
            if (!count)
                continue;
            const vv_color c = color_of(log10((double)count) / top);
            memcpy(image->rgba + 4 * ((y1 + y) * (size_t)image->width + x0 + x), (float[]){c.r, c.g, c.b, 1}, 16);
        }
}

static vv_status scale_tick(const frame *f, double x, int power, double top)
{
    char label[16], raised[8];
    const double y = f->y0 + power / top * (f->y1 - f->y0);
    snprintf(label, sizeof label, "%.0f", power < 4 ? pow(10, power) : 10);
    snprintf(raised, sizeof raised, "%d", power);
    vv_status st = line(f, x, y, x + TICK, y, &(vvi_gfx_stroke){.color = ink, .width = 1.2});
    if (st == VV_OK)
        st = text(f, x + TICK + 4, y, VVI_GFX_BEGIN, VVI_GFX_CENTRE, SMALL, label);
    return st == VV_OK && power >= 4
               ? text(f, x + TICK + 5 + 1.12 * SMALL, y - 6, VVI_GFX_BEGIN, VVI_GFX_CENTRE, RAISED, raised)
               : st;
}

static vv_status draw_scale(const frame *f)
{
    const double x0 = f->x1 + 24, x1 = x0 + SCALE_WIDTH, top = top_of(f->plot->density);
    const int each = (int)ceil(top / 9);
    const vvi_gfx_fill fill = {.stops = ramp, .n_stops = STOPS, .from = {x0, f->y0, 0}, .to = {x0, f->y1, 0}};
    const vv_vec3 box[4] = {{x0, f->y0, 0}, {x1, f->y0, 0}, {x1, f->y1, 0}, {x0, f->y1, 0}};
    vv_status st = vvi_gfx_rectangle(f->gfx, x0, f->y1, x1, f->y0, &fill);
    if (st == VV_OK)
        st = vvi_gfx_line(f->gfx, box, 4, VVI_GFX_LOOP, &(vvi_gfx_stroke){.color = ink, .width = 1});
    for (int p = 0; p <= top + 1e-6 && st == VV_OK; p += each)
        st = scale_tick(f, x1, p, top);
    const vvi_gfx_label turned = {
        .size = TEXT, .anchor = VVI_GFX_MIDDLE, .level = VVI_GFX_BOTTOM, .quarters = 1, .color = ink};
    return st == VV_OK ? letters(f, VVI_PLOT_WIDTH - 6, (f->y0 + f->y1) / 2, &turned, f->plot->density->label) : st;
}

static vv_status draw_density(frame *f)
{
    const vvi_plot_density *d = f->plot->density;
    f->lo[0] = d->x_lo;
    f->hi[0] = d->x_hi;
    f->lo[1] = d->y_lo;
    f->hi[1] = d->y_hi;
    f->y_unit = 1;
    vv_status st = draw_x_axis(f);
    if (st == VV_OK && (st = draw_y_axis(f)) == VV_OK && (st = draw_marks(f)) == VV_OK && (st = draw_box(f)) == VV_OK &&
        (st = draw_scale(f)) == VV_OK)
        st = draw_names(f);
    return st;
}

const char *vvi_plot_words(char *out, size_t room, const char *words)
{
    if (!words)
        return NULL;
    snprintf(out, room, "%s", words);
    vvi_text_clean(out); /* it may be cut inside of a letter, too */
    return out;
}

vv_status vvi_plot_draw(vvi_gfx *gfx, const vvi_plot *plot, vv_job *job)
{
    frame f = frame_of(plot);
    f.gfx = gfx;
    if (plot->density) {
        vvi_gfx_camera(gfx, NULL);
        return draw_density(&f);
    }
    if (plot->n == 0)
        return vv_fail(VV_E_ARGUMENT, "there is nothing to plot");
    vv_vec3 *points = vvi_alloc(job, (2 * plot->n + 2) * sizeof *points, VVI_MEM_SCRATCH);
    if (!points)
        return vv_fail_memory((2 * plot->n + 2) * sizeof *points);
    find_ranges(&f);
    vvi_gfx_camera(gfx, NULL);
    vv_status st = vvi_gfx_rectangle(gfx, 0, 0, VVI_PLOT_WIDTH, VVI_PLOT_HEIGHT, &(vvi_gfx_fill){.color = paper});
    if (st == VV_OK && (st = draw_x_axis(&f)) == VV_OK && (st = draw_y_axis(&f)) == VV_OK)
        st = plot->steps ? draw_steps(&f, points) : draw_curve(&f, points);
    if (st == VV_OK && (st = draw_marks(&f)) == VV_OK && (st = draw_box(&f)) == VV_OK)
        st = draw_names(&f);
    vvi_free(points);
    return st;
}
