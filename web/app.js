// smalti's page: the list of jobs (#/) and one job (#/jobs/ID), read from the public API.
//
// One loop asks for what the present view needs and shows it; a view never asks by itself. Answers are kept with their
// ETag, so a job at rest costs one 304 per turn. Everything from the server is shown by
// textContent. SPDX-License-Identifier: MIT
"use strict";

const $ = (selector, root = document) => root.querySelector(selector);
const field = (root, name) => $(`[data-f="${name}"]`, root);
const stamp = (id) => $("#" + id).content.cloneNode(true);
const LIVE = ["queued", "running", "paused"];

// --- numbers for people ----------------------------------------------------------------------

const plural = (n, word) => `${n}\u00a0${word}${n === 1 ? "" : "s"}`;

function percent(x) { // three digits at most: 12 %, 4.1 %, 0.32 %
    const p = 100 * x;
    return `${p >= 10 ? p.toFixed(0) : p >= 1 ? p.toFixed(1) : p.toPrecision(2)}\u00a0%`;
}

// Progress is rounded down: 100 % is said only when it is reached.
const progressText = (job) => `${Math.floor(100 * job.progress)}\u00a0%`;

function big(n) {
    for (const [unit, size] of [["T", 1e12], ["G", 1e9], ["M", 1e6], ["k", 1e3]])
        if (n >= 0.9995 * size)
            return `${(n / size).toPrecision(3)}\u00a0${unit}`;
    return String(Math.round(n));
}

function duration(seconds) {
    const s = Math.round(seconds);
    const two = (n) => String(n).padStart(2, "0");
    if (s < 60)
        return seconds < 9.95 ? `${seconds.toFixed(1)}\u00a0s` : `${s}\u00a0s`;
    if (s < 3600)
        return `${Math.floor(s / 60)}\u00a0min\u00a0${two(s % 60)}\u00a0s`;
    if (s < 172800)
        return `${Math.floor(s / 3600)}\u00a0h\u00a0${two(Math.floor(s / 60) % 60)}\u00a0min`;
    return `${Math.floor(s / 86400)}\u00a0d\u00a0${Math.floor(s / 3600) % 24}\u00a0h`;
}

function errorText(job) {
    if (job.error === null)
        return "not known before 8 spp";
    const interval = job.report.error.interval;
    return percent(job.error) + (interval ? ` (${percent(interval[0])} to ${percent(interval[1])})` : "");
}

function trustText(pixels) { // of the error bars
    if (pixels.trusted === null)
        return "not known yet";
    const parts = [`${percent(pixels.trusted)} of the pixels`];
    if (pixels.unknown > 0)
        parts.push(`${percent(pixels.unknown)} not known`);
    if (pixels.heavy_tail > 0)
        parts.push(`${percent(pixels.heavy_tail)} heavy tail`);
    return parts.join(", ");
}

const date = (ms) => new Date(ms).toLocaleString("en-GB", { dateStyle: "medium", timeStyle: "short" });
const title = (job) => job.title || `Job ${job.id}`;

function targetText({ error, spp, seconds }) {
    const parts = [`${spp}\u00a0spp`];
    if (error !== null)
        parts.unshift(`error\u00a0${Number((100 * error).toPrecision(4))}\u00a0%`);
    if (seconds !== null)
        parts.push(duration(seconds));
    return parts.join(" or ");
}

// --- the server ------------------------------------------------------------------------------

class Away extends Error {} // no answer, or one that says "later"

class Refused extends Error { // a problem document (RFC 9457)
    constructor(status, problem) {
        super(problem.detail || problem.title || `The coordinator answered ${status}.`);
        this.status = status;
    }
}

async function ask(path, options = {}) {
    let answer, body = null;
    try {
        answer = await fetch(path, { cache: "no-store", signal: AbortSignal.timeout(10000), ...options });
        if (answer.status !== 304 && answer.status !== 204)
            body = await answer.json();
    } catch {
        if (!answer || answer.ok)
            throw new Away();
        body = {};
    }
    if (answer.status >= 500)
        throw new Away();
    if (answer.status >= 400)
        throw new Refused(answer.status, body);
    return { status: answer.status, etag: answer.headers.get("ETag"), body };
}

const kept = new Map(); // path -> last answer, of the present view only

async function get(path) {
    const old = kept.get(path);
    const answer = await ask(path, old?.etag ? { headers: { "If-None-Match": old.etag } } : {});
    if (answer.status === 304)
        return old.body;
    kept.set(path, answer);
    return answer.body;
}

// --- pieces of views -------------------------------------------------------------------------

function say(node, text) { // touches the page only when something changed
    if (node.textContent !== text)
        node.textContent = text;
}

