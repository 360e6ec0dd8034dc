// The curve of a job: its error against its samples, both logarithmic, the target as a dashed line, the forecast as a
// cone to where it should be met.
// SPDX-License-Identifier: MIT
"use strict";

const CURVE = { left: 58, top: 16, bottom: 254, height: 300, right: 18 }; // px; right: of the margin

function shape(name, attributes, text = "") {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes))
        node.setAttribute(key, value);
    node.textContent = text;
    return node;
}

// 1, 2, 5 x 10^k in [low, high]; 10^k alone where these are too many.
function marks(low, high, most) {
    const first = Math.floor(Math.log10(low)), count = Math.log10(high) - first + 1;
    const inside = (steps) => Array.from({ length: count }, (_, k) => steps.map((v) => v * 10 ** (first + k))).flat()
        .filter((v) => v >= low && v <= high);
    const all = inside([1, 2, 5]);
    return all.length > most ? inside([1]) : all;
}

// What is shown of samples per pixel (x) and error (y).
function curveRange(points, target, forecast, pixels) {
    const xs = points.map((p) => p.samples / pixels), ys = points.map((p) => p.error);
    if (target !== null)
        ys.push(target);
    if (forecast)
        xs.push(forecast.samples / pixels, Math.min(forecast.samples_high / pixels, 100 * Math.max(...xs)));
    return { x0: Math.min(...xs) / 1.25, x1: Math.max(...xs) * 1.25, y0: Math.min(...ys) / 1.25, y1: Math.max(...ys) * 1.25 };
}

// 500, 2 k, 10 M
const markText = (n) => big(n).replace(/(\.\d*?)0+(?!\d)/, "$1").replace(/\.(?!\d)/, "");

function curveAxes(svg, width, range, x, y) {
    const { left, top, bottom, height } = CURVE, right = width - CURVE.right;
    const label = (at, text) => svg.append(shape("text", at, text));
    const rule = (x1, y1, x2, y2) => svg.append(shape("line", { x1, y1, x2, y2, class: "grid" }));
    for (const v of marks(range.x0, range.x1, width / 80)) {
        rule(x(v), top, x(v), bottom);
        label({ x: x(v), y: bottom + 17, "text-anchor": "middle" }, markText(v));
    }
    for (const v of marks(range.y0, range.y1, 7)) {
        rule(left, y(v), right, y(v));
        label({ x: left - 7, y: y(v) + 4, "text-anchor": "end" }, percent(v));
    }
    label({ x: (left + right) / 2, y: height - 8, "text-anchor": "middle" }, "samples per pixel");
}

function curveSummary(last, target, forecast, pixels) {
    const parts = [`Error ${percent(last.error)} after ${duration(last.seconds)}`];
    if (target.error !== null)
        parts.push(`target ${percent(target.error)}`);
    if (forecast && forecast.samples > target.spp * pixels) {
        const then = last.error * (target.spp * pixels / last.samples) ** forecast.slope;
        parts.push(`the limit of ${target.spp} spp comes first, at about ${percent(then)}`);
    } else if (forecast?.seconds_left > 0)
        parts.push(`expected in ${duration(forecast.seconds_left)} `
            + `(${duration(forecast.seconds_left_low)} to ${duration(forecast.seconds_left_high)})`);
    return parts.join(", ") + ".";
}

// Fills `root`, a section, from the answer of /convergence; hides it while there is nothing to see.
function showCurve(root, { pixels, points, target, forecast }) {
    const seen = points.filter((p) => p.error > 0 && p.samples > 0), last = seen.at(-1);
    root.hidden = seen.length < 2;
    const width = Math.max(280, Math.min(640, root.clientWidth - 34));
    const key = JSON.stringify([width, last, target, forecast]);
    if (root.hidden || root.dataset.key === key)
        return;
    root.dataset.key = key;
    const { left, top, bottom, height } = CURVE, right = width - CURVE.right;
    const range = curveRange(seen, target.error, forecast, pixels);
    const along = (v, a, b) => Math.log(v / a) / Math.log(b / a);
    const x = (v) => left + (right - left) * along(Math.min(v, range.x1), range.x0, range.x1);
    const y = (v) => bottom - (bottom - top) * along(Math.max(v, range.y0), range.y0, range.y1);
    const at = (samples, error) => `${x(samples / pixels)},${y(error)}`;
    const summary = curveSummary(last, target, forecast, pixels);
    const svg = shape("svg", { width, height, viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": summary, class: "curve" });
    const draw = (name, attributes, text) => svg.append(shape(name, attributes, text));
    curveAxes(svg, width, range, x, y);
    if (target.error !== null) {
        const level = y(target.error), end = at(last.samples, last.error);
        if (forecast?.samples > last.samples) {
            const [low, most, high] = [forecast.samples_low, forecast.samples, forecast.samples_high].map((n) => at(n, target.error));
            draw("polygon", { points: `${end} ${low} ${high}`, class: "cone" });
            draw("polyline", { points: `${end} ${most}`, class: "forecast" });
        }
        draw("line", { x1: left, x2: right, y1: level, y2: level, class: "target" });
        draw("text", { x: left + 6, y: level - 6, class: "target-name" }, "target");
    }
    draw("polyline", { points: seen.map((p) => at(p.samples, p.error)).join(" ") });
    for (const p of seen) {
        const cx = x(p.samples / pixels);
        if (p.interval?.[0] > 0)
            draw("line", { x1: cx, x2: cx, y1: y(p.interval[0]), y2: y(Math.min(p.interval[1], range.y1)) });
        draw("circle", { cx, cy: y(p.error), r: 3.2 });
    }
    field(root, "curve").replaceChildren(svg);
    say(field(root, "summary"), summary);
}
