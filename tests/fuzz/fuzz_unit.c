/* Quantities: the first byte chooses which, the rest is the text. Numbers that are read print so that they are read
 * back. */
#include "core/units.h"
#include "fuzz.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    static const vv_property_context context = {.length_unit = "mm", .voxel = 0.5};
    char number[32], *text = malloc(n + 1);
    double value, back;
    fuzz_expect(text != NULL);
    if (n > 0)
        memcpy(text, data, n);
    text[n] = 0;
    if (n > 0) {
        const vv_status st =
            vvi_parse_quantity(&value, text + 1, (vv_quantity)(data[0] % (VV_Q_RATIO + 1)), &context, "input");
        fuzz_expect(st == VV_OK || vv_error_last()->message[0]);
    }
    if (vvi_parse_number(&value, text) && isfinite(value)) {
        vvi_print_number(number, value);
        fuzz_expect(vvi_parse_number(&back, number) && back == value);
    }
    free(text);
    return 0;
}