function showState(node, state) {
    if (node.textContent !== state) {
        node.textContent = state;
        node.className = `state ${state}`;
    }
}

// Keeps `list`'s children in step with `items`, by key, moving none that need not move: a poll must not
// steal the focus or the reader's place.
function sync(list, items, keyOf, templateId, show) {
    const have = new Map([...list.children].map((node) => [node.dataset.key, node]));
    items.forEach((item, i) => {
        const key = String(keyOf(item));
        let node = have.get(key);
        have.delete(key);
        if (!node) {
            node = stamp(templateId).firstElementChild;
            node.dataset.key = key;
        }
        if (list.children[i] !== node)
            list.insertBefore(node, list.children[i] ?? null);
        show(node, item);
    });
    for (const node of have.values())
        node.remove();
}

// The picture of a job. A new version is loaded aside and put in place when it is whole: no flicker.
async function showPicture(frame, job, alt) {
    const version = String(job.image.version);
    if (!job.image.version || frame.dataset.version === version || frame.dataset.loading)
        return;
    frame.dataset.loading = version;
    const image = new Image();
    image.alt = alt;
    image.src = `/v1/jobs/${job.id}/preview.png?version=${version}`;
    try {
        await image.decode();
        frame.replaceChildren(image);
        frame.dataset.version = version;
    } catch {
        // The old picture stays; the next turn tries again.
    }
    delete frame.dataset.loading;
}

function showProgress(root, job) {
    $("progress", root).value = 100 * job.progress;
    say($("progress", root), progressText(job));
    say(field(root, "percent"), progressText(job));
}

function showFarm(root, workers) {
    if (!root.firstElementChild)
        root.append(stamp("farm"));
    say(field(root, "start"), `smalti-worker --server ${location.origin}`);
    field(root, "none").hidden = workers.length > 0;
    sync($("ul", root), workers, (w) => w.name, "worker-item", (node, w) => {
        say(field(node, "name"), w.name);
        showState(field(node, "state"), w.state);
        const facts = [plural(w.threads, "thread"), plural(w.leases, "lease"),
            `${w.delivered}\u00a0delivered`, `${duration(w.cpu_seconds)}\u00a0CPU`];
        if (w.state === "lost")
            facts.push(`last seen ${duration(w.seen_ms_ago / 1000)} ago`);
        say(field(node, "facts"), facts.join("\u00a0· "));
    });
}

const threadsOf = (workers) => workers.filter((w) => w.state !== "lost").reduce((n, w) => n + w.threads, 0);

function summary(workers) {
    const here = workers.filter((w) => w.state !== "lost").length;
    say($("#summary"), `${plural(here, "worker")}, ${plural(threadsOf(workers), "thread")}`);
}

// --- the list --------------------------------------------------------------------------------

function listFacts(job) {
    const facts = [`${job.film.width}\u00a0×\u00a0${job.film.height}`, `${job.spp}\u00a0spp`];
    if (job.error !== null)
        facts.push(`error\u00a0${percent(job.error)}`);
    if (job.state === "running" && job.eta_seconds !== null)
        facts.push(`${duration(job.eta_seconds)}\u00a0left`);
    return facts.join("\u00a0· ");
}

function showListItem(node, job) {
    const link = field(node, "title");
    say(link, title(job));
    link.href = `#/jobs/${job.id}`;
    showState(field(node, "state"), job.state);
    say(field(node, "facts"), listFacts(job));
    $("progress", node).setAttribute("aria-label", `Progress of ${title(job)}`);
    showProgress(node, job);
    showPicture($(".thumb", node), job, "");
}

function listView(after) {
    const root = $("#main");
    root.replaceChildren(stamp("list-view"));
    field(root, "newest").hidden = !after;
    say(field(root, "curl"), "curl -H 'Content-Type: application/json' --data-binary @scenes/cornell-box.json "
        + `${location.origin}/v1/jobs`);
    say(field(root, "cli"), `smalti submit --server ${location.origin} scenes/cornell-box.json`);
    document.title = "Jobs · smalti";
    return {
        paths: [`/v1/jobs?limit=50${after ? `&after=${encodeURIComponent(after)}` : ""}`, "/v1/workers"],
        show([{ jobs, next }, { workers }]) {
            $(".empty", root).hidden = jobs.length > 0 || Boolean(after);
            sync($(".jobs", root), jobs, (job) => job.id, "list-item", showListItem);
            const older = field(root, "older");
            older.hidden = !next;
            if (next)
                older.href = `#/after/${next}`;
            $(".pages", root).hidden = !next && !after;
            showFarm($(".farm", root), workers);
            summary(workers);
            return jobs.some((job) => job.state === "running") ? 1500 : 4000;
        },
        gone: "There is no such page of jobs.",
    };
}

