/* Colours: planes to samples, luma and chroma to red, green and blue; and run lengths. */
#include "io/formats/dicom/dicom.h"
#include <string.h>

void vvi_dicom_interleave(uint8_t *out, const uint8_t *in, size_t n, int components, size_t bytes)
{
    for (int c = 0; c < components; c++, in += n * bytes)
        for (size_t i = 0; i < n; i++)
            memcpy(out + (i * (size_t)components + (size_t)c) * bytes, in + i * bytes, bytes);
}

static uint8_t clamp(double v)
{
    return (uint8_t)(v <= 0 ? 0 : v >= 255 ? 255 : v + 0.5);
}

/* PS3.3 C.7.6.3.1.2, YBR_FULL: ITU-R BT.601 over the full range. */
static void to_rgb(uint8_t *out, double y, double cb, double cr)
{
    out[0] = clamp(y + 1.402 * (cr - 128));
    out[1] = clamp(y - 0.344136 * (cb - 128) - 0.714136 * (cr - 128));
    out[2] = clamp(y + 1.772 * (cb - 128));
}

void vvi_dicom_ybr_to_rgb(uint8_t *samples, size_t n)
{
    for (size_t i = 0; i < n; i++)
        to_rgb(samples + 3 * i, samples[3 * i], samples[3 * i + 1], samples[3 * i + 2]);
}

/* Two pixels are four bytes: Y Y Cb Cr. */
void vvi_dicom_ybr422_to_rgb(uint8_t *out, const uint8_t *in, size_t n)
{
    for (size_t i = 0; i + 1 < n; i += 2, in += 4) {
        to_rgb(out + 3 * i, in[0], in[2], in[3]);
        to_rgb(out + 3 * i + 3, in[1], in[2], in[3]);
    }
}

static uint32_t u32(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* A segment: n bytes to every step-th of the output. Packed bits as in TIFF. */
static bool unpack_segment(uint8_t *out, size_t n, size_t step, const uint8_t *in, size_t n_in)
{
    size_t at = 0, i = 0;
    while (i < n && at < n_in) {
        const int8_t code = (int8_t)in[at++];
        if (code >= 0) {
            for (size_t m = (size_t)code + 1; m > 0 && i < n && at < n_in; m--)
                out[step * i++] = in[at++];
        } else if (code != -128 && at < n_in) {
            for (size_t m = (size_t)(1 - code); m > 0 && i < n; m--)
                out[step * i++] = in[at];
            at++;
        }
    }
    return i == n;
}

/* A segment holds one byte of each sample of one component, the most significant first (PS3.5 annex G). */
bool vvi_dicom_unpack_rle(uint8_t *out, size_t n, int components, size_t bytes, const uint8_t *in, size_t n_in)
{
    const size_t n_segments = (size_t)components * bytes, step = n_segments;
    if (n_in < 64 || u32(in) != n_segments || n_segments > 15)
        return false;
    for (size_t s = 0; s < n_segments; s++) {
        const uint32_t from = u32(in + 4 + 4 * s);
        const uint32_t to = s + 1 < n_segments ? u32(in + 8 + 4 * s) : (uint32_t)n_in;
        const size_t component = s / bytes, byte = bytes - 1 - s % bytes;
        if (from < 64 || from > to || to > n_in ||
            !unpack_segment(out + component * bytes + byte, n, step, in + from, to - from))
            return false;
    }
    return true;
}
