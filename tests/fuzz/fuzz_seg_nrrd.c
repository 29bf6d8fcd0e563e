#include "fuzz.h"
#include "registry.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    fuzz_format(&vvi_format_seg_nrrd, data, n, NULL);
    return 0;
}
