/* volvis-import: reads volume files for a program that runs with --safe. Not for people. */
#include "import/import_wire.h"
#include "lock.h"
#include "serve.h"
#include <stdio.h>
#include <sys/socket.h>
#include <sys/stat.h>

int main(int argc, char **argv)
{
    struct stat about;
    if (argc != 1 || fstat(VVI_IMPORT_SOCKET, &about) != 0 || !S_ISSOCK(about.st_mode)) {
        fprintf(stderr, "%s: is started by volvis when it reads with --safe, not by hand\n", argv[0]);
        return 2;
    }
    import_lock_early();
    return import_serve(VVI_IMPORT_SOCKET, NULL);
}
