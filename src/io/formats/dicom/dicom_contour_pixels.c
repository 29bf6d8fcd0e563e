/* Contours drawn into a slice: a sample is inside when its centre is, by the even-odd rule over all contours of the
 * region in one plane. */
#include "core/job.h"
#include "io/formats/dicom/dicom_contours.h"
#include <math.h>
#include <string.h>

typedef struct canvas {
    uint8_t *out; /* where the inside begins or ends in each row, until the rows are filled */
    int64_t columns, rows;
} canvas;

typedef struct spot {
    double x, y; /* columns and rows */
} spot;

/* The point at right angles above or below, in the plane of the slice. */
static spot spot_of(const vvi_dicom_structures *s, double depth, const double *p)
{
    const vv_vec3 n = s->normal;
    const double up = depth - (p[0] * n.x + p[1] * n.y + p[2] * n.z);
    const vv_vec3 at = vv_affine_point(s->to_index, (vv_vec3){p[0] + up * n.x, p[1] + up * n.y, p[2] + up * n.z});
    return (spot){at.x, at.y};
}

/* Rows at y0 <= row < y1 are crossed. An edge that is walked both ways, as the bridges of keyholes are, crosses at the
 * same places both times, to the last bit. */
static void draw_edge(canvas *c, spot a, spot b)
{
    if (a.y > b.y || (a.y == b.y && a.x > b.x)) {
        const spot other = a;
        a = b;
        b = other;
    }
    const double from = fmax(ceil(a.y), 0), to = fmin(ceil(b.y), (double)c->rows);
    if (!(from < to))
        return;
    for (int64_t row = (int64_t)from; row < (int64_t)to; row++) {
        const double x = ceil(a.x + ((double)row - a.y) * ((b.x - a.x) / (b.y - a.y)));
        if (x < (double)c->columns)
            c->out[row * c->columns + (x > 0 ? (int64_t)x : 0)] ^= 1;
    }
}

static void draw_contour(canvas *c, const vvi_dicom_structures *s, double depth, const vvi_dicom_contour *contour)
{
    spot last = spot_of(s, depth, contour->at + 3 * (contour->n_points - 1));
    for (size_t i = 0; i < contour->n_points; i++) {
        const spot here = spot_of(s, depth, contour->at + 3 * i);
        draw_edge(c, last, here);
        last = here;
    }
}

static void fill_rows(canvas *c)
{
    for (int64_t j = 0; j < c->rows; j++) {
        uint8_t *row = c->out + j * c->columns;
        for (int64_t i = 1; i < c->columns; i++)
            row[i] ^= row[i - 1];
    }
}

vv_status vvi_dicom_draw_frame(uint8_t *out, const vvi_dicom_image *image, int64_t frame, vv_job *job)
{
    const vvi_dicom_structures *s = image->structures;
    const vvi_dicom_drawing *drawing = &s->frame[frame];
    canvas c = {.out = out, .columns = s->grid.dims[0], .rows = s->grid.dims[1]};
    const vv_vec3 at = vv_affine_point(s->grid.index_to_world, (vv_vec3){0, 0, drawing->slice});
    const double depth = at.x * s->normal.x + at.y * s->normal.y + at.z * s->normal.z;
    vv_status st = VV_OK;
    memset(out, 0, (size_t)(c.columns * c.rows));
    for (size_t i = 0; i < drawing->n && st == VV_OK; i++) {
        draw_contour(&c, s, depth, &s->contour[drawing->first + i]);
        st = vvi_job_poll(job);
    }
    fill_rows(&c);
    return st;
}
