"""The page in headless Chromium, with a real coordinator and worker: shows a running job, and cancels it
by keyboard. With $SHOTS set to a directory, screenshots of both views are left there.
SPDX-License-Identifier: MIT"""

import os

import browser
import farm

# WCAG 2.2: 4.5 : 1 for text. Of every element that shows text of its own, against the nearest opaque
# background behind it; returns the offenders.
CONTRAST = """
    const luminance = ([r, g, b]) => [r, g, b].map((v) => v / 255)
        .map((v) => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4)
        .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
    const parts = (color) => (color.match(/[\\d.]+/g) || []).map(Number);
    const opaque = (node) => {
        for (; node; node = node.parentElement) {
            const color = parts(getComputedStyle(node).backgroundColor);
            if (color.length === 3)
                return color;
        }
    };
    return [...document.querySelectorAll("body *")]
        .filter((node) => node.checkVisibility()
            && [...node.childNodes].some((child) => child.nodeType === 3 && child.data.trim()))
        .map((node) => {
            const [a, b] = [luminance(parts(getComputedStyle(node).color)), luminance(opaque(node))];
            return { text: node.innerText ?? node.textContent, ratio: (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) };
        })
        .filter(({ text, ratio }) => text.trim() && !(ratio >= 4.5))
        .map(({ text, ratio }) => `${ratio.toFixed(2)}: ${text}`);
"""

# What a screen reader needs to find its way; returns what is missing.
NAMED = """
    const missing = [...document.querySelectorAll("img:not([alt]), progress:not([aria-label], [aria-labelledby])")]
        .map((node) => node.outerHTML);
    if (document.querySelectorAll("h1").length !== 1)
        missing.push("exactly one h1");
    for (const landmark of ["header", "main"])
        if (document.querySelectorAll(landmark).length !== 1)
            missing.push(`exactly one ${landmark}`);
    for (const node of document.querySelectorAll("a, button"))
        if (node.checkVisibility() && !node.innerText.trim() && !node.querySelector("img[alt]:not([alt=''])"))
            missing.push("a name for " + node.outerHTML);
    for (const node of document.querySelectorAll("[aria-labelledby]"))
        if (!document.getElementById(node.getAttribute("aria-labelledby")))
            missing.push("the label of " + node.outerHTML.slice(0, 80));
    return missing;
"""


# The Cornell box, small and with a far smaller error than the test waits for.
FLAGS = ("--image-interval", "0.5", "--tile", "32")
SCENE = farm.scene("cornell-box.json", 128, 128, spp=65536, error=0.004)


class Page:
    def __init__(self, f, t, b):
        self.farm, self.t, self.b = f, t, b

    def wait(self, what, script, *args):
        """Until the expression is true; its value."""
        return self.farm.wait_for(what, lambda: self.b.run("return " + script, *args))

    def wait_state(self, job, state):
        self.farm.wait_for(f"the job to be {state}", lambda: self.farm.job(job)["state"] == state)

    def shot(self, name):
        if os.environ.get("SHOTS"):
            os.makedirs(os.environ["SHOTS"], exist_ok=True)
            self.b.screenshot(os.path.join(os.environ["SHOTS"], name + ".png"))

    def look(self, view):
        """Both colour schemes, a phone, the names: of the view that is shown now."""
        for scheme in ("light", "dark"):
            self.b.media(prefers_color_scheme=scheme)
            bad = self.b.run(CONTRAST)
            self.t.ok(not bad, f"{view}, {scheme}: the contrast of all text is at least 4.5", *bad)
            self.shot(f"{view}-{scheme}")
        for width in (360, 320):
            self.b.size(width, 720, phone=True)
            needed = self.b.run("return document.documentElement.scrollWidth")
            self.t.ok(needed <= width, f"{view}: {width} px are wide enough", f"needs {needed} px")
        self.wait("the curve, if any, to fit the screen",
                  "!(document.querySelector('.curve')?.getAttribute('width') > innerWidth)")
        self.shot(f"{view}-phone")
        self.b.size(1200, 900)
        missing = self.b.run(NAMED)
        self.t.ok(not missing, f"{view}: headings, landmarks and names are there", *missing)


def check_weight(f, t):
    weight = 0
    for path in ("/", "/app.js", "/curve.js", "/style.css"):
        reply = f.call("GET", path)
        weight += len(reply.body)
        policy = reply.headers.get("Content-Security-Policy", "")
        t.ok("default-src 'self'" in policy and "unsafe" not in policy, f"{path}: only our own scripts may run", policy)
    t.ok(weight < 40 * 1000, f"the page weighs less than 40 KB in all: {weight} bytes")


def check_list(page, job):
    page.wait("the job to be listed", "document.querySelector('.jobs a')")
    link = page.b.run("return document.querySelector('.jobs a').getAttribute('href')")
    page.t.equal(link, f"#/jobs/{job}", "the job is listed")
    page.wait("the list to show its picture", "document.querySelector('.thumb img')?.naturalWidth > 0")
    page.look("list")