// --- one job ---------------------------------------------------------------------------------

function leftText(job) {
    if (job.state === "queued")
        return "Waits for a worker.";
    if (job.state === "paused")
        return "Paused: no new work is given out.";
    if (job.state !== "running")
        return job.finished_unix_ms === null ? "" : `Ended ${date(job.finished_unix_ms)}.`;
    return job.eta_seconds === null ? "Time left: not known yet." : `About ${duration(job.eta_seconds)} left.`;
}

function methodRows(job, plan) { // plan: of a job with "auto", once it is there
    if (!job.auto)
        return [];
    if (job.method === null)
        return [["Method", "not planned yet"]];
    const rows = [["Method", `${job.method.integrator}, ${job.method.strategy}`]];
    if (!plan)
        return rows;
    const missing = Object.entries(plan.missing);
    rows.push(["Chosen since it is", plan.why]);
    if (missing.length)
        rows.push(["Light that is missing", missing.map(([name, share]) => `${name}\u00a0${percent(share)}`).join(", ")]);
    return rows;
}

function jobFacts(job, plan) {
    const passes = job.tile_passes, leases = job.leases, bad = job.invalid_samples;
    const { pixels, spp, stopped, removed, triangles_dropped: dropped } = job.report;
    const rows = [
        ["Error (95\u00a0% interval)", errorText(job)],
        ["Error bars hold for", trustText(pixels)],
        ["Samples per pixel", stopped ? `${spp.least} to ${spp.most}, enough in ${percent(stopped)} of the pixels` : `${job.spp} of ${job.target.spp}`],
        ["Samples", big(job.samples)],
        ["Rate", job.samples_per_second === null ? "–" : `${big(job.samples_per_second)}\u00a0samples/s`],
        ["Workers on it", String(job.workers)],
        ["Target", targetText(job.target)],
        ...methodRows(job, plan),
        ["Time", `${duration(job.elapsed_seconds)}, ${duration(job.cpu_seconds)}\u00a0CPU`],
        ["Tile passes", `${passes.done} of ${passes.total}`],
    ];
    if (leases.expired || leases.returned || leases.duplicates)
        rows.push(["Leases", `${leases.expired} expired, ${leases.returned} returned, ${leases.duplicates} twice`]);
    if (bad.count)
        rows.push(["Invalid samples", `${bad.count}, the first at ${bad.keys.slice(0, 3)
            .map(([x, y, sample]) => `(${x}, ${y}) sample ${sample}`).join(", ")}`]);
    for (const [name, what] of [["Light cut by max_bounces", removed.max_bounces], ["Light taken by clamp", removed.clamp]])
        if (what.share >= 0.0005)
            rows.push([name, percent(what.share)]);
    if (dropped.degenerate + dropped.not_finite)
        rows.push(["Triangles left out", `${dropped.degenerate} without area, ${dropped.not_finite} not finite`]);
    rows.push(["Priority", String(job.priority)], ["Submitted", date(job.created_unix_ms)], ["Job", job.id]);
    return rows;
}

function showFacts(list, rows) {
    rows.forEach(([name, value], i) => {
        let row = list.children[i];
        if (!row) {
            row = document.createElement("div");
            row.append(document.createElement("dt"), document.createElement("dd"));
            list.append(row);
        }
        say(row.firstChild, name);
        say(row.lastChild, value);
    });
    while (list.children.length > rows.length)
        list.lastChild.remove();
}

function failureText(failure) {
    const where = [];
    if (failure.tile !== undefined && failure.tile !== null)
        where.push(`tile ${failure.tile}`);
    if (failure.rect)
        where.push(`pixels (${failure.rect[0]}, ${failure.rect[1]}) to (${failure.rect[2]}, ${failure.rect[3]})`);
    if (failure.pass !== undefined && failure.pass !== null)
        where.push(`pass ${failure.pass}`);
    return where.length ? `${failure.reason} (${where.join(", ")})` : failure.reason;
}

