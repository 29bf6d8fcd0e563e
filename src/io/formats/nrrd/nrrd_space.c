/* The space that a header speaks of, and where its axes lie in it. */
#include "io/formats/nrrd/nrrd_lines.h"
#include "io/scan.h"
#include <math.h>
#include <string.h>

static vv_status parse_space(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    static const struct {
        const char *name;
        int dimension;
        bool anatomical;
        double flip[3];
    } spaces[] = {
        {"rightanteriorsuperior", 3, true, {1, 1, 1}},
        {"ras", 3, true, {1, 1, 1}},
        {"leftanteriorsuperior", 3, true, {-1, 1, 1}},
        {"las", 3, true, {-1, 1, 1}},
        {"leftposteriorsuperior", 3, true, {-1, -1, 1}},
        {"lps", 3, true, {-1, -1, 1}},
        {"rightanteriorsuperiortime", 4, true, {1, 1, 1}},
        {"rast", 4, true, {1, 1, 1}},
        {"leftanteriorsuperiortime", 4, true, {-1, 1, 1}},
        {"last", 4, true, {-1, 1, 1}},
        {"leftposteriorsuperiortime", 4, true, {-1, -1, 1}},
        {"lpst", 4, true, {-1, -1, 1}},
        {"scannerxyz", 3, false, {1, 1, 1}},
        {"scannerxyztime", 4, false, {1, 1, 1}},
        {"3drighthanded", 3, false, {1, 1, 1}},
        {"3drighthandedtime", 4, false, {1, 1, 1}},
        {"3dlefthanded", 3, false, {1, 1, -1}},
        {"3dlefthandedtime", 4, false, {1, 1, -1}},
    };
    char word[40];
    int64_t n;
    h->flip[0] = h->flip[1] = h->flip[2] = 1;
    if (l->text[F_SPACE_DIMENSION]) {
        vv_status st = vvi_nrrd_parse_int(&n, l, F_SPACE_DIMENSION, 1, 4);
        h->space_dimension = st == VV_OK ? (int)n : 0;
        return st;
    }
    if (!l->text[F_SPACE])
        return VV_OK;
    vvi_nrrd_plain_word(word, sizeof word, l->text[F_SPACE], strlen(l->text[F_SPACE]));
    for (size_t i = 0; i < sizeof spaces / sizeof *spaces; i++)
        if (strcmp(spaces[i].name, word) == 0) {
            h->space_dimension = spaces[i].dimension;
            h->anatomical = spaces[i].anatomical;
            memcpy(h->flip, spaces[i].flip, sizeof h->flip);
            return VV_OK;
        }
    return vvi_nrrd_fail_line(
        l, F_SPACE, "is '%.40s', which is not a space; write for example 'right-anterior-superior'", l->text[F_SPACE]);
}

bool vvi_nrrd_scan_vector(double *out, int n, const char *at, const char **end)
{
    at += strspn(at, " \t");
    if (*at++ != '(')
        return false;
    for (int i = 0; i < n; i++) {
        if (!vvi_scan_real(&out[i], at, &at))
            return false;
        at += strspn(at, " \t");
        if (*at++ != (i + 1 < n ? ',' : ')'))
            return false;
    }
    *end = at;
    return true;
}

static vv_status parse_directions(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *at = l->text[F_SPACE_DIRECTIONS];
    h->has_directions = at != NULL;
    if (at && h->space_dimension == 0)
        return vvi_nrrd_fail_line(l, F_SPACE_DIRECTIONS, "needs a field 'space' or 'space dimension'");
    for (int a = 0; at && a < h->dimension; a++) {
        at += strspn(at, " \t");
        vvi_nrrd_axis *axis = &h->axis[a];
        if (strncmp(at, "none", 4) == 0) {
            at += 4;
        } else if (vvi_nrrd_scan_vector(axis->direction, h->space_dimension, at, &at)) {
            axis->has_direction = true;
        } else {
            return vvi_nrrd_fail_line(l, F_SPACE_DIRECTIONS, "has no vector of %d numbers for axis %d of %d",
                                      h->space_dimension, a + 1, h->dimension);
        }
        for (int i = 0; i < h->space_dimension; i++)
            if (!isfinite(axis->direction[i]))
                return vvi_nrrd_fail_line(l, F_SPACE_DIRECTIONS, "of axis %d is not finite", a + 1);
    }
    if (at && at[strspn(at, " \t")] != 0)
        return vvi_nrrd_fail_line(l, F_SPACE_DIRECTIONS, "has more than the %d entries that 'dimension' says",
                                  h->dimension);
    return VV_OK;
}

static vv_status parse_origin(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    const char *text = l->text[F_SPACE_ORIGIN], *end;
    if (!text)
        return VV_OK;
    if (h->space_dimension == 0)
        return vvi_nrrd_fail_line(l, F_SPACE_ORIGIN, "needs a field 'space' or 'space dimension'");
    if (!vvi_nrrd_scan_vector(h->origin, h->space_dimension, text, &end))
        return vvi_nrrd_fail_line(l, F_SPACE_ORIGIN, "is '%.40s', not a vector of %d numbers", text,
                                  h->space_dimension);
    for (int i = 0; i < h->space_dimension; i++)
        if (!isfinite(h->origin[i]))
            return vvi_nrrd_fail_line(l, F_SPACE_ORIGIN, "is not finite");
    h->has_origin = true;
    return VV_OK;
}

vv_status vvi_nrrd_parse_space(vvi_nrrd *h, const vvi_nrrd_lines *l)
{
    vv_status st = parse_space(h, l);
    if (st == VV_OK)
        st = parse_directions(h, l);
    return st == VV_OK ? parse_origin(h, l) : st;
}
