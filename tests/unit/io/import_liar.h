/** @file
 * What the import programs that lie hear of the program that asks them.
 */
#ifndef TESTS_IMPORT_LIAR_H
#define TESTS_IMPORT_LIAR_H
#include "import/import_wire.h"
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

static int shared = -1; /* the shared memory that came with a request */

static void take(void *out, size_t n)
{
    char control[CMSG_SPACE(sizeof(int))];
    while (n > 0) {
        struct iovec piece = {out, n};
        struct msghdr message = {
            .msg_iov = &piece, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
        const ssize_t got = recvmsg(VVI_IMPORT_SOCKET, &message, 0);
        if (got <= 0)
            _exit(0);
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        if (c)
            memcpy(&shared, CMSG_DATA(c), sizeof shared);
        out = (char *)out + got;
        n -= (size_t)got;
    }
}

static char *take_message(size_t *n)
{
    vvi_wire_head head;
    take(&head, sizeof head);
    char *bytes = malloc(head.n_bytes + 1);
    take(bytes, head.n_bytes);
    *n = head.n_bytes;
    return bytes;
}

#endif
