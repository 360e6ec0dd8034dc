/* progress.c: the line says what is known and nothing else; plain lines come at their pace.
 * SPDX-License-Identifier: MIT */
#include "client/progress.h"

#include <string.h>

#include "tests/tap.h"

static void says(const struct remote_job *job, const char *want)
{
    char text[160];
    progress_text(job, text, sizeof text);
    if (!ok(!strcmp(text, want), "'%s'", want))
        diag("got '%s'", text);
}

static void texts(void)
{
    struct remote_job job = {.state = REMOTE_QUEUED, .error = -1, .rate = -1, .eta_seconds = -1};
    says(&job, "  0 %  0 spp");
    job = (struct remote_job){.state = REMOTE_RUNNING,
                              .progress = 0.437,
                              .error = 0.0412,
                              .rate = 1.204e6,
                              .eta_seconds = 41.2,
                              .spp = 110,
                              .workers = 2};
    says(&job, " 43 %  110 spp  error 0.0412  1.20 Msamples/s  2 workers  0:41 left");
    job.workers = 1;
    job.rate = 73400;
    job.eta_seconds = 7384;
    says(&job, " 43 %  110 spp  error 0.0412  73.4 ksamples/s  1 worker  2:03:04 left");
    struct remote_job judged = job;
    judged.error_low = .0398;
    judged.error_high = .0431;
    judged.untrusted = .0125;
    judged.rate = -1;
    says(&judged, " 43 %  110 spp  error 0.0412 (0.0398 to 0.0431)  1.2 % untrusted  1 worker  "
                  "2:03:04 left");
    job.progress = 0.99999;
    job.eta_seconds = 1e30;
    says(&job, " 99 %  110 spp  error 0.0412  73.4 ksamples/s  1 worker  27777:46:40 left");
    job = (struct remote_job){
        .state = REMOTE_DONE, .progress = 1, .error = 0, .spp = 256, .eta_seconds = 0};
    says(&job, "100 %  256 spp  error 0");
    struct remote_job stopped = job;
    stopped.spp_least = 32;
    stopped.spp_most = 256;
    says(&stopped, "100 %  32 to 256 spp  error 0");
    stopped.state = REMOTE_RUNNING;
    says(&stopped, "100 %  256 spp  error 0  0:00 left");
    job.progress = 0 * -1e308 * 10;
    says(&job, "  0 %  256 spp  error 0");
    char small[12];
    progress_text(&job, small, sizeof small);
    ok(strlen(small) == 11 && !strncmp(small, "  0 %  256 ", 11), "a short buffer cuts the line");
}

static int lines_in(FILE *f)
{
    int n = 0;
    rewind(f);
    for (int c; (c = fgetc(f)) != EOF;)
        n += c == '\n';
    return n;
}

static void plain_lines(void)
{
    FILE *f = tmpfile();
    struct progress p = progress_make(f, false);
    ok(p.style == PROGRESS_PLAIN, "a file gets plain lines");
    struct remote_job job = {.state = REMOTE_QUEUED};
    progress_show(&p, &job, 1000);
    ok(lines_in(f) == 1, "the first look is shown");
    for (int64_t t = 1250; t < 6000; t += 250)
        progress_show(&p, &job, t);
    ok(lines_in(f) == 1, "nothing new for five seconds: nothing said");
    progress_show(&p, &job, 6000);
    ok(lines_in(f) == 2, "then a line");
    job.state = REMOTE_RUNNING;
    progress_show(&p, &job, 6001);
    ok(lines_in(f) == 3, "a change of state is said at once");
    progress_end(&p);
    ok(lines_in(f) == 3, "the end adds nothing");
    fclose(f);

    f = tmpfile();
    p = progress_make(f, true);
    progress_show(&p, &job, 0);
    progress_end(&p);
    ok(lines_in(f) == 0 && ftell(f) == 0, "quiet is silent");
    p = (struct progress){.out = f, .style = PROGRESS_MOVING};
    progress_show(&p, &job, 0);
    progress_show(&p, &job, 100);
    ok(lines_in(f) == 0, "a moving line stays on its line");
    progress_end(&p);
    ok(lines_in(f) == 1, "and ends with one newline");
    fclose(f);
}

int main(void)
{
    texts();
    plain_lines();
    return tap_done();
}
