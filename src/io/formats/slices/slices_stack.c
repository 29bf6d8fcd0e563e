/* TIFF files of several pages that are volumes by themselves, and no slices, wherever no number in their names counts.
 */
#include "core/text.h"
#include "io/formats/slices/slices.h"
#include "io/layout.h"
#include "io/sample_writer.h"
#include <string.h>
#include <strings.h>

static bool is_tiff(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot && (strcasecmp(dot, ".tif") == 0 || strcasecmp(dot, ".tiff") == 0);
}

/* Whether two names differ in their numbers alone. */
static bool same_shape(const char *a, const char *b)
{
    static const char digits[] = "0123456789";
    while (*a || *b) {
        const size_t n = strspn(a, digits), m = strspn(b, digits);
        if ((n > 0) != (m > 0) || (n == 0 && *a != *b))
            return false;
        a += n ? n : 1;
        b += m ? m : 1;
    }
    return true;
}

/* Whether it is the only one of its shape, among pictures that are few enough to be looked into. */
static bool is_alone(const vvi_names *names, const char *name)
{
    size_t n = 0;
    for (size_t i = 0; i < names->n && n <= VVI_SLICES_LOOKED; i++) {
        const char *other = names->name[i];
        if (strchr(other, '/') || !vvi_slices_is_picture(other))
            continue;
        n++;
        if (strcmp(name, other) != 0 && same_shape(name, other))
            return false;
    }
    return n <= VVI_SLICES_LOOKED;
}

/* Integer of a file, of at most 8 bytes. */
static bool take(uint64_t *out, vv_source *source, size_t bytes, bool swap)
{
    uint8_t raw[8] = {0};
    uint16_t two;
    uint32_t four;
    size_t n = 0;
    if (vvi_source_read_some(source, raw, bytes, &n) != VV_OK || n != bytes)
        return false;
    if (swap)
        vvi_swap_bytes(raw, bytes, 1);
    memcpy(&two, raw, sizeof two);
    memcpy(&four, raw, sizeof four);
    memcpy(out, raw, sizeof *out);
    *out = bytes == 2 ? two : bytes == 4 ? four : *out;
    return true;
}

/* Whether a directory follows the first. */
static bool has_pages(vv_source *source)
{
    uint64_t version, first, n, next;
    uint8_t order[2];
    size_t got = 0;
    if (vvi_source_read_some(source, order, sizeof order, &got) != VV_OK || got != 2 || order[0] != order[1])
        return false;
    const bool swap = vvi_order_swapped(order[0] == 'M');
    if (!take(&version, source, 2, swap) || (version != 42 && version != 43))
        return false;
    const bool big = version == 43;
    const size_t wide = big ? 8 : 4;
    return (!big || take(&n, source, 4, swap)) && take(&first, source, wide, swap) &&
           vvi_source_seek(source, first) == VV_OK && take(&n, source, big ? 8 : 2, swap) && n < 65536 &&
           vvi_source_seek(source, first + (big ? 8 + 20 * n : 2 + 12 * n)) == VV_OK &&
           take(&next, source, wide, swap) && next != 0;
}

bool vvi_slices_is_stack(const vvi_names *names, const char *name, const vv_source *folder, vv_job *job)
{
    vv_source *source = NULL;
    if (strchr(name, '/') || !is_tiff(name) || !is_alone(names, name) ||
        vvi_source_open_beside(&source, folder, name, job) != VV_OK)
        return false;
    const bool stack = has_pages(source);
    vvi_source_close(source);
    return stack;
}
