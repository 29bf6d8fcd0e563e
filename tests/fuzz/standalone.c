/* Gives a fuzz target the files (and the files in the folders) that it is called with: for compilers without libFuzzer,
 * for valgrind, and for the test that replays every kept input. */
#include "fuzz.h"
#include <ftw.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

static size_t runs;

static int replay(const char *path, const struct stat *info, int type, struct FTW *where)
{
    (void)where;
    if (type != FTW_F)
        return 0;
    FILE *file = fopen(path, "rb");
    uint8_t *data = malloc((size_t)info->st_size + 1);
    if (!file || !data) {
        fprintf(stderr, "%s cannot be read\n", path);
        exit(1);
    }
    const size_t n = fread(data, 1, (size_t)info->st_size, file);
    fclose(file);
    /* a copy of exactly that size: the sanitizers then see a read past its end */
    uint8_t *exact = realloc(data, n ? n : 1);
    LLVMFuzzerTestOneInput(exact ? exact : data, n);
    free(exact ? exact : data);
    runs++;
    return 0;
}

int main(int argc, char **argv)
{
    for (int i = 1; i < argc; i++)
        if (nftw(argv[i], replay, 16, FTW_PHYS) != 0) {
            fprintf(stderr, "%s cannot be walked\n", argv[i]);
            return 1;
        }
    printf("%zu inputs replayed\n", runs);
    return runs > 0 ? 0 : 1;
}
