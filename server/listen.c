/* SPDX-License-Identifier: MIT */
#include "server/listen.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netinet/in.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

int listen_open(const char *address, uint16_t port, uint16_t *bound, struct err *err)
{
    struct sockaddr_storage where = {0};
    struct sockaddr_in *four = (struct sockaddr_in *)&where;
    struct sockaddr_in6 *six = (struct sockaddr_in6 *)&where;
    socklen_t size;
    if (inet_pton(AF_INET, address, &four->sin_addr) == 1) {
        four->sin_family = AF_INET;
        four->sin_port = htons(port);
        size = sizeof *four;
    } else {
        six->sin6_family = AF_INET6;
        six->sin6_addr = in6addr_loopback;
        six->sin6_port = htons(port);
        size = sizeof *six;
    }
    const int fd = socket(where.ss_family, SOCK_STREAM, 0);
    const int one = 1;
    if (fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &one, sizeof one) == 0 &&
        bind(fd, (struct sockaddr *)&where, size) == 0 && listen(fd, SOMAXCONN) == 0 &&
        getsockname(fd, (struct sockaddr *)&where, &size) == 0) {
        *bound = ntohs(where.ss_family == AF_INET ? four->sin_port : six->sin6_port);
        return fd;
    }
    err_set(err, ERR_IO, "listen on %s port %u: %s", address, port, strerror(errno));
    if (fd >= 0)
        close(fd);
    return -1;
}
