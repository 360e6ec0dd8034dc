/* The coordinator under malformed, hostile and merely wrong requests: each is answered with the
 * right 4xx or its connection is closed, and the daemon lives. SPDX-License-Identifier: MIT */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "common/clock.h"
#include "common/hash.h"
#include "server/http.h"
#include "tests/daemon.h"
#include "tests/tap.h"

/* ANY_4XX: closed, or an answer of 400 to 499, or 505 for another version of HTTP; where
 * libmicrohttpd answers by itself, it is not a problem document. */
enum { CLOSED = 0, ANY_4XX = 4 };

#define HOST "Host: localhost\r\n"
#define JSON "Content-Type: application/json\r\n"
#define SHA  "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"

static struct daemon d;

struct probe {
    const char *bytes;
    size_t count; /* 0: strlen */
    int status;
    const char *name;
};

#define P(status, name, text)                                                                      \
    {                                                                                              \
        text, 0, status, name                                                                      \
    }
#define N(status, name, text)                                                                      \
    {                                                                                              \
        text, sizeof text - 1, status, name                                                        \
    }

static const struct probe probes[] = {
    /* request lines */
    P(ANY_4XX, "one word", "GET\r\n\r\n"),
    P(ANY_4XX, "no version", "GET /healthz\r\n" HOST "\r\n"),
    P(ANY_4XX, "HTTP/3.0", "GET /healthz HTTP/3.0\r\n" HOST "\r\n"),
    P(400, "HTTP/1.2", "GET /healthz HTTP/1.2\r\n" HOST "\r\n"),
    P(ANY_4XX, "version is rubbish", "GET /healthz FTP/9\r\n" HOST "\r\n"),
    P(ANY_4XX, "spaces in the target", "GET /heal thz HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "unknown method", "BREW /healthz HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "lower-case method", "get /healthz HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "CONNECT", "CONNECT /healthz HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "TRACE", "TRACE / HTTP/1.1\r\n" HOST "\r\n"),
    P(ANY_4XX, "OPTIONS *", "OPTIONS * HTTP/1.1\r\n" HOST "\r\n"),
    P(400, "absolute target of another site", "GET http://evil/healthz HTTP/1.1\r\n" HOST "\r\n"),
    N(ANY_4XX, "NUL in the request line", "GET /hea\0lthz HTTP/1.1\r\n" HOST "\r\n"),
    P(ANY_4XX, "TLS hello", "\x16\x03\x01\x02\x01\x01\x01\x01\xfc\x03\x03\r\n\r\n"),
    P(ANY_4XX, "HTTP/2 preface", "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"),
    /* targets */
    P(400, "%00 in the path", "GET /healthz%00 HTTP/1.1\r\n" HOST "\r\n"),
    P(400, "%00 in the query", "GET /v1/jobs?limit=1%00 HTTP/1.1\r\n" HOST "\r\n"),
    P(400, "broken escape", "GET /v1/jobs/%zz HTTP/1.1\r\n" HOST "\r\n"),
    P(400, "escape cut short", "GET /v1/jobs/%2 HTTP/1.1\r\n" HOST "\r\n"),
    P(400, "bytes above 127", "GET /v1/jobs/\xc3\xa4 HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "dots", "GET /../../etc/passwd HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "escaped dots", "GET /%2e%2e/%2e%2e/etc/passwd HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "escaped slashes in an asset's name",
      "GET /v1/assets/..%2f..%2fsmalti.db HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "no such route", "GET /v2/jobs HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "slash at the end", "GET /v1/jobs/ HTTP/1.1\r\n" HOST "\r\n"),
    P(404, "two slashes", "GET //v1/jobs HTTP/1.1\r\n" HOST "\r\n"),
    /* headers */
    P(ANY_4XX, "no Host", "GET /healthz HTTP/1.1\r\n\r\n"),
    P(ANY_4XX, "two Hosts", "GET /healthz HTTP/1.1\r\n" HOST HOST "\r\n"),
    P(421, "another Host", "GET /healthz HTTP/1.1\r\nHost: example.org\r\n\r\n"),
    P(421, "Host that begins well", "GET /healthz HTTP/1.1\r\nHost: localhost.example.org\r\n\r\n"),
    P(421, "127 and a name", "GET / HTTP/1.1\r\nHost: 127.0.0.1.example.org\r\n\r\n"),
    P(421, "Host with rubbish for a port", "GET / HTTP/1.1\r\nHost: localhost:80:80\r\n\r\n"),
    P(421, "empty Host", "GET / HTTP/1.1\r\nHost:\r\n\r\n"),
    P(ANY_4XX, "header without colon", "GET /v1/nothing HTTP/1.1\r\n" HOST "rubbish\r\n\r\n"),
    P(ANY_4XX, "space before colon", "GET /v1/nothing HTTP/1.1\r\nHost : localhost\r\n\r\n"),
    P(ANY_4XX, "folded header", "GET /v1/nothing HTTP/1.1\r\n" HOST "X: a\r\n b\r\n\r\n"),
    N(ANY_4XX, "NUL in a header", "GET /v1/nothing HTTP/1.1\r\n" HOST "X: a\0b\r\n\r\n"),
    /* framing */
    P(400, "two lengths",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 2\r\nContent-Length: 3\r\n\r\n{} "),
    P(400, "one length twice",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 2\r\nContent-Length: 2\r\n\r\n{}"),
    P(400, "length and chunks",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON
      "Content-Length: 2\r\nTransfer-Encoding: chunked\r\n\r\n2\r\n{}\r\n0\r\n\r\n"),
    P(400, "another transfer coding",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Transfer-Encoding: gzip, chunked\r\n\r\n0\r\n\r\n"),
    P(400, "two transfer codings",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON
      "Transfer-Encoding: chunked\r\nTransfer-Encoding: chunked\r\n\r\n0\r\n\r\n"),
    P(ANY_4XX, "negative length",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: -1\r\n\r\n"),
    P(ANY_4XX, "signed length",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: +2\r\n\r\n{}"),
    P(ANY_4XX, "hexadecimal length",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 0x2\r\n\r\n{}"),
    P(ANY_4XX, "length beyond 64 bits",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 99999999999999999999\r\n\r\n"),
    P(413, "length of all 64 bits",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 18446744073709551614\r\n\r\n"),
    P(ANY_4XX, "chunk size is rubbish",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON
      "Transfer-Encoding: chunked\r\n\r\nzz\r\n{}\r\n0\r\n\r\n"),
    P(ANY_4XX, "chunk size beyond 64 bits",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON
      "Transfer-Encoding: chunked\r\n\r\nfffffffffffffffff\r\n{}\r\n0\r\n\r\n"),
    /* media types, methods, sizes */
    P(415, "no media type", "POST /v1/jobs HTTP/1.1\r\n" HOST "Content-Length: 2\r\n\r\n{}"),
    P(415, "a form",
      "POST /v1/jobs HTTP/1.1\r\n" HOST
      "Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 2\r\n\r\n{}"),
    P(415, "text",
      "PATCH /v1/jobs/0 HTTP/1.1\r\n" HOST
      "Content-Type: text/plain\r\nContent-Length: 2\r\n\r\n{}"),
    P(415, "nearly JSON",
      "POST /v1/leases HTTP/1.1\r\n" HOST
      "Content-Type: application/jsonx\r\nContent-Length: 2\r\n\r\n{}"),
    P(415, "JSON for an asset",
      "PUT /v1/assets/" SHA " HTTP/1.1\r\n" HOST JSON "Content-Length: 3\r\n\r\nabc"),
    P(405, "DELETE of the list", "DELETE /v1/jobs HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "PUT of a job", "PUT /v1/jobs/0123456789abcdef HTTP/1.1\r\n" HOST "\r\n"),
    P(405, "GET of leases", "GET /v1/leases HTTP/1.1\r\n" HOST "\r\n"),
    P(413, "a GET with a body", "GET /healthz HTTP/1.1\r\n" HOST "Content-Length: 2\r\n\r\n{}"),
    P(413, "a scene of 5 MB",
      "POST /v1/jobs HTTP/1.1\r\n" HOST JSON "Content-Length: 5000000\r\n\r\n"),
    P(413, "a call of 5000 bytes",
      "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 5000\r\n\r\n"),
    P(413, "an asset of 3 GiB",
      "PUT /v1/assets/" SHA " HTTP/1.1\r\n" HOST
      "Content-Type: application/octet-stream\r\nContent-Length: 3221225472\r\n\r\n"),
    P(413, "refused before it is sent",
      "POST /v1/jobs HTTP/1.1\r\n" HOST JSON
      "Expect: 100-continue\r\nContent-Length: 5000000\r\n\r\n"),
};

struct call {
    int status;
    const char *method, *target, *type, *body, *name;
};

#define J "application/json"
#define B "application/octet-stream"

static const struct call calls[] = {
    {400, "POST", "/v1/jobs", J, "", "no scene at all"},
    {400, "POST", "/v1/jobs", J, "{\"a\": 1,}", "a comma too many"},
    {400, "POST", "/v1/jobs", J, "\xff\xfe{}", "not UTF-8"},
    {422, "POST", "/v1/jobs", J, "{}", "an empty scene"},
    {422, "POST", "/v1/jobs", J, "[1, 2]", "an array for a scene"},
    {400, "GET", "/v1/jobs?limit=0", NULL, "", "a list of nothing"},
    {400, "GET", "/v1/jobs?limit=201", NULL, "", "a list of too much"},
    {400, "GET", "/v1/jobs?limit=1e9", NULL, "", "a number that is none"},
    {400, "GET", "/v1/jobs?limit=99999999999999999999", NULL, "", "a number beyond 64 bits"},
    {404, "GET", "/v1/jobs?after=zzz", NULL, "", "after nothing"},
    {404, "GET", "/v1/jobs/0123456789abcdef", NULL, "", "no such job"},
    {404, "GET", "/v1/jobs/0123456789abcdeg", NULL, "", "not an id"},
    {404, "GET", "/v1/jobs/0123456789abcdef/image.exr", NULL, "", "no such job's image"},
    {404, "DELETE", "/v1/jobs/0123456789abcdef", NULL, "", "cancel what is not there"},
    {404, "PATCH", "/v1/jobs/0123456789abcdef", J, "{\"priority\": 1}", "change what is not there"},
    {400, "GET", "/v1/assets/abc", NULL, "", "not a hash"},
    {404, "GET", "/v1/assets/" SHA, NULL, "", "no such asset"},
    {404, "HEAD", "/v1/assets/" SHA, NULL, "", "no such asset, asked for its head"},
    {422, "PUT", "/v1/assets/" SHA, B, "abd", "bytes that do not have the name"},
    {422, "PUT", "/v1/assets/" SHA, B, "", "no bytes at all"},
    {400, "POST", "/v1/leases", J, "[]", "an array for a call"},
    {400, "POST", "/v1/leases", J, "{", "half an object"},
    {400, "POST", "/v1/leases", J, "{}", "who asks?"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a b\", \"threads\": 1, \"version\": \"0.1.0\", \"want\": 1}", "a bad name"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"threads\": 1, \"version\": \"0.1.0\", \"want\": 65}",
     "too many leases"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"threads\": -1, \"version\": \"0.1.0\", \"want\": 1}",
     "too few threads"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"threads\": 1, \"version\": \"0.1.0\", \"want\": 1, \"wait_ms\": 25001}",
     "too long a wait"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"threads\": 1, \"version\": \"0.1.0\", \"want\": 1, \"more\": 1}",
     "an unknown key"},
    {400, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"worker\": \"b\", \"threads\": 1, \"version\": \"0.1.0\", \"want\": 1}",
     "one key twice"},
    {409, "POST", "/v1/leases", J,
     "{\"worker\": \"a\", \"threads\": 1, \"version\": \"9.9.9\", \"want\": 1}", "another version"},
    {400, "PUT", "/v1/leases/0000000000000001?worker=a", B, "rubbish", "a payload of rubbish"},
    {400, "PUT", "/v1/leases/0000000000000001?worker=a", B, "", "an empty payload"},
    {400, "POST", "/v1/leases/xyz/renew", NULL, "", "not a lease"},
    {404, "POST", "/v1/leases/0000000000000001/renew", NULL, "", "a lease that nobody holds"},
    {404, "DELETE", "/v1/leases/0000000000000001", NULL, "", "to give back what one has not"},
    {415, "DELETE", "/v1/leases/0000000000000001", "text/plain", "oops", "a reason in plain text"},
    {413, "POST", "/v1/leases/0000000000000001/renew", J, "{}", "renewal takes no body"},
    {404, "PATCH", "/v1/workers/nobody", J, "{\"state\": \"draining\"}", "no such worker"},
};

static bool problem_is_sound(const struct answer *a)
{
    return strstr((char *)a->text.data, "application/problem+json") && *a->body == '{' &&
           strstr(a->body, "\"status\":") && strstr(a->body, "\"detail\":");
}

static bool is_refusal(int status)
{
    return status == CLOSED || (status >= 400 && status < 500) || status == 505;
}

static void malformed(void)
{
    for (size_t i = 0; i < countof(probes); i++) {
        const struct probe *p = &probes[i];
        struct answer a = daemon_send(&d, p->bytes, p->count ? p->count : strlen(p->bytes));
        const bool fine = p->status == ANY_4XX ? is_refusal(a.status) : a.status == p->status;
        ok(fine, "%s: %d", p->name, a.status);
        if (p->status > ANY_4XX && fine)
            ok(problem_is_sound(&a), "%s: with a problem document", p->name);
        buf_release(&a.text);
    }
}

static void wrong(void)
{
    for (size_t i = 0; i < countof(calls); i++) {
        const struct call *c = &calls[i];
        struct answer a = daemon_call(&d, c->method, c->target, c->type, c->body, strlen(c->body));
        const bool fine = a.status == c->status;
        ok(fine && (problem_is_sound(&a) || !strcmp(c->method, "HEAD")), "%s: %d %.160s", c->name,
           a.status, a.body ? a.body : "");
        buf_release(&a.text);
    }
}

static void large(void)
{
    struct buf m = {0};
    static const char head[] = "GET /healthz HTTP/1.1\r\n" HOST "X-Long: ";
    buf_append(&m, head, sizeof head - 1);
    memset(buf_grow(&m, 100000), 'a', 100000);
    buf_append(&m, "\r\n\r\n", 4);
    struct answer a = daemon_send(&d, m.data, m.size);
    ok(is_refusal(a.status), "a header of 100 kB: %d", a.status);
    buf_release(&a.text);

    m.size = 5;
    memcpy(m.data, "GET /", 5);
    memset(buf_grow(&m, 100000), 'a', 100000);
    static const char tail[] = " HTTP/1.1\r\n" HOST "\r\n";
    buf_append(&m, tail, sizeof tail - 1);
    a = daemon_send(&d, m.data, m.size);
    ok(is_refusal(a.status), "a target of 100 kB: %d", a.status);
    buf_release(&a.text);

    m.size = 0;
    static const char many[] = "GET /healthz HTTP/1.1\r\n" HOST;
    buf_append(&m, many, sizeof many - 1);
    for (int i = 0; i < 5000; i++)
        buf_append(&m, "X-A: b\r\n", 8);
    buf_append(&m, "\r\n", 2);
    a = daemon_send(&d, m.data, m.size);
    ok(is_refusal(a.status), "5000 headers: %d", a.status);
    buf_release(&a.text);

    m.size = 0;
    static const char chunked[] =
        "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Transfer-Encoding: chunked\r\n\r\n";
    buf_append(&m, chunked, sizeof chunked - 1);
    for (int i = 0; i < 64; i++) {
        buf_append(&m, "400\r\n", 5);
        memset(buf_grow(&m, 1024), ' ', 1024);
        buf_append(&m, "\r\n", 2);
    }
    buf_append(&m, "0\r\n\r\n", 5);
    a = daemon_send(&d, m.data, m.size);
    ok(a.status == 413, "64 kB in chunks where 4 kB are taken: %d", a.status);
    buf_release(&a.text);
    buf_release(&m);
}

/* What a client may rely on. */
static void sound(void)
{
    static const char keep[] = "GET /healthz HTTP/1.1\r\n" HOST "\r\n";
    const int fd = daemon_connect(&d);
    bool same = true;
    for (int i = 0; i < 3; i++) {
        send(fd, keep, sizeof keep - 1, MSG_NOSIGNAL);
        struct answer a = daemon_read(fd);
        same &= a.status == 200 && strstr(a.body, "\"status\":\"ok\"");
        buf_release(&a.text);
    }
    close(fd);
    ok(same, "a connection serves one request after another");
    struct answer a = daemon_call(&d, "PUT", "/v1/assets/" SHA, B, "abc", 3);
    ok(a.status == 201, "an asset is taken: %d", a.status);
    buf_release(&a.text);
    a = daemon_call(&d, "PUT", "/v1/assets/" SHA, B, "abc", 3);
    ok(a.status == 200, "and known the second time: %d", a.status);
    buf_release(&a.text);
    a = daemon_call(&d, "GET", "/v1/assets/" SHA, NULL, NULL, 0);
    ok(a.status == 200 && !strcmp(a.body, "abc") && strstr((char *)a.text.data, "immutable"),
       "it comes back, to be kept for ever");
    buf_release(&a.text);
    a = daemon_call(&d, "GET", "/", NULL, NULL, 0);
    ok(a.status == 200 && strstr((char *)a.text.data, "text/html") &&
           strstr((char *)a.text.data, "Content-Security-Policy: default-src 'self'") &&
           strstr((char *)a.text.data, "nosniff"),
       "the page comes with its security headers");
    const char *etag = strstr((char *)a.text.data, "ETag: ");
    char match[256];
    snprintf(match, sizeof match, "GET / HTTP/1.1\r\n" HOST "If-None-Match: %.34s\r\n\r\n",
             etag ? etag + 6 : "none");
    buf_release(&a.text);
    a = daemon_send(&d, match, strlen(match));
    ok(a.status == 304, "and is not sent again to who has it: %d", a.status);
    buf_release(&a.text);
    a = daemon_call(&d, "HEAD", "/v1/workers", NULL, NULL, 0);
    ok(a.status == 200 && !*a.body, "HEAD is GET without its body");
    buf_release(&a.text);
}

/* Byte by byte, for longer than anyone needs: libmicrohttpd alone would wait for ever. */
static void slow(void)
{
    static const char head[] = "GET /healthz HTTP/1.1\r\n" HOST "X-Slow: ";
    const int64_t begin_ms = clock_ms();
    const int fd = daemon_connect(&d);
    send(fd, head, sizeof head - 1, MSG_NOSIGNAL);
    struct pollfd p = {.fd = fd, .events = POLLIN};
    int64_t age_ms = 0;
    for (; age_ms < 40000 && poll(&p, 1, 500) == 0; age_ms = clock_ms() - begin_ms)
        if (send(fd, "a", 1, MSG_NOSIGNAL) != 1)
            break;
    close(fd);
    ok(age_ms > 10000 && age_ms < 25000, "a header that never ends is cut off after %lld ms",
       (long long)age_ms);
}

/* Half-open and silent connections up to the limit: the daemon serves on when they are gone. */
static void crowd(void)
{
    int fds[HTTP_MAX_CONNECTIONS / 2];
    for (size_t i = 0; i < countof(fds); i++) {
        fds[i] = daemon_connect(&d);
        send(fds[i], "GET /", i % 5, MSG_NOSIGNAL);
    }
    struct answer a = daemon_call(&d, "GET", "/healthz", NULL, NULL, 0);
    ok(a.status == 200, "beside %zu silent connections it answers: %d", countof(fds), a.status);
    buf_release(&a.text);
    for (size_t i = 0; i < countof(fds); i++)
        close(fds[i]);
}

static void parked(void)
{
    static const char call[] = "{\"worker\": \"p\", \"threads\": 1, \"version\": \"" SMALTI_VERSION
                               "\", \"want\": 1, \"wait_ms\": 300}";
    const int64_t begin_ms = clock_ms();
    struct answer a = daemon_call(&d, "POST", "/v1/leases", J, call, strlen(call));
    ok(a.status == 200 && !strcmp(a.body, "{\"leases\":[]}") && clock_ms() - begin_ms >= 290,
       "a call for work waits as long as it says: %d %s", a.status, a.body ? a.body : "");
    buf_release(&a.text);
}

static void stopped_while_parked(void)
{
    static const char call[] = "POST /v1/leases HTTP/1.1\r\n" HOST JSON "Content-Length: 74\r\n\r\n"
                               "{\"worker\":\"p\",\"threads\":1,\"version\":\"" SMALTI_VERSION
                               "\",\"want\":1,\"wait_ms\":25000}     ";
    const int fd = daemon_connect(&d), half = daemon_connect(&d);
    send(fd, call, sizeof call - 1, MSG_NOSIGNAL);
    send(half, call, 100, MSG_NOSIGNAL);
    struct answer a = {.status = 0};
    for (const int64_t until = clock_ms() + 5000; clock_ms() < until; clock_sleep_ms(10)) {
        a = daemon_call(&d, "GET", "/v1/workers", NULL, NULL, 0);
        const bool seen =
            a.body && strstr(a.body, "\"seen_ms_ago\":") && strstr(a.body, "\"name\":\"p\"");
        buf_release(&a.text);
        if (seen)
            break;
    }
    const int64_t begin_ms = clock_ms();
    ok(daemon_stop(&d) == 0, "with a parked call and half a request it stops with status 0");
    ok(clock_ms() - begin_ms < 5000, "without waiting for either: %lld ms",
       (long long)(clock_ms() - begin_ms));
    a = daemon_read(fd);
    ok(a.status == 503, "the parked call is answered: %d", a.status);
    buf_release(&a.text);
    close(fd);
    close(half);
}

int main(void)
{
    static const char *const flags[] = {"--log", "error", NULL};
    if (!ok(daemon_start(&d, flags), "a coordinator starts"))
        return tap_done();
    malformed();
    wrong();
    large();
    sound();
    parked();
    crowd();
    slow();
    ok(daemon_lives(&d), "after all this the daemon lives");
    struct answer a = daemon_call(&d, "GET", "/healthz", NULL, NULL, 0);
    ok(a.status == 200, "and is well");
    buf_release(&a.text);
    stopped_while_parked();
    daemon_remove(&d);
    return tap_done();
}
