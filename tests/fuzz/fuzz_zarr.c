/* A folder of two files: a line that names the first (".zarray" or "zarr.json"), its text up to a line "--", and then
 * the bytes of its only chunk. */
#include "fuzz.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <volvis/volvis.h>

static const char *const files[] = {".zarray", "zarr.json", ".zgroup", ".zattrs", "0.0.0", "c/0/0/0", "0/zarr.json"};
#define N_FILES (sizeof files / sizeof *files)

static char folder[64];

static void remove_all(void)
{
    static const char *const folders[] = {"c/0/0", "c/0", "c", "0", ""};
    char path[128];
    for (size_t i = 0; i < N_FILES; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, files[i]);
        unlink(path);
    }
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, folders[i]);
        rmdir(path);
    }
}

static void make_folders(void)
{
    static const char *const folders[] = {"c", "c/0", "c/0/0", "0"};
    char path[128];
    if (folder[0])
        return;
    strcpy(folder, access("/dev/shm", W_OK) == 0 ? "/dev/shm/volvis-fuzz-XXXXXX" : "/tmp/volvis-fuzz-XXXXXX");
    fuzz_expect(mkdtemp(folder) != NULL);
    for (size_t i = 0; i < sizeof folders / sizeof *folders; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, folders[i]);
        fuzz_expect(mkdir(path, 0755) == 0);
    }
    atexit(remove_all);
}

static void put(const char *name, const void *data, size_t n)
{
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    fuzz_expect(file != NULL);
    fuzz_expect(fwrite(data, 1, n, file) == n);
    fuzz_expect(fclose(file) == 0);
}

static void read_folder(void)
{
    vv_file *file;
    vv_status st = vv_file_open(&file, folder, NULL, fuzz_job());
    for (int64_t f = 0; st == VV_OK && f < vv_file_info(file)->n_frames && f < 3; f++) {
        vv_field *field = NULL;
        st = vv_file_read(&field, file, f, NULL, fuzz_job());
        fuzz_expect((st == VV_OK) == (field != NULL));
        vv_field_release(field);
    }
    fuzz_expect(st == VV_OK || (vv_error_last()->status == st && vv_error_last()->message[0]));
    fuzz_expect(st != VV_E_INTERNAL);
    vv_file_close(file);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t n)
{
    const uint8_t *line = memchr(data, '\n', n);
    if (!line)
        return 0;
    const bool v2 = (size_t)(line - data) == 7 && memcmp(data, ".zarray", 7) == 0;
    const uint8_t *text = line + 1, *end = data + n;
    const uint8_t *mark = memmem(text, (size_t)(end - text), "\n--\n", 4);
    const uint8_t *chunk = mark ? mark + 4 : end;
    make_folders();
    for (size_t i = 0; i < N_FILES; i++) {
        char path[128];
        snprintf(path, sizeof path, "%s/%s", folder, files[i]);
        unlink(path);
    }
    put(v2 ? ".zarray" : "zarr.json", text, (size_t)((mark ? mark : end) - text));
    put(v2 ? "0.0.0" : "c/0/0/0", chunk, (size_t)(end - chunk));
    read_folder();
    return 0;
}
