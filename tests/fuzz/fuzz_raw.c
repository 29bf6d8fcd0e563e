/* The first line is the layout, as after --raw; the rest are the samples. */
#include "fuzz.h"
#include "registry.h"
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    char layout[256];
    vv_read_options options;
    const uint8_t *end = n > 0 ? memchr(data, '\n', n) : NULL;
    const size_t n_line = end ? (size_t)(end - data) : 0;
    if (!end || n_line >= sizeof layout)
        return 0;
    memcpy(layout, data, n_line);
    layout[n_line] = 0;
    vv_read_options_init(&options, sizeof options);
    options.raw = layout;
    fuzz_format(&vvi_format_raw, end + 1, n - n_line - 1, &options);
    return 0;
}