function showJob(root, job, plan) {
    const live = LIVE.includes(job.state), image = job.image.version > 0;
    say(field(root, "title"), title(job));
    showState(field(root, "state"), job.state);
    $(".failure", root).hidden = !job.failure;
    if (job.failure)
        say(field(root, "failure"), failureText(job.failure));

    const full = field(root, "full"), [x0, y0, x1, y1] = job.film.crop;
    full.style.aspectRatio = `${x1 - x0} / ${y1 - y0}`; // keeps the place of the first image
    if (image)
        full.href = `/v1/jobs/${job.id}/preview.png`;
    showPicture(full, job, `${title(job)}, the image so far. Open it in full size.`);
    say(field(root, "caption"), `${x1 - x0} × ${y1 - y0} pixels, `
        + (image ? `version ${job.image.version} of the image` : "no image yet"));

    showProgress(root, job);
    say(field(root, "left"), leftText(job));
    showFacts($("dl", root), jobFacts(job, plan));

    const exr = field(root, "exr"), pause = field(root, "pause"), cancel = field(root, "cancel");
    const held = [pause, cancel].includes(document.activeElement);
    exr.hidden = !image;
    exr.href = `/v1/jobs/${job.id}/image.exr`;
    exr.download = `${title(job).replace(/[^\w.-]+/g, "-")}-${job.id}.exr`;
    pause.hidden = cancel.hidden = !live;
    say(pause, job.state === "paused" ? "Resume" : "Pause");
    if (held && !live) // the focus must not vanish with its button
        $("h1", root).focus();
    document.title = `${live ? `${progressText(job)} ` : `${job.state}: `}${title(job)} · smalti`;
}

function jobView(id) {
    const root = $("#main"), path = `/v1/jobs/${encodeURIComponent(id)}`;
    root.replaceChildren(stamp("job-view"));
    say(field(root, "title"), `Job ${id}`);
    document.title = `Job ${id} · smalti`;
    let state = null;

    async function order(button, options) {
        button.disabled = true;
        try {
            await ask(path, options);
            notice("");
        } catch (problem) {
            notice(problem instanceof Refused ? problem.message : "That did not reach the coordinator. Try again.");
        }
        button.disabled = false;
        button.focus();
        wake();
    }
    const pause = field(root, "pause"), cancel = field(root, "cancel"), dialog = $("dialog", root);
    pause.onclick = () => order(pause, {
        method: "PATCH",
        headers: { "Content-Type": "application/json" },
        body: JSON.stringify({ state: state === "paused" ? "running" : "paused" }),
    });
    cancel.onclick = () => {
        dialog.returnValue = "keep";
        dialog.showModal();
    };
    dialog.onclose = () => {
        if (dialog.returnValue === "cancel")
            order(cancel, { method: "DELETE" });
    };
    const paths = [path, "/v1/workers", `${path}/convergence`];
    let plan;
    return {
        paths,
        show([job, { workers }, curve, found]) {
            plan ??= found; // asked for in the turn after it is made, and once
            paths[3] = `${path}/plan`;
            paths.length = job.method && !plan ? 4 : 3;
            showJob(root, job, plan);
            showCurve($(".convergence", root), curve);
            showFarm($(".farm", root), workers);
            summary(workers);
            if (state !== null && state !== job.state)
                say($("#news"), `${title(job)} is ${job.state}.`);
            state = job.state;
            return LIVE.includes(state) ? 1000 : 10000;
        },
        gone: `There is no job ${id} here.`,
    };
}

// --- the loop --------------------------------------------------------------------------------

let view = null, timer = 0, failures = 0, away = false;

function notice(text) {
    say($("#notice"), text);
}

function showRefusal(text) {
    $("#main").replaceChildren(stamp("refusal"));
    say(field($("#main"), "why"), text);
    document.title = "smalti";
    $("#main h1").focus();
}

function route() {
    const [, kind, id] = location.hash.match(/^#\/(jobs|after)\/([\w-]+)$/) || [];
    const first = view === null;
    kept.clear();
    if (!away)
        notice("");
    view = kind === "jobs" ? jobView(id) : listView(id);
    if (!first) { // tell a screen reader that the page is another one
        $("#main h1").focus({ preventScroll: true });
        scrollTo(0, 0);
    }
    wake();
}

function wake() {
    clearTimeout(timer);
    turn(view);
}

async function turn(mine) {
    let delay_ms;
    try {
        const answers = await Promise.all(mine.paths.map(get));
        if (mine !== view)
            return;
        delay_ms = mine.show(answers);
        failures = 0;
        if (away)
            notice("");
        away = false;
    } catch (problem) {
        if (mine !== view)
            return;
        delay_ms = Math.min(1000 * 2 ** failures++, 15000);
        if (problem instanceof Away) {
            away = true;
            notice("The coordinator is not reachable, trying again.");
        } else if (problem instanceof Refused) {
            away = false;
            notice("");
            showRefusal(problem.status === 404 ? mine.gone : problem.message);
            mine.show = () => { // it is there after all, when somebody looks again
                route();
                return 1000;
            };
            return; // until then, asking would not help
        } else {
            reportError(problem); // a mistake of ours
        }
    }
    clearTimeout(timer); // a turn that was woken meanwhile keeps one timer only
    timer = setTimeout(() => turn(view), document.hidden ? Math.max(delay_ms, 20000) : delay_ms);
}

addEventListener("hashchange", route);
addEventListener("online", wake);
document.addEventListener("visibilitychange", () => document.hidden || wake());
route();
