#include "fuzz.h"
#include "registry.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    fuzz_image(&vvi_image_format_webp, data, n);
    return 0;
}
