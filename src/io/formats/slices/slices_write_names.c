/* What the slices of a folder are called: by words that reading takes for what they are, or as a pattern says. */
#include "core/text.h"
#include "io/formats/slices/slices_write.h"
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#define WIDTH_MOST 20

static size_t count_places(const char *names)
{
    int width;
    size_t places = 0;
    for (; *names; names++)
        places += vvi_text_place(names, &width) > 0;
    return places;
}

const char *vvi_slices_pattern(const char *path)
{
    const char *slash = strrchr(path, '/'), *names = slash ? slash + 1 : path;
    return count_places(names) > 0 ? names : NULL;
}

static bool ends_with(const char *text, const char *end)
{
    const size_t n = strlen(text), n_end = strlen(end);
    return n > n_end && strcasecmp(text + n - n_end, end) == 0;
}

vv_status vvi_slices_check_pattern(const char **encoding_out, const char *names, const char *encoding)
{
    int width;
    const char *own = ends_with(names, ".png")                                ? "png"
                      : ends_with(names, ".tif") || ends_with(names, ".tiff") ? "tiff"
                                                                              : NULL;
    if (!own)
        return vv_fail(VV_E_ARGUMENT, "-o '%.80s': slices are written as .png or .tif; end the names with one of them",
                       names);
    if (encoding && strcmp(encoding, own) != 0)
        return vv_fail(VV_E_ARGUMENT, "-o '%.80s' is a name of %s, and --encoding says %s; leave it out", names, own,
                       encoding);
    if (strlen(names) > VVI_SLICES_NAME_MOST - 4 * WIDTH_MOST)
        return vv_fail(VV_E_ARGUMENT, "-o '%.40s...': the name is too long", names);
    for (const char *at = names; (at = strchr(at, '%')) != NULL; at++)
        if (vvi_text_place(at, &width) == 0 || width > WIDTH_MOST || (width > 0 && at[1] != '0'))
            return vv_fail(VV_E_ARGUMENT,
                           "-o '%.80s': '%.4s' is no place for a number; there are %%d and, with zeros in front, %%03d",
                           names, at);
    *encoding_out = own;
    return VV_OK;
}

vv_status vvi_slices_check_places(const char *names, uint64_t frames, uint64_t channels, uint64_t slices)
{
    const size_t wanted = 1 + (frames > 1) + (channels > 1), places = count_places(names);
    if (places == wanted)
        return VV_OK;
    char axes[160], times[64] = "", colors[64] = "";
    if (frames > 1)
        snprintf(times, sizeof times, "%" PRIu64 " time steps, ", frames);
    if (channels > 1)
        snprintf(colors, sizeof colors, "%" PRIu64 " channels, ", channels);
    snprintf(axes, sizeof axes, "%s%s%" PRIu64 " slice%s", times, colors, slices, slices == 1 ? "" : "s");
    return vv_fail(VV_E_ARGUMENT, "-o '%.80s' has %zu places for numbers (%%d), and %zu %s needed, in this order: %s%s",
                   names, places, wanted, wanted == 1 ? "is" : "are", axes,
                   wanted > 1 ? "; name them as t%02d_c%d_z%03d, or choose with --frame and --channel" : "");
}

void vvi_slices_fill(char out[VVI_SLICES_NAME_MOST], const char *names, const uint64_t *numbers)
{
    size_t n = 0, used = 0;
    int width;
    while (*names && n + WIDTH_MOST + 1 < VVI_SLICES_NAME_MOST) {
        const size_t place = vvi_text_place(names, &width);
        if (place > 0)
            n += (size_t)snprintf(out + n, VVI_SLICES_NAME_MOST - n, "%0*" PRIu64, width, numbers[used++]);
        else
            out[n++] = *names;
        names += place > 0 ? place : 1;
    }
    out[n] = 0;
}
