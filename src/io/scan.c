#include "io/scan.h"
#include "core/units.h"
#include <ctype.h>
#include <math.h>
#include <string.h>
#include <strings.h>

static const char *after_blanks(const char *text)
{
    return text + strspn(text, " \t");
}

bool vvi_scan_uint(uint64_t *out, const char *text, const char **end)
{
    const char *at = after_blanks(text);
    uint64_t v = 0;
    at += *at == '+';
    if (!isdigit((unsigned char)*at))
        return false;
    for (; isdigit((unsigned char)*at); at++) {
        const unsigned digit = (unsigned)(*at - '0');
        if (v > (UINT64_MAX - digit) / 10)
            return false;
        v = v * 10 + digit;
    }
    *out = v;
    *end = at;
    return true;
}

bool vvi_scan_int(int64_t *out, const char *text, const char **end)
{
    const char *at = after_blanks(text);
    uint64_t v;
    const bool minus = *at == '-';
    if (minus && !isdigit((unsigned char)at[1]))
        return false;
    if (!vvi_scan_uint(&v, at + minus, &at) || v > (uint64_t)INT64_MAX + minus)
        return false;
    *out = minus ? (int64_t)(0 - v) : (int64_t)v;
    *end = at;
    return true;
}

/* Fortran's double precision: 1.5D-03 after its 1.5 was read. False where it is too large. */
static bool scan_fortran_exponent(double *out, const char *text, const char **end)
{
    char copy[64];
    const char *at = *end, *stop;
    const size_t n = (size_t)(at - text);
    if ((*at != 'D' && *at != 'd') || memchr(text, 'e', n) || memchr(text, 'E', n))
        return true;
    at++;
    at += *at == '+' || *at == '-';
    const size_t digits = strspn(at, "0123456789"), all = (size_t)(at - text) + digits;
    if (digits == 0 || all >= sizeof copy)
        return true; /* a word that begins with d */
    memcpy(copy, text, all);
    copy[all] = 0;
    copy[n] = 'e';
    if (!vvi_scan_number(out, copy, &stop) || *stop)
        return false;
    *end = text + all;
    return true;
}

bool vvi_scan_real(double *out, const char *text, const char **end)
{
    const char *at = after_blanks(text);
    const bool minus = *at == '-';
    const char *word = at + (minus || *at == '+');
    if (strncasecmp(word, "nan", 3) == 0) {
        *out = minus ? -(double)NAN : (double)NAN;
        *end = word + 3;
        return true;
    }
    return vvi_scan_number(out, at, end) && scan_fortran_exponent(out, at, end);
}

size_t vvi_utf8_cut(const char *text, size_t n, size_t most)
{
    if (n <= most)
        return n;
    while (most > 0 && ((unsigned char)text[most] & 0xc0) == 0x80)
        most--;
    return most;
}

void vvi_unit_name(char out[16], const char *text, size_t n)
{
    static const struct {
        const char *said, *meant;
    } known[] = {
        {"millimeter", "mm"},   {"millimeters", "mm"}, {"millimetre", "mm"},
        {"millimetres", "mm"},  {"micron", "um"},      {"microns", "um"},
        {"micrometer", "um"},   {"micrometers", "um"}, {"micrometre", "um"},
        {"micrometres", "um"},  {"\xc2\xb5m", "um"},   {"\xce\xbcm", "um"},
        {"nanometer", "nm"},    {"nanometers", "nm"},  {"meter", "m"},
        {"meters", "m"},        {"metre", "m"},        {"metres", "m"},
        {"angstrom", "A"},      {"centimeter", "cm"},  {"centimeters", "cm"},
        {"seconds", "s"},       {"second", "s"},       {"sec", "s"},
        {"milliseconds", "ms"}, {"msec", "ms"},        {"millisecond", "ms"},
        {"microsecond", "us"},  {"\xc2\xb5s", "us"},   {"\xce\xbcs", "us"},
        {"microseconds", "us"}, {"day", "d"},          {"minutes", "min"},
        {"hours", "h"},         {"days", "d"},         {"minute", "min"},
        {"hour", "h"},          {"picometer", "pm"},   {"kilometer", "km"},
        {"inch", "in"},         {"foot", "ft"},        {"angstroms", "A"},
        {"\xc3\x85", "A"},      {"\xe2\x84\xab", "A"}, {"\xc3\x85ngstr\xc3\xb6m", "A"},
    };
    while (n > 0 && (*text == ' ' || *text == '\t')) {
        text++;
        n--;
    }
    while (n > 0 && (text[n - 1] == ' ' || text[n - 1] == '\t'))
        n--;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strlen(known[i].said) == n && strncasecmp(known[i].said, text, n) == 0) {
            strcpy(out, known[i].meant);
            return;
        }
    n = vvi_utf8_cut(text, n, 15);
    memcpy(out, text, n);
    out[n] = 0;
}

bool vvi_scan_label(vv_label_id *out, const char *text, const char **end)
{
    uint64_t v;
    if (vvi_scan_int(out, text, end))
        return true;
    if (!vvi_scan_uint(&v, text, end))
        return false;
    *out = (vv_label_id)v;
    return true;
}
