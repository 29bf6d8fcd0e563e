#include "io/foreign_files.h"
#include <stdbool.h>
#include <string.h>
#include <strings.h>

typedef struct mark {
    size_t at, n;
    const char *bytes, *kind;
} mark;

#define MARK(at, bytes, kind)                                                                                          \
    {                                                                                                                  \
        at, sizeof(bytes) - 1, bytes, kind                                                                             \
    }
#define ARCHIVE ": unpack it and name what is inside"

static const mark marks[] = {
    MARK(0, "PK\003\004", "a ZIP archive" ARCHIVE),
    MARK(0, "Rar!\032\007", "a RAR archive" ARCHIVE),
    MARK(0, "7z\274\257\047\034", "a 7-Zip archive" ARCHIVE),
    MARK(257, "ustar", "a TAR archive" ARCHIVE),
    MARK(0, "\3757zXZ", "packed by xz: unpack it with 'xz -d' first"),
    MARK(0, "\004\042\115\030", "packed by LZ4: unpack it with 'lz4 -d' first"),
    MARK(0, "version https://git-lfs", "a pointer of Git LFS, not the data: fetch the data with 'git lfs pull'"),
    MARK(0, "%PDF-", "a PDF document, not a volume"),
    MARK(0, "{\\rtf", "a text document, not a volume"),
    MARK(0, "\320\317\021\340\241\261\032\341", "a Microsoft Office document, not a volume"),
    MARK(4, "ftyp", "a film or photograph (MP4, MOV, HEIC), not a volume"),
    MARK(0, "\032\105\337\243", "a film (Matroska, WebM), not a volume"),
    MARK(8, "AVI ", "a film (AVI), not a volume"),
    MARK(0, "GIF8", "a GIF picture: save its slices as TIFF or PNG files in a folder and name the folder"),
    MARK(8, "WEBP", "a WebP picture: save it as PNG or TIFF"),
    MARK(0, "\177ELF", "a program, not a volume"),
    MARK(0, "MATLAB 5.0 MAT", "a MATLAB file of version 5: save it with save(..., '-v7.3'), which makes HDF5"),
    MARK(0, "SIMPLE  =", "a FITS file, which is not read: save its array as .npy or .h5"),
    MARK(0, "GRIB", "a GRIB file, which is not read: convert it to netCDF-4"),
    MARK(0, "\016\003\023\001", "an HDF4 file, which is not read: convert it with h4toh5"),
    MARK(0, "SQLite format 3", "a database, not a volume"),
};

static bool has(const uint8_t *head, size_t n, const char *word)
{
    const size_t m = strlen(word);
    for (size_t i = 0; i + m <= n; i++)
        if (memcmp(head + i, word, m) == 0)
            return true;
    return false;
}

/* The first word of a text, letter case aside. */
static bool begins(const uint8_t *head, size_t n, const char *word)
{
    size_t at = n >= 3 && memcmp(head, "\357\273\277", 3) == 0 ? 3 : 0;
    while (at < n && strchr(" \t\r\n", head[at]) && head[at])
        at++;
    return n - at >= strlen(word) && strncasecmp((const char *)head + at, word, strlen(word)) == 0;
}

/* Line ends and whatever can be printed; bytes above 127 are letters of some language. */
static bool is_text(const uint8_t *head, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if ((head[i] < 32 && !(head[i] >= 9 && head[i] <= 13)) || head[i] == 127)
            return false;
    return n > 0;
}

const char *vvi_foreign_mark(const uint8_t *head, size_t n)
{
    if (n >= 4 && memcmp(head, "PK\003\004", 4) == 0 && has(head, n < 64 ? n : 64, "[Content_Types]"))
        return "an Office document, not a volume";
    for (size_t i = 0; i < sizeof marks / sizeof *marks; i++)
        if (n >= marks[i].at + marks[i].n && memcmp(head + marks[i].at, marks[i].bytes, marks[i].n) == 0)
            return marks[i].kind;
    if (begins(head, n, "<!doctype html") || begins(head, n, "<html"))
        return "a web page, not a volume: the download may need a login or another link";
    return NULL;
}

const char *vvi_foreign_kind(const uint8_t *head, size_t n)
{
    const char *kind = vvi_foreign_mark(head, n);
    if (kind || !is_text(head, n))
        return kind;
    if (begins(head, n, "ply\n") || begins(head, n, "ply\r") || begins(head, n, "solid "))
        return "a mesh of a surface, not a volume";
    if (begins(head, n, "#!"))
        return "a program, not a volume";
    if (begins(head, n, "{"))
        return "JSON that is not the header of a volume; a scene's name ends in .vv.json";
    return "a text that is not a header of a known format ('volvis formats' lists them)";
}