def check_job(page, job):
    b = page.b
    page.t.ok(b.tab_to(page.farm.job(job)["title"]), "Tab reaches the job")
    b.press(browser.ENTER)
    page.wait("the job's view", "document.querySelector('.job dl div')")
    page.t.equal(b.focus(), page.farm.job(job)["title"], "the new view's heading has the focus")
    width = page.wait("the picture", "document.querySelector('.picture img')?.naturalWidth")
    page.t.equal(width, 128, "the view shows the image")
    first = b.run("return document.querySelector('.picture img').src")
    page.wait("a newer picture", "document.querySelector('.picture img').src !== arguments[0]", first)
    page.t.ok(True, "the image is replaced by newer ones")
    was = b.run("return document.querySelector('.job progress').value")
    page.wait("progress", "document.querySelector('.job progress').value > arguments[0]", was)
    page.t.ok(True, "the progress grows")
    facts = b.text(".job dl")
    page.t.ok(all(word in facts for word in ("Error", "Samples", "Rate", "Target", "65536")),
         "error, samples, rate and target are shown", facts)
    page.t.equal(b.text(".head .state"), "running", "the state is shown")
    page.wait("the worker to be shown", "document.querySelector('.workers li .active')")
    page.t.ok(True, "the worker is listed as active")
    href = b.run("return document.querySelector('.job a[download]').getAttribute('href')")
    page.t.equal(page.farm.call("GET", href).body[:4], b"\x76\x2f\x31\x01", "the link to the EXR gives an EXR")
    check_curve(page, job)
    page.look("job")


def check_curve(page, job):
    """The live curve: a point for every judged round, the target, the forecast; said in words, too."""
    page.wait("the curve", "document.querySelectorAll('.curve circle').length >= 4")
    answer = page.farm.call("GET", f"/v1/jobs/{job}/convergence").json()
    errors, samples = [[p[name] for p in answer["points"]] for name in ("error", "samples")]
    page.t.ok(samples == sorted(set(samples)) and errors[-1] < errors[0], "the points are in order, the error falls",
              str(answer["points"]))
    words = page.b.text(".convergence [data-f='summary']")
    page.t.ok("Error" in words and "target 0.40" in words and "comes first, at about" in words, "what it shows is said in words", words)
    page.t.ok(page.b.run("return Boolean(document.querySelector('.curve .target') && document.querySelector('.curve .cone'))"),
              "target and forecast are drawn")
    grown = "document.querySelectorAll('.curve circle').length > arguments[0]"
    page.wait("a new point", grown, len(errors))
    page.t.ok(True, "the curve grows while one looks")


def check_pause(page, job):
    page.t.ok(page.b.tab_to("Pause"), "Tab reaches Pause")
    page.b.press(browser.ENTER)
    page.wait_state(job, "paused")
    page.wait("Resume", "document.activeElement.innerText === 'Resume'")
    page.t.ok(True, "the button becomes Resume and keeps the focus")
    page.b.press(browser.ENTER)
    page.wait_state(job, "running")
    page.wait("the view to say so", "document.querySelector('.head .state').innerText === 'running'")
    page.t.ok(True, "Resume resumes")


def check_cancel(page, job):
    b = page.b
    page.t.ok(b.tab_to("Cancel job…"), "Tab reaches Cancel")
    b.press(browser.ENTER)
    page.t.equal(b.focus(), "Keep it", "it asks, and the harmless answer has the focus")
    b.press(browser.ESCAPE)
    page.t.equal(b.focus(), "Cancel job…", "Escape goes back to where one was")
    page.t.equal(page.farm.job(job)["state"], "running", "and cancels nothing")
    b.press(browser.ENTER)
    page.t.ok(b.tab_to("Cancel job"), "Tab reaches the other answer")
    b.press(browser.ENTER)
    page.wait_state(job, "cancelled")
    page.t.ok(True, "the job is cancelled")
    page.wait("the page to show it", "document.querySelector('.head .state').innerText === 'cancelled'")
    page.wait("the focus on the heading", "document.activeElement === document.querySelector('h1')")
    page.t.ok(True, "the view says so, and the focus goes to its heading")


def check_enough(page):
    """A job whose pixels stop at different samples."""
    job = page.farm.done(page.farm.submit(farm.scene("cornell-box.json", 48, 48, error=.12)))
    spp = job["report"]["spp"]
    page.b.run(f"location.hash = '#/jobs/{job['id']}'")
    page.wait("its facts", f"document.querySelector('.job dl')?.innerText.includes('{spp['least']} to {spp['most']}, enough in')")
    page.t.ok(spp["least"] < spp["most"], "it says that pixels have different samples, and how many have enough", spp)


def check_away(page):
    """A coordinator that is gone for a while: said, and over by itself."""
    notice = "document.querySelector('#notice').innerText"
    page.farm.server.kill()
    page.wait("the page says that the coordinator is away", notice + ".includes('not reachable')")
    page.t.ok(True, "the page says that the coordinator is not reachable")
    page.farm.start_server(*FLAGS)
    page.wait("the page recovers", f"!{notice}")
    page.t.ok(True, "it recovers by itself")


def check_gone(page):
    page.b.run("location.hash = '#/jobs/0000000000000000'")
    page.wait("a word on the unknown job", "document.querySelector('h1').innerText.includes('no job 0000000000000000')")
    page.t.ok(page.b.tab_to("All jobs"), "an address without a job says so, and leads back to the list")


def check_empty(page):
    page.b.size(1200, 900)
    page.b.open(page.farm.url + "/")
    page.wait("the empty list", "document.querySelector('.empty')?.checkVisibility()")
    page.t.ok(f"{page.farm.url}/v1/jobs" in page.b.text("pre"), "without jobs the page says how to submit one")
    page.shot("empty")


def test(f, t):
    f.start_server(*FLAGS)
    check_weight(f, t)
    b = browser.Browser(f)
    page = Page(f, t, b)
    check_empty(page)
    f.start_worker("--threads", "1")
    job = f.submit(SCENE)
    check_list(page, job)
    check_job(page, job)
    check_pause(page, job)
    check_cancel(page, job)
    said = b.console()
    t.ok(not said, "the console has no errors and no warnings", *said)
    check_enough(page)
    check_away(page)
    check_gone(page)
    b.close()


if browser.missing():
    farm.skip_all(browser.missing())
farm.main(test)
